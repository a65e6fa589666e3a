"""Channels of a run on one time base; nothing is made up where readings are missing."""

from collections.abc import Sequence
from pathlib import PurePath

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.ingest.pool_run_health import GAP_PERIODS
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import QUANTITIES, OffRow, RunTable, mean_held
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.run_notes import run_of

_MOST_ROWS = 50_000_000
#: Of the table on which channels are compared; a day of it, as a clock that jumps makes many.
TABLE_HZ, _MOST_COMPARED = 20.0, 1_800_000
#: Quantities with a column a thruster, and how their columns begin in the channels.
_OF_THRUSTERS = {"command": "command.", "shaft_speed": "shaft_speed_rpm."}
#: Quantity of a channel -> quantity of the table, where they are called otherwise.
_CALLED = {"thruster_command": "command"}
#: What the velocity in body axes is made of where the sensor gives it over the earth.
_TURNED = ("velocity_earth", "attitude")


def _place_on(
    channel: RunChannel, source_s: FloatArray, readings: FloatArray, time_s: FloatArray
) -> FloatArray:
    """Interpolate readings (k, n) at times (m,) [s], or hold them; nan where nothing is known."""
    values = np.full((time_s.size, readings.shape[1]), np.nan)
    if not source_s.size:
        return values
    # a stamp that agrees with a row of the table to a nanosecond belongs to it
    after: IntArray = np.searchsorted(source_s, time_s + 1e-9, side="right")
    before, longest = after - 1, _longest_hold(channel)
    left, right = np.maximum(before, 0), np.minimum(after, source_s.size - 1)
    since = time_s - source_s[left]
    if channel.holds:
        there = (before >= 0) & (since <= longest)
        values[there] = readings[before[there]]
        return values
    exact = (before >= 0) & (np.abs(since) <= 1e-9)
    width = source_s[right] - source_s[left]
    there = exact | ((before >= 0) & (after < source_s.size) & (width <= longest))
    share = np.where(exact | (width <= 0), 0.0, since / np.where(width > 0, width, 1.0))
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
    return values


def kept_readings(channel: RunChannel, begin_ns: int) -> tuple[FloatArray, FloatArray]:
    """Return times (k,) [s] and values (k, n) of the readings that count, sorted, one a time."""
    kept = channel.usable()
    if kept.all() and (np.diff(channel.time_ns) > 0).all():
        return (channel.time_ns - begin_ns) / 1e9 - channel.delay_s, channel.values
    time_ns = channel.time_ns[kept] - begin_ns
    order = np.argsort(time_ns, kind="stable")
    time_ns, readings = time_ns[order], channel.values[kept][order]
    if time_ns.size:
        # of several readings of one time the last holds
        last = np.concatenate([np.diff(time_ns) > 0, [True]])
        time_ns, readings = time_ns[last], readings[last]
    return time_ns / 1e9 - channel.delay_s, readings


def _longest_hold(channel: RunChannel) -> float:
    """Say how far apart two readings may be for a value between them [s]."""
    if not channel.is_regular or not np.isfinite(channel.period_s):
        return float("inf") if channel.holds else max(1.0, 5.0 * channel.period_s)
    if channel.holds:
        return max(1.0, 10.0 * channel.period_s)
    timely = channel.timely()
    steps = np.diff(channel.time_ns[timely]) / 1e9
    marked = channel.marks.get("after_gap")
    if marked is not None:  # else no gap was found; what left-out readings tear open is one
        steps = steps[~marked[timely][1:] & (steps > 0)]
    return float(max(GAP_PERIODS * channel.period_s, steps.max() if steps.size else 0.0))


def resample(
    run: PoolRun,
    rate_hz: float,
    *,
    quantities: Sequence[str] | None = None,
    by_step: bool = False,
    off_rows: bool = True,
) -> RunTable:
    """Put the channels of a run onto one evenly spaced time base.

    Sensors are interpolated between the two readings around (quaternions on the shorter arc); a
    command holds until the next. No value is made up in a gap, before the first or after the last
    reading: it is not a number and `valid` is False. Readings with the marks of
    `LEFT_OUT_OF_TABLES` take no part and are counted. A thruster without a command has 0, one
    without shaft speed is not a number, and `notes` say so. Where only the velocity over the earth
    was measured, the attitude turns it into body axes.

    Parameters
    ----------
    run : PoolRun
        The run; known delays are taken off.
    rate_hz : float
        Rate of the table. Below the rate of a sensor, its noise above half of it folds back. [Hz]
    quantities : sequence of str, optional
        Names of `QUANTITIES`; default all that the run has.
    by_step : bool
        Each row has the mean of the commands over the step that follows it, for simulation from row
        to row: the one at the row would be late by half a step on average, as if the drives lagged.
    off_rows : bool
        Keep how readings differ from the rows nearest to them.

    Raises
    ------
    CannotComputeError
        For a rate or times that make no table, or a quantity that the run does not have.
    """
    by_quantity: dict[str, list[RunChannel]] = {}
    for channel in run.channels.values():
        called = _CALLED.get(channel.quantity, channel.quantity)
        by_quantity.setdefault(called, []).append(channel)
    time_s, begin_ns = _time_base(run, rate_hz), run.start_time_ns
    values: dict[str, FloatArray] = {}
    valid: dict[str, BoolArray] = {}
    reading: dict[str, BoolArray] = {}
    off_row: dict[str, OffRow] = {}
    notes: list[str] = []
    wanted = _wanted(run, by_quantity, quantities)
    # those of the log where the vehicle file states none
    every = [name for one in _OF_THRUSTERS for name in thrusters_of(run, one)]
    names = run.thrusters or tuple(dict.fromkeys(every))
    for quantity in wanted:
        if quantity == "velocity" and quantity not in by_quantity:
            parts = [placed_on(by_quantity[name][0], begin_ns, time_s) for name in _TURNED]
            there = parts[0][1] & parts[1][1]
            values[quantity] = into_body(parts[0][0], parts[1][0])
            valid[quantity], reading[quantity] = there, parts[0][2] & there
            notes.append("velocity: measured over the earth and turned by the attitude")
            continue
        channels = by_quantity[quantity]
        if quantity in _OF_THRUSTERS:
            step_s = 1.0 / rate_hz if by_step and quantity == "command" else 0.0
            placed, said = _of_thrusters(quantity, channels, names, begin_ns, time_s, step_s=step_s)
            notes += said
        else:
            placed = placed_on(channels[0], begin_ns, time_s)
            read = kept_readings(channels[0], begin_ns)
            off = OffRow.of(time_s, placed[0], *read) if off_rows else None
            if off is not None:
                off_row[quantity] = off
        values[quantity], valid[quantity], reading[quantity] = placed
    return RunTable(
        run_of(PurePath(run.file)),
        time_s,
        values,
        valid,
        tuple(notes),
        reading,
        off_row,
        names,
        begin_ns,
        _left_out(run, wanted),
    )


def on_one_base(run: PoolRun) -> RunTable:
    """Resample what is compared; raises `CannotComputeError` where times make no such table."""
    rows = TABLE_HZ * run.duration_s
    if rows > _MOST_COMPARED:
        raise CannotComputeError(f"a table of {rows:.0f} rows is too long")
    return resample(run, TABLE_HZ, off_rows=False)


def thrusters_of(run: PoolRun, quantity: str) -> tuple[str, ...]:
    """Names of the thrusters with a "command" or "shaft_speed", in the vehicle file's order."""
    found = {
        column.removeprefix(_OF_THRUSTERS[quantity]): None
        for channel in run.channels.values()
        if _CALLED.get(channel.quantity, channel.quantity) == quantity
        for column in channel.columns
    }
    stated = [name for name in run.thrusters if name in found]
    return (*stated, *(name for name in found if name not in stated))


def _wanted(
    run: PoolRun, by_quantity: dict[str, list[RunChannel]], quantities: Sequence[str] | None
) -> list[str]:
    has = [name for name in QUANTITIES if name in by_quantity]
    if "velocity" not in has and set(_TURNED) <= set(by_quantity):
        has.append("velocity")
    if quantities is None:
        return has
    missing = [name for name in quantities if name not in has]
    if missing:
        raise CannotComputeError(
            f"{run.file}: there is no {', '.join(missing)}; the run has {', '.join(has)}"
        )
    return list(quantities)


def _time_base(run: PoolRun, rate_hz: float) -> FloatArray:
    begin, end = run.start_time_ns, run.end_time_ns
    if not 0 < rate_hz <= 1e5 or end < begin:
        raise CannotComputeError(
            f"{run.file}: no table with {rate_hz:g} Hz over {(end - begin) / 1e9:g} s"
        )
    count = int((end - begin) / 1e9 * rate_hz + 1e-6) + 1
    if count > _MOST_ROWS:
        raise CannotComputeError(f"{run.file}: a table of {count} rows is too long")
    return np.arange(count) / rate_hz


def placed_on(
    channel: RunChannel, begin_ns: int, time_s: FloatArray, step_s: float = 0.0
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Values (m, k) of a channel, where there are any (m,), and the samples of readings (m,).

    Time is 0 at `begin_ns` on the clock of the log. With `step_s` the values are the means of what
    is held over that time from each sample on. [s]
    """
    own_s, own = kept_readings(channel, begin_ns)
    values = _place_on(channel, own_s, own, time_s + 0.5 * step_s)
    there: BoolArray = np.asarray(np.isfinite(values).all(axis=1))
    if step_s > 0.0 and there.any():
        values = np.where(there[:, None], mean_held(own_s, own, time_s, step_s), np.nan)
    return values, there, _nearest(own_s, time_s) & there


def _nearest(source_s: FloatArray, time_s: FloatArray) -> BoolArray:
    """Mark the sample nearest to each reading."""
    period_s = float(time_s[1] - time_s[0]) if time_s.size > 1 else 1.0
    index: IntArray = np.rint(source_s / period_s).astype(np.int64)
    marked = np.zeros(time_s.size, np.bool_)
    marked[index[(index >= 0) & (index < time_s.size)]] = True
    return marked


def _of_thrusters(
    quantity: str,
    channels: Sequence[RunChannel],
    names: Sequence[str],
    begin_ns: int,
    time_s: FloatArray,
    *,
    step_s: float,
) -> tuple[tuple[FloatArray, BoolArray, BoolArray], list[str]]:
    """Put the channels of a quantity together, a column for each name; as `placed_on`."""
    empty = 0.0 if quantity == "command" else np.nan
    values = np.full((time_s.size, len(names)), empty)
    valid = np.ones(time_s.size, np.bool_)
    reading = np.zeros(time_s.size, np.bool_)
    missing = dict.fromkeys(names)
    for channel in channels:
        new, there, nearest = placed_on(channel, begin_ns, time_s, step_s)
        valid &= there
        reading |= nearest
        for column, name in zip(new.T, channel.columns, strict=True):
            thruster = name.removeprefix(_OF_THRUSTERS[quantity])
            if thruster in missing:
                values[:, names.index(thruster)] = column
                del missing[thruster]
    said = []
    if missing:
        meant = "0 is taken" if quantity == "command" else "not measured"
        said.append(f"{quantity}: none in the log for {', '.join(missing)}; {meant}")
    return (values, valid, reading & valid), said


def into_body(velocity_ned: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Turn vectors (m, 3) from NED into body axes; quaternion w, x, y, z (m, 4) body to NED."""
    w, vector = quaternion[:, :1], -quaternion[:, 1:]
    turned = 2.0 * np.cross(vector, velocity_ned)
    return np.asarray(velocity_ned + w * turned + np.cross(vector, turned))


def _left_out(run: PoolRun, wanted: Sequence[str]) -> dict[str, dict[str, int]]:
    """Count the readings that take no part, by channel and mark."""
    found: dict[str, dict[str, int]] = {}
    for name, channel in run.channels.items():
        called = _CALLED.get(channel.quantity, channel.quantity)
        if called not in wanted and not (called == "velocity_earth" and "velocity" in wanted):
            continue
        kept = channel.usable()
        if not kept.all():
            found[name] = {
                mark: int((rows & ~kept).sum())
                for mark, rows in channel.marks.items()
                if (rows & ~kept).any()
            }
    return found
