"""Commas that part thousands and look like decimal ones: "1,324" among "612" and "987"."""

import re
from collections.abc import Iterable, Sequence

from pipeline.ingest.cells import NotANumberError, parse_number
from pipeline.ingest.sheet import Cell, Sheet

_THOUSANDS = re.compile(r"[+\-\u2212]?[1-9]\d{0,2},\d{3}")
_COMMA = re.compile(r"\d,\d")
_POINT = re.compile(r"\d\.\d")
#: Whoever parts thousands writes numbers up to 999 without a comma.
_LARGE = 100.0


def is_unclear(cell: Cell) -> bool:
    """Tell whether a cell may be thousands or a number with three decimals.

    >>> is_unclear("1,324"), is_unclear("0,324"), is_unclear("1,32"), is_unclear(1.324)
    (True, False, False, False)
    """
    return isinstance(cell, str) and _THOUSANDS.fullmatch(cell.strip()) is not None


def columns_with_thousands(
    sheet: Sheet, columns: Sequence[int], first: int, last: int
) -> frozenset[int]:
    """Return the columns of a table whose commas part thousands rather than decimals.

    Parameters
    ----------
    sheet : Sheet
        The sheet.
    columns : sequence of int
        Columns that are read.
    first, last : int
        Rows of numbers.

    Returns
    -------
    frozenset of int
        Columns whose commas all stand before three digits, where the other numbers of the column
        are larger than these would be as decimals, or the other columns have decimal points.
    """
    cells = {index: [sheet.cell(row, index) for row in range(first, last + 1)] for index in columns}
    doubtful = {index for index, own in cells.items() if any(map(is_unclear, own))}
    if not doubtful:
        return frozenset()
    texts = [cell for own in cells.values() for cell in own if isinstance(cell, str)]
    points = any(_POINT.search(text) for text in texts)
    decimals = any(_COMMA.search(text) and not is_unclear(text) for text in texts)
    if points and not decimals:
        return frozenset(doubtful)
    return frozenset(index for index in doubtful if _are_thousands(cells[index]))


def _are_thousands(cells: Sequence[Cell]) -> bool:
    with_comma = [cell for cell in cells if _has_comma(cell)]
    if not all(map(is_unclear, with_comma)):
        return False
    others = _sizes(cell for cell in cells if not _has_comma(cell))
    smallest = min((size for size in others if size > 0.0), default=0.0)
    return max(others, default=0.0) >= _LARGE and smallest > max(_sizes(with_comma))


def _has_comma(cell: Cell) -> bool:
    return isinstance(cell, str) and _COMMA.search(cell) is not None


def _sizes(cells: Iterable[Cell]) -> list[float]:
    sizes: list[float] = []
    for cell in cells:
        try:
            number = parse_number(cell)
        except NotANumberError:
            continue
        if number is not None:
            sizes.append(abs(number))
    return sizes
