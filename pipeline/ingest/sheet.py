"""A sheet of a raw file as a plain table, and the limits a file must keep."""

import functools
from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.errors import Place, Problem

Cell = str | float | bool | None
Row = tuple[Cell, ...]


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
    sheet by itself, e.g. formula cells without values.
    """

    file: str
    name: str | None
    rows: tuple[Row, ...]
    first_row: int
    problems: tuple[Problem, ...] = ()
    filled: frozenset[tuple[int, int]] = frozenset()

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

    def turned(self) -> "Sheet":
        """Return the sheet with rows for columns; row 1 is its first column."""
        rows = tuple(
            tuple(cells[at] if at < len(cells) else None for cells in self.rows)
            for at in range(self.width)
        )
        return Sheet(self.file, self.name, rows, 1)

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
