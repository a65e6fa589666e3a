"""Differences to the published tables, checked by hand arithmetic."""

import numpy as np
import pytest
import synthetic_records

from pipeline.records.fit_values import polynomial_band, static_thrust, table2_thrust
from pipeline.records.fits import SpeedInverse
from pipeline.report.results import VehicleResults
from pipeline.report.sections.tables import (
    Coefficient,
    coefficients,
    fit_difference,
    largest,
    largest_relative_difference,
    table2_differences,
    table4_difference,
)
from pipeline.vehicle.bench_schema import Published


def published(results: VehicleResults) -> Published:
    assert results.vehicle.published is not None
    return results.vehicle.published


def test_published_table2_at_full_code_is_what_the_errata_computed() -> None:
    # 42.48, 38.76, 34.36, 30.30, 25.40 N at code 127
    rows = zip(synthetic_records.KF0, synthetic_records.KF1, synthetic_records.KF2, strict=True)
    thrust = [float(table2_thrust(row, 127.0)) for row in rows]
    assert thrust == pytest.approx([42.48, 38.76, 34.36, 30.30, 25.40], abs=0.006)


def test_dead_zone_of_published_table2_is_where_the_polynomial_is_not_positive() -> None:
    # root of -4 + 0.254 N + 8.82e-4 N^2: (-0.254 + sqrt(0.064516 + 0.014112)) / 0.001764 = 14.97
    at_rest = (-4.0, 0.254, 8.82e-4)
    assert float(table2_thrust(at_rest, 14.9)) == 0.0
    assert float(table2_thrust(at_rest, 15.1)) > 0.0
    assert float(table2_thrust(at_rest, -4.5)) == 0.0


def test_own_table2_is_tenth_of_a_newton_below_the_published(results: VehicleResults) -> None:
    static, table2 = results.static, published(results).table2
    assert static is not None
    assert table2 is not None
    codes = [60.0, 100.0, 127.0]
    ours = [
        difference
        for name, _, difference in table2_differences(static, table2, codes)
        if name == "our quadratic Table 2"
    ]
    assert len(ours) == len(table2.speed_mps)
    for difference in ours:
        assert difference == pytest.approx([-0.1] * 3, abs=1e-9)


def test_family_is_scored_only_where_the_published_thrust_is_over_half_a_newton(
    results: VehicleResults,
) -> None:
    static, table2 = results.static, published(results).table2
    assert static is not None
    assert table2 is not None
    codes = [20.0, 30.0, 40.0]
    worst = {
        speed_mps: largest(codes, difference)
        for name, speed_mps, difference in table2_differences(static, table2, codes)
        if name == "the family"
    }
    # at 2 m/s the published thrust of codes 20 to 40 is zero: nothing is scored
    assert worst[2.0] is None
    assert worst[0.0] is not None


def test_a_missing_working_point_is_not_zero_thrust(results: VehicleResults) -> None:
    static = results.static
    assert static is not None
    last = len(static.speed_mps) - 1
    assert static.status[last][0] == "no_working_point"
    assert np.isnan(static_thrust(static, last, 1.0))
    assert float(static_thrust(static, last, 3.0)) == 0.0


def test_table3_differs_by_the_constant_that_was_added(results: VehicleResults) -> None:
    inverse, table3 = results.inverse, published(results).table3
    assert inverse is not None
    assert inverse.table3_positive is not None
    assert table3 is not None
    difference = fit_difference(inverse.table3_positive, table3.positive, [1.0, 20.0, 42.0])
    assert difference == pytest.approx([0.4, 0.4, 0.4])


def test_table4_difference_is_left_blank_above_either_largest_thrust(
    results: VehicleResults,
) -> None:
    table4 = published(results).table4
    assert table4 is not None
    printed = tuple(column[0] for column in synthetic_records.KN)
    ours = SpeedInverse(
        speed_mps=0.0,
        thrust_max_n=41.0,
        coefficients=(printed[0] + 1.0, *printed[1:]),
        ci95=((0.0, 1.0),) * 4,
    )
    difference = table4_difference(ours, table4, [0.5, 10.0, 41.0, 41.5])
    assert difference is not None
    assert np.isnan(difference[0])  # the dead band itself
    assert difference[1:3] == pytest.approx([1.0, 1.0])
    assert np.isnan(difference[3])
    assert table4_difference(ours.model_copy(update={"speed_mps": 0.7}), table4, [10.0]) is None


def test_relative_difference_of_table1(results: VehicleResults) -> None:
    assert results.propeller is not None
    # 0.1391 against 0.139 everywhere: 0.0001 / 0.139
    difference = largest_relative_difference(results.propeller.thrust, synthetic_records.K_T, 0.6)
    assert difference == pytest.approx(0.0001 / 0.139)


def test_inside_and_distance_of_a_published_coefficient() -> None:
    inside = Coefficient("a", 1.0, (0.8, 1.2), 1.1)
    outside = Coefficient("a", 1.0, (0.8, 1.2), 1.5)
    assert inside.inside is True
    assert outside.inside is False
    assert outside.half_widths_away == pytest.approx(2.5)
    assert Coefficient("a", 1.0, (0.8, 1.2), None).inside is None


def test_more_coefficients_than_published_ones_are_all_kept() -> None:
    both = coefficients(("a", "b"), (1.0, 2.0), ((0.0, 2.0), (1.0, 3.0)), (1.5,))
    assert [c.published for c in both] == [1.5, None]


def test_band_has_the_half_width_that_the_covariance_says(results: VehicleResults) -> None:
    assert results.propeller is not None
    fit = results.propeller.thrust
    _, half = polynomial_band(fit, np.array([0.0]))
    # at J = 0 the curve is its first coefficient, so the band is that coefficient's interval
    assert half[0] == pytest.approx((fit.ci95[0][1] - fit.ci95[0][0]) / 2)
