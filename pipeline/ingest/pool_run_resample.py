"""Channels of a run on one time base."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.ingest.pool_run_health import GAP_PERIODS
from pipeline.records.run_arrays import PoolRun, RunChannel, RunTable
from pipeline.types import BoolArray, FloatArray, IntArray

_MOST_ROWS = 50_000_000


def resample(
    run: PoolRun,
    rate_hz: float,
    *,
    channels: Sequence[str] | None = None,
    begin_ns: int | None = None,
    end_ns: int | None = None,
) -> RunTable:
    """Put the channels of a run onto one evenly spaced time base.

    A reading stands at its time less its known delay. Sensors are interpolated on a line between
    the two readings around (quaternions on the shorter arc, normalised); a command holds until the
    next. No value is made up in a gap, before the first or after the last reading: it is not a
    number and `valid` is False. Readings with the marks of `LEFT_OUT_OF_TABLES` take no part and
    are counted.

    Parameters
    ----------
    run : PoolRun
        The run.
    rate_hz : float
        Rate of the table. Below the rate of a sensor, its noise above half of it folds back. [Hz]
    channels : sequence of str, optional
        Names of channels; default all.
    begin_ns, end_ns : int, optional
        Times on the clock of the log; default the whole run. [ns]

    Returns
    -------
    RunTable
        Times count from `begin_ns`.

    Raises
    ------
    CannotComputeError
        For a rate or times that make no table, or a channel that the run does not have.
    """
    names = list(run.channels) if channels is None else list(channels)
    missing = [name for name in names if name not in run.channels]
    if missing:
        raise CannotComputeError(
            f"{run.file}: there is no channel {', '.join(missing)}; the run has "
            f"{', '.join(run.channels)}"
        )
    begin = run.start_time_ns if begin_ns is None else begin_ns
    end = run.end_time_ns if end_ns is None else end_ns
    if not 0 < rate_hz <= 1e5 or end < begin:
        raise CannotComputeError(
            f"{run.file}: no table with {rate_hz:g} Hz over {(end - begin) / 1e9:g} s"
        )
    count = int((end - begin) / 1e9 * rate_hz + 1e-6) + 1
    if count > _MOST_ROWS:
        raise CannotComputeError(f"{run.file}: a table of {count} rows is too long")
    time_s = np.arange(count) / rate_hz
    columns: list[str] = []
    values: list[FloatArray] = []
    valid: list[BoolArray] = []
    left_out: dict[str, dict[str, int]] = {}
    for name in names:
        channel = run.channels[name]
        new, there = _one_channel(channel, begin, time_s)
        columns += channel.columns
        values.append(new)
        valid.append(np.repeat(there[:, None], new.shape[1], axis=1) & np.isfinite(new))
        kept = channel.usable()
        if not kept.all():
            left_out[name] = {
                mark: int((rows & ~kept).sum())
                for mark, rows in channel.marks.items()
                if (rows & ~kept).any()
            }
    none = np.empty((count, 0))
    return RunTable(
        begin,
        rate_hz,
        time_s,
        tuple(columns),
        np.concatenate([none, *values], axis=1),
        np.concatenate([none.astype(np.bool_), *valid], axis=1),
        left_out,
    )


def _one_channel(
    channel: RunChannel, begin_ns: int, time_s: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Values (n, m) of a channel at the times of a table, and where there are any (n,)."""
    source_s, readings = _in_order(channel, begin_ns)
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


def _in_order(channel: RunChannel, begin_ns: int) -> tuple[FloatArray, FloatArray]:
    """Return times [s] and values of the readings that count, sorted, one a time."""
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
    steps = np.diff(channel.time_ns) / 1e9
    usual = steps[~marked[1:] & (steps > 0)]
    return float(max(GAP_PERIODS * channel.period_s, usual.max() if usual.size else 0.0))


def _longest_step(channel: RunChannel) -> float:
    steps = np.diff(channel.time_ns) / 1e9
    return float(steps.max()) if steps.size else 0.0
