"""One way to read the tests of a bench, whatever their kind: files, tables, readings, points."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import FoundTable, read_bench_file, source_name
from pipeline.ingest.blocks import Block
from pipeline.ingest.columns_stated import sheet_read
from pipeline.ingest.headers import Wanted
from pipeline.ingest.load_test_rows import RowWords
from pipeline.ingest.repeats import BenchTable, Repeats, without_copies
from pipeline.ingest.usable import with_cause
from pipeline.ingest.vocabulary import Vocabulary
from pipeline.records.measurements import (
    LoadTestPoint,
    MooringPoint,
    OpenWaterPoint,
    SheetRead,
)
from pipeline.vehicle.bench_schema import Column
from pipeline.vehicle.schema import Vehicle

Point = TypeVar("Point", LoadTestPoint, MooringPoint, OpenWaterPoint)


@dataclass(frozen=True)
class FileFound:
    """The tables of one file, for the functions of a kind, which add what is wrong."""

    path: Path
    place: Place
    tables: tuple[FoundTable, ...]
    vehicle: Vehicle
    problems: list[Problem]


@dataclass(frozen=True)
class Kind(Generic[Point]):
    """A kind of test: what its columns are, and how its tables become points.

    `name` is its section of vehicle.yaml, `noun` and `looked_for` are for messages.
    """

    name: str
    noun: str
    looked_for: str
    vocabulary: Vocabulary
    required: tuple[tuple[str, ...], ...]
    """Of each group at least one quantity must be there."""
    tables: Callable[[FileFound], list[BenchTable]]
    """Readings with codes and marks; none of a table that is left out."""
    points: Callable[[FileFound, Sequence[BenchTable]], list[tuple[Point, ...]]]
    """Points of each table."""
    summary: Callable[[BenchTable, Sequence[Point]], str]
    """A table with points in words."""
    remarks: Callable[[Place, Sequence[Point]], list[Problem]] = lambda *_: []
    """What is said once of the points of a file."""
    over_all: Callable[[Sequence[Point], Place, Vehicle], list[Problem]] = lambda *_: []
    """What only all files together show, by the points to be fitted."""
    row_words: Callable[[Block, Vehicle], RowWords] | None = None
    shared: frozenset[str] = frozenset()
    split_words: tuple[str, ...] = ()
    copies_by_row: bool = False


@dataclass(frozen=True)
class Measured(Generic[Point]):
    """What was read of the files of a folder."""

    points: tuple[Point, ...]
    sheets: tuple[SheetRead, ...]
    problems: tuple[Problem, ...]
    tables: tuple[BenchTable, ...]


def read_files(
    kind: Kind[Point], paths: Sequence[Path], vehicle: Vehicle, raw_root: Path
) -> Measured[Point]:
    """Read the files of a folder.

    A file or table that cannot be read becomes a problem of severity "error"; the others are read.
    """
    columns = getattr(vehicle.columns, kind.name)
    stated = {name: getattr(columns, name) for name in type(columns).model_fields}
    wanted = Wanted(
        kind.vocabulary,
        required=kind.required,
        kind=kind.name,
        mapping={name: one for name, one in stated.items() if isinstance(one, Column)},
        only=columns.only,
        shared=kind.shared,
        split_words=kind.split_words,
    )
    points: list[Point] = []
    sheets: list[SheetRead] = []
    tables: list[BenchTable] = []
    repeats = Repeats(by_row=kind.copies_by_row)
    kept, problems = without_copies(paths, [source_name(path, raw_root) for path in paths])
    for path in kept:
        shown_as = source_name(path, raw_root)
        words = None if kind.row_words is None else _of_vehicle(kind.row_words, vehicle)
        found = read_bench_file(path, shown_as, wanted, columns, kind.looked_for, words_of=words)
        file: FileFound = FileFound(
            path, Place(shown_as), found.tables, vehicle, list(found.problems)
        )
        own_tables = repeats.marked(kind.tables(file), file.problems)
        of_tables = kind.points(file, own_tables)
        for one, table, measured in zip(found.tables, own_tables, of_tables, strict=True):
            said = kind.summary(table, measured) if measured else "left out"
            sheets.append(sheet_read(one.block, columns, len(one.readings), said))
        own: list[Point] = [point for measured in of_tables for point in measured]
        marks = [point.marks for point in own]
        points += own
        tables += own_tables
        if found.is_blank:
            problems.extend(file.problems)
        else:
            problems.extend(with_cause(file.problems, shown_as, marks, kind.noun))
        problems.extend(kind.remarks(file.place, own))
    fitted = [point for point in points if not point.marks]
    if fitted:
        folder = Place(source_name(min(paths).parent, raw_root))
        problems += kind.over_all(fitted, folder, vehicle)
    return Measured(tuple(points), tuple(sheets), tuple(dict.fromkeys(problems)), tuple(tables))


def _of_vehicle(
    row_words: Callable[[Block, Vehicle], RowWords], vehicle: Vehicle
) -> Callable[[Block], RowWords]:
    return lambda block: row_words(block, vehicle)
