"""Tables 3 and 4 and the firmware grid: round trips, monotony, known cubics."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.identify.cubic_inverse import fit_table3, smallest_maximum
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.static import thruster_model
from pipeline.identify.thrust_curve import curve_from_family, curve_from_measurements
from pipeline.identify.working_grid import solve_grid
from pipeline.records.fit_values import drive_degrees, static_factor, student_95
from pipeline.records.fits import (
    DriveFit,
    FirmwareCharacteristic,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.vehicle.schema import Vehicle

Maker = Callable[[Callable[[float], float], float], MooringRecord]
# Table 3 of Kostenko 2023, positive thrust
PRINTED = (12.7, 4.336, -0.070, 7.29e-4)


def printed_thrust(code: float) -> float:
    """Invert the printed cubic N(T)."""
    roots = np.polynomial.polynomial.polyroots([PRINTED[0] - code, *PRINTED[1:]])
    return float(min(r.real for r in roots if abs(r.imag) < 1e-9 and r.real > 0))


@pytest.fixture(scope="module")
def inverse(static: StaticCharacteristic, vehicle: Vehicle) -> InverseCharacteristic:
    """What follows from the load and open-water tests alone."""
    return inverse_characteristic(static, None, vehicle)


def test_table3_comes_back_from_its_own_points(mooring_from: Maker, vehicle: Vehicle) -> None:
    inverse = inverse_characteristic(None, mooring_from(printed_thrust, 0.05), vehicle)
    assert inverse.table3_positive is not None
    assert inverse.table3_negative is not None
    thrust = np.linspace(0.5, 42, 100)
    fitted = np.polynomial.polynomial.polyval(thrust, inverse.table3_positive.coefficients)
    printed = np.polynomial.polynomial.polyval(thrust, PRINTED)
    assert np.abs(fitted - printed).max() < 1.0
    mirrored = np.polynomial.polynomial.polyval(-thrust, inverse.table3_negative.coefficients)
    assert np.abs(mirrored + printed).max() < 1.0


def test_noiseless_mooring_gives_the_exact_cubic(mooring_from: Maker, vehicle: Vehicle) -> None:
    inverse = inverse_characteristic(None, mooring_from(printed_thrust, 0.0), vehicle)
    assert inverse.table3_positive is not None
    np.testing.assert_allclose(inverse.table3_positive.coefficients, PRINTED, rtol=1e-6)


def test_many_readings_at_three_codes_make_no_cubic(mooring_from: Maker) -> None:
    """Their noise would: 4 to 7 codes off between them, and sure of one."""
    points = mooring_from(printed_thrust, 0.05).points

    def moored(*codes: float) -> tuple[MooringPoint, ...]:
        noise = np.random.default_rng(6).normal(0, 0.05, (20, len(points)))
        return tuple(
            point.model_copy(update={"thrust_n": point.thrust_n + more})
            for row in noise.tolist()
            for point, more in zip(points, row, strict=True)
            if point.code in codes
        )

    with pytest.raises(CannotComputeError, match="only 3 of the 4 codes that a cubic needs"):
        fit_table3(moored(40, 80, 120), 1, 0.5)
    fit = fit_table3(moored(40, 60, 80, 120), 1, 0.5)
    between = np.polynomial.polynomial.polyval(printed_thrust(100), fit.coefficients)
    assert between == pytest.approx(100, abs=1)


def test_round_trips_through_our_own_family(inverse: InverseCharacteristic) -> None:
    assert [trip.speed_mps for trip in inverse.round_trip][:21] == pytest.approx(
        np.arange(21) * 0.1
    )  # every 0.1 m/s, tabulated or between
    for trip in inverse.round_trip:
        assert trip.firmware_n <= 0.1
        assert trip.firmware_rounded_codes <= 0.5 + 0.1 / 0.1  # 0.1 N is at most one code
    # at rest this bench has no dead zone and N(T) starts with a vertical tangent: no cubic has one
    cubic = [t.cubic_n for t in inverse.round_trip if t.cubic_n is not None and t.speed_mps > 0]
    assert len(cubic) == 4
    assert max(cubic) <= 0.3


def test_table4_intervals_are_those_of_fits_to_moved_coefficients(
    propeller: PropellerFit,
    drive: DriveFit,
    static: StaticCharacteristic,
    inverse: InverseCharacteristic,
    vehicle: Vehicle,
) -> None:
    """Moved by half a standard error both ways along each axis of their covariance."""
    model = thruster_model(propeller, drive, vehicle)
    table4 = inverse.table4
    values, axes = np.linalg.eigh(model.covariance())
    speed, code = np.array([0.0, 0.5]), np.array(static.code)
    shifts: list[list[np.ndarray]] = [[], []]
    for value, axis in zip(values, axes.T, strict=True):
        ends = []
        for half in (-0.5, 0.5):
            k_t, k_m, of_drive = np.split(half * np.sqrt(max(value, 0.0)) * axis, [3, 6])
            moved = replace(
                model,
                propeller=replace(
                    model.propeller,
                    thrust_coefficients=model.propeller.thrust_coefficients + k_t,
                    torque_coefficients=model.propeller.torque_coefficients + k_m,
                ),
                surface=replace(model.surface, coefficients=model.surface.coefficients + of_drive),
            )
            grid = solve_grid(moved, speed_mps=speed, code=code)
            curves = [curve_from_family(code, row) for row in grid.thrust_n]
            ends.append([smallest_maximum(c, 0.5) for c in curves if c is not None])
        for k in range(2):
            shifts[k].append(ends[1][k] - ends[0][k])
    for k in range(2):
        std = np.sqrt(np.sum(np.square(shifts[k]), axis=0))
        half_width = np.diff(table4[k].ci95, axis=1).ravel() / 2
        factor = student_95(drive_degrees(drive))
        np.testing.assert_allclose(half_width, factor * std, rtol=0.3)


def test_firmware_grid_is_monotone(inverse: InverseCharacteristic) -> None:
    firmware = inverse.firmware
    assert firmware is not None
    code = np.array(firmware.positive.code)
    assert (np.diff(code, axis=1) > 0).all()
    assert (np.diff(firmware.positive.thrust_max_n) < 0).all()
    np.testing.assert_allclose(code[:, -1], 127)
    assert firmware.negative.code == firmware.positive.code
    assert (firmware.code_min, firmware.code_max) == (-127, 127)


def test_range_of_codes_is_the_drives(static: StaticCharacteristic, vehicle: Vehicle) -> None:
    drives = {"motor": vehicle.drive.model_copy(update={"code_min": -100})}
    firmware = inverse_characteristic(
        static, None, vehicle.model_copy(update={"drives": drives})
    ).firmware
    assert firmware is not None
    assert (firmware.code_min, firmware.code_max) == (-100, 127)
    old = {k: v for k, v in firmware.model_dump().items() if k != "code_min"}
    assert FirmwareCharacteristic.model_validate(old).code_min == -127


def test_gap_between_mooring_and_calculation_is_found(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle
) -> None:
    rest = np.array(static.thrust_n[0])

    def weaker(code: float) -> float:
        return float(np.interp(code, static.code, rest)) - 1.0

    name = "mooring test agrees with the calculation at rest"
    apart = inverse_characteristic(static, mooring_from(weaker, 0.0), vehicle)
    (gap,) = [check for check in apart.checks if check.name == name]
    assert not gap.passed
    assert "+1.00 N" in gap.text
    assert "positive codes" in gap.text
    assert "negative codes" in gap.text
    same = inverse_characteristic(static, mooring_from(lambda c: weaker(c) + 1.0, 0.0), vehicle)
    (none,) = [check for check in same.checks if check.name == name]
    assert none.passed


def test_gap_is_judged_by_the_interval_that_is_shown(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle
) -> None:
    """A code may be off by the 95 % half-width, which is more than two standard errors of 3 N."""
    rest, std = np.array(static.thrust_n[0]), np.array(static.thrust_std_n[0])
    at_100 = float(np.interp(100, static.code, std))
    wide = static.model_copy(
        update={
            "thrust_std_n": tuple(tuple(3.0 / at_100 * np.array(r)) for r in static.thrust_std_n)
        }
    )
    factor = static_factor(static)
    assert factor > 2.01
    for share, agrees in ((0.9995, True), (1.01, False)):
        off = share * factor * 3.0
        sound = mooring_from(lambda c: float(np.interp(c, static.code, rest)), 0.0)
        points = tuple(
            p.model_copy(update={"thrust_n": p.thrust_n - off}) if p.code == 100 else p
            for p in sound.points
        )
        record = sound.model_copy(update={"points": points})
        checks = inverse_characteristic(wide, record, vehicle).checks
        (gap,) = [check for check in checks if check.name.startswith("mooring test agrees")]
        assert gap.passed is agrees


@pytest.mark.parametrize(("sign", "alone"), [(1, False), (1, True), (-1, False)])
def test_gap_of_either_sign_alone_is_found(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle, sign: int, *, alone: bool
) -> None:
    """One sign pulls 1.85 N less than calculated at code 60, the other as calculated or not."""
    rest = np.array(static.thrust_n[0])
    sound = mooring_from(lambda c: float(np.interp(c, static.code, rest)), 0.0)
    points = tuple(
        p.model_copy(update={"thrust_n": p.thrust_n - sign * 1.85}) if p.code == sign * 60 else p
        for p in sound.points
    )
    kept = tuple(p for p in points if sign * p.code >= 0 or not alone)
    record = sound.model_copy(update={"points": kept})
    checks = inverse_characteristic(static, record, vehicle).checks
    (gap,) = [check for check in checks if check.name.startswith("mooring test agrees")]
    assert not gap.passed
    assert f"at code {sign * 60} (+1.85 N" in gap.text


def test_mooring_alone_gives_tables_at_rest(mooring_from: Maker, vehicle: Vehicle) -> None:
    inverse = inverse_characteristic(None, mooring_from(printed_thrust, 0.02), vehicle)
    assert inverse.table4 == ()
    assert inverse.firmware is not None
    assert inverse.firmware.positive.speed_mps == (0.0,)
    assert any("at rest only" in line for line in inverse.explanations)


def test_voltages_must_be_chosen(mooring_from: Maker, vehicle: Vehicle) -> None:
    record = mooring_from(printed_thrust, 0.0)
    two = record.model_copy(
        update={
            "points": tuple(
                p.model_copy(update={"voltage_v": v}) for v in (12.0, 16.0) for p in record.points
            )
        }
    )
    with pytest.raises(CannotComputeError, match=r"12 to 16 V.*supply_voltage_v"):
        inverse_characteristic(None, two, vehicle)
    chosen = vehicle.model_copy(
        update={"tables": vehicle.tables.model_copy(update={"supply_voltage_v": 16.0})}
    )
    inverse = inverse_characteristic(None, two, chosen)
    assert inverse.table3_positive is not None
    assert inverse.table3_positive.quality.points == 24
    other = vehicle.model_copy(
        update={"tables": vehicle.tables.model_copy(update={"supply_voltage_v": 20.0})}
    )
    with pytest.raises(CannotComputeError, match="taken at 12, 16 V"):
        inverse_characteristic(None, two, other)


def test_one_family_over_code_speed_and_voltage(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle
) -> None:
    """Moored at 40, 48 and 60 V; at 54 V the thrust at rest and under way lies between."""
    record = mooring_from(printed_thrust, 0.0)
    volts = (40.0, 48.0, 60.0)
    points = tuple(
        p.model_copy(update={"voltage_v": v, "thrust_n": p.thrust_n * (v / 48.0) ** 1.2})
        for v in volts
        for p in record.points
    )

    @cache
    def made(supply_v: float) -> InverseCharacteristic:
        tables = vehicle.tables.model_copy(update={"supply_voltage_v": supply_v})
        moored = record.model_copy(update={"points": points})
        return inverse_characteristic(static, moored, vehicle.model_copy(update={"tables": tables}))

    found = {v: made(v).family for v in (48.0, 54.0, 60.0)}
    rows = made(48.0).voltages
    assert [row.voltage_v for row in rows] == list(volts)
    for speed in (0.0, 1.0):
        thrust, half = [], []
        for family in found.values():
            assert family is not None
            side = family.positive
            row = int(np.argmin(np.abs(np.array(side.speed_mps) - speed)))
            thrust.append(float(np.interp(100.0, side.code, side.thrust_n[row])))
            half.append(float(np.interp(100.0, side.code, side.half95_n[row])))
        assert np.all(np.diff(thrust) > 1.0)
        if speed == 0.0:
            wanted = printed_thrust(100.0) * (54.0 / 48.0) ** 1.2
            assert abs(thrust[1] - wanted) < min(half[1], 0.1)
    # what a voltage between others is missed by is in the interval between two
    missed = rows[0].between95_n[0]
    assert 0.0 < max(missed) < 1.0
    assert made(48.0).firmware == next(r.firmware for r in rows if r.voltage_v == 48.0).model_copy(
        update={"sources": made(48.0).firmware.sources}  # type: ignore[union-attr]
    )


def test_neither_source_says_so(vehicle: Vehicle) -> None:
    with pytest.raises(CannotComputeError, match="mooring"):
        inverse_characteristic(None, None, vehicle)


def test_curve_is_its_own_inverse() -> None:
    code = np.arange(1.0, 128.0)
    curve = curve_from_family(code, np.maximum(-4 + 0.254 * code + 8.82e-4 * code**2, 0))
    assert curve is not None
    wanted = np.linspace(0, curve.thrust_max_n, 333)
    np.testing.assert_allclose(curve.thrust(curve.code_at(wanted)), wanted, atol=1e-9)
    assert curve.code[0] == pytest.approx(14.97, abs=0.05)
    assert curve_from_family(code, np.zeros(127)) is None


def test_measured_curve_takes_noise_out() -> None:
    generator = np.random.default_rng(0)
    code = np.repeat(np.arange(0.0, 401.0, 4.0), 2)
    truth = 50 * (np.maximum(code - 30, 0) / 370) ** 1.5
    noise = np.where(truth > 0, generator.normal(0, 0.2, code.size), 0)
    curve = curve_from_measurements(code, truth + noise)
    assert (np.diff(curve.thrust_n) > 0).all()
    inner = np.arange(60.0, 390.0)
    assert np.abs(curve.thrust(inner) - 50 * ((inner - 30) / 370) ** 1.5).max() < 0.3


def test_a_force_that_was_lost_is_no_dead_zone() -> None:
    """The zero at code 100 is no end of the dead zone, which would take 24 codes along."""
    code = np.arange(0.0, 128.0, 4.0)
    thrust = np.maximum(code - 10.0, 0.0) / 3.0
    thrust[code == 8.0] = -0.2  # noise
    curve_from_measurements(code, thrust)
    thrust[code == 100.0] = 0.0
    with pytest.raises(CannotComputeError, match=r"code 100 gives no .* smaller one gives 28\.7 N"):
        curve_from_measurements(code, thrust)
