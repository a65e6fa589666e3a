"""Thrusters unlike the bundled one: small, wrongly signed, without slope, bent at the top."""

import numpy as np
import pytest

from pipeline.control.inverse import thrust_grid
from pipeline.errors import CannotComputeError
from pipeline.identify.drive import fit_drive
from pipeline.identify.firmware_grid import firmware_grid
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.linear_fit import fit_linear
from pipeline.identify.static import static_characteristic
from pipeline.identify.thrust_family import both_signs
from pipeline.physics.thrust_grid import code_from_thrust
from pipeline.records.base import Source
from pipeline.records.fits import Check, DriveFit, FirmwareCharacteristic, PropellerFit
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord, MooringPoint, MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Drive, Vehicle


def test_a_propeller_of_less_than_one_newton(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    small = propeller.model_copy(update={"diameter_m": 0.035})
    static = static_characteristic(small, drive, vehicle)
    assert 0 < np.max(static.thrust_n) < 1


def test_thrust_of_the_wrong_sign_is_explained(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    turned = tuple(-c for c in propeller.thrust.coefficients)
    thrust = propeller.thrust.model_copy(update={"coefficients": turned})
    wrong = propeller.model_copy(update={"thrust": thrust})
    with pytest.raises(CannotComputeError, match=r"no positive thrust.*sign of the thrust"):
        static_characteristic(wrong, drive, vehicle)


def test_a_response_that_does_not_vary_is_explained_fully() -> None:
    x = np.linspace(0, 1, 12)
    fit = fit_linear(np.vander(x, 3, increasing=True), np.full(12, 0.1))
    assert fit.r_squared == 1.0
    assert fit.coefficients[0] == pytest.approx(0.1)


def bent_torque(shaft_rps: FloatArray, code: float) -> FloatArray:
    """A characteristic with an inflection, as measured drives have: no parabola follows it."""
    x = (shaft_rps - code / 4) / 8
    return 0.006 * code * (1 - 0.5 * x - 0.4 * x**3)


def test_outliers_are_found_on_a_bent_characteristic(vehicle: Vehicle) -> None:
    """The neighbours of a torn reading are judged by a cubic, which a bend does not hide."""
    generator = np.random.default_rng(3)
    points = []
    for code in (40.0, 60.0, 80.0, 100.0, 120.0):
        shaft = np.linspace(code / 4 - 8, code / 4 + 8, 50)
        torque = bent_torque(shaft, code) + generator.normal(0, 0.002, 50)
        if code == 80.0:
            torque[30] *= 1.15
        points += [
            LoadTestPoint(
                source=Source(file="drive.xlsx", sheet=f"code {code:g}", row=row),
                code=code,
                shaft_speed_rpm=n * 60,
                torque_nm=m,
                branch="loading",
            )
            for row, (n, m) in enumerate(zip(shaft, torque, strict=True))
        ]
    fit = fit_drive(LoadTestRecord(points=tuple(points), sheets=(), problems=()), vehicle)
    (outlier,) = fit.quality.outliers
    assert outlier.source == Source(file="drive.xlsx", sheet="code 80", row=30)


def bollard(
    code: FloatArray, thrust_n: FloatArray, signs: tuple[float, ...] = (1.0, -1.0)
) -> tuple[MooringPoint, ...]:
    return tuple(
        MooringPoint(
            source=Source(file="bollard.csv", row=row),
            code=sign * c,
            thrust_n=sign * t,
            sweep="up",
        )
        for sign in signs
        for row, (c, t) in enumerate(zip(code, thrust_n, strict=True))
    )


def moored_grid(points: tuple[MooringPoint, ...], vehicle: Vehicle) -> FirmwareCharacteristic:
    return firmware_grid(both_signs(None, points, reverses=True, notes=[]), vehicle, None)


def test_a_mooring_curve_that_levels_off_is_followed_to_its_end(vehicle: Vehicle) -> None:
    """Drives reach a limit near the largest code; the grid has knots enough there."""
    code = np.arange(0.0, 128.0)
    thrust = 40 * (1 - np.exp(-((np.maximum(code - 10, 0) / 70) ** 2)))
    firmware = moored_grid(bollard(code, thrust), vehicle)
    sent = code_from_thrust(
        thrust,
        0.0,
        positive=thrust_grid(firmware.positive),
        negative=thrust_grid(firmware.negative),
        thrust_dead_n=0.5,
    )
    assert np.abs(sent - code)[thrust > 0.5].max() < 0.5
    assert "under way" in firmware.positive.against_motion


CODES = np.arange(0.0, 128.0, 8.0)


def test_a_drive_of_one_direction_needs_no_reverse_test(vehicle: Vehicle) -> None:
    points = bollard(CODES, 0.003 * CODES**2, signs=(1.0,))
    mooring = MooringRecord(points=points, sheets=(), problems=())
    drive = vehicle.drive.model_copy(update={"code_min": 0})
    forward_only = vehicle.model_copy(update={"drives": {vehicle.tables.drive: drive}})
    inverse = inverse_characteristic(None, mooring, forward_only)
    assert inverse.firmware is not None
    assert inverse.firmware.code_min == 0
    assert not [note for note in inverse.explanations if "negative" in note]
    both = inverse_characteristic(None, mooring, vehicle)
    assert both.firmware is None
    assert "No firmware tables: negative codes: none was measured." in both.explanations


def test_a_thruster_that_never_exceeds_the_dead_thrust_gets_no_tables(vehicle: Vehicle) -> None:
    """Every wanted thrust within its reach would give code 0, and nobody would be told."""
    weak = bollard(CODES, 0.5 * (CODES / 120.0) ** 2)
    with pytest.raises(CannotComputeError, match=r"code 120 gives 0.*dead thrust of 0.5 N"):
        moored_grid(weak, vehicle)
    strong_enough = bollard(CODES, 0.6 * (CODES / 120.0) ** 2)
    assert moored_grid(strong_enough, vehicle).positive.thrust_max_n[0] > 0.5


def test_a_mooring_test_that_ends_early_is_told(vehicle: Vehicle) -> None:
    """The tables hold what was tested: a drive of 127 codes moored to 80 gives no code above."""

    def reach(code: FloatArray) -> Check:
        points = bollard(code, 0.003 * code**2)
        mooring = MooringRecord(points=points, sheets=(), problems=())
        checks = inverse_characteristic(None, mooring, vehicle).checks
        (found,) = [check for check in checks if "ends of the codes" in check.name]
        return found

    early = reach(np.arange(0.0, 81.0, 8.0))
    assert not early.passed
    assert "from code -80 (of -127) to 80 (of 127); the tables give no code" in early.text
    assert reach(np.linspace(0.0, 127.0, 11)).passed


def test_codes_between_zero_and_one_are_told_to_be_whole_numbers(
    propeller: PropellerFit, load_test: LoadTestRecord, vehicle: Vehicle
) -> None:
    points = tuple(
        point.model_copy(update={"code": (point.code or 0.0) / 127}) for point in load_test.points
    )
    unit = vehicle.model_copy(update={"drives": {"motor": Drive(code_min=-1, code_max=1)}})
    drive = fit_drive(load_test.model_copy(update={"points": points}), unit)
    static = static_characteristic(propeller, drive, unit)
    with pytest.raises(CannotComputeError, match=r"code 1 alone gives thrust \(42.*whole numbers"):
        inverse_characteristic(static, None, unit)


def test_a_thruster_of_half_a_kilonewton_is_held_to_shares_of_its_thrust(
    propeller: PropellerFit, load_test: LoadTestRecord, vehicle: Vehicle
) -> None:
    """Thirteen times the thrust by 1.9 times the size: the firmware form is as good as before."""
    factor = 1.9
    points = tuple(
        point.model_copy(update={"torque_nm": factor**5 * point.torque_nm})
        for point in load_test.points
    )
    drive = fit_drive(load_test.model_copy(update={"points": points}), vehicle)
    large = propeller.model_copy(update={"diameter_m": factor * propeller.diameter_m})
    static = static_characteristic(large, drive, vehicle)
    mooring = MooringRecord(
        points=bollard(np.array(static.code[19::10]), np.array(static.thrust_n[0][19::10]) + 2.0),
        sheets=(),
        problems=(),
    )
    inverse = inverse_characteristic(static, mooring, vehicle)
    assert max(trip.firmware_n for trip in inverse.round_trip) > 0.1
    passed = {check.name: check.passed for check in inverse.checks}
    assert passed["round trip of the firmware form"]
    assert passed["mooring test agrees with the calculation at rest"]
