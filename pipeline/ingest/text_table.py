"""Tables in text files: encoding and delimiter found by looking."""

import csv
import re
from collections import Counter
from collections.abc import Iterable
from io import StringIO

from pipeline.errors import InputError, Place
from pipeline.ingest.cells import is_number, is_text
from pipeline.ingest.sheet import Limits, Row, Sheet

_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_BINARY = re.compile("[\x00-\x08\x0e-\x1f\x7f\ufffd]")
_DECIMAL = re.compile(r"[+-]?\d+(?:,\d+)?")
_LOOKED_AT = 200


def decode(data: bytes, place: Place) -> str:
    """Decode a text file: UTF-8 and UTF-16 with or without mark, else Windows-1251.

    Raises
    ------
    InputError
        The file is not text.
    """
    text: str | None = None
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            text = _try(data, encoding)
            break
    else:
        sample = data[:4000]
        if sample[1::2].count(0) > len(sample) // 4:
            text = _try(data, "utf-16-le")
        elif sample[0::2].count(0) > len(sample) // 4:
            text = _try(data, "utf-16-be")
        else:
            text = _try(data, "utf-8")
            text = text if text is not None else _try(data, "cp1251")
    if text is None or _BINARY.search(text[:100_000]):
        raise InputError.at(
            place,
            "this is not a text file (unreadable characters in it).",
            expected="a table as text in UTF-8, UTF-16 or Windows-1251, or an .xlsx workbook.",
            remedy="Export it again as CSV or xlsx.",
        )
    return text


def _try(data: bytes, encoding: str) -> str | None:
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return None


def read_text_table(data: bytes, place: Place, limits: Limits) -> Sheet:
    """Read a CSV, TSV or blank-separated table.

    Parameters
    ----------
    data : bytes
        The whole file.
    place : Place
        The file, for messages.
    limits : Limits
        What it may cost.

    Returns
    -------
    Sheet
        Cells are text as written; empty cells are None.

    Raises
    ------
    InputError
        Not text, HTML or XML, decimal commas that cannot be told from separators, too large.
    """
    text = decode(data, place)
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
    rows = _split(text, place, limits)
    return Sheet(place.file, None, tuple(rows), 1)


def _split(text: str, place: Place, limits: Limits) -> list[Row]:
    sample = text.splitlines()[:_LOOKED_AT]
    delimiter = _delimiter(sample)
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
            f"the table cannot be split into cells near row {len(rows) + 1}: {error}.",
            expected="one row a line, cells parted by semicolon, comma or tab.",
            remedy="Export it again as CSV or xlsx.",
        ) from error
    if delimiter == ",":
        _refuse_decimal_commas(rows, place)
    return rows


def _delimiter(lines: list[str]) -> str | None:
    """Return the delimiter, None for blanks."""
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


def _refuse_decimal_commas(rows: list[Row], place: Place) -> None:
    """Refuse "rpm,torque" followed by "1324,5,0,378": the cells cannot be told apart."""
    header = next((row for row in rows if sum(is_text(cell) for cell in row) >= 2), None)
    if header is None:
        return
    number = rows.index(header)
    widths = Counter(len(row) for row in rows[number + 1 :] if any(is_number(c) for c in row))
    if widths and widths.most_common(1)[0][0] == 2 * len(header):
        raise InputError.at(
            Place(place.file, None, number + 2),
            f"{2 * len(header)} cells under {len(header)} column names: the comma seems to be both "
            "the decimal sign and the separator.",
            expected="cells parted by semicolon or tab where numbers have decimal commas.",
            remedy="Export it again with another separator, or as xlsx.",
        )
