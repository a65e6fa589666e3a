"""What a load-test table says about itself that cannot be true, and what is likely the cause."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.readings import Reading
from pipeline.ingest.unit_text import factor, unit_worth
from pipeline.types import FloatArray

_CHANNELS = ("current", "voltage", "input_power", "output_power")
_RATIO_TOLERANCE = 0.05
_STEADY = 0.05


def drop_dead_channels(
    block: Block, readings: Sequence[Reading]
) -> tuple[list[Reading], list[Problem]]:
    """Leave out channels that are zero throughout while the drive is loaded, and say so."""
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


def check_powers(block: Block, readings: Sequence[Reading]) -> list[Problem]:
    """Compare the power columns with 2 pi n M and with U I; a constant ratio betrays a unit.

    The warnings name the unit that would make it right, if there is one.
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
        what, expected = "", ""
        if efficiency > 1.02:
            what = (
                f"the shaft gives {efficiency:.3g} times the power that the drive takes: a "
                "unit of torque, speed, current or voltage is likely wrong."
            )
            expected = "an efficiency below 1."
        elif efficiency < 0.005:
            what = (
                f"the drive's efficiency comes out as {efficiency:.2g}: a unit of torque, "
                "speed, current or voltage is likely wrong."
            )
            expected = "an efficiency between some per cent and 1."
        if what:
            place = block.place(block.first_row, "torque")
            remedy = f"Check the units: {_units(block)}."
            problems.append(Problem("warning", place, what, expected, remedy))
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
