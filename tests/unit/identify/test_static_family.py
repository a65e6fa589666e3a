"""The torque balance against its closed form at rest, and the two error propagations."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.identify.drive import fit_drive
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.static import static_characteristic, thruster_model
from pipeline.identify.working_grid import thrust_jacobian
from pipeline.records.fit_values import drive_degrees, student_95
from pipeline.records.fits import (
    DriveFit,
    Interval,
    PolynomialFit,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import LoadTestRecord
from pipeline.vehicle.schema import Vehicle


def row(static: StaticCharacteristic, speed_mps: float) -> np.ndarray:
    return np.array(static.thrust_n[static.speed_mps.index(speed_mps)])


def test_thrust_at_rest_is_the_root_of_the_quadratic(static: StaticCharacteristic) -> None:
    code = np.array(static.code)
    a, k = 0.0171 * 1000.62 * 0.14**5, 0.04
    c = (0.73 + 0.04 * 28.2) * code / 127
    n = (-k + np.sqrt(k**2 + 4 * a * c)) / (2 * a)
    truth = 0.139 * 1000.62 * n**2 * 0.14**4
    tested = code >= 20
    assert np.abs(row(static, 0.0) - truth)[tested].max() < 0.25


def test_thrust_falls_with_speed_and_dies(static: StaticCharacteristic) -> None:
    assert all(check.passed for check in static.checks), static.checks
    status = static.status[static.speed_mps.index(2.0)]
    assert status[0] == "dead"
    assert status[126] == "live"
    assert any("give no thrust" in line for line in static.explanations)


def test_truth_lies_in_the_interval_of_thrust(static: StaticCharacteristic) -> None:
    """Standard errors are honest: the known thrust at rest is within three of them."""
    code = np.array(static.code)[19:]
    a, k = 0.0171 * 1000.62 * 0.14**5, 0.04
    n = (-k + np.sqrt(k**2 + 4 * a * (0.73 + 0.04 * 28.2) * code / 127)) / (2 * a)
    truth = 0.139 * 1000.62 * n**2 * 0.14**4
    pull = (row(static, 0.0)[19:] - truth) / np.array(static.thrust_std_n[0])[19:]
    assert np.abs(pull).max() < 3


def test_jacobian_is_the_derivative(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    model = thruster_model(propeller, drive, vehicle)
    code, speed = np.array([40.0, 90.0, 127.0]), np.array([0.0, 1.0, 2.0])
    points = model.solve(code, speed)
    jacobian = thrust_jacobian(model, points, code)
    for part, (fit, width) in enumerate(
        ((propeller.thrust, 3), (propeller.torque, 3), (drive, len(drive.coefficients)))
    ):
        for i in range(width):
            moved = list(fit.coefficients)
            step = 1e-6 * max(abs(moved[i]), 1e-3)
            moved[i] += step
            fits = [propeller, drive]
            if part < 2:
                name = ("thrust", "torque")[part]
                new = getattr(propeller, name).model_copy(update={"coefficients": tuple(moved)})
                fits[0] = propeller.model_copy(update={name: new})
            else:
                fits[1] = drive.model_copy(update={"coefficients": tuple(moved)})
            after = thruster_model(fits[0], fits[1], vehicle).solve(code, speed)
            numeric = (after.thrust_n - points.thrust_n) / step
            column = (0, 3, 6)[part] + i
            np.testing.assert_allclose(jacobian[:, column], numeric, rtol=2e-3, atol=1e-2)


def test_monte_carlo_agrees_with_the_jacobian(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    """The balance solved anew for drawn coefficients; 200 draws know a deviation to 5 %."""
    model = thruster_model(propeller, drive, vehicle)
    code, speed = np.array([40.0, 90.0, 127.0, 127.0]), np.array([0.0, 1.0, 0.0, 2.0])
    jacobian = thrust_jacobian(model, model.solve(code, speed), code)
    analytic = np.sqrt(np.diag(jacobian @ model.covariance() @ jacobian.T))
    mean = [propeller.thrust.coefficients, propeller.torque.coefficients, drive.coefficients]
    draws = np.random.default_rng(1).multivariate_normal(
        np.concatenate(mean), model.covariance(), 200, method="svd"
    )
    thrust = [
        replace(
            model,
            propeller=replace(
                model.propeller, thrust_coefficients=one[:3], torque_coefficients=one[3:6]
            ),
            surface=replace(model.surface, coefficients=one[6:]),
        )
        .solve(code, speed)
        .thrust_n
        for one in draws
    ]
    np.testing.assert_allclose(np.std(thrust, axis=0) / analytic, 1.0, atol=0.2)


def test_table2_row_follows_the_family(static: StaticCharacteristic) -> None:
    for table_row in static.table2:
        k = table_row.fit.coefficients
        code = np.array(table_row.mode_code)
        polynomial = k[0] + k[1] * code + k[2] * code**2
        family = row(static, table_row.speed_mps)[code.astype(int) - 1]
        assert np.abs(polynomial - family).max() < 0.6
        assert table_row.thrust_max_ci95[0] < table_row.thrust_max_n < table_row.thrust_max_ci95[1]


def test_codes_below_the_bench_continue_the_line(static: StaticCharacteristic) -> None:
    """Nothing was tested below code 20: the thrust runs on straight and stops at zero."""
    rest = row(static, 0.0)
    np.testing.assert_allclose(np.diff(rest[15:21], 2), 0, atol=1e-9)
    assert static.status[0][18] == "extrapolated"
    assert static.status[0][0] == "dead"
    assert (rest >= 0).all()


def in_range(propeller: PropellerFit, thrust: Interval, torque: Interval) -> PropellerFit:
    """The same curves from a test over other advance ratios."""
    fits = {}
    for name, ends in (("thrust", thrust), ("torque", torque)):
        fit: PolynomialFit = getattr(propeller, name)
        quality = fit.quality.model_copy(update={"valid_range": ends})
        fits[name] = fit.model_copy(update={"quality": quality})
    return propeller.model_copy(update=fits)


def test_rest_is_no_measurement_of_a_propeller_tested_under_way_alone(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    """Open-water tests often begin at J = 0.5: what they say of rest is the curve continued."""
    late = in_range(propeller, (0.2, 0.8), (0.2, 0.8))
    static = static_characteristic(late, drive, vehicle)
    tested = static.code.index(100.0)
    assert static.status[0][tested] == "extrapolated"
    assert static.status[static.speed_mps.index(1.5)][tested] == "live"
    assert any("begins at J = 0.200" in line for line in static.explanations)
    early = in_range(propeller, (0.05, 0.8), (0.05, 0.8))
    static = static_characteristic(early, drive, vehicle)
    assert static.status[0][tested] == "live"
    assert not any("begins at J" in line for line in static.explanations)


def test_a_working_point_needs_both_coefficients_measured(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    short = in_range(propeller, (0.0, 0.3), (0.0, 0.8))
    static = static_characteristic(short, drive, vehicle)
    row_at, code_at = static.speed_mps.index(2.0), static.code.index(127.0)
    assert 0.3 < static.advance_ratio[row_at][code_at] < 0.8
    assert static.status[row_at][code_at] == "extrapolated"
    assert any("beyond J = 0.300" in line for line in static.explanations)


def test_curves_that_never_meet_say_so(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    """A propeller a tenth of the size loads the drive so little that it would overspeed."""
    small = propeller.model_copy(update={"diameter_m": 0.014})
    with pytest.raises(CannotComputeError, match="meets the drive's at no code") as error:
        static_characteristic(small, strong(drive), vehicle)
    assert "diameter" in str(error.value)


def strong(drive: DriveFit) -> DriveFit:
    """The same drive without the fall of its torque."""
    flat = tuple(
        c if power[0] == 0 else 0.0
        for c, power in zip(drive.coefficients, drive.exponents, strict=True)
    )
    return drive.model_copy(update={"coefficients": flat})


def test_what_happens_at_untested_codes_is_said_as_it_is(
    static: StaticCharacteristic,
    propeller: PropellerFit,
    load_test: LoadTestRecord,
    vehicle: Vehicle,
) -> None:
    """Codes 1 to 19 lie on the line through 20 and 21, or at zero."""
    (line,) = [text for text in static.explanations if "not on the bench" in text]
    assert line.startswith("Codes below 20 were not on the bench")
    assert "the line through the two nearest tested codes" in line
    thrust = row(static, 0.0)
    assert thrust[14] == pytest.approx(thrust[19] - 5 * (thrust[20] - thrust[19]))
    middle = tuple(p for p in load_test.points if p.code is not None and p.code <= 110)
    drive = fit_drive(load_test.model_copy(update={"points": middle}), vehicle)
    both = static_characteristic(propeller, drive, vehicle)
    assert any(text.startswith("Codes below 20 and above 110 were") for text in both.explanations)
    thrust = row(both, 1.0)
    assert thrust[126] == pytest.approx(thrust[109] + 17 * (thrust[109] - thrust[108]))


def test_table2_and_table4_end_where_the_family_ends(
    propeller: PropellerFit, load_test: LoadTestRecord, vehicle: Vehicle
) -> None:
    """Codes above 80 were not on the bench: one line for all, and the less known the further."""
    tested = tuple(p for p in load_test.points if p.code is not None and p.code <= 80)
    drive = fit_drive(load_test.model_copy(update={"points": tested}), vehicle)
    static = static_characteristic(propeller, drive, vehicle)
    table4 = inverse_characteristic(static, None, vehicle).table4
    assert static.table2
    for table_row, inverse in zip(static.table2, table4, strict=True):
        row_index = static.speed_mps.index(table_row.speed_mps)
        std = np.array(static.thrust_std_n[row_index])
        assert table_row.thrust_max_n == static.thrust_n[row_index][-1]
        assert inverse.thrust_max_n == pytest.approx(table_row.thrust_max_n)
        assert std[126] > 1.5 * std[79]
        low, high = table_row.thrust_max_ci95
        assert high - low == pytest.approx(2 * student_95(drive_degrees(drive)) * std[126])


def test_the_dead_zone_is_told_at_the_speeds_of_the_tables(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    tables = vehicle.tables.model_copy(update={"speed_mps": (0.0, 0.3, 3.0)})
    other = vehicle.model_copy(update={"tables": tables})
    explained = static_characteristic(propeller, drive, other).explanations
    told = [line.split(" codes")[0] for line in explained if "give no thrust: at" in line]
    assert told == ["At 0.3 m/s", "At 3 m/s"]


@pytest.mark.parametrize("share", [1e-3, 1e-15])
def test_a_drive_with_almost_no_torque_gives_a_plain_reason(
    load_test: LoadTestRecord, propeller: PropellerFit, vehicle: Vehicle, share: float
) -> None:
    weak = load_test.model_copy(
        update={
            "points": tuple(
                p.model_copy(update={"torque_nm": share * p.torque_nm}) for p in load_test.points
            )
        }
    )
    drive = fit_drive(weak, vehicle)
    with pytest.raises(CannotComputeError, match=r"within the dead thrust of 0\.5 N"):
        inverse_characteristic(static_characteristic(propeller, drive, vehicle), None, vehicle)


def test_a_surface_that_turns_no_propeller_is_explained(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    """Torque against the turning at every point: the balance is dead everywhere."""
    braking = drive.model_copy(update={"coefficients": tuple(-c for c in drive.coefficients)})
    with pytest.raises(CannotComputeError, match="at no code at rest"):
        static_characteristic(propeller, braking, vehicle)
