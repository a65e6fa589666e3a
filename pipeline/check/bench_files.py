"""Read files of the bench: those of one kind in a folder together, the kind told if need be."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.check.findings import FileFinding, Quantity
from pipeline.errors import Problem
from pipeline.records.measurements import LoadTestPoint, MooringPoint, OpenWaterPoint, SheetRead
from pipeline.stages.bench_records import READERS
from pipeline.vehicle.schema import Vehicle

Point = LoadTestPoint | MooringPoint | OpenWaterPoint


@dataclass(frozen=True)
class RawFile:
    """A raw file to read; `kind` is empty until its content has told it."""

    path: Path
    kind: str
    kind_from: str
    vehicle: Vehicle


def kind_by_content(file: RawFile) -> str:
    """Return the kind whose reader understands most of a file."""
    return max(READERS, key=lambda kind: _how_well(read_together([replace(file, kind=kind)])[0][0]))


def _how_well(finding: FileFinding) -> tuple[bool, int, int]:
    """Rank readings of one file by different readers."""
    errors = sum(problem.severity == "error" for problem in finding.problems)
    return (errors == 0, finding.points - sum(finding.marks.values()), finding.points)


def read_together(files: Sequence[RawFile]) -> tuple[list[FileFinding], list[Problem]]:
    """Read files of one kind and folder; return each one's finding, and what is the folder's."""
    folder = files[0].path.parent
    paths = [file.path for file in files]
    record = READERS[files[0].kind](paths, files[0].vehicle, folder.absolute().parent.parent)
    by_name: dict[str, list[Problem]] = {path.name: [] for path in paths}
    of_folder: list[Problem] = []
    for problem in record.problems:
        by_name.get(Path(problem.place.file).name, of_folder).append(problem)
    points: dict[str, list[Point]] = {path.name: [] for path in paths}
    for point in record.points:
        points[point.source.file.rpartition("/")[2]].append(point)
    sheets: dict[str, list[SheetRead]] = {path.name: [] for path in paths}
    for sheet in record.sheets:
        sheets[sheet.file.rpartition("/")[2]].append(sheet)
    # what the only file lacks its folder lacks
    of_all = paths[0] if len(paths) == 1 else folder if folder.name else folder.absolute()
    return (
        [
            _finding(file, sheets[name], points[name], by_name[name])
            for file in files
            for name in (file.path.name,)
        ],
        [problem.shown_as(str(of_all)) for problem in of_folder],
    )


def _finding(
    file: RawFile, sheets: Sequence[SheetRead], points: Sequence[Point], problems: Sequence[Problem]
) -> FileFinding:
    used = [point for point in points if not point.marks]
    marks = Counter(mark for point in points for mark in point.marks)
    codes = Counter(code for point in used if (code := getattr(point, "code", None)) is not None)
    return FileFinding(
        str(file.path),
        file.kind,
        file.kind_from,
        tuple(sheets),
        len(points),
        dict(sorted(marks.items())),
        {f"{code:g}": count for code, count in sorted(codes.items())},
        _quantities(used),
        # as the user named it; records name it from the raw folder on
        tuple(problem.shown_as(str(file.path)) for problem in problems),
    )


def _quantities(points: Sequence[object]) -> tuple[Quantity, ...]:
    found: dict[str, list[float]] = {}
    for point in points:
        for name, value in vars(point).items():
            if isinstance(value, float):
                found.setdefault(name, []).append(value)
    return tuple(
        Quantity(name, len(values), min(values), max(values)) for name, values in found.items()
    )
