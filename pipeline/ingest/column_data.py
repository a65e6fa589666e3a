"""What the numbers of a column say: thousands, blank, constant, a counter, in steps."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np

from pipeline.ingest.cells import Cell, NotANumberError, Sheet, parse_number
from pipeline.types import BoolArray, FloatArray

Meaning = Literal["decimals", "thousands", "unclear"]
_THOUSANDS = re.compile(r"[+\-\u2212]?[1-9]\d{0,2}[.,]\d{3}")
_SHORTEST = len("1,000")
_ONE_SIGN = re.compile(r"[+\-\u2212]?\d*[.,]\d+(?:[eE][+-]?\d+)?")
#: In ln: a step between neighbours by a factor of e more in one reading than in the other decides.
_CLEARER = 1.0
#: A largest value below it is no reading of a thruster: in the units of the records. What is set
#: or counted is then thousands for sure, what is measured may be a very small thruster's.
_IMPOSSIBLE: Mapping[str, float] = {"shaft_speed": 20.0, "pwm": 300.0}
_UNLIKELY: Mapping[str, float] = {"thrust": 0.2, "torque": 0.002, "input_power": 0.1}
#: Fewer numbers may be in a row by chance.
_LEAST = 4
#: Two columns are compared where the first is above this share of its largest value.
_LARGE = 0.1


def is_unclear(cell: Cell) -> bool:
    """Tell whether a cell may be thousands or a number with three decimals.

    >>> is_unclear("1,324"), is_unclear("0,324"), is_unclear("1.32"), is_unclear(1.324)
    (True, False, False, False)
    """
    if not isinstance(cell, str) or len(cell) < _SHORTEST:
        return False
    return _THOUSANDS.fullmatch(cell.strip()) is not None


def meaning_of_signs(
    sheet: Sheet, index: int, rows: tuple[int, int], quantity: str, worth: float
) -> Meaning:
    """Tell what the point or comma of a column's numbers means, between two rows.

    "thousands" where other numbers of the table, or the neighbours of each number, say so;
    "unclear" where they contradict each other. `worth` is one unit of it in the unit of the
    records.
    """
    own = sheet.column(index, rows)
    doubtful = [cell for cell in own if is_unclear(cell)]
    signs = {_sign(cell) for cell in doubtful}
    if len(signs) != 1:
        return "unclear" if signs else "decimals"
    sign = signs.pop()
    if sign in _decimal_signs(own):
        return "decimals"
    others = (sheet.cells(row) for row in range(rows[0], rows[1] + 1))
    beside = (cell for cells in others for at, cell in enumerate(cells) if at != index)
    elsewhere = set(_decimal_signs(beside))
    by_neighbours = _by_neighbours(own)
    meaning: Meaning = "decimals"
    if elsewhere and sign not in elsewhere:
        meaning = "thousands"
    elif by_neighbours is not None:
        meaning = "unclear" if by_neighbours == "thousands" and elsewhere else by_neighbours
    elif not elsewhere:
        largest = max(_sizes(doubtful), default=0.0) * abs(worth)
        if largest < _IMPOSSIBLE.get(quantity, 0.0):
            meaning = "thousands"
        elif largest < _UNLIKELY.get(quantity, 0.0):
            meaning = "unclear"
    return meaning


def without_thousands(cell: Cell) -> Cell:
    """Return a cell whose sign parts thousands as a plain number.

    >>> without_thousands("-1.324"), without_thousands("612")
    ('-1324', '612')
    """
    return re.sub("[.,]", "", cell) if isinstance(cell, str) and is_unclear(cell) else cell


def _sign(cell: Cell) -> str:
    return "." if "." in str(cell) else ","


def _decimal_signs(cells: Iterable[Cell]) -> Iterator[str]:
    """Yield the sign of each cell in which it can only be the decimal one."""
    for cell in cells:
        if isinstance(cell, str) and _ONE_SIGN.fullmatch(cell.strip()) and not is_unclear(cell):
            yield _sign(cell)


def _by_neighbours(cells: Sequence[Cell]) -> Meaning | None:
    """Tell from the steps between plain numbers and those with a sign; None where there are none.

    Whoever writes three decimals writes them for all numbers; whoever parts thousands writes
    numbers up to 999 without a sign.
    """
    sizes = [(size, is_unclear(cell)) for cell in cells for size in _sizes([cell]) if size > 0.0]
    plain = [size for size, parted in sizes if not parted]
    if not plain:
        return None
    parted = [size for size, is_parted in sizes if is_parted]
    steps = [
        math.log(one[0] / two[0]) if one[1] else math.log(two[0] / one[0])
        for one, two in pairwise(sizes)
        if one[1] != two[1]
    ] or [math.log(max(parted) / max(plain))]
    thousand = math.log(1000.0)
    as_decimals = sorted(map(abs, steps))[len(steps) // 2]
    as_thousands = sorted(abs(step + thousand) for step in steps)[len(steps) // 2]
    if as_thousands < as_decimals - _CLEARER and max(plain) < 1000.0:
        return "thousands"
    return "decimals" if as_decimals < as_thousands - _CLEARER else "unclear"


def _sizes(cells: Iterable[Cell]) -> list[float]:
    return [abs(one) for one in map(_number_or_nan, cells) if not math.isnan(one)]


def _number_or_nan(cell: Cell) -> float:
    with suppress(NotANumberError):
        number = parse_number(cell)
        return math.nan if number is None else number
    return math.nan


@dataclass(frozen=True)
class ColumnData:
    """The numbers of one column as they stand, NaN where there is none."""

    values: FloatArray

    @cached_property
    def numbers(self) -> FloatArray:
        """The numbers alone."""
        return self.values[np.isfinite(self.values)]

    @property
    def is_blank(self) -> bool:
        """Whether no cell holds a number."""
        return self.numbers.size == 0

    @property
    def is_zero(self) -> bool:
        """Whether every number is 0."""
        return self.numbers.size >= _LEAST and not self.numbers.any()

    @property
    def is_constant(self) -> bool:
        """Whether all numbers are the same."""
        return self.numbers.size >= _LEAST and float(np.ptp(self.numbers)) == 0.0

    @property
    def is_counter(self) -> bool:
        """Whether the numbers count the rows, from 0 or 1.

        >>> [ColumnData(np.array(x)).is_counter for x in ([1.0, 2, 3, 4], [0.0, 20, 40, 60])]
        [True, False]
        """
        numbers = self.numbers
        if numbers.size < _LEAST or float(numbers[0]) not in (0.0, 1.0):
            return False
        steps = np.diff(numbers)
        begins_anew = numbers[1:] == numbers[0]
        few = begins_anew.sum() <= numbers.size // _LEAST
        return bool(((steps == 1.0) | begins_anew).all() and few)

    @property
    def is_even(self) -> bool:
        """Whether all numbers are above 0, in steps of one size, as the numbers of rows may be."""
        steps = np.diff(self.numbers)
        return bool(steps.size >= _LEAST and self.numbers.min() > 0.0 and np.ptp(steps) == 0.0)

    @property
    def largest(self) -> float:
        """Size of the largest number, 0 where there is none."""
        return float(np.abs(self.numbers).max(initial=0.0))


def read_column(sheet: Sheet, index: int, rows: tuple[int, int]) -> ColumnData:
    """Read the numbers of a column from the first to the last of these rows."""
    parted = meaning_of_signs(sheet, index, rows, "", 1.0) == "thousands"
    cells = (without_thousands(cell) if parted else cell for cell in sheet.column(index, rows))
    return ColumnData(np.array([*map(_number_or_nan, cells)]))


@dataclass(frozen=True)
class Ratio:
    """A second column over a first one where the first is large: median, and spread about it."""

    median: float
    spread: float
    is_equal: bool
    """Whether both hold the same numbers in every row."""


def ratio_of(first: FloatArray, second: FloatArray) -> Ratio | None:
    """Compare two columns row by row; None where too few rows have both.

    >>> ratio_of(np.array([0.0, 1, 2, 3, 4]), np.array([0.0, 2, 4, 6, 8])).median
    2.0
    """
    both = np.isfinite(first) & np.isfinite(second)
    if not both.any():
        return None
    one, two = first[both], second[both]
    large: BoolArray = np.abs(one) > _LARGE * np.abs(one).max()
    if large.sum() < _LEAST - 1:
        return None
    ratios = two[large] / one[large]
    median = float(np.median(ratios))
    spread = float(np.max(np.abs(ratios - median))) / abs(median) if median else np.inf
    return Ratio(median, spread, bool((one == two).all()))


def wholes_of(columns: Sequence[FloatArray], tolerance: float = 0.02) -> list[tuple[int, str]]:
    """Find the columns that are the sum or the mean of all the others.

    None where one never changes: that is an offset, and what has none is the reading.

    Returns position, and "sum" or "mean", of each.

    >>> parts = np.array([1.0, 2, 3, 4]), np.array([1.5, 2.5, 2, 4])
    >>> wholes_of([*parts, parts[0] + parts[1]])
    [(2, 'sum')]
    """
    if len(columns) < 3 or any(ColumnData(one).is_constant for one in columns):
        return []
    wholes: list[tuple[int, str]] = []
    for index, column in enumerate(columns):
        rest = [other for at, other in enumerate(columns) if at != index]
        total = np.sum(rest, axis=0)
        for name, whole in (("sum", total), ("mean", total / len(rest))):
            found = ratio_of(column, whole)
            if found is not None and abs(found.median - 1.0) + found.spread <= tolerance:
                wholes.append((index, name))
    return wholes
