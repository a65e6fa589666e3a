"""Readings that are none: their message says so, or they are larger than the quantity can be."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.ingest.mcap_types import Path
from pipeline.ingest.pool_run_codec import value_at
from pipeline.types import BoolArray, FloatArray

#: Quantity -> largest believable size. Units of the records.
LARGEST: Mapping[str, float] = {
    "angular_velocity": 40.0,
    "specific_force": 200.0,
    "velocity": 20.0,
    "velocity_earth": 20.0,
    "depth": 12_000.0,
    "position": 1e7,
    "voltage": 2_000.0,
    "current": 2_000.0,
    "shaft_speed": 100_000.0,
}
#: Where more of the readings are beyond, the unit is wrong and not the readings.
_MOST_IMPOSSIBLE = 0.2
#: A unit that is wrong makes readings of every size; what means "none" stands far from the others.
_EMPTY_BELOW = 0.5
_FLAGS = ("velocity_valid", "velocity_is_valid", "is_valid", "valid")


def impossible(quantity: str, values: FloatArray) -> BoolArray:
    """Find readings that cannot be, such as the -32.768 m/s of a DVL without bottom lock.

    Parameters
    ----------
    quantity : str
        Of the records.
    values : ndarray, shape (k, m)
        Readings, in the units of the records.

    Returns
    -------
    ndarray, shape (k,)
        None are found where the unit is more likely wrong.
    """
    none = np.zeros(values.shape[0], np.bool_)
    most = LARGEST.get(quantity)
    if most is None:
        return none
    with np.errstate(invalid="ignore"):
        size = np.abs(values).max(axis=1, initial=0.0)
        beyond = size > most
        near = (size > _EMPTY_BELOW * most) & ~beyond
    count = int(beyond.sum())
    if count > _MOST_IMPOSSIBLE * beyond.size or 10 * int(near.sum()) > count:
        return none
    return np.asarray(beyond)


def validity_of(quantity: str, probe: Mapping[str, Any], numbers: Sequence[Path]) -> Path | None:
    """Return where a message says whether its velocity is valid, None where it does not.

    Parameters
    ----------
    quantity : str
        Only velocities are asked.
    probe : mapping
        A message.
    numbers : sequence of path
        Where the components are; the flag stands beside them or above.
    """
    if not quantity.startswith("velocity") or not numbers:
        return None
    shared = numbers[0]
    for length in range(len(shared) - 1, -1, -1):
        above = shared[:length]
        if any(path[:length] != above for path in numbers):
            continue
        for name in _FLAGS:
            flag = value_at(probe, (*above, name))
            if isinstance(flag, int) and flag in (0, 1):  # a bool of a binary message is a number
                return (*above, name)
    return None
