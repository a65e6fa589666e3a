"""Read raw files as the workflow would, one by one, and collect what was understood."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.plan import RAW_KINDS, VEHICLE_FILE, UsageError, VehicleFolder, is_raw
from pipeline.records.measurements import (
    LoadTestRecord,
    MooringRecord,
    OpenWaterRecord,
    SheetRead,
)
from pipeline.vehicle.load import load_vehicle, vehicle_notes
from pipeline.vehicle.schema import Vehicle

RawRecord = LoadTestRecord | MooringRecord | OpenWaterRecord
READERS: dict[str, Callable[[Sequence[Path], Vehicle, Path], RawRecord]] = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}
#: What a file is read by when no vehicle file is near; every number of it is shown as assumed.
_STAND_IN = {
    "name": "unknown",
    "title": "no vehicle file",
    "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.80665},
    "propellers": {"unknown": {"diameter_m": 0.1}},
    "drives": {"unknown": {"code_min": -127, "code_max": 127}},
    "tables": {"propeller": "unknown", "drive": "unknown"},
}
_STAND_IN_NOTE = Problem(
    "note",
    Place(VEHICLE_FILE),
    "there is none near the file: codes from -127 to 127, fresh water and a propeller of 0.1 m "
    "are assumed for this check alone.",
    remedy="Give the right one with --vehicle FILE.",
)


@dataclass(frozen=True)
class Quantity:
    """The range of one quantity over the points that a fit would use."""

    name: str
    count: int
    least: float
    most: float


@dataclass(frozen=True)
class FileFinding:
    """One raw file as it was understood."""

    file: str
    kind: str
    kind_from: str
    sheets: tuple[SheetRead, ...]
    points: int
    marks: dict[str, int]
    codes: dict[str, int]
    quantities: tuple[Quantity, ...]
    problems: tuple[Problem, ...]
    of_folder: tuple[Problem, ...] = ()
    """What would be wrong with the folder if this were its only file."""


@dataclass(frozen=True)
class VehicleFinding:
    """One vehicle file as it was understood."""

    file: str
    name: str
    notes: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()


@dataclass
class Findings:
    """All that a check found, in the order in which it was asked."""

    vehicles: list[VehicleFinding] = field(default_factory=list)
    files: list[FileFinding] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)

    @cached_property
    def all_problems(self) -> tuple[Problem, ...]:
        """Every problem once, in the order found."""
        found = list(self.problems)
        for vehicle in self.vehicles:
            found += vehicle.problems
        for file in self.files:
            found += file.problems
        return tuple(dict.fromkeys([*found, *self._of_folders()]))

    def _of_folders(self) -> list[Problem]:
        """Return what is wrong with a folder read whole: what each of its files alone shows."""
        by_folder: dict[Path, list[FileFinding]] = {}
        for file in self.files:
            by_folder.setdefault(Path(file.file).parent, []).append(file)
        return [
            problem
            for folder, files in by_folder.items()
            if len(files) == sum(is_raw(path.name) for path in folder.iterdir())
            for problem in files[0].of_folder
            if all(problem in file.of_folder for file in files[1:])
        ]

    @property
    def failed(self) -> bool:
        """Whether anything was refused."""
        return any(problem.severity == "error" for problem in self.all_problems)


def check_paths(
    paths: Sequence[str],
    *,
    raw: Path,
    vehicle_file: Path | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> Findings:
    """Read everything that the paths name.

    Parameters
    ----------
    paths : sequence of str
        Raw files, folders of them, vehicle folders, or names of vehicles under `raw`.
    raw : Path
        The raw folder.
    vehicle_file : Path, optional
        The vehicle file to read by, instead of the one in the vehicle's folder.
    tell : callable
        Is told each file before it is read.

    Returns
    -------
    Findings
        What was understood and every problem.

    Raises
    ------
    UsageError
        When a path does not exist.
    """
    findings = Findings()
    reader = _Reader(findings, vehicle_file, tell)
    for text in paths:
        path = Path(text)
        if not path.exists() and (raw / text).exists():
            path = raw / text
        if not path.exists():
            raise UsageError(f'"{text}" does not exist, neither here nor under {raw}.')
        reader.read(path)
    return findings


class _Reader:
    def __init__(
        self, findings: Findings, vehicle_file: Path | None, tell: Callable[[str], None]
    ) -> None:
        self._findings = findings
        self._vehicle_file = vehicle_file
        self._tell = tell
        self._vehicles: dict[Path | None, Vehicle | None] = {}

    def read(self, path: Path) -> None:
        """Read a file, or everything in a folder."""
        before = len(self._findings.files) + len(self._findings.vehicles)
        if path.name == VEHICLE_FILE:
            self._vehicle(path)
        elif path.is_file():
            self._file(path)
        elif (path / VEHICLE_FILE).exists():
            self._vehicle(path / VEHICLE_FILE)
            folder = VehicleFolder(path.name, str(path))
            for kind in RAW_KINDS:
                shown = f"{folder.folder}/{kind}"
                self._findings.problems += folder.misnamed_problems(kind, shown)
                for file in folder.raw_files(kind):
                    self._file(Path(file))
        else:
            for inner in sorted(path.iterdir()):
                known = inner.name in RAW_KINDS or (inner / VEHICLE_FILE).exists()
                if (inner.is_dir() and known) or (inner.is_file() and is_raw(inner.name)):
                    self.read(inner)
        if before == len(self._findings.files) + len(self._findings.vehicles):
            self._findings.problems.append(
                Problem(
                    "error",
                    Place(str(path)),
                    "holds nothing to check.",
                    f"raw files, a folder of them ({', '.join(RAW_KINDS)}), or {VEHICLE_FILE}.",
                )
            )

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
            finding = VehicleFinding(str(path), vehicle.name, vehicle_notes(vehicle))
        self._findings.vehicles.append(finding)
        self._vehicles[path] = vehicle
        return vehicle

    def _vehicle_for(self, file: Path) -> Vehicle | None:
        if self._vehicle_file is not None:
            return self._vehicle(self._vehicle_file)
        for folder in (file.parent.parent, file.parent):
            if (folder / VEHICLE_FILE).exists():
                return self._vehicle(folder / VEHICLE_FILE)
        if None not in self._vehicles:
            self._vehicles[None] = Vehicle.model_validate(_STAND_IN)
            self._findings.problems.append(_STAND_IN_NOTE)
        return self._vehicles[None]

    def _file(self, path: Path) -> None:
        # a vehicle file that cannot be used has had its message; the raw file is read all the same
        vehicle = self._vehicle_for(path) or Vehicle.model_validate(_STAND_IN)
        self._tell(str(path))
        kind = path.parent.name
        if kind in READERS:
            self._findings.files.append(_finding(path, kind, "folder", vehicle))
            return
        tried = [_finding(path, kind, "content", vehicle) for kind in READERS]
        self._findings.files.append(max(tried, key=_how_well))


def _how_well(finding: FileFinding) -> tuple[bool, int, int]:
    """Rank readings of one file by different readers."""
    errors = sum(problem.severity == "error" for problem in finding.problems)
    return (errors == 0, finding.points - sum(finding.marks.values()), finding.points)


def _finding(path: Path, kind: str, kind_from: str, vehicle: Vehicle) -> FileFinding:
    shown = str(path)
    try:
        record = READERS[kind]((path,), vehicle, path.parent.parent)
    except InputError as error:
        return FileFinding(shown, kind, kind_from, (), 0, {}, {}, (), (error.problem,))
    own = [p for p in record.problems if Path(p.place.file).name == path.name]
    used = [point for point in record.points if not point.marks]
    marks = Counter(mark for point in record.points for mark in point.marks)
    codes = Counter(f"{point.code:g}" for point in used if hasattr(point, "code"))
    return FileFinding(
        shown,
        kind,
        kind_from,
        record.sheets,
        len(record.points),
        dict(sorted(marks.items())),
        dict(sorted(codes.items(), key=lambda item: float(item[0]))),
        _quantities(used),
        tuple(_with_path(problem, path) for problem in own),
        tuple(
            replace(problem, place=replace(problem.place, file=str(path.parent)))
            for problem in record.problems
            if problem not in own
        ),
    )


def _with_path(problem: Problem, path: Path) -> Problem:
    """Show the file as the user named it; records name it from the raw folder on."""
    return replace(problem, place=replace(problem.place, file=str(path)))


def _quantities(points: Sequence[object]) -> tuple[Quantity, ...]:
    found: dict[str, list[float]] = {}
    for point in points:
        for name, value in vars(point).items():
            if isinstance(value, float):
                found.setdefault(name, []).append(value)
    return tuple(
        Quantity(name, len(values), min(values), max(values)) for name, values in found.items()
    )
