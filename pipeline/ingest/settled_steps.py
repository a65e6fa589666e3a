"""A bench log in time: each step of the command counts once, after it has settled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import Reading
from pipeline.ingest.rows import counted, listed
from pipeline.types import FloatArray

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


@dataclass(frozen=True)
class Steps:
    """Readings with one left unmarked for each step, and what was found; empty for a ramp."""

    readings: tuple[Reading, ...]
    problems: tuple[Problem, ...]


def settle(place: Place, readings: tuple[Reading, ...], quantity: str) -> Steps:
    """Average the settled part of each step of a log.

    Parameters
    ----------
    place : Place
        The table, for messages.
    readings : tuple of Reading
        In the order of time, with a time where the file has one.
    quantity : str
        What settles, e.g. "thrust".

    Returns
    -------
    Steps
        The readings as they are where the file is no log in time: with fewer than four rows a
        step, or without a time and without steps that settle.
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
        f"a log in time, a row every {period_s:g} s, whose command never rests: the thrust lags "
        "behind it. So the table was left out.",
        "steps that are held until the thrust rests.",
        "Sweep in steps of a second or more.",
    )
