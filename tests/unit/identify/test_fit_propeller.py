"""Table 1 against the curve the points were drawn from."""

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.identify.polynomial import fit_polynomial
from pipeline.identify.propeller import fit_propeller
from pipeline.records.fits import PropellerFit
from pipeline.records.measurements import OpenWaterRecord
from pipeline.vehicle.schema import Vehicle

K_T = np.array([0.139, -0.155, -0.061])
K_M = np.array([0.0171, -0.0164, -0.0055])


def test_curves_come_back_within_one_per_cent(propeller: PropellerFit) -> None:
    j = np.linspace(0, 0.6, 61)
    for fit, truth in ((propeller.thrust, K_T), (propeller.torque, K_M)):
        error = np.polynomial.polynomial.polyval(j, np.array(fit.coefficients) - truth)
        assert np.abs(error).max() <= 0.01 * truth[0]
        assert all(low <= true <= high for (low, high), true in zip(fit.ci95, truth, strict=True))


def test_checks_pass_on_a_propeller(propeller: PropellerFit) -> None:
    assert [check.name for check in propeller.checks if not check.passed] == []
    assert "J = 0.70" in propeller.checks[0].text


def test_swapped_curves_fail_the_checks(open_water: OpenWaterRecord, vehicle: Vehicle) -> None:
    swapped = open_water.model_copy(
        update={
            "points": tuple(
                p.model_copy(
                    update={
                        "thrust_coefficient": p.torque_coefficient,
                        "torque_coefficient": p.thrust_coefficient,
                    }
                )
                for p in open_water.points
            )
        }
    )
    failed = [c.name for c in fit_propeller(swapped, vehicle).checks if not c.passed]
    assert "K_T crosses zero before K_M" in failed


def test_order_scores_prefer_the_true_degree(propeller: PropellerFit) -> None:
    scores = {score.order: score for score in propeller.thrust.quality.orders}
    assert scores["degree 1"].leave_one_out_rmse > 3 * scores["degree 2"].leave_one_out_rmse
    assert scores["degree 2"].chosen
    assert "AICc" in propeller.thrust.quality.order_reason


def test_a_bad_row_is_named_not_dropped(open_water: OpenWaterRecord, vehicle: Vehicle) -> None:
    bad = open_water.points[10].model_copy(update={"thrust_coefficient": 0.02})
    points = (*open_water.points[:10], bad, *open_water.points[11:])
    fit = fit_propeller(open_water.model_copy(update={"points": points}), vehicle)
    (outlier,) = fit.thrust.quality.outliers
    assert outlier.source == bad.source
    assert fit.thrust.quality.points == 24
    assert fit.torque.quality.points == 25


def test_no_points_say_what_to_do(vehicle: Vehicle) -> None:
    with pytest.raises(CannotComputeError, match="open_water/"):
        fit_propeller(OpenWaterRecord(points=(), sheets=(), problems=()), vehicle)


def test_degrees_are_compared_over_the_same_points() -> None:
    """A bend is not a row of outliers, which a straight line would be praised for leaving out."""
    generator = np.random.default_rng(1)
    j = np.linspace(0, 0.8, 36)
    k_t = 0.14 - 0.15 * j - 1.8 * np.maximum(j - 0.6, 0) ** 2 + generator.normal(0, 7e-4, 36)
    k_t[10] += 0.1  # a reading that no degree makes sense of
    fit = fit_polynomial(j, k_t, degree=2, quantity="K_T", variable="J", unit="1", degree_reason="")
    aicc = [score.aicc for score in fit.quality.orders]
    error = [score.leave_one_out_rmse for score in fit.quality.orders]
    assert aicc == sorted(aicc, reverse=True)
    assert error == sorted(error, reverse=True)
    assert error[0] > 0.01
    assert error[-1] < 0.003
