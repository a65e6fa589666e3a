"""A bench log in time: each step of the command counts once, after it has settled."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.rows import counted, listed
from pipeline.types import BoolArray, FloatArray, IntArray

_SETTLING, _AVERAGED = "settling", "averaged"
#: A log holds a step for at least so many rows; with fewer each row is a reading of its own.
_LEAST_ROWS = 4
_LEAST_STEPS = 3
#: Of the largest value of the file: what the rest of a step may differ from its end.
_TOLERANCE = 0.01
#: Above it the value still moved when the command changed; only the end of such a step counts.
_MOVING = 0.03
_LAST_SHARE = 5
#: In a log without times a step is told by its first row, which is still so far from its end.
_LATE = 0.05
#: A log that is written faster than this, and whose command never rests, is a ramp.
_RAMP_PERIOD_S = 0.5
_LEAST_RAMP_ROWS = 40
#: Of a load test's log: what the speed may move in a second, of its largest, over which time it is
#: told, and the least share of rows in which it rests.
_MOST_PER_S, _WINDOW_S, _LEAST_STEADY = 0.03, 0.25, 0.25
#: Of the largest speed: what a speed is measured by at a command at which it all but stands.
_SMALL = 0.1


def settle(table: Table) -> Iterator[Problem]:
    """Average the settled part of each step of a mooring test's log in time.

    The readings, in the order of time, stay as they are where the file is no such log: with fewer
    than four rows a step, or without a time and without steps that settle.
    """
    readings = table.readings
    live = [at for at, one in enumerate(readings) if not one.marks]
    if not live:
        return
    values, time_s, period_s, runs, rows = _in_time(table.live(), table.measured)
    if np.isnan(time_s).any() and not _begin_late(values, runs):
        return
    if rows < _LEAST_ROWS:
        if 0.0 < period_s < _RAMP_PERIOD_S and len(live) >= _LEAST_RAMP_ROWS:
            yield _ramp(table, period_s)
        return
    if len(runs) < _LEAST_STEPS:
        return
    scale = float(np.max(np.abs(values)))
    done = list(readings)
    moving: list[int] = []
    for first, last in runs:
        step = values[first:last]
        start = first + _settled_from(step, scale)
        third = max(1, len(step) // 3)
        before = step[-2 * third : -third] if len(step) > 1 else step
        moved = abs(float(np.mean(step[-third:]) - np.mean(before)))
        if moved > max(_MOVING * scale, 3.0 * noise_of(step[len(step) // 2 :])):
            moving.append(readings[live[first]].row)
            start = max(start, last - max(2, len(step) // _LAST_SHARE))
        for at in live[first:last]:
            done[at] = replace(done[at], marks=(_SETTLING if at < live[start] else _AVERAGED,))
        done[live[start]] = _mean([readings[at] for at in live[start:last]])
    table.readings = done
    yield table.place.note(
        f"a log in time of {counted(len(runs), 'step')} of about {rows:g} rows: each step counts "
        "once, as the mean of its settled rows."
    )
    if moving:
        table.must_go = 3 * len(moving) > len(runs)
        yield Problem(
            "error" if table.must_go else "warning",
            table.at(moving[0]),
            f"the thrust still moves at the end of the steps that begin in {listed(moving)}.",
            "steps that are held until the thrust rests.",
            "Hold each command longer, or mark the rows with #.",
        )


def settle_loads(table: Table) -> Iterator[Problem]:
    """Leave of a load test's log in time what is steady: steps of the load, or a slow ramp of it.

    The readings stay as they are where no times are there or the rows come seldom: each is a
    reading then. Rows in which speed or torque still move are marked, the rows of a step are
    averaged. The table is left out where the command never rests or little else is steady.
    """
    readings = table.readings
    live = [at for at, one in enumerate(readings) if not one.marks]
    speed, _, period_s, runs, rows = _in_time(table.live(), "shaft_speed")
    if len(live) < _LEAST_RAMP_ROWS or not 0.0 < period_s < _RAMP_PERIOD_S:
        return
    if rows < _LEAST_ROWS:
        yield _ramp(table, period_s)
        return
    signals = np.stack([speed, numbers(table.live(), "torque")], axis=1)
    largest = np.abs(signals).max(axis=0) + 1e-12
    done = [one if one.marks else one.marked(_SETTLING) for one in readings]
    steady, steps = 0, 0
    for first, last in runs:
        own = signals[first:last]
        scale = np.maximum(np.abs(own).max(axis=0), _SMALL * largest)
        for part in _stretches(_rests(own[:, 0] / scale[0], period_s), period_s):
            at = [live[first + index] for index in part]
            steady += len(at)
            # a slow ramp is no step
            parts = [one.mean(axis=0) for one in np.array_split(own[part] / scale, _LEAST_ROWS)]
            as_step = bool((np.ptp(parts, axis=0) <= 2.0 * _TOLERANCE).all())
            steps += as_step
            for index in at:
                done[index] = readings[index].marked(*[_AVERAGED] * as_step)
            if as_step:
                done[at[0]] = _mean([readings[index] for index in at])
    if steady < _LEAST_STEADY * len(live):
        problem = table.place.error(
            f"a log in time, a row every {period_s:.3g} s, whose speed rests in {steady} of "
            f"{len(live)} rows only: it lags behind command and load. So the table was left out.",
            "steps of the load that are held until the speed rests, or a slow ramp of it.",
            "Hold each load for some seconds; or write one settled row for each load.",
        )
        yield table.leave_out(problem)
        return
    table.readings = done
    if steps or steady < len(live):
        yield table.place.note(
            f"a log in time: in {steady} of {len(live)} rows the speed rests; "
            f"{counted(steps, 'step')} of these count once each, as the mean."
        )


def _in_time(
    readings: Sequence[Reading], quantity: str
) -> tuple[FloatArray, FloatArray, float, list[tuple[int, int]], float]:
    """Return a quantity, times, their usual step [s], steps of the command, their usual rows."""
    time_s, runs = numbers(readings, "time"), _runs(readings) if readings else []
    period_s = float(np.median(np.diff(time_s))) if len(readings) > 1 else np.inf
    rows = float(np.median([last - first for first, last in runs])) if runs else 0.0
    return numbers(readings, quantity), time_s, period_s, runs, rows


def _rests(speed: FloatArray, period_s: float) -> BoolArray:
    """Tell in which rows the speed, a share of the largest, moves by no more than some per cent.

    In a second: times the time constant of a drive, some tenths of a second, it is the error. The
    load may move: what lags is the speed.
    """
    half = max(2, round(_WINDOW_S / period_s))
    if len(speed) <= 2 * half:
        return np.zeros(len(speed), np.bool_)
    sums = np.concatenate([[0.0], np.cumsum(speed)])
    step = (sums[2 * half :] - 2.0 * sums[half:-half] + sums[: -2 * half]) / half
    noise = 3.0 * noise_of(speed) * (2.0 / half) ** 0.5
    rests = np.abs(step) <= max(_MOST_PER_S * half * period_s, noise)
    return np.pad(rests, (half, len(speed) - half - len(rests)), mode="edge")


def _stretches(rests: BoolArray, period_s: float) -> list[IntArray]:
    """Return the rows of each stretch of rest; a short one is a turn between two moves."""
    quiet = np.flatnonzero(rests)
    parts = np.split(quiet, np.flatnonzero(np.diff(quiet) > 1) + 1)
    return [part for part in parts if len(part) >= max(_LEAST_ROWS, 2.0 * _WINDOW_S / period_s)]


def _begin_late(values: FloatArray, runs: Sequence[tuple[int, int]]) -> bool:
    """Tell whether most steps begin away from their end: repeated readings do not."""
    scale = float(np.max(np.abs(values)))
    late = [
        abs(float(values[first]) - float(np.median(values[first:last][-(last - first) // 3 :])))
        > _LATE * scale
        for first, last in runs
        if last - first >= 2 * _LEAST_ROWS and abs(float(values[last - 1])) > 3 * _LATE * scale
    ]
    return len(late) >= _LEAST_STEPS and 2 * sum(late) > len(late)


def _runs(readings: Sequence[Reading]) -> list[tuple[int, int]]:
    commands = [(one.values.get("code"), one.values.get("pwm")) for one in readings]
    starts = [at for at, one in enumerate(commands) if at == 0 or one != commands[at - 1]]
    return list(zip(starts, [*starts[1:], len(commands)], strict=True))


def _settled_from(step: FloatArray, scale: float) -> int:
    """Return from where on the values of a step stay with those of its end.

    >>> _settled_from(np.array([0.0, 6.0, 9.0, 10.0, 10.1, 9.9, 10.0, 10.0]), 10.0)
    3
    """
    tail = step[-max(2, len(step) // 3) :]
    end, noise = float(np.median(tail)), noise_of(step[len(step) // 2 :])
    away = np.flatnonzero(np.abs(step - end) > max(_TOLERANCE * scale, 3.0 * noise))
    start = int(away[-1]) + 1 if away.size else 0
    return min(start, len(step) - 1)


def noise_of(values: FloatArray) -> float:
    """Scatter from second differences, which hold no steady drift."""
    if len(values) < _LEAST_ROWS:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 2)))) / (0.6745 * 6**0.5)


def _mean(readings: Sequence[Reading]) -> Reading:
    means = {
        name: value
        if name == "time"
        else float(np.mean([one.values[name] for one in readings if name in one.values]))
        for name, value in readings[0].values.items()
    }
    return replace(readings[0], values=means)


def _ramp(table: Table, period_s: float) -> Problem:
    return table.leave_out(
        table.place.error(
            f"a log in time, a row every {period_s:.3g} s, whose command never rests: what is "
            "measured lags behind it. So the table was left out.",
            "steps that are held until the readings rest.",
            "Sweep in steps of a second or more.",
        )
    )
