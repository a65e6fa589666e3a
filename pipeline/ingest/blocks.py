"""A table found on a sheet: which column holds which quantity, in which unit."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from pipeline.errors import Place
from pipeline.ingest.cells import (
    Cell,
    NotANumberError,
    Row,
    Sheet,
    column_letter,
    is_number,
    parse_number,
    shorten,
)
from pipeline.ingest.column_data import Meaning, is_unclear, without_thousands
from pipeline.records.measurements import ColumnNotUsed, ColumnRead

#: Why a column is not read of which nothing else is to be said.
NO_QUANTITY = "no quantity of this kind of test"
UnitFrom = Literal["header", "unit row", "mapping", "assumed"]

#: Error values of spreadsheets in CSV exports start like a comment.
_ERROR_VALUE = re.compile(
    r"#(?:DIV/0!|N/A|NAME\?|NULL!|NUM!|REF!|VALUE!|SPILL!|CALC!|ДЕЛ/0!|Н/Д|ИМЯ\?|ПУСТО!|ЧИСЛО!"
    r"|ССЫЛКА!|ЗНАЧ!)",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class BlockColumn:
    """One column: value in the record's unit = cell * factor * sign."""

    quantity: str
    index: int
    header: str
    unit: str = ""
    """As written; empty where the quantity has none."""
    unit_from: UnitFrom = "assumed"
    unit_row: int | None = None
    """Row where the unit stands, for messages."""
    factor: float = 1.0
    sign: int = 1
    plus: tuple[int, ...] = ()
    """Columns whose numbers are added, as vehicle.yaml states."""
    group: str = ""
    """Texts above the name in this column, e.g. "Loading" over several names."""
    signs_mean: Meaning = "decimals"
    """What the sign of "1,324" is here; where that is unclear it is no number to go by."""

    @property
    def letter(self) -> str:
        """The spreadsheet's name of the column."""
        return column_letter(self.index)

    def value(self, cell: Cell) -> float | None:
        """Return the cell's number in the unit of the records; None where it is empty.

        Raises `NotANumberError`.
        """
        if self.signs_mean == "thousands":
            cell = without_thousands(cell)
        elif self.signs_mean == "unclear" and is_unclear(cell):
            raise NotANumberError(
                f'"{cell}" may be {without_thousands(cell)} or {str(cell).replace(",", ".")}: the '
                "other numbers do not tell thousands from decimals"
            )
        number = parse_number(cell, self.unit or None)
        return None if number is None else number * self.factor * self.sign

    def as_record(self) -> ColumnRead:
        """Return what the record says about this column."""
        return ColumnRead(
            quantity=self.quantity,
            header=self.header,
            column=self.letter,
            unit=self.unit,
            unit_from=self.unit_from,
        )

    def unit_stated(self) -> str:
        """Say where the unit is from, for a message.

        e.g. ``kg cm, the unit stated in cell C3``.
        """
        if not self.unit:
            return "no unit"
        if self.unit_from == "mapping":
            return f"{self.unit}, the unit stated in vehicle.yaml"
        if self.unit_row is not None:
            return f"{self.unit}, the unit stated in cell {self.letter}{self.unit_row}"
        return f"{self.unit}, {'assumed' if self.unit_from == 'assumed' else 'as the header says'}"


@dataclass(frozen=True)
class HeadingCell:
    """A cell above a table that belongs to none of its columns' names."""

    row: int
    column: int
    value: Cell


@dataclass(frozen=True)
class Block:
    """One table of a sheet."""

    sheet: Sheet
    columns: Mapping[str, BlockColumn]
    header_row: int
    first_row: int
    """First row of data; numbers are as a spreadsheet shows them."""
    last_row: int
    above: tuple[HeadingCell, ...]
    """What stands over the numbers apart from the names: top to bottom, left to right."""
    not_used: Mapping[int, str] = field(default_factory=dict)
    """Why a column that fits a quantity is not read, by its index."""
    thruster: str | None = None
    """Name of the thruster, where the columns are of several."""
    only: tuple[tuple[int, str], ...] = ()
    span: tuple[int, int] = (0, 10_000)
    """First and last column index of the block, for tables side by side."""

    def rows(self) -> Iterator[tuple[int, Row]]:
        """Yield (row number, cells) of the data rows, comments and section headings included."""
        for row in range(self.first_row, self.last_row + 1):
            cells = self.sheet.cells(row)
            if not self.only or all(_same(_at(cells, index), text) for index, text in self.only):
                yield row, cells

    def value(self, cells: Row, quantity: str) -> float | None:
        """Return a number of a row in the record's unit; None: no such column, or empty.

        Raises `NotANumberError`.
        """
        column = self.columns.get(quantity)
        if column is None:
            return None
        value = column.value(_at(cells, column.index))
        for index in column.plus:
            part = column.value(_at(cells, index))
            if value is None or part is None:
                return None
            value += part
        return value

    def text(self, cells: Row, quantity: str) -> str | None:
        """Return a cell of a row as text; None where there is none."""
        column = self.columns.get(quantity)
        cell = None if column is None else _at(cells, column.index)
        return None if cell is None else str(cell)

    def is_blank(self, quantity: str) -> bool:
        """Tell whether a quantity's column has no cell that is filled."""
        index = self.columns[quantity].index
        return all(_at(cells, index) is None for _, cells in self.rows())

    def is_merged_over(self, row: int, quantity: str) -> bool:
        """Tell whether a quantity's cell is covered by one further up that holds a number."""
        index = self.columns[quantity].index
        if (row, index) not in self.sheet.filled or row == self.first_row:
            return False
        return is_number(self.sheet.cell(row - 1, index))

    def rows_of_numbers(self) -> list[int]:
        """Return the rows that hold a number in a column that is read."""
        columns = [column.index for column in self.columns.values()]
        return [
            row for row, cells in self.rows() if any(is_number(_at(cells, at)) for at in columns)
        ]

    def heads_not_read(self) -> list[tuple[int, str]]:
        """Return the index and the name of each column within the table that is not read."""
        read = {index for one in self.columns.values() for index in (one.index, *one.plus)}
        low, high = self.span
        above = self.header_row < self.sheet.first_row
        heads = () if above else self.sheet.cells(self.header_row)[: high + 1]
        return [
            (index, head)
            for index, head in enumerate(heads)
            if index >= low and isinstance(head, str) and index not in read
        ]

    def texts_in(self, rows: Iterable[int], index: int) -> dict[int, str]:
        """Return what the filled cells of a column say, by row."""
        cells = ((row, self.sheet.cell(row, index)) for row in rows)
        return {
            row: f"{cell:g}" if isinstance(cell, float) else cell.strip()
            for row, cell in cells
            if isinstance(cell, (float, str))
        }

    def columns_not_used(self, directions: int | None) -> tuple[ColumnNotUsed, ...]:
        """Return the columns of the table that nothing is read from, and why.

        `directions` is the column of words that the direction of the rows is told by, if any.
        """
        return tuple(
            ColumnNotUsed(
                header=shorten(head),
                column=column_letter(index),
                reason=self.not_used.get(index, NO_QUANTITY),
            )
            for index, head in self.heads_not_read()
            if index != directions
        )

    def place(self, row: int | None = None, quantity: str | None = None) -> Place:
        """Return the place of a row, and of a quantity's column, for a message."""
        column = self.columns.get(quantity) if quantity is not None else None
        return self.sheet.place(row, None if column is None else column.letter)

    def section_text(self, cells: Row) -> str | None:
        """Return the text of a row that holds text but no numbers within the block."""
        low, high = self.span
        inside = [cell for cell in cells[low : high + 1] if cell is not None]
        if not inside or any(is_number(cell) for cell in inside):
            return None
        texts = [cell for cell in inside if isinstance(cell, str)]
        return " ".join(dict.fromkeys(texts)) or None


def is_commented(cells: Row) -> bool:
    """Tell whether the first filled cell of a row starts with ``#``.

    >>> is_commented(("# 1324", "0,5")), is_commented((None, "#", 1.0)), is_commented(("#DIV/0!",))
    (True, True, False)
    """
    for cell in cells:
        if cell is not None:
            return (
                isinstance(cell, str) and cell.startswith("#") and _ERROR_VALUE.match(cell) is None
            )
    return False


def without_comment_mark(cells: Row) -> Row:
    """Return a commented row with the number behind its ``#``, so that it can be kept.

    >>> without_comment_mark(("# 40", "0,5")), without_comment_mark((None, "#", 1.0))
    (('40', '0,5'), (None, None, 1.0))
    """
    return tuple((cell.lstrip("# ") or None) if isinstance(cell, str) else cell for cell in cells)


def _at(cells: Row, index: int) -> Cell:
    return cells[index] if index < len(cells) else None


def _same(cell: Cell, text: str) -> bool:
    if is_number(cell) and is_number(text):
        return parse_number(cell) == parse_number(text)
    return cell is not None and str(cell).casefold().split() == text.casefold().split()


def heading_text(cells: tuple[HeadingCell, ...]) -> str:
    """Return the headings as one text, repeats from merged cells left out."""
    return " ".join(dict.fromkeys(shorten(str(cell.value)) for cell in cells))


def headings(sheet: Sheet, first: int, row: int, low: int, high: int) -> tuple[HeadingCell, ...]:
    """Return the filled cells of the rows from `first` to before `row`, merged ones once."""
    cells: list[HeadingCell] = []
    for at in range(first, row):
        for index, cell in enumerate(sheet.cells(at)[low : high + 1], start=low):
            merged = (at, index) in sheet.filled and index > low
            if cell is not None and not merged:
                cells.append(HeadingCell(at, index, cell))
    return tuple(cells)
