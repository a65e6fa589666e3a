"""The drive's surface against straight characteristics that are known."""

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.identify.drive import fit_drive
from pipeline.physics.drive import drive_torque, drive_torque_slope
from pipeline.records.fit_values import drive_degrees, torque_surface
from pipeline.records.fits import Check, DriveFit
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.vehicle.schema import Vehicle


def true_torque(n: np.ndarray, code: np.ndarray) -> np.ndarray:
    y = code / 127.0
    return 0.73 * y - 0.04 * (n - 28.2 * y)


def changed(record: LoadTestRecord, **update: object) -> LoadTestRecord:
    return record.model_copy(
        update={"points": tuple(p.model_copy(update=update) for p in record.points)}
    )


def test_surface_interpolates_between_codes(drive: DriveFit) -> None:
    code = np.array([25.0, 55.0, 85.0, 123.0])
    n = 28.2 * code / 127 + 1
    fitted = drive_torque(n, code, torque_surface(drive))
    np.testing.assert_allclose(fitted, true_torque(n, code), atol=0.002)


def test_the_straight_characteristic_is_found(drive: DriveFit) -> None:
    """Powers of the code stay, because the centre line of the sweeps is a cubic of the code."""
    chosen = next(score for score in drive.quality.orders if score.chosen)
    assert chosen.order == "x^1 N^3"
    assert all(check.passed for check in drive.checks)


def test_slope_is_the_derivative(drive: DriveFit) -> None:
    surface = torque_surface(drive)
    n, step = np.linspace(0, 60, 50), 1e-5  # beyond the measured band too
    numeric = (drive_torque(n + step, 60, surface) - drive_torque(n - step, 60, surface)) / (
        2 * step
    )
    np.testing.assert_allclose(drive_torque_slope(n, 60, surface), numeric, atol=1e-7)


def test_spread_between_drives_is_found(drive: DriveFit) -> None:
    """The two drives were made 0.6 % apart in torque."""
    scales = list(drive.torque_scale_by_file.values())
    assert scales[1] / scales[0] == pytest.approx(1.006, abs=0.002)
    assert drive.torque_scale_std == pytest.approx(0.006 / np.sqrt(2), rel=0.3)


def test_a_torn_reading_is_named(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    index = max(range(len(load_test.points)), key=lambda i: load_test.points[i].torque_nm)
    torn = load_test.points[index]
    bad = torn.model_copy(update={"torque_nm": torn.torque_nm * 1.3})
    points = (*load_test.points[:index], bad, *load_test.points[index + 1 :])
    fit = fit_drive(load_test.model_copy(update={"points": points}), vehicle)
    assert [outlier.source for outlier in fit.quality.outliers] == [bad.source]


def test_reverse_sweeps_mirror(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    reverse = load_test.model_copy(
        update={
            "points": tuple(
                p.model_copy(
                    update={
                        "code": -p.code,
                        "shaft_speed_rpm": -p.shaft_speed_rpm,
                        "torque_nm": -p.torque_nm,
                    }
                )
                for p in load_test.points
                if p.code is not None
            )
        }
    )
    assert fit_drive(reverse, vehicle).coefficients == fit_drive(load_test, vehicle).coefficients


def test_marked_points_are_left_out(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    first = load_test.points[0]
    warm_up = LoadTestPoint(**{**first.model_dump(), "torque_nm": 99.0, "marks": ("warm-up",)})
    spoiled = load_test.model_copy(update={"points": (*load_test.points, warm_up)})
    assert fit_drive(spoiled, vehicle) == fit_drive(load_test, vehicle)


def test_missing_codes_say_what_to_do(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    with pytest.raises(CannotComputeError, match=r"no control code.*columns\.load_test\.code"):
        fit_drive(changed(load_test, code=None), vehicle)
    with pytest.raises(CannotComputeError, match=r"1 control code \(90\)"):
        fit_drive(changed(load_test, code=90.0), vehicle)
    with pytest.raises(CannotComputeError, match="load_test/"):
        fit_drive(changed(load_test, marks=("duplicate",)), vehicle)


def test_a_bench_without_torque_is_explained(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    with pytest.raises(CannotComputeError, match="shows no torque at any point: the largest is 0"):
        fit_drive(changed(load_test, torque_nm=0.0), vehicle)


def test_sweeps_too_few_to_carry_the_covariance_are_said(
    load_test: LoadTestRecord, drive: DriveFit, vehicle: Vehicle
) -> None:
    assert drive.clustered
    assert drive_degrees(drive) == 47
    assert sweeps_check(drive).passed
    few = tuple(
        point
        for point in load_test.points
        if point.code in {40, 80, 120}
        and point.branch == "loading"
        and point.source.file == "drive-0.xlsx"
    )
    fit = fit_drive(load_test.model_copy(update={"points": few}), vehicle)
    assert (fit.clusters, fit.clustered) == (3, False)
    assert drive_degrees(fit) == fit.quality.points - len(fit.coefficients)
    assert not sweeps_check(fit).passed
    assert f"3 sweeps are too few for the {len(fit.coefficients)} terms" in sweeps_check(fit).text


def test_fewer_than_two_sweeps_a_term_are_said(load_test: LoadTestRecord, vehicle: Vehicle) -> None:
    """A covariance of whole sweeps there is, but what it rests on is thin."""
    one_branch = tuple(
        point
        for point in load_test.points
        if point.branch == "loading" and point.source.file == "drive-0.xlsx"
    )
    fit = fit_drive(load_test.model_copy(update={"points": one_branch}), vehicle)
    assert fit.clustered
    assert drive_degrees(fit) == 11
    assert not sweeps_check(fit).passed
    assert "fewer than two for each term" in sweeps_check(fit).text


def sweeps_check(fit: DriveFit) -> Check:
    (check,) = [c for c in fit.checks if c.name == "sweeps enough for the intervals"]
    return check


def test_readings_at_code_0_are_left_out_and_counted(
    load_test: LoadTestRecord, drive: DriveFit, vehicle: Vehicle
) -> None:
    """The sheet of a bench that also logged the drive at rest: no sign, no characteristic."""
    idle = tuple(
        point.model_copy(update={"code": 0.0, "shaft_speed_rpm": 3.0, "torque_nm": 0.002})
        for point in load_test.points[:30]
    )
    with_idle = load_test.model_copy(update={"points": (*load_test.points, *idle)})
    fit = fit_drive(with_idle, vehicle)
    *checks, said = fit.checks
    assert fit.model_copy(update={"checks": tuple(checks)}) == drive
    assert said.name == "readings at code 0 left out"
    assert said.text.startswith("30 at code 0")
    with pytest.raises(CannotComputeError, match=r"readings at code 0 alone \(30 of them\)"):
        fit_drive(load_test.model_copy(update={"points": idle}), vehicle)
