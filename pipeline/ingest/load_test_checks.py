"""What a load-test table says about itself that cannot be true, and what is likely the cause."""

from collections.abc import Iterator

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table, numbers
from pipeline.ingest.blocks import Block
from pipeline.ingest.column_data import ratio_of
from pipeline.ingest.rows import listed
from pipeline.ingest.unit_text import factor, unit_worth
from pipeline.types import FloatArray

_RATIO_TOLERANCE = 0.05
_STEADY = 0.05
#: Two measured columns are not so nearly in proportion.
_EXACT, _LEAST_ROWS = 2e-3, 6
#: Any motor has more somewhere.
_LEAST_EFFICIENCY = 0.1
#: More or less than a propeller of that size and speed takes.
_MOST_TIMES = 50.0
#: A shaft that is loaded by so much of the largest torque turns slower than one that is not.
_LOADED, _SLOWER = 0.02, 0.98


def check_powers(table: Table) -> Iterator[Problem]:
    """Compare the power columns with 2 pi n M and with U I; a constant ratio betrays a unit.

    The warnings name the unit that would make it right, if there is one.
    """
    block, live = table.block, table.live()
    shaft = 2.0 * np.pi * numbers(live, "shaft_speed") / 60.0 * numbers(live, "torque")
    electrical = numbers(live, "current") * numbers(live, "voltage")
    drawn = numbers(live, "input_power")
    given = numbers(live, "output_power")
    problems = [
        *_compare(block, "output_power", (given, shaft), "2 pi n M", ("torque", "shaft_speed")),
        *_compare(block, "input_power", (drawn, electrical), "U I", ("current", "voltage")),
    ]
    if problems:
        yield from problems
        return
    drawn = np.where(np.isfinite(drawn), drawn, electrical)
    usable = np.isfinite(drawn) & (drawn > 0) & (shaft > 0)
    usable &= shaft > 0.1 * shaft.max(initial=0.0)
    if usable.sum() < 3:
        return
    efficiency, best = (
        float(one) for one in np.quantile(shaft[usable] / drawn[usable], [0.5, 0.9])
    )
    place, remedy = block.place(block.first_row, "torque"), f"Check the units: {_units(block)}."
    if efficiency > 1.02:
        what = (
            f"the shaft gives {efficiency:.3g} times the power that the drive takes: a "
            "unit of torque, speed, current or voltage is likely wrong."
        )
        yield place.warning(what, "an efficiency below 1.", remedy)
    elif best < _LEAST_EFFICIENCY:
        what = (
            f"the drive's efficiency comes out as {best:.2g} at best: a unit of torque, speed, "
            "current or voltage is likely wrong, or it was hardly loaded."
        )
        yield place.warning(what, "an efficiency of some ten per cent under load.", remedy)


def _compare(
    block: Block,
    quantity: str,
    powers: tuple[FloatArray, FloatArray],
    formula: str,
    causes: tuple[str, str],
) -> Iterator[Problem]:
    given, computed = powers
    usable = np.isfinite(given) & np.isfinite(computed)
    if usable.sum() < 3:
        return
    given, computed = given[usable], computed[usable]
    large = np.abs(computed) > 0.1 * np.abs(computed).max()
    if large.sum() < 3 or not np.abs(given[large]).max() > 0:
        return
    ratios = given[large] / computed[large]
    ratio = float(np.median(ratios))
    spread = float(np.median(np.abs(ratios - ratio))) / abs(ratio) if ratio else np.inf
    # The sign of a computed column follows the writer's taste; sizes are what is compared.
    if abs(abs(ratio) - 1.0) <= _RATIO_TOLERANCE:
        return
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
    yield block.place(block.first_row, quantity).warning(
        what, f"{name} = {formula} within {_RATIO_TOLERANCE:.0%}; read as {_units(block)}.", remedy
    )


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


def torque_not_written(table: Table) -> Iterator[Problem]:
    """Leave out rows whose torque is 0 although loaded ones of their code turn faster."""
    live = table.live()
    largest = max((abs(one.values["torque"]) for one in live), default=0.0)
    fastest: dict[float | None, float] = {}
    for one in live:
        if abs(one.values["torque"]) > _LOADED * largest:
            code, speed = one.values.get("code"), abs(one.values["shaft_speed"])
            fastest[code] = max(speed, fastest.get(code, 0.0))
    empty = {
        one.row
        for one in live
        if one.values["torque"] == 0.0
        and abs(one.values["shaft_speed"]) < _SLOWER * fastest.get(one.values.get("code"), 0.0)
    }
    if not empty:
        return
    table.mark(empty, "torque not written")
    yield table.at(min(empty), "torque").warning(
        f"the torque is 0 in {listed(sorted(empty))}, where the shaft turns slower than with a "
        "load: nothing was measured there; left out.",
        "a blank cell where there is no reading.",
        'Mark these rows with "#" in column A.',
    )


def torque_of_current(table: Table) -> Iterator[Problem]:
    """Warn of a torque that is the current times a constant: computed from it, not measured."""
    live = table.live()
    found = ratio_of(numbers(live, "current"), numbers(live, "torque"))
    if found is not None and len(live) >= _LEAST_ROWS and found.spread <= _EXACT:
        yield table.at(live[0].row, "torque").warning(
            f"the torque is {found.median:.4g} N m for each ampere in every row, without the "
            "current of no load: it was computed from the current, not measured.",
            "the torque of a sensor.",
            "State the column of the measured torque in vehicle.yaml under columns: load_test: "
            "torque.",
        )


def check_magnitudes(table: Table) -> Iterator[Problem]:
    """Warn where torque or speed is far from anything that the propeller could take."""
    block, live = table.block, table.live()
    density_kgpm3 = table.vehicle.water.density_kgpm3
    diameter_m = table.vehicle.propeller.diameter_m
    if len(live) < 3:
        return
    torque = max(abs(reading.values["torque"]) for reading in live)
    speed_rps = max(abs(reading.values["shaft_speed"]) for reading in live) / 60.0
    # A screw takes about K_M = 0.03; a bench may go far above and below, but not by 50 times.
    usual = 0.03 * density_kgpm3 * speed_rps**2 * diameter_m**5
    if usual <= 0.0 or 1.0 / _MOST_TIMES < torque / usual < _MOST_TIMES:
        return
    yield block.place(block.first_row, "torque").warning(
        f"the largest torque ({torque:.3g} N m) is {torque / usual:.2g} times what a propeller "
        f"of {diameter_m:g} m takes at {speed_rps * 60:.0f} rpm: a unit may be wrong.",
        "the same order of magnitude.",
        f"Check the units: {_units(block)}.",
    )


def _units(block: Block) -> str:
    return ", ".join(
        f"{column.quantity.replace('_', ' ')} in {column.unit}"
        for column in block.columns.values()
        if column.unit and column.quantity != "time"
    )
