"""What a message says beside its numbers: its time, its frame, whether the readings are valid."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.ingest.data_files import data_of
from pipeline.ingest.message_definitions import Path
from pipeline.ingest.pool_run_codec import value_at
from pipeline.ingest.quantities import largest
from pipeline.types import BoolArray, FloatArray, IntArray

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_DOWNWARDS = frozenset({"frd", "ned"})
#: Frames of REP 105 that do not move with the vehicle, and what else they are called.
_EARTH = frozenset({"map", "odom", "earth", "world"})
_EARTH_AXES = frozenset({"ned", "enu", "nwu"})
#: Frames in which a velocity is in body axes already.
_BODY = ("base_link", "body")
#: Stands for a message that has no time of its own.
NO_STAMP, _LATEST = np.iinfo(np.int64).min, np.iinfo(np.int64).max
_SECOND_NS = 1_000_000_000
#: Where more of the readings are beyond, the unit is wrong and not the readings.
_MOST_IMPOSSIBLE = 0.2
#: A unit that is wrong makes readings of every size; what means "none" stands far from the others.
_EMPTY_BELOW = 0.5
_ANY_FLAGS = ("is_valid", "valid")
#: Validity by letters, as NMEA 0183 and DVLs after it write it.
LETTERS = {"A": 1.0, "V": 0.0}
#: So many times as much is another quality, or roughness; fewer readings say nothing of it.
_UNUSUAL, _LEAST_ODD, _LEAST_WEIGHED = 3.0, 3, 20


def words_of(frame: str) -> frozenset[str]:
    """Cut the name of a frame into words in lower case.

    >>> sorted(words_of("rov1/base_link_frd")), sorted(words_of("mapNED"))
    (['base', 'frd', 'link', 'rov'], ['map', 'ned'])
    """
    return frozenset(word.lower() for word in _WORD.findall(frame))


def points_down(frames: str) -> bool:
    """Tell whether names of frames say that z points down: one of their words is frd or ned.

    >>> points_down("map_ned"), points_down("odom_combined")
    (True, False)
    """
    return bool(words_of(frames) & _DOWNWARDS)


def is_earth(frame: str) -> bool:
    """Tell whether a frame does not move with the vehicle.

    >>> is_earth("map"), is_earth("odom_combined"), is_earth("base_link_ned"), is_earth("")
    (True, True, False, False)
    """
    words = words_of(frame)
    return bool(words & _EARTH) or (bool(words) and words <= _EARTH_AXES)


def is_body(frame: str) -> bool:
    """Tell whether a frame has the axes of the body, and not of a DVL on it.

    >>> is_body("rov/base_link"), is_body("dvl_base_link"), is_body("dvl_link")
    (True, False, False)
    """
    frame = frame.lower()
    return "dvl" not in frame and any(name in frame for name in _BODY)


@dataclass(frozen=True)
class Stamp:
    """Where a message says its time: a field, or seconds and nanoseconds.

    `unit_ns` is what one of the first field is worth.
    """

    first: Path
    unit_ns: int = _SECOND_NS
    nanoseconds: Path | None = None

    @property
    def parts(self) -> tuple[tuple[Path, int], ...]:
        """Where each part of the time stands, and what one of it is worth. [ns]."""
        rest = () if self.nanoseconds is None else ((self.nanoseconds, 1),)
        return ((self.first, self.unit_ns), *rest)


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


def stamps_of(
    column: Callable[[Path], npt.NDArray[Any] | None], stamp: Stamp, count: int
) -> IntArray:
    """Return the times (k,) of messages, `NO_STAMP` for none.

    `column` gives the numbers (k,) that stand at a path, None where there are none. A time beyond
    64 bits is none.
    """
    time_ns, no_time = np.zeros(count, np.int64), np.zeros(count, np.bool_)
    for path, unit_ns in stamp.parts:
        numbers = column(path)
        if numbers is None:
            return np.full(count, NO_STAMP)
        ticks = ticks_ns(numbers, unit_ns)
        total = time_ns + ticks  # wraps round: then its sign is neither of the one nor the other
        no_time |= (ticks == NO_STAMP) | (((time_ns ^ total) & (ticks ^ total)) < 0)
        time_ns = total
    return np.asarray(np.where(no_time, NO_STAMP, time_ns))


def stamp_of(tree: object, stamp: Stamp) -> int:
    """Time of one decoded message; the same arithmetic as for many."""
    total = 0
    for path, unit_ns in stamp.parts:
        number = value_at(tree, path)
        number = number_of_text(number) if isinstance(number, str) else number
        if isinstance(number, float):
            exact = number * float(unit_ns)
            ticks = int(np.rint(exact)) if abs(exact) < 9.0e18 else int(NO_STAMP)
        elif isinstance(number, int):
            ticks = number * unit_ns
        else:
            return int(NO_STAMP)
        total += ticks
        if not NO_STAMP < ticks <= _LATEST or not NO_STAMP < total <= _LATEST:
            return int(NO_STAMP)
    return total


def number_of_text(text: str) -> float | int | None:
    """Return a number that JSON writes as text (64-bit integers, times of ISO 8601 in seconds).

    >>> number_of_text("12"), number_of_text("V"), number_of_text("no")
    (12, 0.0, None)
    """
    if text in LETTERS:
        return LETTERS[text]
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return None


@dataclass(frozen=True)
class Flag:
    """A number of a message that says whether its readings are valid, and what it then is.

    Valid are `least` to `most`, in words `says`. What a number that is `weighed` means nobody can
    know by its name: the readings tell.
    """

    path: Path
    least: float
    most: float
    says: str
    weighed: bool = False

    @property
    def is_telling(self) -> bool:
        """Whether it is said also where all readings are valid; a covariance is there always."""
        return not isinstance(self.path[-1], int) and not self.weighed

    def invalid(self, numbers: FloatArray, readings: FloatArray) -> BoolArray:
        """Tell which readings (k, m) are not valid; a flag that is missing says nothing."""
        if self.weighed:
            return _unlike(numbers, readings)
        with np.errstate(invalid="ignore"):
            return np.asarray((numbers < self.least) | (numbers > self.most))


def _unlike(numbers: FloatArray, readings: FloatArray) -> BoolArray:
    """Find readings (k, m) with another status or quality than usual that are rougher, or stand.

    Whether a status of 1 is good or bad, or how much a figure of merit may be, is not asked.
    """
    none = np.zeros(numbers.size, np.bool_)
    if not np.isfinite(numbers).any() or numbers.size < _LEAST_WEIGHED:
        return none
    middle = float(np.nanmedian(numbers))
    with np.errstate(invalid="ignore"):
        odd = (numbers > max(_UNUSUAL * middle, 0.0)) | (numbers < min(middle / _UNUSUAL, middle))
    rough = np.full(numbers.size, np.nan)
    rough[1:-1] = np.linalg.norm(readings[2:] - 2.0 * readings[1:-1] + readings[:-2], axis=1)
    if not (np.isfinite(rough[odd]).sum() >= _LEAST_ODD and np.isfinite(rough[~odd]).any()):
        return none
    among_odd, among_usual = (float(np.nanmedian(rough[rows])) for rows in (odd, ~odd))
    return odd if among_odd > _UNUSUAL * among_usual or among_odd == 0.0 < among_usual else none


def impossible(quantity: str, values: FloatArray) -> BoolArray:
    """Find readings that cannot be, such as the -32.768 m/s of a DVL without bottom lock.

    Of values (k, m) in the units of the records; none are found where the unit is more likely
    wrong.
    """
    most = largest(quantity)
    with np.errstate(invalid="ignore"):
        size = np.abs(values).max(axis=1, initial=0.0)
        beyond = size > most
        near = (size > _EMPTY_BELOW * most) & ~beyond
    count = int(beyond.sum())
    unit_is_wrong = count > _MOST_IMPOSSIBLE * beyond.size or 10 * int(near.sum()) > count
    return np.zeros_like(beyond) if unit_is_wrong else np.asarray(beyond)


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
    flags = (*data_of("topics")["flags"].get(kind, ()), *_ANY_FLAGS)
    weighed = data_of("topics")["weighed"]
    weighed = weighed["names"] if kind in weighed["quantities"] else ()
    found = []
    above = _shared(numbers)
    for length in range(len(above), -1, -1):
        here = above[:length]
        beside = value_at(probe, here)
        for name, flag in beside.items() if isinstance(beside, dict) else ():
            # "isValid" is "is_valid"; a bool of a binary message is a number
            plain = "_".join(word.lower() for word in _WORD.findall(name))
            # tables in time have whole numbers as floats; "h" may be a height there, and "valid"
            # of another sensor
            is_own = plain.endswith(("_valid", "_lock")) and plain not in _ANY_FLAGS
            counts = is_own or not isinstance(flag, float)
            if plain in flags and counts and flag in (0, 1, *LETTERS):
                found.append(Flag((*here, name), 1.0, 1.0, f"{name} calls valid"))
            elif plain in weighed and isinstance(flag, int | float):
                says = f"are as {name} usually has them"
                found.append(Flag((*here, name), 0.0, 0.0, says, weighed=True))
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
