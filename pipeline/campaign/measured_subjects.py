"""Measured vehicles for the blind check: a vehicle file and the runs that were flown with it.

Every folder within DATA that holds ``vehicle.yaml`` and logs (in it or in its ``pool/``) is one.
Two public data sets are known by the names of their folders, and their vehicle files come with the
package: ``brov2_tank_mocap`` (tank) and ``exjobbrov_pool`` (pool).
"""

import io
import runpy
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pipeline
from pipeline.errors import InputError, Place
from pipeline.ingest.log_files import logs_of
from pipeline.inputs.runs_to_identify import read_run
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.plan import VEHICLE_FILE
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.schema import Vehicle

#: Folder of a public data set -> its short name, and its vehicle.
PUBLIC = {"brov2_tank_mocap": ("tank", "brov2_tank"), "exjobbrov_pool": ("pool", "exjobbrov")}
_CONVERTER = "brov2_tank_to_mcap.py"


@dataclass(frozen=True)
class MeasuredSubject:
    """A measured vehicle: `runs` by the beginning of their logs, in the order of their names."""

    name: str
    vehicle: Vehicle
    packed: PackedVehicle
    runs: tuple[RunTable, ...]


def load_subjects(data: Path, cache: Path) -> list[MeasuredSubject]:
    """Read every measured vehicle of a folder; logs made of other files go to `cache`."""
    folders = sorted(one for one in data.iterdir() if one.is_dir()) if data.is_dir() else []
    found = [
        load_subject(folder, cache)
        for folder in folders
        if folder.name in PUBLIC or ((folder / VEHICLE_FILE).is_file() and _logs(folder))
    ]
    if not found:
        raise InputError.at(
            Place(str(data)),
            "there is no measured vehicle in this folder.",
            expected=f"folders with {VEHICLE_FILE} and logs of runs (*.mcap, or pool/*.mcap), or "
            f"one of {', '.join(PUBLIC)}.",
            remedy="Give the folder that holds the vehicles' folders.",
        )
    return found


def load_subject(folder: Path, cache: Path) -> MeasuredSubject:
    """Read a measured vehicle and its runs."""
    name, vehicle = PUBLIC.get(folder.name, (folder.name, ""))
    stated = _with_package(vehicle) if vehicle else folder
    one = load_simulated(str(stated), Path("raw"), Path())
    logs = _logs(folder) or _converted(folder, cache / name)
    raw = logs[0].parent.parent if logs[0].parent.name == "pool" else logs[0].parent
    runs = tuple(read_run(log, one, raw)[1] for log in logs)
    return MeasuredSubject(name, one.vehicle, one.packed, runs)


def _logs(folder: Path) -> list[Path]:
    return logs_of(folder) or logs_of(folder / "pool")


def _converted(folder: Path, target: Path) -> list[Path]:
    """Make the logs of the tank runs, which are published as arrays."""
    if not _logs(target):
        with redirect_stdout(io.StringIO()):  # what it says is for a person who converts
            main = runpy.run_path(str(_with_package(_CONVERTER)))["main"]
            main([str(folder), "--to", str(target)])
    logs = _logs(target)
    if not logs:
        raise InputError.at(
            Place(str(folder)),
            "there are no runs in this folder.",
            expected="logs (*.mcap), or the arrays of the tank runs (*_measured.npz).",
            remedy="See what the folder holds.",
        )
    return logs


def _with_package(name: str) -> Path:
    """Find what comes with the package; in the source tree it has a place of its own."""
    package = Path(pipeline.__file__).resolve().parent
    tree = package.parent
    rooms = (package / "examples", tree / "tests/acceptance", tree / "docs/examples")
    for room in rooms:
        if (room / name).exists():
            return room / name
    raise InputError.at(
        Place(str(rooms[0] / name)),
        "is missing from the installed package.",
        remedy="Install the package again.",
    )
