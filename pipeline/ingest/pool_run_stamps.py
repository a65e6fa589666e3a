"""Times that messages carry, as nanoseconds: for many messages at once and for one, alike."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.ingest.mcap_types import Path
from pipeline.ingest.pool_run_codec import value_at
from pipeline.types import IntArray

#: Stands for a message that has no time of its own.
NO_STAMP = np.iinfo(np.int64).min
_SECOND_NS = 1_000_000_000


@dataclass(frozen=True)
class Stamp:
    """Where a message says its time: a field, or seconds and nanoseconds.

    `unit_ns` is what one of the first field is worth.
    """

    first: Path
    unit_ns: int = _SECOND_NS
    nanoseconds: Path | None = None


def ticks_ns(numbers: npt.NDArray[np.generic], unit_ns: int) -> IntArray:
    """Convert clock readings to nanoseconds; integers stay exact."""
    if numbers.dtype.kind in "iu":
        if numbers.dtype.itemsize == 8:
            # beyond 292 years it is no time; the product would wrap round
            most = np.iinfo(np.int64).max // unit_ns
            no_time = numbers > numbers.dtype.type(most)  # type: ignore[operator]  # numpy cannot know the kind of the array
            if numbers.dtype.kind == "i":
                no_time |= numbers < numbers.dtype.type(-most)  # type: ignore[operator]  # numpy cannot know the kind of the array
            ticks = np.where(no_time, 0, numbers).astype(np.int64) * unit_ns
            return np.asarray(np.where(no_time, NO_STAMP, ticks))
        return np.asarray(numbers.astype(np.int64) * unit_ns)
    with np.errstate(invalid="ignore", over="ignore"):
        exact = numbers.astype(np.float64) * float(unit_ns)
        no_time = ~(np.abs(exact) < 9.0e18)
        return np.where(no_time, NO_STAMP, np.rint(np.where(no_time, 0.0, exact)).astype(np.int64))


def joined_ns(first: IntArray, second: IntArray) -> IntArray:
    """Add two parts of a time; where one of them is no time, or the sum is beyond 64 bits, none."""
    total = first + second  # wraps round: then its sign is neither that of the one nor the other's
    no_time = (
        (first == NO_STAMP) | (second == NO_STAMP) | (((first ^ total) & (second ^ total)) < 0)
    )
    return np.asarray(np.where(no_time, NO_STAMP, total))


def stamp_of(tree: object, stamp: Stamp) -> int:
    """Time of one decoded message; the same arithmetic as for many."""
    first = value_at(tree, stamp.first)
    if isinstance(first, str):
        first = number_of_text(first)
    if not isinstance(first, int | float):
        return int(NO_STAMP)
    total = _one_tick(first, stamp.unit_ns)
    if stamp.nanoseconds is None or total == NO_STAMP:
        return total
    second = value_at(tree, stamp.nanoseconds)
    if not isinstance(second, int | float):
        return int(NO_STAMP)
    rest = _one_tick(second, 1)
    if rest == NO_STAMP or not NO_STAMP < total + rest <= np.iinfo(np.int64).max:
        return int(NO_STAMP)
    return total + rest


def _one_tick(number: float, unit_ns: int) -> int:
    if isinstance(number, int):
        most = np.iinfo(np.int64).max // unit_ns
        return number * unit_ns if -most <= number <= most else int(NO_STAMP)
    exact = float(number) * float(unit_ns)
    return int(np.rint(exact)) if abs(exact) < 9.0e18 else int(NO_STAMP)


def number_of_text(text: str) -> float | int | None:
    """Return a number that JSON writes as text (64-bit integers, times of ISO 8601 in seconds)."""
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return None
