"""Rates and figures of a campaign: exact bounds, goals, what is not asked."""

import numpy as np
import pytest

from pipeline.blind.rates import at_least, clopper_pearson, figure, rate


@pytest.mark.parametrize(
    ("yes", "cases", "low", "high"),
    [(0, 300, 0.0, 0.012221), (9, 10, 0.554984, 0.997471), (10, 10, 0.691503, 1.0)],
)
def test_bounds_of_clopper_and_pearson(yes: int, cases: int, low: float, high: float) -> None:
    np.testing.assert_allclose(clopper_pearson(yes, cases), (low, high), atol=2e-6)


def test_what_does_not_apply_is_not_counted() -> None:
    found = rate("right", "all", (True, None, False, True), at_least(0.6))
    assert (found.yes, found.cases, found.met) == (2, 3, True)
    nothing = rate("right", "all", (None, None), at_least(0.6))
    assert (nothing.cases, nothing.share, nothing.met) == (0, None, None)


def test_a_goal_may_be_of_the_median_of_the_90th_percentile_or_of_the_mean() -> None:
    values = (1.0, 1.0, 1.0, 1.0, 6.0, None)
    mean = figure("answers", "all", values, "mean <= 1.3", lambda _m, _p90, mean: mean <= 1.3)
    assert (mean.cases, mean.median, mean.mean, mean.met) == (5, 1.0, 2.0, False)
    median = figure("answers", "all", values, "median <= 1.3", lambda median, _p, _m: median <= 1.3)
    assert median.met
    assert median.p90 == pytest.approx(4.0)
    assert figure("answers", "all", ()).met is None
