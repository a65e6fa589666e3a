"""What `find_manoeuvres` makes of every manoeuvre that the simulator flies.

``python -m benchmarks.manoeuvres`` prints a table: for each vehicle and manoeuvre the share of the
run that was recognised as it, and the stretches found. Takes about a minute.
"""

from pathlib import Path

import numpy as np

from evaluation.bundled.mmt300_runs import true_vehicle
from pipeline.identify.manoeuvre_detection import find_manoeuvres
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.sensor_schema import Sensors

_ROOT = Path(__file__).parents[1]
_FOLDERS = (
    _ROOT / "raw" / "mmt300",
    _ROOT / "pipeline" / "bundled" / "vehicles" / "rov8",
    _ROOT / "pipeline" / "bundled" / "vehicles" / "cargo_carrier",
)


def main() -> None:
    """Print a line for each vehicle and manoeuvre."""
    print("| vehicle | flown | recognised | stretches |")
    print("|---|---|---|---|")
    for folder in _FOLDERS:
        vehicle = load_vehicle(folder)
        packed = true_vehicle(vehicle) if vehicle.name == "mmt300" else pack_vehicle(vehicle)
        sensors = vehicle.sensors or Sensors()
        code_max = np.array(
            [vehicle.drives[one.drive].code_max for one in vehicle.thrusters], float
        )
        for manoeuvre in MANOEUVRES.values():
            trajectory = fly(packed, manoeuvre.plan(packed, 1.0, manoeuvre.duration_s))
            log = measure(trajectory, packed, sensors, seed=3)
            run = table_of_log(log, sensors, name=manoeuvre.name)
            found = find_manoeuvres(run, code_max)
            of_it = sum(one.to_s - one.from_s for one in found if one.name == manoeuvre.name)
            parts = ", ".join(f"{one.name} {one.from_s:.0f}-{one.to_s:.0f} s" for one in found)
            share = 100.0 * of_it / run.time_s[-1]
            print(f"| {vehicle.name} | {manoeuvre.name} | {share:.0f} % | {parts} |", flush=True)


if __name__ == "__main__":
    main()
