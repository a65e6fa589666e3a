"""A sheet of a raw file as a plain table; numbers and column letters as people write them."""

import functools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from pipeline.errors import Place, Problem
from pipeline.ingest.unit_text import is_same_unit

Cell = str | float | bool | None
Row = tuple[Cell, ...]
_BLANKS = re.compile(
    r"[\s\u00a0\u00ad\u2000-\u200b\u202f\u2060\ufeff]+|(?<=\d)['\u2019](?=\d{3}(?!\d))"
)
_MINUS = str.maketrans(dict.fromkeys("\u2212\u2010\u2011\u2012\u2013\u2014\ufe63\uff0d", "-"))
#: No reading is larger, nanoseconds since 1970 included; powers and products stay finite.
MOST = 1e30
#: Written where there is no value.
_MISSING = frozenset(
    {"", "-", "--", "---", "nan", "n/a", "na", "#n/a", "none", "null", "нет", "н/д"}
)
_NUMBER = re.compile(
    r"""(?P<sign>[+-]?)[ ]?
    (?P<body>\d{1,3}(?:[ ]\d{3})+(?:[.,]\d*)?   # 1 324,5
    |\d{1,3}(?:,\d{3})+\.\d*                    # 1,324.5
    |\d{1,3}(?:\.\d{3})+,\d*                    # 1.324,5
    |\d{1,3}(?:,\d{3}){2,}|\d{1,3}(?:\.\d{3}){2,}
    |\d+[.,]?\d*|[.,]\d+)
    (?P<exponent>[eE][+-]?\d{1,3})?""",
    re.VERBOSE,
)
_SIGN_BEHIND = re.compile(r"\d[\d ]*(?:[.,]\d+)?-")
#: A number with a sign of a remark, in brackets, or with a short word.
_SPOILT = re.compile(
    r"[^A-Za-zА-Яа-я0-9\s]{0,2}\s*[+\-\u2212]?\d[\d.,\s]*\s*(?:[^\w\s]{1,3}|\(?[A-Za-zА-Яа-я]{0,8}\)?)"
)


@dataclass(frozen=True)
class Limits:
    """What a raw file may cost at most; a bench file is far below all of these."""

    max_bytes: int = 50_000_000
    max_unpacked_bytes: int = 300_000_000
    max_ratio: float = 200.0
    """Largest ratio of unpacked to packed size of one member; above it, it is a zip bomb."""
    max_sheets: int = 200
    max_rows: int = 200_000
    max_columns: int = 500
    max_cells: int = 5_000_000
    """Cells of the used range of one sheet, and of all sheets of a file together."""
    max_text_bytes: int = 300_000_000
    """Text of all cells together, where shared texts count as often as they are used."""


@dataclass(frozen=True)
class Sheet:
    """One sheet; the first column of `rows` is column A, `rows[0]` is row `first_row`.

    `name` is None for a text file. Cells covered by a merged range hold the value of its top left
    cell; `filled` lists them as (row number, column index). `problems` says what was wrong with the
    sheet by itself. `units` are those that the number formats of
    cells show, by row number and column index.
    """

    file: str
    name: str | None
    rows: tuple[Row, ...]
    first_row: int
    problems: tuple[Problem, ...] = ()
    filled: frozenset[tuple[int, int]] = frozenset()
    units: Mapping[tuple[int, int], str] = field(default_factory=dict)
    formulas: frozenset[tuple[int, int]] = frozenset()
    """Cells with a formula and no value, as (row number, column index)."""

    def numbered(self) -> Iterator[tuple[int, Row]]:
        """Yield (row number as a spreadsheet shows it, cells)."""
        return enumerate(self.rows, start=self.first_row)

    def cells(self, row: int) -> Row:
        """Return the cells of the row with this spreadsheet number."""
        return self.rows[row - self.first_row]

    def cell(self, row: int, column: int) -> Cell:
        """Return one cell by row number and column index; None outside of the table."""
        position = row - self.first_row
        if not 0 <= position < len(self.rows) or not 0 <= column < len(self.rows[position]):
            return None
        return self.rows[position][column]

    def column(self, index: int, rows: tuple[int, int]) -> list[Cell]:
        """Return the cells of a column from the first to the last of these rows."""
        first, last = max(rows[0], self.first_row), min(rows[1], self.last_row)
        inside = self.rows[first - self.first_row : max(last - self.first_row + 1, 0)]
        return [cells[index] if index < len(cells) else None for cells in inside]

    def units_shown(self, index: int, rows: tuple[int, int]) -> dict[str, int]:
        """Return the units that the number formats of a column show -> first row of each."""
        found: dict[str, int] = {}
        for row in range(rows[0], rows[1] + 1) if self.units else ():
            if (row, index) in self.units and is_number(self.cell(row, index)):
                found.setdefault(self.units[row, index], row)
        return found

    def turned(self) -> "Sheet":
        """Return the sheet with rows for columns; row 1 is its first column."""
        rows = tuple(
            tuple(cells[at] if at < len(cells) else None for cells in self.rows)
            for at in range(self.width)
        )
        units = {(at + 1, row - self.first_row): one for (row, at), one in self.units.items()}
        return Sheet(self.file, self.name, rows, 1, units=units)

    @functools.cached_property
    def width(self) -> int:
        """Number of columns of the widest row."""
        return max((len(cells) for cells in self.rows), default=0)

    @property
    def last_row(self) -> int:
        """Number of the last row; `first_row - 1` when there is none."""
        return self.first_row + len(self.rows) - 1

    def place(self, row: int | None = None, column: str | None = None) -> Place:
        """Return a place on this sheet, for a message."""
        return Place(self.file, self.name, row, column)


class NotANumberError(ValueError):
    """A cell holds something else than a number; the text says what."""


def parse_number(cell: Cell, unit_text: str | None = None) -> float | None:
    """Read a number with decimal point or comma.

    A single comma is a decimal comma ("1,324" is 1.324); blanks may part thousands; a trailing
    unit is accepted where it is that of the column. None where there is no value: empty, "-".

    Raises `NotANumberError` for text, an error value such as #DIV/0!, a truth value, infinity or a
    number above `MOST`.

    >>> parse_number("1 324,5"), parse_number("\u22120.378"), parse_number("5,2 кгс·см", "кгс см")
    (1324.5, -0.378, 5.2)
    >>> parse_number("1'324"), parse_number("- 0.5"), parse_number("12,5-")
    (1324.0, -0.5, -12.5)
    >>> parse_number("1,2,3")
    Traceback (most recent call last):
    ...
    pipeline.ingest.cells.NotANumberError: "1,2,3" is not a number
    """
    if cell is None:
        return None
    if type(cell) is float and -MOST <= cell <= MOST:
        return cell  # nearly every cell of a workbook
    if isinstance(cell, bool):
        raise NotANumberError(f'"{str(cell).upper()}" is not a number')
    number = (
        _parse_text(cell, unit_text) if isinstance(cell, str) else _finite(float(cell), str(cell))
    )
    if isinstance(number, str):
        raise NotANumberError(number)
    return number


@functools.lru_cache(maxsize=65536)
def _parse_text(cell: str, unit_text: str | None) -> float | str | None:
    """Return the number of a text, None where there is no value, or why it is none."""
    text = _BLANKS.sub(" ", cell.translate(_MINUS)).strip()
    if text.casefold() in _MISSING:
        return None
    if _SIGN_BEHIND.fullmatch(text):  # as book-keeping programs write it
        text = f"-{text[:-1]}"
    found = _NUMBER.match(text)
    rest = text if found is None else text[found.end() :].strip()
    if found is None or (rest and not (unit_text and is_same_unit(rest, unit_text))):
        if rest == "%":
            return f'"{shorten(cell)}" is in per cent, which the name of its column does not say'
        return f'"{shorten(cell)}" is not a number'
    body = found["body"].replace(" ", "")
    last = max(body.rfind("."), body.rfind(","))
    if body.count(".") + body.count(",") > 1 and body[last] in body[:last]:
        body = body.replace(body[last], "")  # thousands only: 1,234,567
    elif last >= 0:
        whole = body[:last].replace(",", "").replace(".", "")
        body = f"{whole or '0'}.{body[last + 1 :]}"
    return _finite(float(f"{found['sign']}{body}{found['exponent'] or ''}"), cell)


def _finite(value: float, text: str) -> float | str | None:
    if math.isinf(value):
        return f'"{shorten(text)}" is not a finite number'
    if abs(value) > MOST:
        return f'"{shorten(text)}" is larger than any reading can be'
    return None if math.isnan(value) else value


def unit_behind(cell: Cell) -> str | None:
    """Return what follows the number in a cell: its unit, perhaps; None where nothing does.

    >>> unit_behind("12.3 N"), unit_behind("-5kgf"), unit_behind(1.5), unit_behind("1.5"),
    ('N', 'kgf', None, None)
    """
    text = _BLANKS.sub(" ", cell.translate(_MINUS)).strip() if isinstance(cell, str) else ""
    found = _NUMBER.match(text)
    return None if found is None else text[found.end() :].strip() or None


def is_number(cell: Cell) -> bool:
    """Tell whether the cell holds a number.

    >>> is_number("1,5"), is_number("x"), is_number(None)
    (True, False, False)
    """
    with suppress(NotANumberError):
        return parse_number(cell) is not None
    return False


def is_text(cell: Cell) -> bool:
    """Tell whether the cell holds text that is neither a number nor a sign of a missing value.

    >>> is_text("Torque"), is_text("1,5"), is_text("-")
    (True, False, False)
    """
    return isinstance(cell, str) and isinstance(_parse_text(cell, None), str)


def are_spoilt(cells: Sequence[Cell]) -> bool:
    """Tell whether cells are numbers with something added, and no names, units or remarks.

    >>> are_spoilt(["-120*", "(22.0)"]), are_spoilt(["code 5", "1/min"]), are_spoilt(["Run", "12"])
    (True, False, False)
    >>> are_spoilt(["-120 (est)", "_22 N"])
    True
    """
    return len(cells) > 1 and all(
        isinstance(cell, str) and _SPOILT.fullmatch(cell.strip()) is not None for cell in cells
    )


def shorten(text: str, length: int = 60) -> str:
    """Return a text of a file fit for a message: one line, printable, not too long.

    >>> shorten("a" * 100, 10)
    'aaaaaaaaa…'
    """
    clean = "".join(sign if sign.isprintable() else " " for sign in text[: 4 * length])
    clean = _BLANKS.sub(" ", clean).strip()
    return clean if len(clean) <= length else clean[: length - 1] + "…"


def column_letter(index: int) -> str:
    """Return the spreadsheet's name of a column counted from 0.

    >>> column_letter(0), column_letter(25), column_letter(26), column_letter(16383)
    ('A', 'Z', 'AA', 'XFD')
    """
    letters = ""
    number = index + 1
    while number > 0:
        number, rest = divmod(number - 1, 26)
        letters = chr(ord("A") + rest) + letters
    return letters


@functools.lru_cache(maxsize=1024)
def column_index(letter: str) -> int:
    """Return the position, from 0, of a column named by its letters.

    >>> column_index("A"), column_index("AA"), column_index("xfd")
    (0, 26, 16383)
    """
    number = 0
    for sign in letter.upper():
        number = number * 26 + ord(sign) - ord("A") + 1
    return number - 1
