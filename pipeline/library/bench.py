"""Vehicle files, bench files and the tables made of them, as frames."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from pipeline.errors import InputError, Place
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import RAW_KINDS, processed_file
from pipeline.provenance import read_tables
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.records.run_table import QUANTITIES, RunTable
from pipeline.vehicle.load import load_vehicle as read_vehicle_file
from pipeline.vehicle.schema import Vehicle

Kind = Literal["load_test", "mooring", "open_water"]
BenchRecord = LoadTestRecord | MooringRecord | OpenWaterRecord
_READERS: dict[str, Callable[[Sequence[Path], Vehicle, Path], BenchRecord]] = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}
_TABLES = ("table1", "table2", "table3", "table4")


def load_vehicle(vehicle: str | Path, raw: str | Path = "raw") -> Vehicle:
    """Read a vehicle file: SI units, angles as the file states them.

    Parameters
    ----------
    vehicle : str or Path
        A name under `raw`, a folder that holds ``vehicle.yaml``, or the name of a bundled vehicle.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError
        When its file cannot be read.
    """
    return read_vehicle_file(find_vehicle(str(vehicle), Path(raw), Path())[1])


def read_bench(path: str | Path, vehicle: Vehicle, kind: Kind | None = None) -> pd.DataFrame:
    """Read one bench file: load test, mooring (bollard) test or open-water test.

    Parameters
    ----------
    path : str or Path
        The file.
    vehicle : Vehicle
        Whose drive, code range and ``columns:`` hold.
    kind : {"load_test", "mooring", "open_water"}, optional
        What was tested; that of the file's folder when it is not given.

    Returns
    -------
    DataFrame
        A row for each point: codes, ``thrust_n``, ``torque_nm``, ``shaft_speed_rpm`` and so on,
        ``file``, ``sheet``, ``row`` and ``marks`` (why a point takes no part in a fit).

    Raises
    ------
    InputError
        When the file gives no point at all; the text says why.
    """
    path = Path(path)
    chosen = path.absolute().parent.name if kind is None else kind
    if chosen not in _READERS:
        raise InputError.at(
            Place(str(path)),
            f'the folder "{chosen}" does not tell what was tested.',
            expected=f"a file in a folder {', '.join(RAW_KINDS)}, or kind= one of these.",
            remedy='Say which, e.g. read_bench(path, vehicle, kind="mooring").',
        )
    record = _READERS[chosen]([path], vehicle, path.absolute().parent)
    if not record.points:
        errors = [one for one in record.problems if one.severity == "error"]
        if errors:
            raise InputError(errors[0])
        raise InputError.at(
            Place(str(path)), "no point was read.", remedy="See what `rig2sea check` says of it."
        )
    rows = []
    for point in record.points:
        row = point.model_dump()
        source = row.pop("source")
        rows.append({**row, **source, "marks": ", ".join(point.marks)})
    frame = pd.DataFrame(rows).dropna(axis="columns", how="all")
    return told(frame, record, [str(problem) for problem in record.problems])


def thruster_tables(vehicle: str, out: str | Path = ".") -> dict[str, pd.DataFrame]:
    """Return Tables 1 to 4 of a vehicle that `rig2sea run` has computed.

    Parameters
    ----------
    vehicle : str
        Its name.
    out : str or Path
        The folder that holds ``processed/``.

    Returns
    -------
    dict of str to DataFrame
        ``table1`` (K_T, K_M over powers of J), ``table2`` (thrust over code, a row for each speed),
        ``table3`` (code over thrust at rest, a column for each sign), ``table4`` (code over thrust,
        a row for each speed). A table that the bench data did not give is absent.

    Raises
    ------
    InputError
        When ``tables.json`` is absent, half-written or edited.
    """
    body = read_tables(Path(out) / processed_file(vehicle, "tables"))
    found = {}
    for name in _TABLES:
        columns = {
            key: values
            for key, values in (body.get(name) or {}).items()
            if isinstance(values, list) and values and not isinstance(values[0], list)
        }
        if columns:
            found[name] = pd.DataFrame({key: pd.Series(values) for key, values in columns.items()})
    return found


#: Quantity -> columns of its frame; those of the commands are named after the thrusters.
_COLUMNS = {
    "angular_velocity": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("specific_force_x_mps2", "specific_force_y_mps2", "specific_force_z_mps2"),
    "attitude": ("attitude_w", "attitude_x", "attitude_y", "attitude_z"),
    "velocity": ("u_mps", "v_mps", "w_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "voltage": ("voltage_v",),
    "current": ("current_a",),
}
_OF_THRUSTERS = {"command": "code", "shaft_speed": "rpm"}


def frame_of(run: RunTable) -> pd.DataFrame:
    """Put a run's channels side by side; readings that are not valid are left empty."""
    columns: dict[str, Any] = {}
    for quantity in QUANTITIES:
        if quantity not in run.valid:
            continue
        values, valid = run.values[quantity], run.valid[quantity]  # noqa: PD011 - no pandas object
        names: Sequence[str] = _COLUMNS.get(quantity, ())
        if quantity in _OF_THRUSTERS:
            names = [f"{quantity}_{one}_{_OF_THRUSTERS[quantity]}" for one in run.thrusters]
        for name, column in zip(names, values.T, strict=True):
            columns[name] = pd.Series(column).where(pd.Series(valid))
    frame = pd.DataFrame(columns)
    frame.index = pd.Index(run.time_s, name="time_s")
    return frame


def told(frame: pd.DataFrame, record: object, warnings: Sequence[str]) -> pd.DataFrame:
    """Keep what a frame was made from, and what was said of it, beside it."""
    frame.attrs["record"] = record
    frame.attrs["warnings"] = tuple(warnings)
    return frame
