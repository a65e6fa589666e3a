"""What the numbers of a column say by themselves: blank, constant, a counter, in steps."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.ingest.cells import NotANumberError, parse_number
from pipeline.ingest.sheet import Sheet
from pipeline.ingest.thousands import meaning_of_signs, without_thousands
from pipeline.types import BoolArray, FloatArray

#: Fewer numbers may be in a row by chance.
_LEAST = 4
#: Two columns are compared where the first is above this share of its largest value.
_LARGE = 0.1


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
    values: list[float] = []
    for cell in sheet.column(index, rows):
        try:
            number = parse_number(without_thousands(cell) if parted else cell)
        except NotANumberError:
            number = None
        values.append(np.nan if number is None else number)
    return ColumnData(np.array(values))


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

    Returns
    -------
    list of tuple of (int, str)
        Position, and "sum" or "mean", of each.

    Examples
    --------
    >>> parts = np.array([1.0, 2, 3, 4]), np.array([1.5, 2.5, 2, 4])
    >>> wholes_of([*parts, parts[0] + parts[1]])
    [(2, 'sum')]
    """
    if len(columns) < 3:
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
