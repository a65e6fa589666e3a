"""The supply voltage as the third argument of the family: T(N, V, U).

Every voltage that was moored has a family of its own (`thrust_family`). Between two of them T_max
and the codes of equal shares of T_max run straight in U (docs/methods/inverse.md).
"""

from itertools import pairwise

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.firmware_gate import rising_points
from pipeline.identify.firmware_grid import FRACTIONS, firmware_grid
from pipeline.identify.thrust_curve import ThrustCurve
from pipeline.identify.thrust_family import MOORED_CODES, Family, both_signs, family_record
from pipeline.identify.thrust_under_way import points_under_way, with_points_under_way
from pipeline.records.fits import AtVoltage, StaticCharacteristic
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import VOLTAGE_TOLERANCE, is_at_supply, voltage_groups
from pipeline.vehicle.schema import Vehicle

#: Ahead and in reverse at a voltage.
Signs = tuple[Family, Family]


def families_by_voltage(
    calculated: Family | None, points: tuple[MooringPoint, ...], vehicle: Vehicle
) -> dict[float, Signs]:
    """Return both signs at each voltage that was moored well enough, by rising voltage.

    `calculated` is what the torque balance gives at the voltage of the load test; `points` are
    usable readings of all voltages, at rest and in a flow. Mean voltage [V] to the families; empty
    where fewer than two can be told apart.
    """
    reverses = vehicle.drive.code_min < 0
    found: dict[float, Signs] = {}
    rest, moving = [p for p in points if not p.marks], points_under_way(points)
    for low, high in voltage_groups(p.voltage_v for p in rest if p.voltage_v is not None):
        mine = tuple(p for p in rest if p.voltage_v is not None and low <= p.voltage_v <= high)
        volts = round(float(np.mean([p.voltage_v for p in mine if p.voltage_v is not None])), 3)
        if high - low > 2 * VOLTAGE_TOLERANCE * volts:
            continue  # a supply that sags with the load has no one voltage
        try:
            signs = both_signs(calculated, rising_points(mine)[0], reverses=reverses, notes=[])
        except CannotComputeError:
            continue
        if all(one.basis == "measured" for one in signs[: 2 if reverses else 1]):
            own = [p for p in moving if is_at_supply(p.voltage_v, volts)]
            found[volts] = with_points_under_way(signs, own, [])
    return found if len(found) > 1 else {}


def at_voltage(found: dict[float, Signs], voltage_v: float) -> Signs | None:
    """Return the families at a voltage between those that were moored; None beyond them."""
    known = sorted(found)
    for low, high in pairwise(known):
        if low <= voltage_v <= high:
            share = (voltage_v - low) / (high - low)
            wide = between95(found)[known.index(low)]
            ahead, reverse = (
                _mixed(a, b, share, 4.0 * share * (1.0 - share) * half)
                for a, b, half in zip(found[low], found[high], wide, strict=True)
            )
            return ahead, reverse
    return None


def between95(found: dict[float, Signs]) -> list[tuple[FloatArray, FloatArray]]:
    """Half-width that interpolation adds at rest, midway from each voltage to the next. [N].

    Ahead and in reverse, at the codes of `codes_of`: twice the root mean square of what the
    voltages between others are missed by when left out, code by code; of two voltages half of what
    lies between them, which no rising law exceeds. The last voltage has that of the one before.
    """
    code, known = codes_of(found), sorted(found)
    rest = [[one.curves[0] for one in found[volts]] for volts in known]
    gaps: list[tuple[FloatArray, FloatArray]] = []
    for low, high in pairwise(rest):
        pairs = zip(low, high, strict=True)
        ahead, reverse = (0.5 * np.abs(b.thrust(code) - a.thrust(code)) for a, b in pairs)
        gaps.append((ahead, reverse))
    if len(known) > 2:
        misses: list[list[FloatArray]] = [[], []]
        for k in range(1, len(known) - 1):
            share = (known[k] - known[k - 1]) / (known[k + 1] - known[k - 1])
            for side in (0, 1):
                told = _mixed_curve(rest[k - 1][side], rest[k + 1][side], share)
                misses[side].append(told.thrust(code) - rest[k][side].thrust(code))
        ahead, reverse = (2.0 * np.sqrt(np.mean(np.square(rows), axis=0)) for rows in misses)
        gaps = [(ahead, reverse)] * len(gaps)
    return [*gaps, gaps[-1]]


def voltage_rows(
    found: dict[float, Signs], vehicle: Vehicle, static: StaticCharacteristic | None
) -> tuple[AtVoltage, ...]:
    """Tabulate each voltage, for the record and for the firmware.

    Raises
    ------
    CannotComputeError
        If one of the voltages gives no more than the dead thrust.
    """
    if not found:
        return ()
    code = codes_of(found)
    return tuple(
        AtVoltage(
            voltage_v=volts,
            family=family_record(signs, static, code),
            firmware=firmware_grid(signs, vehicle, static).model_copy(
                update={"supply_voltage_v": volts}
            ),
            between95_n=[half.tolist() for half in wide],
        )
        for (volts, signs), wide in zip(sorted(found.items()), between95(found), strict=True)
    )


def voltage_sentence(rows: tuple[AtVoltage, ...]) -> str:
    """Say at which voltages the family stands, and how well it is known between them."""
    named = ", ".join(f"{one.voltage_v:g}" for one in rows)
    half = max(max(side) for one in rows for side in one.between95_n)
    return (
        f"Thrust was measured at {named} V: the family and the firmware take the voltage, between "
        f"two of these within {half:.2f} N midway at rest (95 %)."
    )


def codes_of(found: dict[float, Signs]) -> FloatArray:
    """Codes at which the rows of every voltage are tabulated."""
    last = max(float(one.curves[0].code[-1]) for signs in found.values() for one in signs)
    return np.linspace(0.0, last, MOORED_CODES)


def _mixed_curve(low: ThrustCurve, high: ThrustCurve, share: float) -> ThrustCurve:
    codes = [one.code_at(FRACTIONS * one.thrust_max_n) for one in (low, high)]
    largest = (1.0 - share) * low.thrust_max_n + share * high.thrust_max_n
    return ThrustCurve((1.0 - share) * codes[0] + share * codes[1], FRACTIONS * largest)


def _mixed(low: Family, high: Family, share: float, wide_n: FloatArray) -> Family:
    """Mix two families at the speeds of both; `wide_n` is at the codes of `codes_of`."""
    curves, halves = [], []
    for k in range(min(len(low.curves), len(high.curves))):
        curve = _mixed_curve(low.curves[k], high.curves[k], share)
        ends = [np.interp(curve.code, one.curves[k].code, one.half95_n[k]) for one in (low, high)]
        code = np.linspace(0.0, float(curve.code[-1]), wide_n.size)
        own = (1.0 - share) * ends[0] + share * ends[1]
        curves.append(curve)
        halves.append(np.hypot(own, np.interp(curve.code, code, wide_n)))
    speeds = low.speed_mps[: len(curves)]
    return Family(low.sign, low.basis, speeds, tuple(curves), tuple(halves))
