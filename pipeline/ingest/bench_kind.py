"""One way to read the tests of a bench, whatever their kind: files, tables, readings, points."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import BenchFile, SheetReader, read_bench_file, source_name
from pipeline.ingest.bench_table import RowWords, Table
from pipeline.ingest.blocks import Block, BlockColumn
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.log_files import is_log_anywhere
from pipeline.ingest.row_directions import directions_of, reverse_texts, words_apart
from pipeline.ingest.rows import with_cause
from pipeline.ingest.tables_agree import CONTRADICTS, Copies, Curves, disagreement
from pipeline.ingest.workbook import read_sheets
from pipeline.records.measurements import LoadTestPoint, MooringPoint, OpenWaterPoint, SheetRead
from pipeline.vehicle.bench_schema import Column, Columns, LoadTestColumns, MooringColumns
from pipeline.vehicle.schema import Vehicle

Point = TypeVar("Point", LoadTestPoint, MooringPoint, OpenWaterPoint)


@dataclass(frozen=True)
class Kind(Generic[Point]):
    """A kind of test: what its columns are, in words, too, and how its tables become points."""

    wanted: Wanted
    looked_for: str
    points: Callable[[BenchFile], list[tuple[Point, ...]]]
    """Points of each table."""
    summary: Callable[[Table, Sequence[Point]], str]
    """A table with points in words."""
    steps: Callable[[BenchFile], None] = lambda _: None
    """Tells codes and marks of the readings of all tables."""
    remarks: Callable[[Place, Sequence[Point]], Iterable[Problem]] = lambda *_: ()
    """What is said once of the points of a file."""
    over_all: Callable[[Sequence[Point], Place, Vehicle], Iterable[Problem]] = lambda *_: ()
    """What only all files together show, by the points to be fitted."""
    compared: tuple[str, Callable[[Sequence[Point]], Curves]] = ("", lambda _: {})
    """What tables of a folder must agree in, and that of a table by its points to be fitted."""
    row_words: Callable[[Block, Vehicle], RowWords] = lambda *_: RowWords()
    sheets: SheetReader = lambda path, shown_as, _: read_sheets(path, shown_as)


@dataclass(frozen=True)
class Measured(Generic[Point]):
    """What was read of the files of a folder."""

    points: tuple[Point, ...]
    sheets: tuple[SheetRead, ...]
    problems: tuple[Problem, ...]
    tables: tuple[Table, ...]


def read_files(
    kind: Kind[Point], paths: Sequence[Path], vehicle: Vehicle, raw_root: Path
) -> Measured[Point]:
    """Read the files of a folder.

    A file or table that cannot be read becomes a problem of severity "error"; the others are read.
    """
    # `columns:` states those of workbooks; the quantities of a log are known
    of_logs = vehicle.model_copy(update={"columns": Columns()})
    sheets: list[SheetRead] = []
    tables: list[Table] = []
    by_table: list[tuple[Point, ...]] = []
    problems: list[Problem] = []
    copies = Copies()
    for path in paths:
        own_vehicle = of_logs if is_log_anywhere(path.name) else vehicle
        file: BenchFile = BenchFile(path, Place(source_name(path, raw_root)), own_vehicle)
        file.told_apart_by = words_apart(path.stem, [one.stem for one in paths])
        wanted = _wanted(kind, own_vehicle)
        read_bench_file(file, wanted, kind.looked_for, kind.row_words, kind.sheets)
        kind.steps(file)
        copies.mark(file.tables)
        of_tables = kind.points(file)
        for table, measured in zip(file.tables, of_tables, strict=True):
            said = kind.summary(table, measured) if measured else "left out"
            sheets.append(_sheet_read(table, said))
        own: list[Point] = [point for measured in of_tables for point in measured]
        tables += file.tables
        by_table += of_tables
        told: list[Problem] = file.problems
        if not file.is_blank:
            told = with_cause(told, file.place, [point.marks for point in own], kind.wanted.kind)
        problems += [*told, *kind.remarks(file.place, own)]
    compared, curves = kind.compared
    live = [[point for point in own if not point.marks] for own in by_table]
    doubts, apart = disagreement(tables, list(map(curves, live)), compared)
    problems += doubts
    points: list[Point] = []
    for at, read in enumerate(by_table):
        points += map(_contradicting, read) if at in apart else read
    fitted = [point for point in points if not point.marks]
    if fitted:
        folder = Place(source_name(min(paths).parent, raw_root))
        problems += kind.over_all(fitted, folder, vehicle)
    return Measured(tuple(points), tuple(sheets), tuple(dict.fromkeys(problems)), tuple(tables))


def _contradicting(point: Point) -> Point:
    return point.model_copy(update={"marks": (*point.marks, CONTRADICTS)})


def _wanted(kind: Kind[Point], vehicle: Vehicle) -> Wanted:
    columns = getattr(vehicle.columns, kind.wanted.kind)
    stated = {name: getattr(columns, name) for name in type(columns).model_fields}
    mapping = {name: one for name, one in stated.items() if isinstance(one, Column)}
    return replace(kind.wanted, mapping=mapping, only=columns.only, sheets=columns.sheets)


def _sheet_read(table: Table, summary: str) -> SheetRead:
    """Tell what was read of a table, which columns are not used, and what would state the others.

    What its section of vehicle.yaml states already is repeated as it is.
    """
    block, columns = table.block, getattr(table.vehicle.columns, table.kind)
    lines = [
        (name, _line(column, getattr(columns, name)))
        for name, column in block.columns.items()
        if name in type(columns).model_fields
    ]
    at = None
    if isinstance(columns, (LoadTestColumns, MooringColumns)):
        found = directions_of(block, block.rows_of_numbers(), columns.direction, table.kind)
        at = found.column if found.signs else None
        if at is not None:
            head = block.sheet.cell(block.header_row, at)
            back = ", ".join(map(_quoted, reverse_texts(block, found)))
            lines.append(("direction", f"{{header: {_quoted(str(head))}, reverse: [{back}]}}"))
    return SheetRead(
        file=block.sheet.file,
        sheet=block.sheet.name,
        rows=table.rows_read,
        columns=tuple(column.as_record() for column in block.columns.values()),
        summary=summary,
        not_used=block.columns_not_used(at),
        stated_as=() if is_log_anywhere(block.sheet.file) else tuple(lines),
    )


def _quoted(text: str) -> str:
    r"""Return a text as YAML has it in double quotes.

    >>> print(_quoted('a "b"'))
    "a \"b\""
    """
    escaped = " ".join(text.split()).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _line(column: BlockColumn, stated: Column | None) -> str:
    parts = [f"header: {_quoted(column.header)}"]
    if column.unit and column.unit != "1":
        parts.append(f"unit: {_quoted(column.unit)}")
    if column.sign < 0:
        parts.append("sign: -1")
    if stated is not None:
        parts += [f"scale: {stated.scale:g}"] if stated.scale != 1.0 else []
        parts += [f"pole_pairs: {stated.pole_pairs}"] if stated.pole_pairs is not None else []
        plus = ", ".join(map(_quoted, stated.plus))
        parts += [f"plus: [{plus}]"] if plus else []
    return "{" + ", ".join(parts) + "}"
