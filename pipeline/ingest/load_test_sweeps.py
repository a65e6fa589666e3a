"""The course of a load test: two curves in one table, branches."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.load_test_words import Branch
from pipeline.ingest.rows import listed
from pipeline.types import FloatArray

#: Two curves: readings of one group at least, how far apart of the largest speed, and of the
#: scatter about each. One curve, parted at its middle, is 2.6 times its scatter apart.
_LEAST_OF_TWO, _TWO_SHARE, _TWO_SIGMAS = 6, 0.05, 6.0
#: Share of the torque's range by which it must come back before the branch changes.
_TURN_SHARE = 0.08


def two_curves(table: Table) -> Iterator[Problem]:
    """Refuse a table whose drive turns at two speeds under one torque at most of its codes.

    Readings of one code, branch and voltage make one curve n(M). Rows that lie on two curves, far
    apart for how little each scatters, are of two directions, or of two drives: nothing in the
    table tells which.
    """
    groups: dict[tuple[object, ...], list[Reading]] = defaultdict(list)
    for one in table.live():
        volts = one.values.get("voltage")
        if one.values.get("code", 0.0) != 0.0:
            group = (one.values["code"], one.branch, volts and round(math.log(abs(volts)) / 0.1))
            groups[group].append(one)
    large = [own for own in groups.values() if len(own) >= _LEAST_OF_TWO]
    parted = [(own, apart) for own in large if (apart := _apart(own))]
    if not parted or 2 * len(parted) < len(large):
        return
    own, apart = max(parted, key=lambda one: one[1])
    yield table.leave_out(
        table.at(own[0].row, "shaft_speed").error(
            f"at code {own[0].values['code']:g} the shaft turns at two speeds under one torque, "
            f"{apart:.0f} rpm apart ({listed([one.row for one in own])}), and so at most codes: "
            "something parts the rows, such as a direction that no column states. So the table "
            "was left out.",
            "one characteristic in a table.",
            "Write reverse with negative codes, each test on a sheet of its own, or state the "
            "column of the direction in vehicle.yaml:\n  columns:\n    load_test:\n      "
            'direction: {header: "...", reverse: ["..."]}',
        )
    )


def _apart(own: Sequence[Reading]) -> float:
    """Return how far apart two curves of speed over torque are, 0 where there is one. [rpm]."""
    torque, speed = np.abs(numbers(own, "torque")), np.abs(numbers(own, "shaft_speed"))
    scale = float(torque.max())
    if scale == 0.0 or np.ptp(torque) < 0.2 * scale:
        return 0.0
    degree = 2 if len(own) >= 2 * _LEAST_OF_TWO else 1
    off = speed - np.polyval(_curve(torque / scale, speed, degree), torque / scale)
    if np.ptp(off) <= _TWO_SHARE * float(speed.max()):
        return 0.0  # no two rows are so far apart
    above = off > 0.0
    if min(above.sum(), (~above).sum()) < degree + 2:
        return 0.0
    curves = [_curve(torque[side] / scale, speed[side], degree) for side in (above, ~above)]
    rest = [
        speed[side] - np.polyval(curve, torque[side] / scale)
        for side, curve in zip((above, ~above), curves, strict=True)
    ]
    middle = float(np.median(torque / scale))
    apart = abs(float(np.polyval(curves[0], middle) - np.polyval(curves[1], middle)))
    scatter = float(np.sqrt(np.mean(np.concatenate(rest) ** 2)))
    return apart if apart > max(_TWO_SHARE * float(speed.max()), _TWO_SIGMAS * scatter) else 0.0


def _curve(x: FloatArray, y: FloatArray, degree: int) -> FloatArray:
    """Coefficients of the polynomial of least squares, the smallest ones where few x differ."""
    return np.asarray(np.linalg.lstsq(np.vander(x, degree + 1), y, rcond=None)[0])


def with_branches(table: Table) -> tuple[Problem, ...]:
    """Tell the branches that no word tells, code by code, in the order of the rows."""
    by_code: dict[float | None, list[int]] = defaultdict(list)
    for index, reading in enumerate(table.readings):
        if not reading.marks and reading.branch is None:
            by_code[reading.values.get("code")].append(index)
    for indices in by_code.values():
        torque = np.abs(numbers((table.readings[index] for index in indices), "torque"))
        for index, branch in zip(indices, branches_of(torque), strict=True):
            table.readings[index] = replace(table.readings[index], branch=branch)
    return ()


def branches_of(torque: FloatArray) -> list[Branch]:
    """Tell loading from unloading by turning points of the torque that exceed its scatter.

    `torque` (n,) are sizes in the order taken.

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
