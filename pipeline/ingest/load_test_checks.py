"""What a load-test table says about itself that cannot be true, and what is likely the cause."""

import re
from collections.abc import Iterator, Sequence
from pathlib import PurePath

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_table import Table, numbers, stated_voltage
from pipeline.ingest.blocks import Block
from pipeline.ingest.column_data import ratio_of
from pipeline.ingest.rows import listed
from pipeline.ingest.unit_text import factor, unit_worth
from pipeline.records.measurements import LoadTestPoint
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

_RATIO_TOLERANCE = 0.05
_STEADY = 0.05
#: Two measured columns are not so nearly in proportion.
_EXACT, _LEAST_ROWS = 2e-3, 6
#: Any motor has more somewhere.
_LEAST_EFFICIENCY = 0.1
#: K_M = M / (rho n^2 D^5): a bench that goes past what a screw takes begins well below it.
_LEAST_K_M, _MOST_K_M, _LEAST_LOADS = 0.0085, 0.065, 3
#: How far off the line through all other codes is another unit, and how near to it these are.
_ODD_CODE, _ONE_LINE = 5.0, 1.6
#: Of torque over current, by a motor's constant.
_OF_CONSTANT = 3.0
_KV = re.compile(
    r"(?<![\w.])(\d{2,5})\s?(?:KV|Kv|kv|rpm/V)(?![\w/])|(?<![\w.])[Kk][Vv]\s?[=:]?\s?(\d{2,5})(?![\w/.])"
)
#: No drive runs on less or more. [V]
_LEAST_VOLTAGE_V, _MOST_VOLTAGE_V = 3.0, 600.0
#: A shaft that is loaded by so much of the largest torque turns slower than one that is not.
_LOADED, _SLOWER = 0.02, 0.98


def check_powers(table: Table) -> Iterator[Problem]:
    """Compare the power columns with 2 pi n M and with U I; a constant ratio betrays a unit.

    The warnings name the unit that would make it right, if there is one.
    """
    block, live = table.block, table.live()
    shaft = 2.0 * np.pi * numbers(live, "shaft_speed") / 60.0 * numbers(live, "torque")
    voltage_v = numbers(live, "voltage")
    if not np.isfinite(voltage_v).any():
        stated_v = stated_voltage(table.texts) or table.vehicle.tables.supply_voltage_v
        voltage_v = np.full(len(live), np.nan if stated_v is None else stated_v)
    electrical = numbers(live, "current") * voltage_v
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
        yield from _voltage_needed(block, shaft, numbers(live, "current"))
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


def _voltage_needed(block: Block, shaft: FloatArray, current: FloatArray) -> Iterator[Problem]:
    """Say where a current would give the power of the shaft at no voltage that a drive has."""
    there = np.isfinite(current) & (current > 0.0) & (shaft > 0.1 * shaft.max(initial=0.0))
    if there.sum() < _LEAST_LOADS:
        return
    least_v = float(np.quantile(shaft[there] / current[there], 0.9))
    if not _LEAST_VOLTAGE_V <= least_v <= _MOST_VOLTAGE_V:
        yield block.place(block.first_row, "torque").warning(
            f"the shaft gives as much power as {least_v:.2g} V at the current: a unit of torque, "
            "speed or current is likely wrong.",
            "a voltage that a drive has.",
            f"Check the units: {_units(block)}.",
        )


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


def check_magnitudes(
    points: Sequence[LoadTestPoint], folder: Place, vehicle: Vehicle
) -> Iterator[Problem]:
    """Warn where the loads at the largest code are far from what the propeller would take."""
    turning = [one for one in points if one.shaft_speed_rpm]
    most = max((abs(one.code or 0.0) for one in turning), default=0.0)
    at_most = [one for one in turning if abs(one.code or 0.0) == most]
    loads = at_most if len(at_most) >= _LEAST_LOADS else turning
    if len(loads) < _LEAST_LOADS or vehicle.name == "unknown":
        return
    speed_rps = np.array([one.shaft_speed_rpm for one in loads]) / 60.0
    diameter_m = vehicle.propeller.diameter_m
    propeller_nm = vehicle.water.density_kgpm3 * speed_rps**2 * diameter_m**5
    k_m = np.abs([one.torque_nm for one in loads]) / propeller_nm
    middle, largest = float(np.median(k_m)), float(np.max(k_m))
    if largest >= _LEAST_K_M and middle <= _MOST_K_M:
        return
    said = f"is above {middle:.2g} for half of the loads"
    if largest < _LEAST_K_M:
        said = f"is {largest:.2g} at most"
    yield folder.warning(
        f"the torque is far from what a propeller of {diameter_m:g} m takes at that speed: "
        f"M / (rho n^2 D^5) {said}, a screw has 0.01 to 0.05. A unit may be wrong.",
        "loads about those of the propeller.",
        "Check the units of torque and speed, and the diameter in vehicle.yaml.",
    )


def odd_codes(points: Sequence[LoadTestPoint], folder: Place) -> Iterator[Problem]:
    """Say at which code torque or speed is of another size than those at all other codes let hope.

    Their largest values go with a power of the code: one that is far off a line through the others,
    which are near it, is in another unit. At the least code a drive may hardly turn.
    """
    codes = sorted({abs(one.code) for one in points if one.code})
    if len(codes) <= _LEAST_LOADS:
        return
    for name, of in (("torque", "torque_nm"), ("shaft speed", "shaft_speed_rpm")):
        most = [
            max(abs(getattr(one, of)) for one in points if abs(one.code or 0.0) == code)
            for code in codes
        ]
        if min(most) <= 0.0:
            continue
        x, y = np.log(codes), np.log(most)
        for at, code in enumerate(codes):
            rest = np.delete(np.arange(len(codes)), at)
            line = np.polyfit(x[rest], y[rest], 1)
            off = y - np.polyval(line, x)
            far = off[at] if at == 0 else abs(off[at])
            if far > np.log(_ODD_CODE) and np.abs(off[rest]).max() < np.log(_ONE_LINE):
                times = float(np.exp(off[at]))
                yield folder.warning(
                    f"at code {code:g} the {name} is {times:.3g} times what it is by all other "
                    "codes: its unit may be another there.",
                    "one unit at all codes.",
                    "Correct the numbers of this code, or its unit.",
                )


def check_constant(table: Table) -> Iterator[Problem]:
    """Compare torque over current with what a motor's KV says, where some text names it."""
    texts = (*table.texts, PurePath(table.place.file).stem, table.vehicle.drive.source)
    stated = {float(one or other) for one, other in _KV.findall(" ".join(texts))}
    live = table.live()
    current, torque = numbers(live, "current"), np.abs(numbers(live, "torque"))
    there = np.isfinite(current)
    if len(stated) != 1 or there.sum() < _LEAST_LOADS or not np.ptp(current[there]):
        return
    kv = stated.pop()
    slope = abs(float(np.polyfit(current[there], torque[there], 1)[0]))
    expected = 60.0 / (2.0 * np.pi * kv)
    if not expected / _OF_CONSTANT < slope < expected * _OF_CONSTANT:
        yield table.at(table.head, "torque").warning(
            f"the torque grows by {slope:.3g} N m for each ampere; a motor of {kv:g} rpm/V gives "
            f"{expected:.3g}: a unit of torque or current is likely wrong, or the current is that "
            "of the supply at part throttle.",
            "K_t = 60 / (2 pi KV).",
            f"Check the units: {_units(table.block)}.",
        )


def _units(block: Block) -> str:
    return ", ".join(
        f"{column.quantity.replace('_', ' ')} in {column.unit}"
        for column in block.columns.values()
        if column.unit and column.quantity != "time"
    )
