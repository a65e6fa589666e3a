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

#: Powers that are computed from each other.
_EQUAL = (0.95, 1.05)
#: Any motor has more somewhere.
_LEAST_EFFICIENCY, _MOST_EFFICIENCY = 0.1, 1.02
#: K_M = M / (rho n^2 D^5): a bench that goes past what a screw takes begins well below it.
_LEAST_K_M, _MOST_K_M, _LEAST_LOADS = 0.0085, 0.065, 3
#: How far off the line through all other codes is another unit, and how near to it these are.
_ODD_CODE, _ONE_LINE = 5.0, 1.6
#: Two measured columns are not so nearly in proportion.
_EXACT, _LEAST_ROWS = 2e-3, 6
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
    """Compare the powers of the shaft and of the supply with each other and with their columns.

    A ratio that no drive has betrays a unit; the warning names those that would explain it.
    """
    live = table.live()
    shaft = 2.0 * np.pi * numbers(live, "shaft_speed") / 60.0 * numbers(live, "torque")
    volts, amperes = numbers(live, "voltage"), numbers(live, "current")
    stated_v = stated_voltage(table.texts) or table.vehicle.tables.supply_voltage_v
    if stated_v is not None and not np.isfinite(volts).any():
        volts = np.full(len(live), stated_v)
    drawn, given = numbers(live, "input_power"), numbers(live, "output_power")
    taken = np.where(np.isfinite(drawn), drawn, amperes * volts)
    for name, one, other, low, high, causes in (
        ("output power over 2 pi n M", given, shaft, *_EQUAL, ("torque", "shaft_speed")),
        ("input power over U I", drawn, amperes * volts, *_EQUAL, ("current", "voltage")),
        ("2 pi n M over the power taken", shaft, taken, _LEAST_EFFICIENCY, _MOST_EFFICIENCY, ()),
        ("2 pi n M over the current [V]", shaft, amperes, _LEAST_VOLTAGE_V, _MOST_VOLTAGE_V, ()),
    ):
        ratio = _ratio(one, other, best=not causes)
        if ratio is not None and not low <= ratio <= high:
            likely = _suspects(table.block, ratio, causes)
            yield table.block.place(table.block.first_row, "torque").warning(
                f"{name} is {ratio:.3g}: a unit is likely wrong.{likely}",
                f"{low:g} to {high:g}.",
                f"Correct the units in the file or in vehicle.yaml: {_units(table.block)}.",
            )
            return


def _ratio(one: FloatArray, other: FloatArray, *, best: bool) -> float | None:
    """Return the size of a ratio where both are large: the middle one, or nearly the largest."""
    there = np.isfinite(one) & np.isfinite(other) & (other != 0.0)
    there &= np.abs(one) > 0.1 * np.abs(one[np.isfinite(one)]).max(initial=0.0)
    if there.sum() < _LEAST_LOADS:
        return None
    return float(np.quantile(np.abs(one[there] / other[there]), 0.9 if best else 0.5))


def _suspects(block: Block, ratio: float, causes: Sequence[str]) -> str:
    """Name the units of what is divided by that would make a ratio of powers one."""
    columns = [block.columns[cause] for cause in causes if cause in block.columns]
    units = [
        (one, unit_worth(one.quantity, factor(one.unit, one.quantity) * ratio)) for one in columns
    ]
    said = [
        f"{one.quantity.replace('_', ' ')} is in {unit}, not {one.unit}"
        for one, unit in units
        if unit
    ]
    return f" It would agree if {', or if '.join(said)}." if said else ""


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
