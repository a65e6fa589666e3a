"""A bench log in time: each step of the command counts once, after it has settled."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.rows import counted, listed
from pipeline.types import BoolArray, FloatArray

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
#: Of the largest speed: what it is measured by where it all but stands, and the change of it that
#: tells when it follows a command.
_SMALL, _TOLD = 0.1, 0.1
#: Of all torques: what a load is changed by at once. A command has no more loads than this.
_LOAD_STEP, _MOST_LOADS = 0.015, 12
#: Of the rows of a load.
_MOST_LATE = 0.4


def settle(table: Table) -> Iterator[Problem]:
    """Average the settled part of each step of a mooring test's log in time.

    The readings, in the order of time, stay as they are where the file is no such log: with fewer
    than four rows a step, or without a time and without steps that settle.
    """
    if not table.live():
        return
    values, time_s, period_s, runs, rows = _in_time(table.live(), table.measured)
    if np.isnan(time_s).any() and not _begin_late(values, runs):
        return
    if rows < _LEAST_ROWS:
        if 0.0 < period_s < _RAMP_PERIOD_S and len(values) >= _LEAST_RAMP_ROWS:
            yield _ramp(table, period_s)
    elif len(runs) >= _LEAST_STEPS:
        yield from _average(table, runs, [float(np.max(np.abs(values)))] * len(runs))


def settle_loads(table: Table) -> Iterator[Problem]:
    """Average the settled part of each load of a load test's log in time; a slow ramp stays rows.

    The readings stay as they are where the rows come seldom, or have no times, and follow their
    command at once: each is a reading then. Of a ramp the rows in which the speed still moves are
    marked. The table is left out where the command never rests, or the speed lags behind it.
    """
    readings = table.live()
    speed, _, period_s, runs, rows = _in_time(readings, "shaft_speed")
    late = _rows_late(speed, runs)
    is_log = late >= 1.0 or 0.0 < period_s < _RAMP_PERIOD_S
    if len(readings) < _LEAST_RAMP_ROWS or not is_log:
        return
    loads = _held(numbers(readings, "torque"), runs)
    held = float(np.median([last - first for first, last in loads])) if loads else 0.0
    largest = _SMALL * float(np.abs(speed).max())
    scales = [max(largest, float(np.abs(speed[first:last]).max())) for first, last in loads]
    if rows < _LEAST_ROWS:
        yield _ramp(table, period_s)
    elif late > _MOST_LATE * max(held, rows / _MOST_LOADS):
        yield _lags(table, f"follows its command only after {late:g} rows")
    elif held >= _LEAST_ROWS:
        yield from _average(table, loads, scales)
    elif np.isfinite(period_s):
        parts = [speed[first:last] for first, last in runs]
        steady = np.concatenate(
            [_rests(one / np.abs(one).max(initial=largest), period_s) for one in parts]
        )
        if steady.sum() < _LEAST_STEADY * len(steady):
            yield _lags(table, f"rests in {steady.sum()} of {len(steady)} rows only")
            return
        moving = {one.row for one, rests in zip(readings, steady, strict=True) if not rests}
        table.mark(moving, _SETTLING)
        if moving:
            yield table.place.note(f"a log in time: in {listed(sorted(moving))} the speed moves.")


def _average(
    table: Table, runs: Sequence[tuple[int, int]], scales: Sequence[float]
) -> Iterator[Problem]:
    """Average the settled rows of each step; `scales` are of what is measured, for each."""
    readings = table.readings
    live = [at for at, one in enumerate(readings) if not one.marks]
    values, name = numbers(table.live(), table.measured), table.measured.replace("_", " ")
    done = list(readings)
    moving: list[int] = []
    for (first, last), scale in zip(runs, scales, strict=True):
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
    rows = float(np.median([last - first for first, last in runs]))
    yield table.place.note(
        f"a log in time of {counted(len(runs), 'step')} of about {rows:g} rows: each step counts "
        "once, as the mean of its settled rows."
    )
    if moving:
        table.must_go = 3 * len(moving) >= len(runs)
        yield Problem(
            "error" if table.must_go else "warning",
            table.at(moving[0]),
            f"the {name} still moves at the end of the steps that begin in {listed(moving)}.",
            f"steps that are held until the {name} rests.",
            "Hold each command and load longer, or mark the rows with #.",
        )


def _lags(table: Table, how: str) -> Problem:
    return table.leave_out(
        table.place.error(
            f"a log in time whose speed {how}: it lags behind command and load. So the table was "
            "left out.",
            "loads that are held until the speed rests, or a slow ramp of the load.",
            "Hold each load for some seconds; or write one settled row for each load.",
        )
    )


def _rows_late(speed: FloatArray, runs: Sequence[tuple[int, int]]) -> float:
    """Return how many rows after a command the speed is half way to what belongs to it."""
    late = []
    for (first, last), (_, end) in pairwise(runs):
        before = float(np.median(speed[first:last][-max(1, (last - first) // _MOST_LOADS) :]))
        change = speed[last:end] - before
        whole = float(np.median(change[-max(1, len(change) // 2) :]))
        if abs(whole) > _TOLD * float(np.abs(speed).max()):
            late.append(int(np.argmax(change / whole > 0.5)))
    return float(np.median(late)) if late else 0.0


def _held(torque: FloatArray, runs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Part the rows of each command where the load is changed at once; none of a ramp of it."""
    jump = max(_LOAD_STEP * float(np.ptp(torque)), 8.0 * noise_of(torque))
    parts = []
    for first, last in runs:
        at = first + 1 + np.flatnonzero(np.abs(np.diff(torque[first:last])) > jump)
        parts += list(pairwise([first, *at.tolist(), last]))
    held = sum(last - first for first, last in parts if np.ptp(torque[first:last]) <= 2.0 * jump)
    return parts if 2 * held > len(torque) else []


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
