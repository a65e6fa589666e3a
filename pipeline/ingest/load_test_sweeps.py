"""The course of a sweep: which rows load and which unload the drive, and where it warms up."""

from collections.abc import Sequence

import numpy as np

from pipeline.ingest.load_test_words import Branch
from pipeline.ingest.readings import Reading
from pipeline.types import FloatArray

#: Share of the torque's range by which it must come back before the branch changes.
_TURN_SHARE = 0.08
_NO_LOAD_SHARE = 0.02
_STEADY_LOAD_SHARE = 0.003
_LEAST_WARM_UP_ROWS = 6


def with_branches(readings: Sequence[Reading]) -> list[Reading]:
    """Tell loading from unloading by the torque's rise and fall, where no row says it.

    The readings are of one code, one sweep after the other, in the order taken.
    """
    unstated = [index for index, reading in enumerate(readings) if reading.branch is None]
    if not unstated:
        return list(readings)
    torque = np.abs([readings[index].values["torque"] for index in unstated])
    branches = dict(zip(unstated, branches_of(torque), strict=True))
    return [
        Reading(reading.row, reading.values, reading.marks, branches[index])
        if index in branches
        else reading
        for index, reading in enumerate(readings)
    ]


def branches_of(torque: FloatArray) -> list[Branch]:
    """Tell loading from unloading by turning points of the torque that exceed its scatter.

    Parameters
    ----------
    torque : ndarray, shape (n,)
        Magnitude of the torque in the order taken. [any]

    Returns
    -------
    list of str, length n
        "loading" while it rises to a turning point, "unloading" while it falls to one.

    Examples
    --------
    >>> branches_of(np.array([0.0, 1.0, 2.0, 1.5, 0.5]))
    ['loading', 'loading', 'loading', 'unloading', 'unloading']
    """
    count = len(torque)
    if count == 0:
        return []
    turn = _TURN_SHARE * float(np.ptp(torque))
    if turn == 0.0:
        return ["loading"] * count
    branches: list[Branch] = []
    low = high = 0
    branch: Branch | None = None  # until the torque has moved by more than its scatter
    for index in range(count):
        high = index if torque[index] > torque[high] else high
        low = index if torque[index] < torque[low] else low
        if branch != "unloading" and torque[high] - torque[index] > turn:
            if branch is not None:
                branches += [branch] * (high + 1 - len(branches))
            branch, low = "unloading", index
        elif branch != "loading" and torque[index] - torque[low] > turn:
            if branch is not None:
                branches += [branch] * (low + 1 - len(branches))
            branch, high = "loading", index
    return branches + [branch or "loading"] * (count - len(branches))


def mark_drift(readings: Sequence[Reading]) -> tuple[list[Reading], int]:
    """Mark a leading run without load in which the speed still drifts, and count its rows.

    Only where it is plain: at least six rows at the same lowest torque, and a drift of the speed
    far above its scatter and above 0.5 %. The readings are as for `with_branches`.
    """
    if len(readings) < 2 * _LEAST_WARM_UP_ROWS or any("warm-up" in r.marks for r in readings):
        return list(readings), 0
    torque = np.abs([reading.values["torque"] for reading in readings])
    close = np.abs(torque - torque[0]) <= _NO_LOAD_SHARE * np.ptp(torque)
    run = int(np.argmin(close)) if not close.all() else 0
    if run < _LEAST_WARM_UP_ROWS or torque[0] > torque.min() + _NO_LOAD_SHARE * np.ptp(torque):
        return list(readings), 0
    third = run // 3
    moved = abs(float(np.median(torque[run - third : run]) - np.median(torque[:third])))
    if moved > _STEADY_LOAD_SHARE * np.ptp(torque):
        return list(readings), 0  # a slow ramp of the load changes the speed as well
    speed = np.array([reading.values["shaft_speed"] for reading in readings[:run]])
    settled = float(np.median(speed[-third:]))
    # Of a smooth drift the second differences hold the scatter alone.
    scatter = float(np.median(np.abs(np.diff(speed, 2)))) / (0.6745 * 6**0.5)
    if abs(speed[0] - settled) <= max(0.005 * abs(settled), 8.0 * scatter):
        return list(readings), 0
    away = np.abs(speed - settled) > max(0.002 * abs(settled), 4.0 * scatter)
    drifting = int(np.argmin(away)) if not away.all() else 0
    marked = [
        reading.marked("warm-up") if index < drifting else reading
        for index, reading in enumerate(readings)
    ]
    return marked, drifting
