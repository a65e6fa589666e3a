"""What a load-test table says about itself that cannot be true, and what is likely the cause."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_file import COMMENTED, Reading
from pipeline.ingest.blocks import Block
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.statistics_rows import STATISTICS
from pipeline.ingest.unit_text import factor, unit_worth
from pipeline.types import FloatArray

_CHANNELS = ("current", "voltage", "input_power", "output_power")
#: Below this share of the largest torque or speed, its sign means nothing.
_ZERO_SHARE = 0.03
_RATIO_TOLERANCE = 0.05
#: Two curves: readings of one group at least, how far apart of the largest speed, and of the
#: scatter about each. One curve, parted at its middle, is 2.6 times its scatter apart.
_LEAST_OF_TWO, _TWO_SHARE, _TWO_SIGMAS = 6, 0.05, 6.0
_STEADY = 0.05


def check_signs(block: Block, readings: Sequence[Reading]) -> tuple[list[Reading], list[Problem]]:
    """Mark readings outside of the motoring quadrant of their code; signs are never changed.

    Parameters
    ----------
    block : Block
        The table, for messages.
    readings : sequence of Reading
        Its readings.

    Returns
    -------
    tuple of (list of Reading, list of Problem)
        Readings, those with opposed signs marked, and a warning with the likely cause.
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

    Parameters
    ----------
    block : Block
        The table, for messages.
    readings : sequence of Reading
        Its readings.

    Returns
    -------
    tuple of (list of Reading, list of Problem)
        A drive that motors has both signs of its code: with none of either, nothing else is meant.
        One of them alone without a sign is a size only where positive codes stand beside it.
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


def drop_dead_channels(
    block: Block, readings: Sequence[Reading]
) -> tuple[list[Reading], list[Problem]]:
    """Leave out channels that are zero throughout while the drive is loaded.

    Parameters
    ----------
    block : Block
        The table, for messages.
    readings : sequence of Reading
        Its readings.

    Returns
    -------
    tuple of (list of Reading, list of Problem)
        Readings without these channels, and a note or warning about each.
    """
    dead = [
        quantity
        for quantity in _CHANNELS
        if len(values := [one.values[quantity] for one in readings if quantity in one.values]) > 2
        and not any(values)
    ]
    problems = [
        Problem(
            "note",
            block.place(block.first_row, quantity),
            f"{quantity.replace('_', ' ')} is 0 throughout: not connected? It is left out.",
            "",
            "If another column holds it, state its header in vehicle.yaml under "
            f"columns: load_test: {quantity}.",
        )
        for quantity in dead
    ]
    kept = [
        replace(one, values={name: v for name, v in one.values.items() if name not in dead})
        for one in readings
    ]
    return kept, problems


def two_curves(block: Block, readings: Sequence[Reading]) -> Problem | None:
    """Refuse a table whose drive turns at two speeds under one torque at most of its codes.

    Parameters
    ----------
    block : Block
        The table, for the message.
    readings : sequence of Reading
        Its readings with branches; those of one code, branch and voltage make one curve n(M).

    Returns
    -------
    Problem or None
        Rows that lie on two curves, far apart for how little each scatters, are of two directions,
        of two drives: nothing in the table tells which.
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


def check_powers(block: Block, readings: Sequence[Reading]) -> list[Problem]:
    """Compare the power columns with 2 pi n M and with U I; a constant ratio betrays a unit.

    Parameters
    ----------
    block : Block
        The table, for messages and the units that were read.
    readings : sequence of Reading
        Its readings.

    Returns
    -------
    list of Problem
        Warnings, each with the unit that would make it right, if there is one.
    """
    live = [reading for reading in readings if not reading.marks]
    problems: list[Problem] = []
    shaft = np.array([_shaft_power(reading) for reading in live])
    problems += _compare(
        block,
        "output_power",
        (_values(live, "output_power"), shaft),
        "2 pi n M",
        ("torque", "shaft_speed"),
    )
    electrical = _values(live, "current") * _values(live, "voltage")
    problems += _compare(
        block,
        "input_power",
        (_values(live, "input_power"), electrical),
        "U I",
        ("current", "voltage"),
    )
    if problems:
        return problems
    drawn = _values(live, "input_power")
    drawn = np.where(np.isfinite(drawn), drawn, electrical)
    usable = np.isfinite(drawn) & (drawn > 0) & (shaft > 0)
    usable &= shaft > 0.1 * shaft.max(initial=0.0)
    if usable.sum() >= 3:
        efficiency = float(np.median(shaft[usable] / drawn[usable]))
        if efficiency > 1.02:
            problems.append(
                Problem(
                    "warning",
                    block.place(block.first_row, "torque"),
                    f"the shaft gives {efficiency:.3g} times the power that the drive takes: a "
                    "unit of torque, speed, current or voltage is likely wrong.",
                    "an efficiency below 1.",
                    f"Check the units: {_units(block)}.",
                )
            )
        elif efficiency < 0.005:
            problems.append(
                Problem(
                    "warning",
                    block.place(block.first_row, "torque"),
                    f"the drive's efficiency comes out as {efficiency:.2g}: a unit of torque, "
                    "speed, current or voltage is likely wrong.",
                    "an efficiency between some per cent and 1.",
                    f"Check the units: {_units(block)}.",
                )
            )
    return problems


def _compare(
    block: Block,
    quantity: str,
    powers: tuple[FloatArray, FloatArray],
    formula: str,
    causes: tuple[str, str],
) -> list[Problem]:
    given, computed = powers
    usable = np.isfinite(given) & np.isfinite(computed)
    if usable.sum() < 3:
        return []
    given, computed = given[usable], computed[usable]
    large = np.abs(computed) > 0.1 * np.abs(computed).max()
    if large.sum() < 3 or not np.abs(given[large]).max() > 0:
        return []
    ratios = given[large] / computed[large]
    ratio = float(np.median(ratios))
    spread = float(np.median(np.abs(ratios - ratio))) / abs(ratio) if ratio else np.inf
    # The sign of a computed column follows the writer's taste; sizes are what is compared.
    if abs(abs(ratio) - 1.0) <= _RATIO_TOLERANCE:
        return []
    name = quantity.replace("_", " ")
    if spread > _STEADY:
        what = f"{name} and {formula} disagree, by no constant factor (median {ratio:.3g})."
        remedy = "Check that the columns are what their headers say."
    else:
        what = (
            f"{name} is {abs(ratio):.4g} times {formula} throughout: a unit is likely wrong."
            f"{_suspects(block, quantity, abs(ratio), causes)}"
        )
        remedy = "Correct the unit in the file, or state it in vehicle.yaml under columns."
    return [
        Problem(
            "warning",
            block.place(block.first_row, quantity),
            what,
            f"{name} = {formula} within {_RATIO_TOLERANCE:.0%}; read as {_units(block)}.",
            remedy,
        )
    ]


def _suspects(block: Block, quantity: str, ratio: float, causes: tuple[str, str]) -> str:
    """Name the units that would make the ratio 1."""
    suspects: list[str] = []
    for cause in (*causes, quantity):
        column = block.columns.get(cause)
        if column is None or not column.unit:
            continue
        kind = "power" if cause.endswith("power") else cause
        worth = factor(column.unit, kind)
        unit = unit_worth(kind, worth / ratio if cause == quantity else worth * ratio)
        if unit is not None:
            suspects.append(f"{cause.replace('_', ' ')} is in {unit}, not {column.unit}")
    return f" It would agree if {', or if '.join(suspects)}." if suspects else ""


def check_magnitudes(
    block: Block, readings: Sequence[Reading], density_kgpm3: float, diameter_m: float
) -> list[Problem]:
    """Warn where torque or speed is far from anything that the propeller could take.

    Parameters
    ----------
    block : Block
        The table, for messages.
    readings : sequence of Reading
        Its readings.
    density_kgpm3 : float
        Density of the water. [kg/m^3]
    diameter_m : float
        Diameter of the propeller. [m]

    Returns
    -------
    list of Problem
        A warning, or nothing.
    """
    live = [reading for reading in readings if not reading.marks]
    if len(live) < 3:
        return []
    torque = max(abs(reading.values["torque"]) for reading in live)
    speed_rps = max(abs(reading.values["shaft_speed"]) for reading in live) / 60.0
    # A screw takes about K_M = 0.03; a bench may go far above and below, but not by 300 times.
    usual = 0.03 * density_kgpm3 * speed_rps**2 * diameter_m**5
    if usual <= 0.0 or 1.0 / 300.0 < torque / usual < 300.0:
        return []
    return [
        Problem(
            "warning",
            block.place(block.first_row, "torque"),
            f"the largest torque ({torque:.3g} N m) is {torque / usual:.2g} times what a propeller "
            f"of {diameter_m:g} m takes at {speed_rps * 60:.0f} rpm: a unit may be wrong.",
            "the same order of magnitude.",
            f"Check the units: {_units(block)}.",
        )
    ]


def _shaft_power(reading: Reading) -> float:
    return 2.0 * np.pi * reading.values["shaft_speed"] / 60.0 * reading.values["torque"]


def _values(readings: Sequence[Reading], quantity: str) -> FloatArray:
    return np.array([reading.values.get(quantity, np.nan) for reading in readings], dtype=float)


def _units(block: Block) -> str:
    return ", ".join(
        f"{column.quantity.replace('_', ' ')} in {column.unit}"
        for column in block.columns.values()
        if column.unit and column.quantity != "time"
    )
