"""Signs of a load test: the quadrant of its codes, and two directions that nothing tells apart."""

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.readings import COMMENTED, STATISTICS, Reading
from pipeline.ingest.rows import counted, listed

#: Below this share of the largest torque or speed, its sign means nothing.
_ZERO_SHARE = 0.03
#: Two curves: readings of one group at least, how far apart of the largest speed, and of the
#: scatter about each. One curve, parted at its middle, is 2.6 times its scatter apart.
_LEAST_OF_TWO, _TWO_SHARE, _TWO_SIGMAS = 6, 0.05, 6.0


def check_signs(block: Block, readings: Sequence[Reading]) -> tuple[list[Reading], list[Problem]]:
    """Mark readings outside of the motoring quadrant of their code; signs are never changed.

    The warning names the likely cause.
    """
    live = [i for i, one in enumerate(readings) if not {COMMENTED, STATISTICS} & set(one.marks)]
    if not live:
        return list(readings), []
    torque = np.array([readings[index].values["torque"] for index in live])
    speed = np.array([readings[index].values["shaft_speed"] for index in live])
    code = np.array([readings[index].values.get("code", 0.0) for index in live])
    loaded = np.abs(torque) > _ZERO_SHARE * np.abs(torque).max()
    turning = np.abs(speed) > _ZERO_SHARE * np.abs(speed).max()
    # Without a code, or at code 0, the direction of turning is all there is.
    sense = np.where(code == 0.0, np.sign(speed), np.sign(code))
    against = loaded & (torque * sense < 0)
    backwards = turning & (speed * sense < 0)
    marked = list(readings)
    problems: list[Problem] = []
    for wrong, share, mark, quantity in (
        (against, loaded, "negative torque", "torque"),
        (backwards, turning, "speed against the code", "shaft_speed"),
    ):
        if not wrong.any():
            continue
        whole = bool((wrong | ~share).all())
        # of a table turned round the few points near zero say nothing either
        odd = range(len(live)) if whole else np.flatnonzero(wrong)
        for position in odd:
            marked[live[position]] = marked[live[position]].marked(mark)
        rows = [readings[live[position]].row for position in odd]
        problems.append(_sign_problem(block, quantity, rows, whole=whole))
    return marked, problems


def with_signs_of_codes(
    block: Block, readings: Sequence[Reading]
) -> tuple[list[Reading], list[Problem]]:
    """Give speed and torque the sign of a negative code where both were read without one.

    A drive that motors has both signs of its code: with none of either, nothing else is meant. One
    of them alone without a sign is a size only where positive codes stand beside it.
    """
    back, ahead = (
        [one for one in readings if sign * one.values.get("code", 0.0) > 0.0 and not one.marks]
        for sign in (-1.0, 1.0)
    )
    if not back:
        return list(readings), []
    unsigned = [
        name
        for name in ("shaft_speed", "torque")
        if max(one.values[name] for one in back) > 0.0
        and min(one.values[name] for one in (*back, *ahead)) >= 0.0
    ]
    if not unsigned or (len(unsigned) == 1 and not ahead):
        return list(readings), []
    names = " and ".join("speed" if name.startswith("shaft") else "torque" for name in unsigned)
    what = f"{names} stand without sign at the negative codes: given the sign of the code."
    note = Problem("note", block.place(back[0].row), what)
    turned = [
        one.with_values(**{name: -abs(one.values[name]) for name in unsigned})
        if one.values.get("code", 0.0) < 0.0
        else one
        for one in readings
    ]
    return turned, [note]


def _sign_problem(block: Block, quantity: str, rows: list[int], *, whole: bool) -> Problem:
    name = quantity.replace("_", " ")
    column = block.columns[quantity]
    if whole:
        return Problem(
            "warning",
            block.place(rows[0], quantity),
            f"the {name} has the opposite sign of the {_sense(block)} in the whole table: it looks "
            f"like the sign of the sensor. Nothing was turned round; the {len(rows)} points are "
            "kept but not fitted.",
            "speed and torque with the sign of the code where the drive motors.",
            "If the sensor counts the other way, state it in vehicle.yaml:\n"
            f"  columns:\n    load_test:\n      {quantity}: "
            f'{{header: "{column.header}", sign: {-column.sign}}}',
        )
    what = "the drive is driven by the load (regenerating), or the sign is wrong"
    if quantity == "shaft_speed":
        what = "it was turned backwards, or the sign is wrong"
    return Problem(
        "warning",
        block.place(rows[0], quantity),
        f"the {name} is negative (against the {_sense(block)}) in {counted(len(rows), 'row')} "
        f"({listed(rows)}): {what}. The points are kept but not fitted.",
        "the motoring quadrant: torque and speed with the sign of the code.",
        'Mark the rows with "#" in column A if they are not steady motoring points.',
    )


def _sense(block: Block) -> str:
    return "code" if "code" in block.columns else "code or the turning"


def two_curves(block: Block, readings: Sequence[Reading]) -> Problem | None:
    """Refuse a table whose drive turns at two speeds under one torque at most of its codes.

    Readings of one code, branch and voltage make one curve n(M). Rows that lie on two curves, far
    apart for how little each scatters, are of two directions, or of two drives: nothing in the
    table tells which.
    """
    groups: dict[tuple[object, ...], list[Reading]] = defaultdict(list)
    for one in readings:
        volts = one.values.get("voltage")
        if not one.marks and one.values.get("code", 0.0) != 0.0:
            group = (one.values["code"], one.branch, volts and round(math.log(abs(volts)) / 0.1))
            groups[group].append(one)
    large = [own for own in groups.values() if len(own) >= _LEAST_OF_TWO]
    parted = [(own, apart) for own in large if (apart := _apart(own))]
    if not parted or 2 * len(parted) < len(large):
        return None
    own, apart = max(parted, key=lambda one: one[1])
    code = own[0].values["code"]
    return Problem(
        "error",
        block.place(own[0].row, "shaft_speed"),
        f"at code {code:g} the shaft turns at two speeds under one torque, {apart:.0f} rpm apart "
        f"({listed([one.row for one in own])}), and so at most codes: something parts the rows, "
        "such as a direction that no column states. So the table was left out.",
        "one characteristic in a table.",
        "Write reverse with negative codes, each test on a sheet of its own, or state the column "
        "of the direction in vehicle.yaml:\n  columns:\n    load_test:\n      direction: "
        '{header: "...", reverse: ["..."]}',
    )


def _apart(own: Sequence[Reading]) -> float:
    """Return how far apart two curves of speed over torque are, 0 where there is one. [rpm]."""
    torque, speed = (
        np.abs([one.values[name] for one in own]) for name in ("torque", "shaft_speed")
    )
    scale = float(torque.max())
    if scale == 0.0 or np.ptp(torque) < 0.2 * scale:
        return 0.0
    degree = 2 if len(own) >= 2 * _LEAST_OF_TWO else 1
    off = speed - np.polyval(np.polyfit(torque / scale, speed, degree), torque / scale)
    if np.ptp(off) <= _TWO_SHARE * float(speed.max()):
        return 0.0  # no two rows are so far apart
    above = off > 0.0
    if min(above.sum(), (~above).sum()) < degree + 2:
        return 0.0
    curves = [np.polyfit(torque[side] / scale, speed[side], degree) for side in (above, ~above)]
    rest = [
        speed[side] - np.polyval(curve, torque[side] / scale)
        for side, curve in zip((above, ~above), curves, strict=True)
    ]
    middle = float(np.median(torque / scale))
    apart = abs(float(np.polyval(curves[0], middle) - np.polyval(curves[1], middle)))
    scatter = float(np.sqrt(np.mean(np.concatenate(rest) ** 2)))
    return apart if apart > max(_TWO_SHARE * float(speed.max()), _TWO_SIGMAS * scatter) else 0.0
