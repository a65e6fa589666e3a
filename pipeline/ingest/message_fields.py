"""What a message says beside its numbers: its time, its frame, whether the readings are valid."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from pipeline.ingest.data_files import data_of
from pipeline.ingest.message_definitions import Path
from pipeline.ingest.pool_run_codec import value_at
from pipeline.ingest.quantities import largest
from pipeline.ingest.thruster_names import words_of
from pipeline.types import BoolArray, FloatArray, IntArray

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
_MOST_FLAGS, _MOST_BEAMS = 12, 8
#: Validity by letters, as NMEA 0183 and DVLs after it write it.
LETTERS = {"A": 1.0, "V": 0.0}
#: So many times as much is another quality, or roughness; fewer readings say nothing of it; of more
#: values a status has none.
_UNUSUAL, _LEAST_ODD, _LEAST_WEIGHED, _MOST_STATES = 3.0, 3, 20, 4
#: Share of the steps between readings that a jump goes beyond.
_MOST_STEPS = 0.95
#: Numbers that stand for words are above it: no reading is as large.
_WORDS_ABOVE = 1e16


def points_down(frames: str) -> bool:
    """Tell whether names of frames say that z points down: one of their words is frd or ned.

    >>> points_down("map_ned"), points_down("odom_combined")
    (True, False)
    """
    return not _DOWNWARDS.isdisjoint(words_of(frames))


def is_earth(frame: str) -> bool:
    """Tell whether a frame does not move with the vehicle.

    >>> is_earth("map"), is_earth("odom_combined"), is_earth("base_link_ned"), is_earth("")
    (True, True, False, False)
    """
    words = {one for one in words_of(frame) if one.isalpha()}
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
    """Where a message says its time; one of the first field is worth `unit_ns`."""

    first: Path
    unit_ns: int = _SECOND_NS
    nanoseconds: Path | None = None

    @property
    def parts(self) -> tuple[tuple[Path, int], ...]:
        """Where each part of the time stands, and what one of it is worth. [ns]."""
        rest = () if self.nanoseconds is None else ((self.nanoseconds, 1),)
        return ((self.first, self.unit_ns), *rest)


def ticks_ns(numbers: npt.NDArray[Any], unit_ns: int) -> IntArray:
    """Convert clock readings to nanoseconds; integers stay exact."""
    if numbers.dtype.kind in "iu":
        # beyond 292 years it is no time; the product would wrap round
        most = np.iinfo(np.int64).max // unit_ns
        no_time = (numbers > most) | (numbers < -most)
        return np.where(no_time, NO_STAMP, np.where(no_time, 0, numbers).astype(np.int64) * unit_ns)
    with np.errstate(invalid="ignore", over="ignore"):
        exact = numbers.astype(np.float64) * float(unit_ns)
        no_time = ~(np.abs(exact) < 9.0e18)
        return np.where(no_time, NO_STAMP, np.rint(np.where(no_time, 0.0, exact)).astype(np.int64))


def stamps_of(
    column: Callable[[Path], npt.NDArray[Any] | None], stamp: Stamp, count: int
) -> IntArray:
    """Return the times (k,) of messages, `NO_STAMP` for none; `column` gives numbers by path."""
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


def number_of_text(text: str, *, is_flag: bool = False) -> float | int | None:
    """Return a number that JSON writes as text (64-bit integers, times of ISO 8601 in seconds).

    Any word of a flag is a number of its own, that of truth values 1 and 0.

    >>> number_of_text("12"), number_of_text("V"), number_of_text("no")
    (12, 0.0, None)
    >>> number_of_text("LOST", is_flag=True) == number_of_text("OK", is_flag=True)
    False
    """
    if text in LETTERS:
        return LETTERS[text]
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return _WORDS_ABOVE + 4.0 * crc32(text.encode()) if is_flag else None


@dataclass(frozen=True)
class Flag:
    """A number of a message that says whether its readings are valid: from `least` to `most`.

    What a number that is `weighed` means nobody can know by its name: the readings tell.
    """

    path: Path
    least: float
    most: float
    says: str
    weighed: bool = False
    by_name: bool = True
    """Whether its name says that it is of validity; else it must be a state of few values."""

    @property
    def is_telling(self) -> bool:
        """Whether it is said also where all readings are valid; a covariance is there always."""
        return not isinstance(self.path[-1], int) and not self.weighed

    def invalid(self, numbers: FloatArray, readings: FloatArray) -> BoolArray:
        """Tell which readings (k, m) are not valid; a flag that is missing says nothing."""
        with np.errstate(invalid="ignore"):
            beyond = np.asarray((numbers < self.least) | (numbers > self.most))
        if not self.weighed:
            return beyond
        known = np.where(beyond, np.nan, numbers)
        return np.asarray(beyond | _unlike(known, readings, by_name=self.by_name))


def _unlike(numbers: FloatArray, readings: FloatArray, *, by_name: bool) -> BoolArray:
    """Find readings (k, m) with another status or quality than usual that are unlike the others.

    They are rougher, stand still, or are jumped into and out of. What a name does not say to be of
    validity may be of the motion, in which readings are not noise.
    """
    left_out = np.zeros(numbers.size, np.bool_)
    known = numbers[np.isfinite(numbers)]
    if known.size < _LEAST_WEIGHED:
        return left_out
    states, counts = np.unique(known, return_counts=True)
    if states.size < 2:
        return left_out
    step, rough = np.full((2, numbers.size), np.nan)
    with np.errstate(invalid="ignore", over="ignore"):  # damaged bytes are any number
        step[1:] = np.linalg.norm(np.diff(readings, axis=0), axis=1)
        rough[1:-1] = np.linalg.norm(np.diff(readings, 2, axis=0), axis=1)
        if states.size <= _MOST_STATES:
            usual = numbers == states[counts.argmax()]
            unusual = [numbers == one for one in states if one != states[counts.argmax()]]
        elif by_name:
            middle = float(np.median(known))
            odd = (numbers > max(_UNUSUAL * middle, 0.0)) | (
                numbers < min(middle / _UNUSUAL, middle)
            )
            usual, unusual = ~odd, [odd]
        else:
            return left_out
    for odd in unusual if np.isfinite(rough[usual]).any() else ():
        if np.isfinite(rough[odd]).sum() < _LEAST_ODD:
            continue
        among_odd, among_usual = (float(np.nanmedian(rough[rows])) for rows in (odd, usual))
        # no vehicle jumps: what does wherever the state changes is of another kind, as a velocity
        # through the water is, however smooth
        borders = step[1:][odd[1:] != odd[:-1]]
        most = _UNUSUAL * float(np.nanquantile(step[usual], _MOST_STEPS))
        jumps = min(among_odd, among_usual) > 0.0 and bool((borders > most).all())
        is_noise = by_name or among_odd > float(np.nanmedian(step[odd]))
        stands = by_name and among_odd == 0.0 < among_usual
        if jumps or stands or (is_noise and among_odd > _UNUSUAL * among_usual):
            left_out |= odd
    return left_out


def impossible(quantity: str, values: FloatArray) -> BoolArray:
    """Find readings (k, m) that cannot be, such as the -32.768 m/s of a DVL without bottom lock.

    None are found where the unit is more likely wrong.
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

    It stands beside the components (`numbers`) or above them: truth values whose name says that
    the reading is good or bad, and nothing of another quantity; the mode and the beams of
    marine_acoustic_msgs/Dvl, whose velocity may be that through the water; a covariance that
    begins with -1, which in sensor_msgs is "no estimate". Other states are weighed.
    """
    if not numbers:
        return ()
    kind = quantity.removesuffix("_earth")
    found: list[Flag] = []
    weighed: list[Flag] = []
    above = _shared(numbers)
    for length in range(len(above), -1, -1):
        here = above[:length]
        beside = (one for one in _beside(value_at(probe, here), here) if one[0] not in numbers)
        for flag in filter(None, (_flag(path, value, kind) for path, value in beside)):
            (weighed if flag.weighed else found).append(flag)
        if kind == "velocity":
            mode, beams = ((*here, one) for one in ("velocity_mode", "num_good_beams"))
            of_dvl = (
                Flag(mode, 0.0, 1.0, "velocity_mode says are over ground"),
                Flag(beams, 3.0, np.inf, "num_good_beams gives three beams or more"),
            )
            found += [one for one in of_dvl if isinstance(value_at(probe, one.path), int)]
        if found:
            break
    hard = {one.path for one in found}
    weighed.sort(key=lambda one: not one.by_name)
    weighed = [one for one in dict.fromkeys(weighed) if one.path not in hard]
    return (*found, *weighed[:_MOST_FLAGS], *_covariance(probe, above))


def _flag(path: Path, value: float | str, kind: str) -> Flag | None:
    """Return what the name of a number says of the readings of a kind; None for nothing."""
    words = data_of("topics")["validity"]
    first = kind.split("_", maxsplit=1)[0]
    own = {first, *words["of"].get(first, ())}
    name = next(step for step in reversed(path) if isinstance(step, str))
    said = {*words_of(name)}
    good = said & {*words["good"], *words["good_of"].get(kind, ())}
    bad = said & {*words["bad"]}
    is_state = value in (0, 1, *LETTERS)
    rest = said - good - bad - {*words["fill"]}
    # tables in time have whole numbers as floats; "h" may be a height there, and "valid" of another
    # sensor
    is_own = rest <= own and (bool(rest) or not isinstance(value, float))
    if name == path[-1] and is_state and (good or bad) and is_own:
        well = float(bool(good))
        return Flag(path, well, well, f"{name} calls valid")
    by_name = bool(good or bad or said & {*words["quality"]})
    is_mode = isinstance(value, int) and (is_state or bool(said & {*words["mode"]}))
    if kind not in words["weighed"] or not (by_name or is_mode or isinstance(value, str)):
        return None
    says = f"are as {name} usually has them"
    return Flag(path, -np.inf, np.inf, says, weighed=True, by_name=by_name)


def _beside(tree: Any, here: Path) -> Iterator[tuple[Path, Any]]:  # noqa: ANN401  of any type
    """Yield what stands in a part of a message, and in short lists, such as those of beams."""
    for name, value in tree.items() if isinstance(tree, dict) else ():
        some = value if isinstance(value, list) and len(value) <= _MOST_BEAMS else ()
        for at, one in enumerate(some):
            if isinstance(one, dict):
                yield from _beside(one, (*here, name, at))
            elif isinstance(one, int) and one in (0, 1):
                yield (*here, name, at), one
        if isinstance(value, bool | int | float | str):
            yield (*here, name), value


def _shared(numbers: Sequence[Path]) -> Path:
    """Return the longest path that all begin with, without their own last step."""
    shared = numbers[0][:-1]
    while any(path[: len(shared)] != shared for path in numbers):
        shared = shared[:-1]
    return shared


def _covariance(probe: Mapping[str, Any], above: Path) -> list[Flag]:
    """Return the covariance of a vector: ``orientation_covariance``, ``twist.covariance``."""
    texts = tuple(step for step in above if isinstance(step, str))
    names = ("covariance", *(f"{one}_covariance" for one in texts[-1:]))
    for length in range(len(texts), -1, -1):
        for name in names:
            path: Path = (*texts[:length], name, 0)
            if isinstance(value_at(probe, path), int | float):
                says = f"{name} does not call unknown or unusual"
                return [Flag(path, -0.5, np.inf, says, weighed=True)]
    return []
