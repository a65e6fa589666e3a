"""A bench log in time: each step of the command counts once, after it has settled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.readings import Reading
from pipeline.ingest.rows import counted, listed
from pipeline.types import BoolArray, FloatArray, IntArray

SETTLING = "settling"
AVERAGED = "averaged"
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


@dataclass(frozen=True)
class Steps:
    """Readings with one left unmarked for each step, and what was found; empty for a ramp."""

    readings: tuple[Reading, ...]
    problems: tuple[Problem, ...]


def settle(place: Place, readings: tuple[Reading, ...], quantity: str) -> Steps:
    """Average the settled part of each step of a log in time; `quantity` is what settles.

    The readings, in the order of time, stay as they are where the file is no such log: with fewer
    than four rows a step, or without a time and without steps that settle.
    """
    live = [at for at, one in enumerate(readings) if not one.marks and quantity in one.values]
    if not live:
        return Steps(readings, ())
    runs = _runs([_command(readings[at]) for at in live])
    lengths = [last - first for first, last in runs]
    values = np.array([readings[at].values[quantity] for at in live])
    in_time = all("time" in readings[at].values for at in live)
    if not in_time and not _begin_late(values, runs):
        return Steps(readings, ())
    time_s = np.array([readings[at].values.get("time", np.nan) for at in live])
    period_s = float(np.median(np.diff(time_s))) if len(live) > 1 else np.inf
    ramp = 0.0 < period_s < _RAMP_PERIOD_S and len(live) >= _LEAST_RAMP_ROWS
    if float(np.median(lengths)) < _LEAST_ROWS:
        return Steps((), (_ramp(place, period_s),)) if ramp else Steps(readings, ())
    if len(runs) < _LEAST_STEPS:
        return Steps(readings, ())
    scale = float(np.max(np.abs(values)))
    done = list(readings)
    moving: list[int] = []
    for first, last in runs:
        step = values[first:last]
        start = first + settled_from(step, scale)
        if _still_moves(step, scale):
            moving.append(readings[live[first]].row)
            start = max(start, last - max(2, len(step) // _LAST_SHARE))
        for at in live[first:start]:
            done[at] = replace(done[at], marks=(SETTLING,))
        for at in live[start + 1 : last]:
            done[at] = replace(done[at], marks=(AVERAGED,))
        done[live[start]] = _mean([readings[at] for at in live[start:last]])
    return Steps(tuple(done), tuple(_said(place, len(runs), float(np.median(lengths)), moving)))


def settle_loads(place: Place, readings: Sequence[Reading]) -> Steps:
    """Leave of a load test's log in time what is steady: steps of the load, or a slow ramp of it.

    The readings stay as they are where no times are there or the rows come seldom: each is a
    reading then. Rows in which speed or torque still move are marked, the rows of a step are
    averaged. An error where the command never rests or little else is steady.
    """
    live = [at for at, one in enumerate(readings) if not one.marks]
    time_s = np.array([readings[at].values.get("time", np.nan) for at in live])
    period_s = float(np.median(np.diff(time_s))) if len(live) > 1 else np.inf
    if len(live) < _LEAST_RAMP_ROWS or not 0.0 < period_s < _RAMP_PERIOD_S:
        return Steps(tuple(readings), ())
    runs = _runs([_command(readings[at]) for at in live])
    if float(np.median([last - first for first, last in runs])) < _LEAST_ROWS:
        return Steps((), (_ramp(place, period_s),))
    signals = np.array(
        [[readings[at].values[name] for name in ("shaft_speed", "torque")] for at in live]
    )
    largest = np.abs(signals).max(axis=0) + 1e-12
    done = [one if one.marks else one.marked(SETTLING) for one in readings]
    steady, steps = 0, 0
    for first, last in runs:
        own = signals[first:last]
        scale = np.maximum(np.abs(own).max(axis=0), _SMALL * largest)
        for part in _stretches(_rests(own[:, 0] / scale[0], period_s), period_s):
            at = [live[first + index] for index in part]
            steady += len(at)
            as_step = _is_step(own[part] / scale)
            steps += as_step
            for index in at:
                done[index] = readings[index].marked(*[AVERAGED] * as_step)
            if as_step:
                done[at[0]] = _mean([readings[index] for index in at])
    if steady < _LEAST_STEADY * len(live):
        what = (
            f"a log in time, a row every {period_s:.3g} s, whose speed rests in {steady} of "
            f"{len(live)} rows only: it lags behind command and load. So the table was left out."
        )
        expected = "steps of the load that are held until the speed rests, or a slow ramp of it."
        remedy = "Hold each load for some seconds; or write one settled row for each load."
        return Steps((), (Problem("error", place, what, expected, remedy),))
    what = (
        f"a log in time: in {steady} of {len(live)} rows the speed rests; "
        f"{counted(steps, 'step')} of these count once each, as the mean."
    )
    said = [Problem("note", place, what)] if steps or steady < len(live) else []
    return Steps(tuple(done), tuple(said))


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
    noise = 3.0 * _noise(speed) * (2.0 / half) ** 0.5
    rests = np.abs(step) <= max(_MOST_PER_S * half * period_s, noise)
    return np.pad(rests, (half, len(speed) - half - len(rests)), mode="edge")


def _stretches(rests: BoolArray, period_s: float) -> list[IntArray]:
    """Return the rows of each stretch of rest; a short one is a turn between two moves."""
    quiet = np.flatnonzero(rests)
    parts = np.split(quiet, np.flatnonzero(np.diff(quiet) > 1) + 1)
    return [part for part in parts if len(part) >= max(_LEAST_ROWS, 2.0 * _WINDOW_S / period_s)]


def _is_step(shares: FloatArray) -> bool:
    """Tell whether a stretch of steady rows is a step, no slow ramp."""
    parts = [part.mean(axis=0) for part in np.array_split(shares, _LEAST_ROWS)]
    return bool((np.ptp(parts, axis=0) <= 2.0 * _TOLERANCE).all())


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


def _command(reading: Reading) -> tuple[float | None, float | None]:
    return reading.values.get("code"), reading.values.get("pwm")


def _runs(commands: Sequence[object]) -> list[tuple[int, int]]:
    """Return first and last plus one of each run of equal commands."""
    starts = [at for at, one in enumerate(commands) if at == 0 or one != commands[at - 1]]
    return list(zip(starts, [*starts[1:], len(commands)], strict=True))


def settled_from(step: FloatArray, scale: float) -> int:
    """Return from where on the values of a step stay with those of its end.

    >>> settled_from(np.array([0.0, 6.0, 9.0, 10.0, 10.1, 9.9, 10.0, 10.0]), 10.0)
    3
    """
    tail = step[-max(2, len(step) // 3) :]
    end, noise = float(np.median(tail)), _noise(step[len(step) // 2 :])
    away = np.flatnonzero(np.abs(step - end) > max(_TOLERANCE * scale, 3.0 * noise))
    start = int(away[-1]) + 1 if away.size else 0
    return min(start, len(step) - 1)


def _noise(values: FloatArray) -> float:
    """Scatter from second differences, which hold no steady drift."""
    if len(values) < _LEAST_ROWS:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 2)))) / (0.6745 * 6**0.5)


def _still_moves(step: FloatArray, scale: float) -> bool:
    third = max(1, len(step) // 3)
    end, before = step[-third:], step[-2 * third : -third]
    moved = abs(float(np.mean(end)) - float(np.mean(before)))
    return moved > max(_MOVING * scale, 3.0 * _noise(step[len(step) // 2 :]))


def _mean(readings: Sequence[Reading]) -> Reading:
    names = readings[0].values
    means = {
        name: float(np.mean([one.values[name] for one in readings if name in one.values]))
        for name in names
    }
    return replace(readings[0], values={**means, **_first(readings[0], "time")})


def _first(reading: Reading, name: str) -> dict[str, float]:
    return {name: reading.values[name]} if name in reading.values else {}


def _said(place: Place, steps: int, rows: float, moving: Sequence[int]) -> list[Problem]:
    what = (
        f"a log in time of {counted(steps, 'step')} of about {rows:g} rows: each step counts once, "
        "as the mean of its settled rows."
    )
    problems = [Problem("note", place, what)]
    if moving:
        severe = 3 * len(moving) > steps
        what = f"the thrust still moves at the end of the steps that begin in {listed(moving)}."
        problems.append(
            Problem(
                "error" if severe else "warning",
                Place(place.file, place.sheet, moving[0]),
                what,
                "steps that are held until the thrust rests.",
                "Hold each command longer, or mark the rows with #.",
            )
        )
    return problems


def _ramp(place: Place, period_s: float) -> Problem:
    return Problem(
        "error",
        place,
        f"a log in time, a row every {period_s:.3g} s, whose command never rests: what is measured "
        "lags behind it. So the table was left out.",
        "steps that are held until the readings rest.",
        "Sweep in steps of a second or more.",
    )
