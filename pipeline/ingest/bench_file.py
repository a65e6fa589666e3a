"""The tables of a bench file with their readings, and what is wrong with the file."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.errors import InputError, Place, Problem, reason
from pipeline.ingest.bench_table import RowWords, Table
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import Sheet, column_index, is_number, is_text, shorten
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.headers import BlockSearch, find_blocks, names_seen
from pipeline.ingest.readings import readings_of
from pipeline.ingest.row_directions import tells_direction
from pipeline.ingest.rows import listed
from pipeline.ingest.stated_columns import choose_sheets
from pipeline.ingest.vocabulary import (
    HeaderText,
    is_other,
    split_header,
    unit_told_by_name,
    words_of,
)
from pipeline.vehicle.bench_schema import FORM_MARK
from pipeline.vehicle.schema import Vehicle

#: Opens a file by its path, its name in messages and its vehicle, as sheets.
SheetReader = Callable[[Path, str, Vehicle], tuple[Sheet, ...]]
#: A table that lies on its side has a row for each quantity.
_MOST_TURNED_ROWS = 40
#: Columns that say of single rows what they are worth; of one row in so many at most.
_REMARKS, _FEW = words_of("groups", "remarks") + words_of("groups", "valid"), 4
_MOST_TEXTS = 200


@dataclass
class BenchFile:
    """The tables of one file, each with at least one reading, and every problem met."""

    path: Path
    place: Place
    vehicle: Vehicle
    tables: list[Table] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    is_blank: bool = False
    """Whether it is a form that nobody has filled in yet."""
    told_apart_by: frozenset[str] = frozenset()
    """Words of a direction in its name where another file has the opposite one."""


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


def read_bench_file(
    file: BenchFile,
    wanted: Wanted,
    looked_for: str,
    row_words: Callable[[Block, Vehicle], RowWords],
    sheets_of: SheetReader,
) -> None:
    """Read every table of one file; never raises for what is in it.

    `looked_for` are the required columns in words. `row_words` reads the words between the rows of
    a load test, some of which are headings with numbers ("Code: 90"). `sheets_of` opens the file.
    """
    problems = file.problems
    missed: list[tuple[Sheet, str]] = []
    try:
        sheets = sheets_of(file.path, file.place.file, file.vehicle)
    except InputError as error:
        problems.append(error.problem)
        return
    except Exception as error:  # noqa: BLE001 - a broken file may do anything to a library
        what = f"the file cannot be read ({type(error).__name__}: {reason(error, 60)})."
        problems.append(file.place.error(what, "", "Save it again in a spreadsheet program."))
        return
    rows = [row for sheet in sheets for row in sheet.rows]
    # saved as text, the heading may have been parted at its blanks
    texts = (" ".join(cell for cell in row if isinstance(cell, str)) for row in rows)
    if any(FORM_MARK in one for one in texts) and not any(
        is_number(c) for row in rows for c in row
    ):
        remedy = "Fill in rows under the units, or delete the file if there is no such test."
        problems.append(file.place.note("no data yet: the form is still blank.", "", remedy))
        file.is_blank = True
        return
    kept, wrong = choose_sheets(sheets, wanted.sheets, wanted.kind)
    problems += wrong
    for given in kept:
        problems += given.problems
        sheet, search = _search_sheet(given, wanted)
        problems += search.problems
        if not search.blocks and not search.problems:
            cells = sum(is_number(cell) for cells in sheet.rows for cell in cells)
            bare = f"no column names over its {cells} numbers" if cells else ""
            missed += [(sheet, one) for one in [names_seen(sheet) or bare] if one]
        for block in search.blocks:
            problems += [*_assumed_units(block, wanted), *_told_apart(block)]
            words = row_words(block, file.vehicle)
            readings = readings_of(block, wanted, words.headings, problems)
            if readings:
                table = Table(block, wanted.kind, file.vehicle, readings, problems, words)
                table.told_apart_by = file.told_apart_by
                file.tables.append(table)
    if file.tables or any(problem.severity == "error" for problem in problems):
        for sheet, instead in missed:
            what = f"no {looked_for} here; the sheet was not read. It has {instead}."
            problems.append(sheet.place().note(what))
    else:
        problems.append(_nothing(file.place, wanted, looked_for, missed))


def _search_sheet(sheet: Sheet, wanted: Wanted) -> tuple[Sheet, BlockSearch]:
    """Find the tables of a sheet; one that has its names in a column is turned first."""
    search = find_blocks(sheet, wanted)
    if search.blocks or search.problems or not 1 < len(sheet.rows) <= _MOST_TURNED_ROWS:
        return sheet, search
    turned = sheet.turned()
    found = find_blocks(turned, wanted)
    if not found.blocks:
        return sheet, search
    what = "the names stand in a column: the table is read turned, so that rows are its columns."
    note = sheet.place().note(what)
    return turned, BlockSearch(found.blocks, (note, *found.problems))


def _nothing(
    place: Place, wanted: Wanted, looked_for: str, missed: Sequence[tuple[Sheet, str]]
) -> Problem:
    if wanted.only:
        rows = ", ".join(f'{header} = "{text}"' for header, text in wanted.only.items())
        what = f"no row left by columns: {wanted.kind}: only: {rows}."
        return place.error(what, "rows with this text.", "Correct it in vehicle.yaml.")
    it_has = "; ".join(
        instead if sheet.name is None else f'"{sheet.name}" has {instead}'
        for sheet, instead in missed
    )
    return place.error(
        f"no {looked_for} found on any sheet: {it_has}."
        if it_has
        else f"no {looked_for} found on any sheet.",
        "a row of column names over the numbers, in English or Russian.",
        f"Name the columns, or state them in vehicle.yaml by name or by letter:\n  columns:\n"
        f'    {wanted.kind}:\n      {wanted.required[0][0]}: {{header: "column A"}}',
    )


def _told_apart(block: Block) -> Iterator[Problem]:
    """Say which rows words set apart, and that all of them were read.

    A column of remarks or of validity speaks of a few rows; one that has a text in every row, and
    not one of its own in each, is of several machines or settings.
    """
    rows, is_told = block.rows_of_numbers(), bool(block.only)
    for column in block.columns_not_used(None):
        index = column_index(column.column)
        texts = block.texts_in(rows, index)
        usual, _ = (
            Counter(texts.get(row, "") for row in rows).most_common(1)[0] if rows else ("", 0)
        )
        odd = [row for row in rows if texts.get(row, "") != usual]
        place, header = block.sheet.place(None, column.column), shorten(column.header, 30)
        if is_other(HeaderText(column.header), _REMARKS):
            if 0 < _FEW * len(odd) <= len(rows):
                said = shorten(texts.get(odd[0], ""))
                yield replace(place, row=odd[0]).warning(
                    f'"{header}" says "{said}" of {listed(odd)}, which were read as the others.',
                    "rows that may all be fitted.",
                    'Mark those with "#" in column A that are not to be fitted.',
                )
        elif (
            not is_told
            and len(texts) == len(rows)
            and all(map(is_text, texts.values()))
            and 1 < len(set(texts.values())) <= min(_MOST_TEXTS, len(rows) // 2)
            and not tells_direction(column.header, texts.values())
        ):
            is_told = True
            yield replace(place, row=block.header_row).warning(
                f'column "{header}" has {len(set(texts.values()))} different texts: the rows may '
                "be of several machines, and were all read.",
                "the readings of one machine.",
                f'Choose in vehicle.yaml: columns: {{...: {{only: {{"{header}": ...}}}}}}.',
            )


def _assumed_units(block: Block, wanted: Wanted) -> Iterator[Problem]:
    """Say which units were assumed without a word for them in the header."""
    for quantity, column in block.columns.items():
        words = wanted.vocabulary[quantity]
        told = any(unit_told_by_name(header, words) for header in split_header(column.header))
        if column.unit and column.unit_from == "assumed" and not told and column.unit != "1":
            yield block.place(block.header_row, quantity).note(
                f'{quantity.replace("_", " ")} "{shorten(column.header)}": no unit is stated, '
                f"{column.unit} is assumed."
            )
