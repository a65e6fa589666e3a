"""The files of a case, as an engineer would have them; what it is lies sealed elsewhere."""

from pathlib import Path

import numpy as np

from pipeline.blind.generate import GeneratedCase
from pipeline.blind.label import seal
from pipeline.blind.truth.sensors import Log as TrueLog
from pipeline.export.mcap_log import write_run_log
from pipeline.simulate.sensors import Channel, Log
from pipeline.vehicle.load import VEHICLE_FILE
from pipeline.vehicle.schema import Vehicle

#: Instrument of the truth -> what its columns are called in a log.
_COLUMNS = {
    "imu": (
        *("p_radps", "q_radps", "r_radps", "fx_mps2", "fy_mps2", "fz_mps2"),
        *("qw", "qx", "qy", "qz"),
    ),
    "dvl": ("vx_mps", "vy_mps", "vz_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "voltage": ("supply_v",),
}


def write_case(case: GeneratedCase, name: str, folder: Path, sealed: Path) -> None:
    """Write a case to disk: what an engineer would have, and the sealed label elsewhere.

    ``<name>/vehicle.yaml`` and ``<name>/pool/*.mcap`` go to `folder`, ``<name>.json`` to `sealed`.

    Raises
    ------
    CannotComputeError
        If a log cannot be written.
    """
    here, vehicle = folder / name, case.subject.vehicle
    (here / "pool").mkdir(parents=True, exist_ok=True)
    (here / VEHICLE_FILE).write_text(case.subject.text, encoding="utf-8")
    for table in (*case.runs, *case.holdout, *case.healthy):
        write_run_log(
            here / "pool" / f"{table.name}.mcap",
            _channels(case.logs[table.name], vehicle),
            vehicle_name=vehicle.name,
            density_kgpm3=vehicle.water.density_kgpm3,
            gravity_mps2=vehicle.water.gravity_mps2,
            start_time_ns=table.start_time_ns,
        )
    seal(case.label, sealed / f"{name}.json")


def _channels(log: TrueLog, vehicle: Vehicle) -> Log:
    """Name the columns of what the truth's instruments read, the DVL's in its own axes."""
    from scipy.spatial.transform import Rotation

    thrusters = tuple(one.name for one in vehicle.thrusters)
    found: Log = {}
    for instrument, reading in log.items():
        values = reading.values
        if instrument == "dvl":
            dvl = vehicle.sensors.dvl if vehicle.sensors is not None else None
            turn = dvl.rotation_deg if dvl is not None else (0.0, 0.0, 0.0)
            values = Rotation.from_euler("ZYX", np.radians(turn)[::-1]).inv().apply(values)
        columns = _COLUMNS.get(instrument, thrusters)
        found[instrument] = Channel(columns, reading.stamp_s, reading.logged_s, values)
    return found
