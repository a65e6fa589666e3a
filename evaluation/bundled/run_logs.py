"""Write the pool runs of `mmt300`: ``python -m evaluation.bundled.run_logs --to raw/mmt300``.

The same bytes come out every time; the notes beside the logs are written by hand and left alone.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from evaluation.bundled.mmt300_runs import RUNS, BundledRun, bundled_log, true_vehicle
from pipeline.export.mcap_log import write_run_log
from pipeline.vehicle.load import load_vehicle


def write_bundled_runs(folder: Path, to: Path, runs: Sequence[BundledRun] = RUNS) -> list[Path]:
    """Fly runs and write their logs.

    Parameters
    ----------
    folder : Path
        The vehicle's raw folder.
    to : Path
        Folder of the logs.
    runs : sequence of BundledRun
        Which.

    Returns
    -------
    list of Path
        The logs.
    """
    vehicle = load_vehicle(folder)
    packed = true_vehicle(vehicle)
    written = []
    for run in runs:
        path = to / f"{run.name}.mcap"
        write_run_log(
            path,
            bundled_log(run, vehicle, packed),
            vehicle_name=vehicle.name,
            density_kgpm3=vehicle.water.density_kgpm3,
            gravity_mps2=vehicle.water.gravity_mps2,
            # nothing of the truth: who opens the log knows as much as after a trial
            metadata={"note": "simulated; what was flown and the truth: raw/mmt300/README.md"},
            start_time_ns=run.start_time_ns,
        )
        written.append(path)
    return written


def main(arguments: list[str] | None = None) -> None:
    """Write the logs into ``pool/`` of a folder and name each."""
    parser = argparse.ArgumentParser(prog="python -m evaluation.bundled.run_logs")
    parser.add_argument("--to", type=Path, required=True, help="folder, e.g. raw/mmt300")
    folder: Path = parser.parse_args(arguments).to
    for path in write_bundled_runs(folder, folder / "pool"):
        print(path)


if __name__ == "__main__":
    main()
