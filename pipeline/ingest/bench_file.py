"""What the readers of bench tables share: a file's tables, their rows, what is wrong."""

import hashlib
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Literal

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.blank_form import is_blank_form, no_data_yet
from pipeline.ingest.blocks import Block, is_commented, without_comment_mark
from pipeline.ingest.cells import NotANumberError, are_spoilt, is_number, shorten
from pipeline.ingest.formulas import with_one_cause
from pipeline.ingest.headers import BlockSearch, Wanted, choose_sheets, find_blocks, names_seen
from pipeline.ingest.rows import listed
from pipeline.ingest.sheet import Row, Sheet
from pipeline.ingest.statistics_rows import STATISTICS, is_statistics, statistics_problems
from pipeline.ingest.vocabulary import split_header, unit_told_by_name
from pipeline.ingest.workbook import read_sheets
from pipeline.vehicle.bench_schema import BenchColumns, Column

COMMENTED = "commented out"
#: A table that lies on its side has a row for each quantity.
_MOST_TURNED_ROWS = 40
#: In the units of the records (N, N m, rpm, us ...); keeps every later product finite, too.
_LARGEST = 1e9
#: What a person sets on a bench; it may hold for several rows.
_SET = frozenset({"code", "pwm", "voltage", "advance_ratio", "speed", "time"})
_COMMAND = ("code", "pwm")
_WORDS = frozenset({"branch", "status"})
_DAY_S = 86_400.0
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[ T])?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?")


@dataclass(frozen=True)
class Reading:
    """One row: numbers by quantity, in the units of the records, signs of the mapping applied."""

    row: int
    values: Mapping[str, float]
    marks: tuple[str, ...] = ()
    branch: Literal["loading", "unloading"] | None = None

    def marked(self, *marks: str) -> "Reading":
        """Return the reading with more marks, each once."""
        both = tuple(dict.fromkeys((*self.marks, *marks)))
        return Reading(self.row, self.values, both, self.branch)

    def with_values(self, **values: float) -> "Reading":
        """Return the reading with other numbers; adding 0.0 turns -0.0 into 0.0."""
        given = {name: value + 0.0 for name, value in values.items()}
        return Reading(self.row, {**self.values, **given}, self.marks, self.branch)


@dataclass(frozen=True)
class BenchFile:
    """The tables of one file with their readings, and every problem met."""

    tables: tuple[tuple[Block, tuple[Reading, ...]], ...]
    problems: tuple[Problem, ...]
    is_blank: bool = False
    """Whether it is a form that nobody has filled in yet."""


def source_name(path: Path, raw_root: Path) -> str:
    """Return a file's name in sources and messages: relative to the raw folder if it is in it.

    >>> source_name(Path("/a/raw/mmt300/mooring/run-1.xlsx"), Path("/a/raw"))
    'mmt300/mooring/run-1.xlsx'
    >>> source_name(Path("/b/run-1.xlsx"), Path("/a/raw"))
    'run-1.xlsx'
    """
    try:  # links are not followed: what counts is where the engineer put the file
        return path.absolute().relative_to(raw_root.absolute()).as_posix()
    except ValueError:
        return path.name


def without_copies(paths: Sequence[Path], raw_root: Path) -> tuple[list[Path], list[Problem]]:
    """Leave out files that are byte for byte a copy of an earlier one.

    Parameters
    ----------
    paths : sequence of Path
        Files; one that cannot be read is kept, its reader will say why.
    raw_root : Path
        For the names in messages.

    Returns
    -------
    list of Path
        Files to read.
    list of Problem
        A warning for each copy: its points would count twice.
    """
    kept: list[Path] = []
    problems: list[Problem] = []
    first: dict[str, Path] = {}
    for path in paths:
        try:
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError:
            kept.append(path)
            continue
        if first.setdefault(digest, path) is path:
            kept.append(path)
            continue
        what = f"the same content as {source_name(first[digest], raw_root)}; left out."
        place = Place(source_name(path, raw_root))
        problems.append(Problem("warning", place, what, "", "Delete the copy."))
    return kept, problems


def mapped_columns(columns: BenchColumns) -> dict[str, Column]:
    """Return the columns that vehicle.yaml states, by quantity."""
    return {
        name: column
        for name in type(columns).model_fields
        if isinstance(column := getattr(columns, name), Column)
    }


def sheets_of(path: Path, shown_as: str) -> tuple[Sheet, ...] | Problem:
    """Read the sheets of a file, or say why not; whatever is in it, the other files go on."""
    try:
        return read_sheets(path, shown_as)
    except InputError as error:
        return error.problem
    except Exception as error:  # noqa: BLE001 - a broken file may do anything to a library
        what = f"the file cannot be read ({type(error).__name__}: {shorten(str(error))})."
        remedy = "Save it again in a spreadsheet program."
        return Problem("error", Place(shown_as), what, "", remedy)


def _no_rows(block: Block) -> Collection[int]:  # noqa: ARG001
    return ()


def read_bench_file(
    path: Path,
    shown_as: str,
    wanted: Wanted,
    columns: BenchColumns,
    looked_for: str,
    *,
    headings_of: Callable[[Block], Collection[int]] = _no_rows,
) -> BenchFile:
    """Read every table of one file; never raises for what is in it.

    Parameters
    ----------
    path : Path
        The file.
    shown_as : str
        Its name in messages and sources.
    wanted : Wanted
        Quantities to look for.
    columns : BenchColumns
        What vehicle.yaml states: sheets, and texts of rows to keep.
    looked_for : str
        The required columns in words, for the message that there are none.
    headings_of : callable
        Rows of a table that are headings although they hold numbers ("Code: 90").

    Returns
    -------
    BenchFile
        Tables with at least one row.
    """
    problems: list[Problem] = []
    tables: list[tuple[Block, tuple[Reading, ...]]] = []
    missed: list[tuple[Sheet, str]] = []
    wrong: Sequence[Problem]
    sheets = sheets_of(path, shown_as)
    if isinstance(sheets, Problem):
        return BenchFile((), (sheets,))
    if is_blank_form(sheets):
        return BenchFile((), (no_data_yet(shown_as),), is_blank=True)
    kept, wrong = choose_sheets(sheets, columns.sheets, wanted.kind)
    problems += wrong
    for given in kept:
        problems += given.problems
        sheet, search = search_sheet(given, wanted)
        problems += search.problems
        if not search.blocks and not search.problems and (instead := _instead(sheet)):
            missed.append((sheet, instead))
        for block in search.blocks:
            problems += _assumed_units(block, wanted)
            readings, wrong = _readings(block, wanted, headings_of(block))
            problems += wrong
            if readings:
                tables.append((block, readings))
    if tables or any(problem.severity == "error" for problem in problems):
        for sheet, instead in missed:
            what = f"no {looked_for} here; the sheet was not read. It has {instead}."
            problems.append(Problem("note", sheet.place(), what))
    else:
        problems.append(_nothing(shown_as, wanted, looked_for, missed))
    return BenchFile(tuple(tables), tuple(with_one_cause(problems)))


def search_sheet(sheet: Sheet, wanted: Wanted) -> tuple[Sheet, BlockSearch]:
    """Find the tables of a sheet; one that has its names in a column is turned first."""
    search = find_blocks(sheet, wanted)
    if search.blocks or search.problems or not 1 < len(sheet.rows) <= _MOST_TURNED_ROWS:
        return sheet, search
    turned = sheet.turned()
    found = find_blocks(turned, wanted)
    if not found.blocks:
        return sheet, search
    what = "the names stand in a column: the table is read turned, so that rows are its columns."
    note = Problem("note", sheet.place(), what)
    return turned, BlockSearch(found.blocks, (note, *found.problems))


def _instead(sheet: Sheet) -> str:
    """Say what a sheet without a table holds."""
    if names := names_seen(sheet):
        return names
    numbers = sum(is_number(cell) for cells in sheet.rows for cell in cells)
    return f"no column names over its {numbers} numbers" if numbers else ""


def _nothing(
    shown_as: str, wanted: Wanted, looked_for: str, missed: Sequence[tuple[Sheet, str]]
) -> Problem:
    if wanted.only:
        rows = ", ".join(f'{header} = "{text}"' for header, text in wanted.only.items())
        return Problem(
            "error",
            Place(shown_as),
            f"no row left by columns: {wanted.kind}: only: {rows}.",
            "rows with this text.",
            "Correct it in vehicle.yaml.",
        )
    it_has = "; ".join(
        instead if sheet.name is None else f'"{sheet.name}" has {instead}'
        for sheet, instead in missed
    )
    return Problem(
        "error",
        Place(shown_as),
        f"no {looked_for} found on any sheet{it_has and f': {it_has}'}.",
        "a row of column names over the numbers, in English or Russian.",
        f"Name the columns, or state them in vehicle.yaml by name or by letter:\n  columns:\n"
        f'    {wanted.kind}:\n      {wanted.required[0][0]}: {{header: "column A"}}',
    )


def _assumed_units(block: Block, wanted: Wanted) -> list[Problem]:
    """Say which units were assumed without a word for them in the header."""
    notes = []
    for quantity, column in block.columns.items():
        words = wanted.vocabulary[quantity]
        told = any(unit_told_by_name(header, words) for header in split_header(column.header))
        if column.unit and column.unit_from == "assumed" and not told and column.unit != "1":
            what = (
                f'{quantity.replace("_", " ")} "{shorten(column.header)}": no unit is stated, '
                f"{column.unit} is assumed."
            )
            notes.append(Problem("note", block.place(block.header_row, quantity), what))
    return notes


def _readings(
    block: Block, wanted: Wanted, headings: Collection[int]
) -> tuple[tuple[Reading, ...], list[Problem]]:
    """Read the rows of a table; rows without any required number are headings or blank."""
    readings: list[Reading] = []
    odd: dict[str, list[tuple[int, str]]] = defaultdict(list)
    empty: dict[str, list[int]] = defaultdict(list)
    statistics: list[int] = []
    seen: set[str] = set()
    rows = list(block.rows())
    if not rows:
        return (), []  # no row has the texts that vehicle.yaml asks for
    required = wanted.required
    if not block.columns.keys().isdisjoint(_COMMAND):  # a table that has commands has one a row
        required = tuple(dict.fromkeys((_COMMAND, *required)))
    for row, cells in (one for one in rows if one[0] not in headings):
        commented = is_commented(cells)
        given = without_comment_mark(cells) if commented else cells
        values, faults = row_numbers(block, row, given, block.columns)
        # a code in merged cells goes on over the blank rows under a table
        is_bare = all(block.is_merged_over(row, quantity) for quantity in values)
        if is_bare and (commented or not is_spoilt(block, cells, faults)):
            continue  # a heading, a note or a blank row
        seen |= set(values)
        complete = all(any(name in values for name in group) for group in required)
        sums_up = not commented and is_statistics(block, cells)
        marks = (COMMENTED,) * commented + (STATISTICS,) * sums_up
        statistics += [row] * sums_up
        if complete:
            readings.append(Reading(row, values, marks))
        if marks:
            continue
        for quantity, fault in faults.items():
            odd[quantity].append((row, fault))
        if values and not complete:
            for quantity in _absent(block, required, values.keys() | faults.keys()):
                empty[quantity].append(row)
    problems = _faults(block, wanted, odd, empty, seen)
    problems += [*_commented_out(block, readings), *statistics_problems(block, statistics)]
    return tuple(readings), problems


def _commented_out(block: Block, readings: Sequence[Reading]) -> list[Problem]:
    rows = [one.row for one in readings if COMMENTED in one.marks]
    if not rows:
        return []
    what = f'commented out with "#": {listed(rows)}; kept but not fitted.'
    return [Problem("note", block.place(rows[0]), what)]


def is_spoilt(block: Block, cells: Row, faults: Iterable[str]) -> bool:
    """Tell whether a row without a number was one of numbers, by the cells that are at fault."""
    columns = [block.columns[quantity].index for quantity in faults]
    return are_spoilt([cells[index] for index in columns if index < len(cells)])


def row_numbers(
    block: Block, row: int, cells: Row, quantities: Iterable[str]
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the numbers of a row by quantity, and what is wrong with the other cells.

    What is set may stand in cells merged over several rows; what is measured is one reading, of
    the first of them.
    """
    values: dict[str, float] = {}
    faults: dict[str, str] = {}
    # in a towing tank the shaft speed is set, too
    held = _SET | {"shaft_speed"} if "speed" in block.columns else _SET
    for quantity in quantities:
        if quantity in _WORDS:
            continue
        try:
            value = block.value(cells, quantity)
        except NotANumberError as error:
            value = None
            if quantity == "time":  # a clock that was not set is no fault
                value = _clock_s(block.text(cells, quantity) or "")
            else:
                faults[quantity] = str(error)
        if value is None:
            continue
        if quantity not in held and block.is_merged_over(row, quantity):
            faults[quantity] = "stands in a cell that is merged with the one above"
        elif abs(value) > _LARGEST and quantity != "time":
            faults[quantity] = f"{value:.3g} is beyond anything a bench measures"
        else:
            values[quantity] = value
    return values, faults


def _clock_s(text: str) -> float | None:
    """Return the seconds of a clock, of a date since the year 1; None where it was not set."""
    clock = _CLOCK.search(text)
    if clock is None:
        return None
    try:
        day = datetime.fromisoformat(clock[1]).toordinal() if clock[1] else 0
    except ValueError:
        return None  # e.g. 0000-00-00
    seconds = float((clock[4] or "0").replace(",", "."))
    return day * _DAY_S + int(clock[2]) * 3600.0 + int(clock[3]) * 60.0 + seconds


def _absent(block: Block, required: Sequence[Sequence[str]], there: AbstractSet[str]) -> list[str]:
    """Return a required quantity of each group of which nothing is there."""
    groups = [[name for name in group if name in block.columns] for group in required]
    return [group[0] for group in groups if group and not there & set(group)]


def _faults(
    block: Block,
    wanted: Wanted,
    odd: Mapping[str, Sequence[tuple[int, str]]],
    empty: Mapping[str, Sequence[int]],
    seen: set[str],
) -> list[Problem]:
    problems: list[Problem] = []
    for quantity, column in block.columns.items():
        if quantity in seen or quantity in _WORDS or quantity == "time":
            continue
        needed = any(
            quantity in group and not seen.intersection(group) for group in wanted.required
        )
        left_out = "the table was left out" if needed else "the column was left out"
        why = f" ({odd[quantity][0][1]})" if odd.get(quantity) else ""
        # a column that may be left away may be left blank, too
        optional: Literal["note", "warning"] = "note" if block.is_blank(quantity) else "warning"
        problems.append(
            Problem(
                "error" if needed else optional,
                block.place(block.header_row, quantity),
                f'{_name(quantity)} "{shorten(column.header)}" holds no number at all{why}; '
                f"{left_out}.",
                "decimal numbers.",
                "Export the file again; formulas need their stored results.",
            )
        )
    for quantity, faults in odd.items():
        if quantity not in seen:
            continue
        rows = [row for row, _ in faults]
        first = faults[0][1]
        needed = any(quantity in group for group in wanted.required)
        many = f" ({listed(rows)})" if len(rows) > 1 else ""
        left_out = "" if needed else " The rest of the row was read."
        problems.append(
            Problem(
                "warning",
                block.place(rows[0], quantity),
                f"{_name(quantity)} {first}{many}.{left_out}",
                f"a decimal number (point or comma), {block.columns[quantity].unit_stated()}.",
                'Fix the cell, or mark the row with "#" in column A to leave it out.',
            )
        )
    for quantity, blank in empty.items():
        if quantity not in seen:
            continue
        problems.append(
            Problem(
                "warning",
                block.place(blank[0], quantity),
                f"{_name(quantity)} is empty in {listed(blank)}; left out.",
                "a decimal number.",
                'Fill the cell, or mark the row with "#" in column A.',
            )
        )
    return problems


def _name(quantity: str) -> str:
    return quantity.replace("_", " ")
