"""Read raw files as the workflow would, all of one kind in a folder together."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from pipeline.check.bench_files import RawFile, kind_by_content, read_together
from pipeline.check.findings import FileFinding, Findings, RunFinding, VehicleFinding
from pipeline.check.pool_runs import (
    files_of_runs,
    gains_of_checked,
    is_log,
    is_notes,
    read_notes_alone,
    read_run,
    repeated,
    strays,
)
from pipeline.errors import InputError, Place
from pipeline.ignored_files import ignored_file_problems
from pipeline.ingest.log_files import is_log_name, not_a_log, unprintable_log
from pipeline.plan import (
    POOL,
    RAW_KINDS,
    VEHICLE_FILE,
    UsageError,
    VehicleFolder,
    discover,
    is_raw,
    printable,
    vehicle_at,
)
from pipeline.records.run_table import RunTable
from pipeline.stages.bench_records import READERS
from pipeline.vehicle.frames import frame_shown
from pipeline.vehicle.load import load_vehicle, vehicle_notes
from pipeline.vehicle.run_notes import BAG_FILE
from pipeline.vehicle.schema import Vehicle

_KINDS = (*RAW_KINDS, POOL)
#: What a file is read by when no vehicle file is near; every number of it is shown as assumed.
_STAND_IN = {
    "name": "unknown",
    "title": "no vehicle file",
    "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.80665},
    "propellers": {"unknown": {"diameter_m": 0.1}},
    "drives": {"unknown": {"code_min": -127, "code_max": 127}},
    "tables": {"propeller": "unknown", "drive": "unknown"},
}
_STAND_IN_NOTE = Place(VEHICLE_FILE).note(
    "there is none near the file: codes from -127 to 127, fresh water and a propeller of 0.1 m "
    "are assumed for this check alone.",
    remedy="Give the right one with --vehicle FILE.",
)


def check_paths(
    paths: Sequence[str],
    *,
    raw: Path,
    vehicle_file: Path | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Findings:
    """Read everything that the paths name.

    They are raw files, folders of them, vehicle folders, or names of vehicles under `raw`, read by
    `vehicle_file` or the one in the vehicle's folder. `tell` is told each before it is read.
    """
    findings = Findings()
    reader = _Reader(findings, vehicle_file, tell, raw)
    for text in paths:
        if not text:  # Path("") is the current folder
            raise UsageError('a path is "", and names nothing: is a variable of the shell not set?')
        path = Path(text)
        if not path.exists() and (raw / text).exists():
            path = raw / text
        if not path.exists():
            raise UsageError(f'"{text}" does not exist, neither here nor under {raw}.')
        reader.read(path)
    reader.read_files()
    return findings


class _Reader:
    """Goes through the paths; raw files are set aside and then read a kind of a folder at a time.

    What a file lacks another of its folder may hold (the codes of a load test, say), and a file
    can repeat another one: read alone it would look wrong, or right, where it is not.
    """

    def __init__(
        self, findings: Findings, vehicle_file: Path | None, tell: Callable[[str], None], raw: Path
    ) -> None:
        self._findings, self._vehicle_file = findings, vehicle_file
        self._tell, self._raw = tell, raw
        self._vehicles: dict[Path | None, Vehicle | None] = {}
        self._typed: dict[Path, Vehicle] = {}
        self._files: dict[Path, RawFile] = {}
        self._runs: dict[Path, tuple[Path, Vehicle]] = {}
        self._unread: set[Path] = set()

    def read(self, path: Path) -> None:
        """Read a vehicle file; set a raw file, or everything in a folder, aside."""
        if path.name == VEHICLE_FILE:
            self._vehicle(path)
        elif path.is_file():
            self._file(path)
        elif not path.is_dir():
            raise UsageError(f'"{path}" is neither a file nor a folder.')
        elif (path / VEHICLE_FILE).exists():
            self._vehicle_folder(path)
        elif (path / BAG_FILE).is_file() and path.name not in _KINDS:
            self._file(path / BAG_FILE)
        elif not (self._kind_folder(path) if path.name in _KINDS else self._folder(path)):
            expected = f"raw files, a folder of them ({', '.join(_KINDS)}), or {VEHICLE_FILE}."
            self._findings.problems.append(
                Place(str(path)).error("holds nothing to check.", expected)
            )

    def _vehicle_folder(self, path: Path) -> None:
        """Set everything of a vehicle aside."""
        self._vehicle(path / VEHICLE_FILE)
        try:
            vehicle_at(path, Path())
        except InputError as error:  # a run refuses it for the folder's name
            self._findings.problems.append(error.problem)
        for kind in _KINDS:
            self._kind_folder(path / kind)
        self._findings.problems += (
            one.shown_as(str(path / Path(one.place.file).name))
            for one in VehicleFolder(path.name, str(path)).misplaced_problems()
        )

    def _kind_folder(self, path: Path) -> bool:
        """Set aside what a run reads of a test's folder; tell whether there was anything in it."""
        before = len(self._findings.problems)
        vehicle = None
        if path.name != POOL and path.is_dir() and any(one.is_dir() for one in path.iterdir()):
            file = path.parent / VEHICLE_FILE
            vehicle = self._vehicle(file) if file.exists() else None
        types = () if vehicle is None else tuple(vehicle.tables.types)
        self._findings.problems += ignored_file_problems(path, types=types)
        if path.name == POOL:
            self._findings.problems += strays(path)
            files = files_of_runs(path)
        else:
            folder = VehicleFolder(path.absolute().parent.name, str(path.parent))
            self._findings.problems += folder.misnamed_problems(path.name, str(path))
            files = [
                Path(file)
                for one in (folder, *(folder.of_type(name) for name in types))
                for file in one.raw_files(path.name)
            ]
        for file in files:
            self._file(file)
        return bool(files) or len(self._findings.problems) > before

    def _folder(self, path: Path) -> bool:
        """Set everything in a folder aside; tell whether there was something to look into."""
        _, problems = discover(path, Path())
        self._findings.problems += problems
        found = bool(problems)
        for inner in sorted(path.iterdir()):
            known = inner.name in _KINDS or any(
                (inner / name).exists() for name in (VEHICLE_FILE, BAG_FILE)
            )
            if (inner.is_dir() and known) or (inner.is_file() and is_raw(inner.name)):
                found = True  # what is in it says itself when it holds nothing
                self.read(inner)
        return found

    def read_files(self) -> None:
        """Read the raw files that were set aside."""
        found: dict[Path, FileFinding] = {}
        for group in self._groups():
            read, of_folder = read_together(group)
            found |= dict(zip((file.path for file in group), read, strict=True))
            if self._is_whole(group[0].path.parent):
                self._findings.problems += of_folder
        self._findings.files += [found[file.path] for file in self._files.values()]
        tables: list[tuple[RunFinding, RunTable | None, Path | None]] = []
        for path, vehicle in self._runs.values():
            self._tell(str(path))
            file = path.parent if path.name == BAG_FILE else path
            by = "folder" if file.absolute().parent.name == POOL else "suffix"
            finding, table = read_run(path, vehicle, by)
            self._findings.runs.append(finding)
            tables.append((finding, table, self._file_of(vehicle)))
        if any(file is not None for _, _, file in tables):
            self._tell("gains of the thrusters")
        self._findings.problems += repeated(self._findings.runs)
        self._findings.gains += gains_of_checked(tables, self._raw)

    def _file_of(self, vehicle: Vehicle) -> Path | None:
        """Return the file of a vehicle that was read; None of one that stands in."""
        return next(
            (path for path, known in self._vehicles.items() if known is vehicle and path), None
        )

    def _groups(self) -> list[list[RawFile]]:
        """Return the files by folder, kind and vehicle; a kind told by content is told first."""
        groups: dict[tuple[Path, str, int], list[RawFile]] = {}
        for file in self._files.values():
            folder = file.path.absolute().parent
            self._tell(str(file.path))
            one = file if file.kind else replace(file, kind=kind_by_content(file))
            groups.setdefault((folder, one.kind, id(one.vehicle)), []).append(one)
        return list(groups.values())

    def _is_whole(self, folder: Path) -> bool:
        """Tell whether every raw file of a folder was asked for."""
        files = [path for path in folder.iterdir() if is_raw(path.name) and path.is_file()]
        return all(path.absolute() in self._files for path in files)

    def _vehicle(self, path: Path) -> Vehicle | None:
        if path in self._vehicles:
            return self._vehicles[path]
        self._tell(str(path))
        vehicle: Vehicle | None = None
        try:
            vehicle = load_vehicle(path)
        except InputError as error:
            finding = VehicleFinding(str(path), path.absolute().parent.name, (), (error.problem,))
        else:
            notes = (*frame_shown(vehicle), *vehicle_notes(vehicle))
            finding = VehicleFinding(str(path), vehicle.name, notes)
        self._findings.vehicles.append(finding)
        self._vehicles[path] = vehicle
        return vehicle

    def _vehicle_for(self, file: Path) -> Vehicle | None:
        if self._vehicle_file is not None:
            return self._vehicle(self._vehicle_file)
        file = file.parent if file.name == BAG_FILE else file
        typed = self._of_type(file)
        if typed is not None:
            return typed
        above = file.parent.parent if file.parent.name else Path("..")
        for folder in (above, file.parent):
            if (folder / VEHICLE_FILE).exists():
                return self._vehicle(folder / VEHICLE_FILE)
        if None not in self._vehicles:
            self._vehicles[None] = self._stand_in
            self._findings.problems.append(_STAND_IN_NOTE)
        return self._vehicles[None]

    def _of_type(self, file: Path) -> Vehicle | None:
        """Return what a file in the folder of a further type of thruster is read with."""
        folder = file.parent
        vehicle_file = folder.parent.parent / VEHICLE_FILE
        if folder.parent.name not in RAW_KINDS or not vehicle_file.exists():
            return None
        vehicle = self._vehicle(vehicle_file)
        if vehicle is None or folder.name not in vehicle.tables.types:
            return None
        key = folder.parent.parent / folder.name / VEHICLE_FILE
        return self._typed.setdefault(key, vehicle.of_type(folder.name))

    def _file(self, path: Path) -> None:
        if path.absolute() in {*self._files, *self._runs, *self._unread}:
            return
        if is_notes(path):
            self._findings.notes.append(read_notes_alone(path))
            return
        # a vehicle file that cannot be used has had its message; the raw file is read all the same
        vehicle = self._vehicle_for(path) or self._stand_in
        if is_log(path) and not (is_log_name(path.name) and path.name.isprintable()):
            self._unread.add(path.absolute())
            shown = printable(str(path))
            why = unprintable_log if is_log_name(path.name) else not_a_log
            self._findings.problems.append(why(shown))
            return
        if is_log(path):
            self._runs[path.absolute()] = (path, vehicle)
            return
        inner = path.absolute().parent
        folder = inner.parent.name if self._of_type(path) is not None else inner.name
        kind, kind_from = (folder, "folder") if folder in READERS else ("", "content")
        self._files[path.absolute()] = RawFile(path, kind, kind_from, vehicle)

    @cached_property
    def _stand_in(self) -> Vehicle:
        return Vehicle.model_validate(_STAND_IN)
