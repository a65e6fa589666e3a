"""Cells of a text table beyond its last column name: decimal commas taken for separators."""

import re
from collections.abc import Iterator, Sequence

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.blocks import is_commented
from pipeline.ingest.cells import is_number, is_text
from pipeline.ingest.rows import listed
from pipeline.ingest.sheet import Row
from pipeline.ingest.vocabulary import read_unit_cell

_POINT = re.compile(r"\d\.\d|\d\.$|^\.\d")


def check_width(rows: Sequence[Row], place: Place, *, by_comma: bool) -> tuple[Problem, ...]:
    """Warn of rows of a whole table that have more numbers than there are names above them.

    Raises `InputError` where the comma is both the decimal sign and the separator: ``30,4,41``
    under two names. `by_comma` tells whether it parts the cells.
    """
    under_names = list(_rows_under_names(rows))
    wide = [one for one in under_names if _last_number(one[1]) > one[2]]
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
        Problem(
            "warning",
            Place(place.file, None, number),
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


def _last_number(cells: Row) -> int:
    """Return how many columns the numbers of a row reach over."""
    return max(index for index, cell in enumerate(cells) if is_number(cell)) + 1
