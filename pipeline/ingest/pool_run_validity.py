"""Readings that are none: their message says so, or they are larger than the quantity can be."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.ingest.data_files import data_of
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
_ANY_FLAGS = ("is_valid", "valid")


@dataclass(frozen=True)
class Flag:
    """A number of a message that says whether its readings are valid, and what it then is.

    Valid are `least` to `most`, in words `says`.
    """

    path: Path
    least: float
    most: float
    says: str

    @property
    def is_telling(self) -> bool:
        """Whether it is said also where all readings are valid; a covariance is there always."""
        return not isinstance(self.path[-1], int)

    def invalid(self, numbers: FloatArray) -> BoolArray:
        """Tell which readings (k,) are not valid; a flag that is missing says nothing."""
        with np.errstate(invalid="ignore"):
            return np.asarray((numbers < self.least) | (numbers > self.most))


def impossible(quantity: str, values: FloatArray) -> BoolArray:
    """Find readings that cannot be, such as the -32.768 m/s of a DVL without bottom lock.

    Of values (k, m) in the units of the records; none are found where the unit is more likely
    wrong.
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


def validity_of(
    quantity: str, probe: Mapping[str, Any], numbers: Sequence[Path]
) -> tuple[Flag, ...]:
    """Return what in a message says whether its readings are valid.

    A flag stands beside the components (`numbers`) or above them: truth values of many names; the
    mode and the beams of marine_acoustic_msgs/Dvl, whose velocity may be that through the water; a
    covariance that begins with -1, which in sensor_msgs is "no estimate".
    """
    if not numbers:
        return ()
    kind = quantity.removesuffix("_earth")
    found = []
    above = _shared(numbers)
    for length in range(len(above), -1, -1):
        here = above[:length]
        for name in (*data_of("topics")["flags"].get(kind, ()), *_ANY_FLAGS):
            flag = value_at(probe, (*here, name))
            if isinstance(flag, int) and flag in (0, 1):  # a bool of a binary message is a number
                found.append(Flag((*here, name), 1.0, 1.0, f"{name} calls valid"))
        if kind == "velocity":
            found += _of_a_dvl(probe, here)
        if found:
            break
    return (*found, *_covariance(probe, above))


def _shared(numbers: Sequence[Path]) -> Path:
    """Return the longest path that all begin with, without their own last step."""
    shared = numbers[0][:-1]
    while any(path[: len(shared)] != shared for path in numbers):
        shared = shared[:-1]
    return shared


def _of_a_dvl(probe: Mapping[str, Any], here: Path) -> list[Flag]:
    mode, beams = (value_at(probe, (*here, name)) for name in ("velocity_mode", "num_good_beams"))
    found = []
    if isinstance(mode, int):
        path = (*here, "velocity_mode")
        found.append(Flag(path, 0.0, 1.0, "velocity_mode says are over ground"))
    if isinstance(beams, int):
        path = (*here, "num_good_beams")
        found.append(Flag(path, 3.0, np.inf, "num_good_beams gives three beams or more"))
    return found


def _covariance(probe: Mapping[str, Any], above: Path) -> list[Flag]:
    """Return the covariance of a vector: ``orientation_covariance``, ``twist.covariance``."""
    for path in (
        ((*above[:-1], f"{above[-1]}_covariance", 0), (*above[:-1], "covariance", 0))
        if above
        else ()
    ):
        if isinstance(value_at(probe, path), int | float):
            return [Flag(path, -0.5, np.inf, f"{path[-2]} does not call unknown")]
    return []
