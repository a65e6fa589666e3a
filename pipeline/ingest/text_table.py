"""Tables in text files: encoding and delimiter found by looking, cells without a name told."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from io import StringIO

from pipeline.errors import InputError, Place, Problem, reason
from pipeline.ingest.blocks import is_commented
from pipeline.ingest.cells import Limits, Row, Sheet, is_number, is_text, shorten
from pipeline.ingest.rows import listed
from pipeline.ingest.vocabulary import read_unit_cell

_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_BINARY = re.compile("[\x00-\x08\x0e-\x1f\x7f\ufffd]")
_DECIMAL = re.compile(r"[+-]?\d+(?:,\d+)?")
_LOOKED_AT = 200
_MIXED = re.compile("[A-Za-z][\u0400-\u04ff]|[\u0400-\u04ff][A-Za-z]")
_CYRILLIC = re.compile("[\u0400-\u04ff]{2}")
_POINT = re.compile(r"\d\.\d|\d\.$|^\.\d")


def encoding_of(sample: bytes) -> str:
    """Tell the encoding of a text by its beginning.

    UTF-8 and UTF-16 with or without mark, or else Windows-1251, or 1252 where most letters that the
    former has beyond ASCII stand within Latin words.

    >>> [encoding_of(one) for one in ("Тяга".encode(), "Тяга, Н".encode("cp1251"),
    ...                               "Rückwärts".encode("cp1252"))]
    ['utf-8', 'cp1251', 'cp1252']
    """
    for mark, encoding in _MARKS:
        if sample.startswith(mark):
            return encoding
    head = sample[:4000]
    for at, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if head[at::2].count(0) > len(head) // 4:
            return encoding
    with suppress(UnicodeDecodeError):
        codecs.getincrementaldecoder("utf-8")().decode(sample)
        return "utf-8"
    text = sample.decode("cp1251", errors="replace")
    return "cp1252" if len(_MIXED.findall(text)) > len(_CYRILLIC.findall(text)) else "cp1251"


def _decode(data: bytes, place: Place) -> str:
    text: str | None = None
    with suppress(UnicodeDecodeError):
        text = data.decode(encoding_of(data))
    if text is None or _BINARY.search(text[:100_000]):
        raise InputError.at(
            place,
            "this is not a text file (unreadable characters in it).",
            expected="a table as text in UTF-8, UTF-16 or Windows-1251, or an .xlsx workbook.",
            remedy="Export it again as CSV or xlsx.",
        )
    return text


def read_text_table(data: bytes, place: Place, limits: Limits) -> Sheet:
    """Read a CSV, TSV or blank-separated table: cells are text as written, None where empty.

    Raises `InputError` for what is not text, HTML or XML, decimal commas that cannot be told from
    separators, and what is too large.
    """
    text = _decode(data, place)
    start = text.lstrip("\ufeff \t\r\n")[:200].lower()
    if start.startswith("<"):
        page = re.match(r"<(!doctype html|html|head|table|body|meta)", start)
        kind = "an HTML page" if page else "XML"
        raise InputError.at(
            place,
            f"this is {kind}, not a table of numbers.",
            expected="an .xlsx workbook or a CSV file.",
            remedy="Open it in a spreadsheet program and save it as .xlsx.",
        )
    delimiter = delimiter_of(text.splitlines()[:_LOOKED_AT])
    rows = _split(text, delimiter, place, limits)
    problems: tuple[Problem, ...] = _join_names(rows, place) if delimiter == "," else ()
    if delimiter is not None:
        problems += _check_width(rows, place, by_comma=delimiter == ",")
    return Sheet(place.file, None, tuple(rows), 1, problems)


def _split(text: str, delimiter: str | None, place: Place, limits: Limits) -> list[Row]:
    table: Iterable[list[str]]
    if delimiter is None:
        table = (_split_at_blanks(line) for line in text.splitlines())
    else:
        lines = StringIO(text, newline="")
        table = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
    rows: list[Row] = []
    cells = 0
    try:
        for fields in table:
            if delimiter is not None and any("\n" in field for field in fields):
                _refuse_swallowed_rows(fields, delimiter, Place(place.file, None, len(rows) + 1))
            row = tuple(field.strip() or None for field in fields)
            rows.append(row)
            cells += len(row)
            too_long = len(rows) > limits.max_rows or cells > limits.max_cells
            if too_long or len(row) > limits.max_columns:
                raise InputError.at(
                    place,
                    f"the table is too large (at row {len(rows)}).",
                    expected=f"at most {limits.max_rows} rows and {limits.max_columns} columns.",
                    remedy="Export it again in parts.",
                )
    except csv.Error as error:
        raise InputError.at(
            place,
            f"the table cannot be split into cells near row {len(rows) + 1}: {reason(error)}.",
            expected="one row a line, cells parted by semicolon, comma or tab.",
            remedy="Export it again as CSV or xlsx.",
        ) from error
    return rows


def _refuse_swallowed_rows(fields: list[str], delimiter: str, place: Place) -> None:
    """Refuse a cell that holds whole rows of numbers: its quotation mark was never closed."""
    for field in fields:
        for line in field.splitlines()[1:]:
            cells = line.split(delimiter)
            if len(cells) > 1 and sum(is_number(cell) for cell in cells) > len(cells) // 2:
                raise InputError.at(
                    place,
                    f'a quotation mark is not closed: the row "{shorten(line)}" stands within a '
                    "cell.",
                    expected="a quotation mark at the end of each cell that begins with one.",
                    remedy="Close or delete the quotation mark in this row.",
                )


def delimiter_of(lines: list[str]) -> str | None:
    """Return what parts the cells of most lines, None for blanks."""
    for delimiter in ("\t", ";", ",", "|"):
        counts = Counter(line.count(delimiter) for line in lines if line.strip())
        with_it = sum(count for number, count in counts.items() if number > 0)
        # A note with a semicolon here and there makes no table; most lines must have it.
        if with_it >= 0.6 * max(1, sum(counts.values())):
            if delimiter == "," and _blank_parted_decimals(lines):
                return None
            return delimiter
    return None


def _blank_parted_decimals(lines: list[str]) -> bool:
    """Tell whether the lines are numbers with decimal commas parted by blanks ("1,5  2,5")."""
    rows = [line.split() for line in lines if line.strip()]
    like = [row for row in rows if len(row) > 1 and all(_DECIMAL.fullmatch(cell) for cell in row)]
    return len(like) >= 0.6 * max(1, len(rows))


def _split_at_blanks(line: str) -> list[str]:
    numbers = line.split()
    if all(is_number(field) for field in numbers):
        return numbers
    # Names may hold single blanks ("Control code"), so names are parted by two.
    names = re.split(r"\s{2,}", line.strip())
    return names if len(names) > 1 else numbers


def _join_names(rows: list[Row], place: Place) -> tuple[Problem, ...]:
    """Put names together that were cut at a comma within them ("PWM, us"): they outnumber columns.

    A cell of a unit alone is the end of the name before it. Where that does not explain them all a
    name may stand over another column than its own, which is told.
    """
    widths = [(at, len(cells)) for at, cells in enumerate(rows)
              if len(cells) > 1 and 2 * sum(map(is_number, cells)) >= len(cells)]  # fmt: skip
    wide = max((width for _, width in widths), default=0)
    at = widths[0][0] - 1 if widths else -1
    while at > 0 and not any(cell and read_unit_cell(str(cell)) is None for cell in rows[at]):
        at -= 1  # a row of units
    if at < 0 or len(rows[at]) <= wide or not all(map(is_text, rows[at])):
        return ()
    names = [str(cell) for cell in rows[at]]
    tails = [cell for cell in names[1:] if read_unit_cell(cell) is not None]
    here = Place(place.file, None, at + 1)
    if len(tails) == len(names) - wide:
        joined = names[:1]
        for name in names[1:]:
            joined = [*joined[:-1], f"{joined[-1]}, {name}"] if name in tails else [*joined, name]
        rows[at] = tuple(joined)
        return (here.note(f"names were cut at their commas, and put together: {tails}."),)
    return (
        here.warning(
            f"{len(names)} names stand over {wide} columns: one may have been cut at a comma.",
            "a name over each column.",
            "Put names that hold a comma into quotation marks.",
        ),
    )


def _check_width(rows: Sequence[Row], place: Place, *, by_comma: bool) -> tuple[Problem, ...]:
    """Warn of rows of a whole table that have more numbers than there are names above them.

    Raises `InputError` where the comma is both the decimal sign and the separator: ``30,4,41``
    under two names. `by_comma` tells whether it parts the cells.
    """
    under_names = list(_rows_under_names(rows))
    wide = [(at, row, names) for at, row, names in under_names if any(map(is_number, row[names:]))]
    if not wide:
        return ()
    number, cells, names = wide[0]
    count = sum(cell is not None for cell in cells)
    pointless = not any(_POINT.search(str(cell)) for _, row, _ in under_names for cell in row)
    if by_comma and pointless and 2 * len(wide) > len(under_names):
        raise InputError.at(
            Place(place.file, None, number),
            f"{count} cells under {names} column names: the comma seems to be both the decimal "
            "sign and the separator.",
            expected="cells parted by semicolon or tab where numbers have decimal commas.",
            remedy="Export it again with another separator, or as xlsx.",
        )
    return (
        Place(place.file, None, number).warning(
            f"{count} cells under {names} column names; what stands beyond the last name was not "
            f"read ({listed([row for row, _, _ in wide])}).",
            "one number under each name.",
            "Name the column, or use one decimal sign and another separator.",
        ),
    )


def _rows_under_names(rows: Sequence[Row]) -> Iterator[tuple[int, Row, int]]:
    """Yield (row number, cells, number of columns that the names above reach over)."""
    width: int | None = None
    for number, cells in enumerate(rows, start=1):
        texts = [cell for cell in cells if isinstance(cell, str) and is_text(cell)]
        numbers = sum(is_number(cell) for cell in cells)
        if len(texts) >= 2 and len(texts) >= numbers:
            own = max(index for index, cell in enumerate(cells) if cell is not None) + 1
            are_units = all(read_unit_cell(text) is not None for text in texts)
            width = max(width, own) if are_units and width is not None else own
        elif numbers and width is not None and not is_commented(cells):
            yield number, cells, width
