"""The inverse characteristics: Table 3, Table 4 and the monotone firmware form."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.cubic_inverse import (
    fit_table3,
    fit_table4_row,
    points_for_tables,
)
from pipeline.identify.firmware_gate import gate_checks, rising_points
from pipeline.identify.firmware_grid import (
    firmware_grid,
    monotone_checks,
    round_trips,
    trip_checks,
    within_dead_thrust,
)
from pipeline.identify.thrust_family import Family, both_signs, family_curves, family_record
from pipeline.identify.thrust_under_way import points_under_way, with_points_under_way
from pipeline.identify.voltage_family import (
    Signs,
    at_voltage,
    families_by_voltage,
    voltage_rows,
    voltage_sentence,
)
from pipeline.records.fit_values import code_gaps, static_factor, static_std
from pipeline.records.fits import (
    Check,
    FirmwareCharacteristic,
    InverseCharacteristic,
    PolynomialFit,
    RoundTrip,
    SpeedInverse,
    StaticCharacteristic,
)
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.vehicle.bench_schema import is_at_supply
from pipeline.vehicle.schema import Vehicle

#: A smaller gap between mooring test and calculation [N], or share of the largest thrust, is within
#: what such a rig repeats to.
GAP_WITHIN_RIG_N, GAP_WITHIN_RIG_SHARE = 0.5, 0.01

#: A test that ends a little before the largest code still counts as one that reached it.
REACHED = 0.98


def inverse_characteristic(
    static: StaticCharacteristic | None, mooring: MooringRecord | None, vehicle: Vehicle
) -> InverseCharacteristic:
    """Compute everything that turns a wanted thrust into a code.

    With the static family: Table 4, and a firmware grid over speed. With mooring data: Table 3 by
    sign; what was measured at rest and in a flow corrects the grid, each sign by its own points,
    and alone gives one. A sign that was not measured mirrors the other (Kostenko 2023, eq. 8). A
    drive that takes no negative code is asked for none. What cannot be computed is None or empty,
    and `explanations` says why.

    Raises
    ------
    CannotComputeError
        If neither source gives anything.
    """
    notes: list[str] = []
    measured, usable = _mooring_points(mooring, vehicle, notes)
    points, gates = rising_points(measured)
    dead_n = vehicle.tables.thrust_dead_n
    positive = _table3(points, 1, dead_n, notes)
    reverses = vehicle.drive.code_min < 0
    negative = _table3(points, -1, dead_n, notes) if reverses else None
    calculated = family_curves(static, dead_n) if static is not None else None
    table4 = (
        () if static is None or calculated is None else _table4(static, calculated, dead_n, notes)
    )
    moving = () if mooring is None else points_under_way(mooring.points)
    if calculated is None:
        _why_at_rest_only(static, dead_n, notes, moored=bool(usable) and not moving)
    by_voltage = families_by_voltage(calculated, (*usable, *moving), vehicle)
    between = None if points else _between(by_voltage, vehicle, notes)
    wanted = vehicle.tables.supply_voltage_v
    if wanted is not None:
        moving = tuple(
            p for p in moving if p.voltage_v is None or is_at_supply(p.voltage_v, wanted)
        )
    used = (*(points if between is None else usable), *moving)
    families, firmware = _firmware(static, calculated, used, vehicle, between=between, notes=notes)
    source = static if calculated is not None else None
    voltages = () if firmware is None else voltage_rows(by_voltage, vehicle, source)
    if voltages:
        notes.append(voltage_sentence(voltages))
    if firmware is None and positive is None and negative is None:
        raise CannotComputeError(" ".join(notes))
    checks: list[Check] = []
    if measured:
        # what was measured corrects the calculated family, too
        checks.extend((*gates, *gate_checks(measured, (positive, negative), vehicle)))
    trips: tuple[RoundTrip, ...] = ()
    if static is not None and points:
        checks.extend(_gap_check(points, static))
    if firmware is not None and families is not None:
        if calculated is not None:
            trips = round_trips(families, calculated, table4, firmware, vehicle.published)
            checks.extend(trip_checks(trips, table4, calculated.curves[0].thrust_max_n))
        else:
            checks.append(_reach_check(firmware))
        checks.extend(monotone_checks(firmware))
    return InverseCharacteristic(
        table3_positive=positive,
        table3_negative=negative,
        table4=table4,
        firmware=firmware,
        round_trip=trips,
        checks=tuple(checks),
        explanations=tuple(notes),
        family=None if families is None else family_record(families, static),
        voltages=voltages,
    )


def _mooring_points(
    mooring: MooringRecord | None, vehicle: Vehicle, notes: list[str]
) -> tuple[tuple[MooringPoint, ...], tuple[MooringPoint, ...]]:
    """Return the usable points of the tables' voltage, and those of every voltage."""
    if mooring is None:
        notes.append("Table 3 needs mooring data; there are none.")
        return (), ()
    usable = tuple(point for point in mooring.points if not point.marks)
    try:
        return points_for_tables(mooring, vehicle), usable
    except CannotComputeError as error:
        notes.append(str(error))
        return (), usable if vehicle.tables.supply_voltage_v is not None else ()


def _table3(
    points: tuple[MooringPoint, ...], sign: int, dead_n: float, notes: list[str]
) -> PolynomialFit | None:
    if not points:
        return None
    try:
        return fit_table3(points, sign, dead_n)
    except CannotComputeError as error:
        notes.append(f"Table 3, {'positive' if sign > 0 else 'negative'} thrust: {error}.")
        return None


def _firmware(
    static: StaticCharacteristic | None,
    calculated: Family | None,
    points: tuple[MooringPoint, ...],
    vehicle: Vehicle,
    *,
    between: Signs | None,
    notes: list[str],
) -> tuple[Signs | None, FirmwareCharacteristic | None]:
    """Return the families and their grid; a reason in the notes where there is none."""
    if calculated is None and not points:
        return None, None
    try:
        families = between
        if families is None:
            rest = tuple(point for point in points if not point.marks)
            reverses = vehicle.drive.code_min < 0
            families = both_signs(calculated, rest, reverses=reverses, notes=notes)
            families = with_points_under_way(families, points_under_way(points), notes)
        source = static if calculated is not None else None
        return families, firmware_grid(families, vehicle, source, points)
    except CannotComputeError as error:
        notes.append(f"No firmware tables: {error}.")
        return None, None


def _table4(
    static: StaticCharacteristic, family: Family, dead_n: float, notes: list[str]
) -> tuple[SpeedInverse, ...]:
    rows = []
    for row in static.table2:
        if row.speed_mps > family.speed_mps[-1] + 1e-9:
            notes.append(f"Table 4 has no row at {row.speed_mps:g} m/s: no thrust there.")
            continue
        rows.append(fit_table4_row(row, family.at(row.speed_mps), dead_n))
    return tuple(rows)


def _between(by_voltage: dict[float, Signs], vehicle: Vehicle, notes: list[str]) -> Signs | None:
    """Take the families at a voltage that was not moored from those beside it."""
    wanted = vehicle.tables.supply_voltage_v
    found = None if wanted is None else at_voltage(by_voltage, wanted)
    if found is not None:
        notes.append(f"The tables at {wanted:g} V are interpolated between its neighbours.")
    return found


def _why_at_rest_only(
    static: StaticCharacteristic | None, dead_n: float, notes: list[str], *, moored: bool
) -> None:
    """Say why there are neither Table 4 nor firmware tables over speed."""
    if static is not None:
        notes.append(f"No Table 4 and no tables over speed: {_why_no_family(static, dead_n)}.")
    if moored:
        notes.append(
            "Without the static family the tables hold at rest only: the speed of the vehicle "
            "takes thrust away, and nothing here says how much."
        )


def _why_no_family(static: StaticCharacteristic, dead_n: float) -> str:
    code, thrust_n = static.code[-1], static.thrust_n[0][-1]
    if static.status[0][-1] == "no_working_point":
        return f"at rest the curves do not meet at code {code:g}"
    if thrust_n > dead_n:
        return (
            f"at rest code {code:g} alone gives thrust ({thrust_n:.3g} N), and a curve needs two "
            "codes. Codes are whole numbers: state those that the firmware sends (code_max under "
            "drives:)"
        )
    return within_dead_thrust(code, thrust_n, dead_n)


def _reach_check(firmware: FirmwareCharacteristic) -> Check:
    """Compare the codes that were moored with the drive's: the tables hold no others."""
    highest, lowest = firmware.positive.code[0][-1], -firmware.negative.code[0][-1]
    passed = highest >= REACHED * firmware.code_max
    tested = f"tested up to code {highest:g} of {firmware.code_max}"
    if firmware.code_min < 0:
        passed &= lowest <= REACHED * firmware.code_min
        tested = (
            f"tested from code {lowest:g} (of {firmware.code_min}) to {highest:g} "
            f"(of {firmware.code_max})"
        )
    text = tested if passed else f"{tested}; the tables give no code beyond what was tested"
    return Check(name="mooring test reaches the ends of the codes", passed=passed, text=text)


def _gap_check(points: tuple[MooringPoint, ...], static: StaticCharacteristic) -> tuple[Check, ...]:
    """Compare both signs; no check where no code was measured within the family."""
    factor, gaps = static_factor(static), code_gaps(points, static)
    within_rig_n = max(GAP_WITHIN_RIG_N, GAP_WITHIN_RIG_SHARE * max(static.thrust_n[0]))
    passed, texts = True, []
    for sign, name in ((1, "positive"), (-1, "negative")):
        own = [one for one in gaps if sign * one.code > 0]
        if not own:
            continue
        codes = np.array([one.code for one in own])
        gap, std = -np.array([one.gap_n for one in own]), static_std(static, 0, codes)
        worst = int(np.argmax(np.abs(gap)))
        passed &= bool(np.all(np.abs(gap) <= np.maximum(within_rig_n, factor * std)))
        texts.append(
            f"{name} codes {gap.min():+.2f} to {gap.max():+.2f} N, largest at code "
            f"{codes[worst]:g} ({gap[worst]:+.2f} N, standard error of the calculation "
            f"{std[worst]:.2f} N)"
        )
    if not texts:
        return ()
    return (
        Check(
            name="mooring test agrees with the calculation at rest",
            passed=passed,
            text=f"size of the thrust calculated less measured: {'; '.join(texts)}",
        ),
    )
