"""One channel at the times of a table: nothing is made up where readings are missing."""

import numpy as np

from pipeline.ingest.pool_run_health import GAP_PERIODS
from pipeline.records.run_arrays import RunChannel
from pipeline.types import BoolArray, FloatArray, IntArray


def place_on(
    channel: RunChannel, begin_ns: int, time_s: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Interpolate a channel, or hold its values.

    Parameters
    ----------
    channel : RunChannel
        With n columns.
    begin_ns : int
        Where the table's time is 0, on the clock of the log. [ns]
    time_s : ndarray, shape (m,)
        Times of the table. [s]

    Returns
    -------
    values : ndarray, shape (m, n)
        Not a number where nothing is known.
    there : ndarray, shape (m,)
        Where there are any.
    """
    source_s, readings = kept_readings(channel, begin_ns)
    values = np.full((time_s.size, readings.shape[1]), np.nan)
    there = np.zeros(time_s.size, np.bool_)
    if not source_s.size:
        return values, there
    # a stamp that agrees with a row of the table to a nanosecond belongs to it
    after: IntArray = np.searchsorted(source_s, time_s + 1e-9, side="right")
    before = after - 1
    longest = _longest_hold(channel)
    if channel.holds:
        there = (before >= 0) & (time_s - source_s[np.maximum(before, 0)] <= longest)
        values[there] = readings[before[there]]
        return values, there
    exact = (before >= 0) & (np.abs(time_s - source_s[np.maximum(before, 0)]) <= 1e-9)
    between = (before >= 0) & (after < source_s.size)
    left = np.clip(before, 0, source_s.size - 1)
    right = np.clip(after, 0, source_s.size - 1)
    width = source_s[right] - source_s[left]
    there = exact | (between & (width <= longest))
    share = np.where(
        exact | (width <= 0), 0.0, (time_s - source_s[left]) / np.where(width > 0, width, 1.0)
    )
    rows = np.flatnonzero(there)
    first, second = readings[left[rows]], readings[right[rows]]
    if channel.quantity == "attitude":
        # q and -q are the same attitude: the shorter way
        second = second * np.where((first * second).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    mixed = first + share[rows, None] * (second - first)
    mixed[share[rows] == 0.0] = first[share[rows] == 0.0]
    if channel.quantity == "attitude":
        length = np.linalg.norm(mixed, axis=1, keepdims=True)
        mixed = np.where(length > 0, mixed / np.where(length > 0, length, 1.0), np.nan)
    values[rows] = mixed
    return values, there


def kept_readings(channel: RunChannel, begin_ns: int) -> tuple[FloatArray, FloatArray]:
    """Return times (k,) [s] and values (k, n) of the readings that count, sorted, one a time."""
    kept = channel.usable()
    time_ns = channel.time_ns[kept] - begin_ns
    order = np.argsort(time_ns, kind="stable")
    time_ns, readings = time_ns[order], channel.values[kept][order]
    if time_ns.size:
        # of several readings of one time the last holds
        last = np.concatenate([np.diff(time_ns) > 0, [True]])
        time_ns, readings = time_ns[last], readings[last]
    return time_ns / 1e9 - channel.delay_s, readings


def _longest_hold(channel: RunChannel) -> float:
    """Say how far apart two readings may be for a value between them, in seconds.

    Commands that are sent on change hold for any time.
    """
    if not channel.is_regular or not np.isfinite(channel.period_s):
        return float("inf") if channel.holds else max(1.0, 5.0 * channel.period_s)
    if channel.holds:
        return max(1.0, 10.0 * channel.period_s)
    marked = channel.marks.get("after_gap")
    if marked is None:
        # no gap was found; what left-out readings tear open is one
        return max(GAP_PERIODS * channel.period_s, _longest_step(channel))
    timely = channel.timely()
    steps = np.diff(channel.time_ns[timely]) / 1e9
    usual = steps[~marked[timely][1:] & (steps > 0)]
    return float(max(GAP_PERIODS * channel.period_s, usual.max() if usual.size else 0.0))


def _longest_step(channel: RunChannel) -> float:
    steps = np.diff(channel.time_ns[channel.timely()]) / 1e9
    return float(steps.max()) if steps.size else 0.0
