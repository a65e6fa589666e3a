"""What is wrong with single readings of a channel: found and marked, nothing is changed.

`pipeline.records.run_arrays.MARKS` says what the marks mean.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.records.run_table import continuous, stretches
from pipeline.types import BoolArray, FloatArray, IntArray

#: A step between readings of more periods than this is a gap.
GAP_PERIODS = 3.0
#: Frozen: as many equal readings in a row, and as long. [s]
_FROZEN_READINGS = 10
_FROZEN_S = 0.5
#: Saturated: as many readings in a row at the very end of all that were met.
_SATURATED_READINGS = 5
#: A sensor that repeats more of its readings is read faster than it measures.
_MOST_REPEATS = 0.3
_SPIKE_SIGMAS = 12.0
_MOST_LOOKED_AT = 20_000
#: Readings on either side of a spike that say how noisy the sensor is there.
_SPIKE_NEIGHBOURS = 25
#: A dropout is a step to zero and back, larger than so many usual steps.
_DROPOUT_STEPS = 8.0
#: A number that stands for none recurs, and few other readings are as near to it; so many of them.
_RECURS, _MOST_NEAR, _MOST_NUMBERS = 5, 0.005, 3
#: Readings that follow no slower may be noise alone, over so many seconds; means of it over a
#: second vary by this much more than they would.
_LONGEST_OF_NOISE_S, _FEWEST_SECONDS, _NOISE_ALONE = 0.2, 20, 2.5
_NORMAL = 1.4826
#: What is larger comes of damaged bytes, in whatever unit.
_LARGEST = 1e15


@dataclass(frozen=True)
class Rhythm:
    """How readings follow each other. `gaps` are steps (k - 1,) that are too long."""

    period_s: float
    is_regular: bool
    gaps: BoolArray
    longest_gap_s: float


def rhythm_of(time_ns: IntArray) -> Rhythm:
    """Find period and gaps; irregular readings, as commands sent on change are, have none."""
    step = np.diff(time_ns) / 1e9
    forward, gaps = step[step > 0], np.zeros(step.size, np.bool_)
    if not forward.size:
        return Rhythm(float("nan"), is_regular=False, gaps=gaps, longest_gap_s=0.0)
    period, mean = float(np.median(forward)), float(forward.mean())
    steady = (forward > 0.25 * period) & (forward < 4.0 * period)
    if period < 0.5 * mean and float(np.quantile(forward, 0.99)) < 10.0 * mean:
        # logged in bursts (a serial line): the median is far below the mean; the mean is the period
        period, steady = mean, forward < 6.0 * mean
    is_regular = bool(steady.mean() >= 0.9)
    if is_regular:
        gaps = step > max(GAP_PERIODS, 3.0 * float(np.quantile(forward, 0.9)) / period) * period
    return Rhythm(period, is_regular, gaps, float(forward.max()))


def time_marks(time_ns: IntArray, values: FloatArray, rhythm: Rhythm) -> dict[str, BoolArray]:
    """Mark what is wrong with the order of times (k,) [ns]; readings (k, m) tell duplicates."""
    if time_ns.size < 2:
        return {}
    same_time, same = _second(np.diff(time_ns) == 0), _repeats(values)
    return _met(
        {
            "out_of_order": _second(time_ns[1:] < np.maximum.accumulate(time_ns)[:-1]),
            "duplicate": same_time & same,
            "same_stamp": same_time & ~same,
            "after_gap": _second(rhythm.gaps),
        }
    )


def _met(marks: dict[str, BoolArray]) -> dict[str, BoolArray]:
    return {name: mark for name, mark in marks.items() if mark.any()}


def _second(pairs: BoolArray) -> BoolArray:
    """Mark the second of each two neighbours (k - 1,) that are found."""
    return np.concatenate([[False], pairs])


def value_marks(
    values: FloatArray,
    period_s: float,
    *,
    is_quaternion: bool = False,
    jumps: bool = False,
    lowest: float | None = None,
    highest: float | None = None,
) -> dict[str, BoolArray]:
    """Mark what is wrong with readings (k, m) that follow at `period_s`.

    q and -q are one attitude: a change of all signs is no spike, and its components have ends of
    their own: level is w = 1. Shaft speeds follow commands that jump to and fro (`jumps`): they
    have no spikes. `lowest` and `highest` are the range of the sensor, in the unit of the readings.
    """
    finite = _are_readings(values)
    marks = {"not_a_number": ~finite}
    if not finite.all():
        values = np.where(finite[:, None], values, np.nan)
    has_range = lowest is not None or highest is not None
    if has_range:
        low, high = -np.inf if lowest is None else lowest, np.inf if highest is None else highest
        width = high - low if np.isfinite(high - low) else abs(low if highest is None else high)
        marks |= _range_marks(values, (low, high), 1e-6 * width)
    is_constant = all(np.fmin.reduce(one) == np.fmax.reduce(one) for one in values.T if one.size)
    if values.shape[0] < 10 or not finite.any() or is_constant:
        return _met(marks)  # constant throughout: said of the channel, not of its readings
    marks["dropout"] = _dropouts(values, jumps=jumps or is_quaternion)
    repeats = _repeats(values) & finite
    if repeats.mean() < _MOST_REPEATS:
        if not has_range and not is_quaternion:
            marks["saturated"] = _at_the_end(values)
        least = max(_FROZEN_READINGS, round(_FROZEN_S / period_s) if period_s > 0 else 0)
        frozen = _runs(repeats, least - 1)
        frozen[:-1] |= frozen[1:] & repeats[1:]  # the reading that is repeated, too
        marks["frozen"] = frozen & ~marks["dropout"] & ~marks.get("saturated", np.False_)
    if not jumps:
        columns = continuous(values) if is_quaternion else values
        marks["spike"] = np.any([_spikes(column) for column in columns.T], axis=0)
    return _met(marks)


def is_noise_alone(values: FloatArray, period_s: float) -> bool:
    """Tell whether readings (k, m) never tell more than noise: none lasts for a second.

    The means over a second of what is noise alone differ as little as their number lets them.
    """
    count = round(1.0 / period_s) if 0.0 < period_s < _LONGEST_OF_NOISE_S else 0
    seconds = len(values) // max(count, 1)
    if count < 5 or seconds < _FEWEST_SECONDS:
        return False
    parts = values[: seconds * count].reshape(seconds, count, -1)
    means, within = parts.mean(axis=1), parts.var(axis=1, ddof=1).mean(axis=0) / count
    return bool((within > 0.0).any() and (means.var(axis=0) < _NOISE_ALONE * within).all())


def command_marks(
    values: FloatArray, lowest: FloatArray, highest: FloatArray
) -> dict[str, BoolArray]:
    """Mark commands (k, m) at and beyond the range (m,) of their drives."""
    beyond = _range_marks(values, (lowest, highest), 0.5)
    return _met({"not_a_number": ~_are_readings(values), **beyond})


def _are_readings(values: FloatArray) -> BoolArray:
    """Tell which rows hold nothing but numbers that a sensor can give."""
    # column by column: NumPy is slow along short axes
    good = np.ones(values.shape[0], np.bool_)
    for column in values.T:
        good &= np.abs(column) < _LARGEST
    return good


def _range_marks(
    values: FloatArray, ends: tuple[FloatArray | float, FloatArray | float], slack: float
) -> dict[str, BoolArray]:
    """Mark readings beyond the lowest and the highest value, or as near to them as `slack`."""
    low, high = ends
    with np.errstate(invalid="ignore"):
        beyond = (values > high + slack) | (values < low - slack)
        at_end = ((values >= high - slack) | (values <= low + slack)) & ~beyond
    marks = {"outside_range": beyond, "saturated": at_end}
    return {name: np.asarray(rows.any(axis=1)) for name, rows in marks.items()}


def _repeats(values: FloatArray) -> BoolArray:
    """Mark readings equal to the one before in all components; not a number equals itself."""
    same = np.ones(max(values.shape[0] - 1, 0), np.bool_)
    for column in values.T:
        now, before = column[1:], column[:-1]
        same &= (now == before) | (np.isnan(now) & np.isnan(before))
    return _second(same)[: values.shape[0]]


def _dropouts(values: FloatArray, *, jumps: bool) -> BoolArray:
    """Mark one number that stands for no reading: 0, or another that recurs far from all others.

    All components have it. Zeros may also be those of a vehicle at rest: runs of them count that
    are jumped into or out of. Any other number, and zeros one by one, are jumped into and out of,
    and no other reading is near them; where readings `jump` anyway these are not looked for.
    """
    found = np.zeros(values.shape[0], np.bool_)
    same = np.all([column == values[:, 0] for column in values.T], axis=0)
    if values.shape[1] == 1:  # a number far from all others is the least or the largest
        same &= (values[:, 0] == np.nanmin(values)) | (values[:, 0] == np.nanmax(values))
    numbers, counts = np.unique(values[same, 0], return_counts=True)
    recurring = numbers[(counts >= _RECURS) & (counts <= 0.5 * values.shape[0])]
    zeros = np.zeros(1) if values.shape[1] >= 3 else np.zeros(0)
    for number in np.union1d(recurring[-_MOST_NUMBERS:], zeros):
        at = same & (values[:, 0] == number)
        if not at.any() or at.mean() > 0.5:
            continue
        steps = np.linalg.norm(np.diff(values, axis=0), axis=1)
        others = values[~at & np.isfinite(values).all(axis=1)]
        inside = np.linalg.norm(np.diff(others, axis=0), axis=1)
        usual = float(np.quantile(inside, 0.95)) if inside.size else 0.0
        far = np.linalg.norm(values - number, axis=1) > _DROPOUT_STEPS * usual
        alone = number in recurring and usual > 0.0 and not jumps
        alone = alone and bool((~far & ~at & np.isfinite(values[:, 0])).mean() < _MOST_NEAR)
        for begin, end in stretches(at):
            ends = [row for row in (begin - 1, end - 1) if 0 <= row < steps.size]
            away = steps[ends] > _DROPOUT_STEPS * usual
            if (alone and away.all()) or (
                number == 0.0 and zeros.size and end - begin >= 3 and away.any()
            ):
                found[begin:end] = True
    return found


def _runs(mark: BoolArray, least: int) -> BoolArray:
    """Keep runs of at least so many."""
    kept = np.zeros(mark.size, np.bool_)
    for begin, end in stretches(mark):
        kept[begin:end] = end - begin >= least
    return kept


def _at_the_end(values: FloatArray) -> BoolArray:
    """Mark readings at the largest or smallest value of all, if they stay there for a while."""
    found = np.zeros(values.shape[0], np.bool_)
    for column in values.T:
        low, high = np.fmin.reduce(column), np.fmax.reduce(column)
        for end in (low, high) if low < high else ():
            at_end = column == end
            if _runs(at_end, _SATURATED_READINGS).any():
                found |= at_end
    return found


def _spikes(column: FloatArray) -> BoolArray:
    """Single readings far from both neighbours, which agree, by the noise and the sensor's step."""
    found = np.zeros(column.size, np.bool_)
    middle = column[1:-1] - 0.5 * (column[:-2] + column[2:])
    finite = np.isfinite(middle)
    if finite.sum() < 8:
        return found
    # the usual noise, from some thousand readings spread over the run
    apart = max(1, middle.size // _MOST_LOOKED_AT)
    step = np.abs(column[1:-1] - column[:-2])[::apart]
    moving = step[np.isfinite(step) & (step > 0)]
    if not moving.size:
        return found
    sigma = _NORMAL * float(np.median(np.abs(middle[finite][::apart])))
    # where most readings repeat, the median says nothing: take what moves
    usual = max(sigma, 0.5 * float(np.median(moving)))
    with np.errstate(invalid="ignore"):
        far = np.abs(middle) > _SPIKE_SIGMAS * usual
        agree = np.abs(column[2:] - column[:-2]) < 0.25 * np.abs(middle)
    rows = np.flatnonzero(far & agree & finite)
    if rows.size:
        # noise may differ from one part of a run to another
        around = rows[:, None] + np.arange(-_SPIKE_NEIGHBOURS, _SPIKE_NEIGHBOURS + 1)
        size = np.where(finite, np.abs(middle), 0.0)[np.clip(around, 0, middle.size - 1)]
        local = _NORMAL * np.median(size, axis=1)
        rows = rows[np.abs(middle[rows]) > _SPIKE_SIGMAS * local]
    found[rows + 1] = True
    return found
