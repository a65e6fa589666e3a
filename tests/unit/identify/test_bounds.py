"""Steps and intervals of parameters that cannot be negative, against independent references."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.optimize import minimize

from pipeline.identify.bounds import bounded_step, cut_off
from pipeline.types import FloatArray


def positive(generator: np.random.Generator, size: int) -> FloatArray:
    root = generator.standard_normal((size, size))
    return np.asarray(root @ root.T + 0.1 * np.eye(size))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 6))
def test_bounded_step_is_the_least_cost_inside(seed: int, size: int) -> None:
    generator = np.random.default_rng(seed)
    matrix, pull = positive(generator, size), 3.0 * generator.standard_normal(size)
    lowest = np.where(generator.random(size) < 0.6, -np.abs(generator.standard_normal(size)), -9e9)
    step, beyond = bounded_step(matrix, pull, np.where(lowest < -1e9, -np.inf, lowest))

    def cost_of(d: FloatArray) -> float:
        return float(0.5 * d @ matrix @ d - pull @ d)

    def slope_of(d: FloatArray) -> FloatArray:
        return np.asarray(matrix @ d - pull)

    found = minimize(
        cost_of,
        np.zeros(size),
        jac=slope_of,
        bounds=[(low, None) for low in lowest],
        method="L-BFGS-B",
        options={"ftol": 1e-15, "gtol": 1e-10, "maxiter": 5000},
    )
    assert (step >= lowest - 1e-9).all()
    assert cost_of(step) <= found.fun + 1e-6 * max(1.0, abs(found.fun))
    np.testing.assert_allclose(step + beyond, np.linalg.solve(matrix, pull), rtol=1e-6, atol=1e-8)


def test_step_without_a_bound_in_its_way_is_the_plain_one() -> None:
    matrix = np.array([[2.0, 0.5], [0.5, 1.0]])
    step, beyond = bounded_step(matrix, np.array([1.0, 1.0]), np.array([-1.0, -np.inf]))
    np.testing.assert_allclose(matrix @ step, [1.0, 1.0])
    assert not beyond.any()


def test_bounds_that_are_far_change_nothing() -> None:
    assert cut_off(np.array([5.0, 0.0]), np.eye(2), np.array([0.0, -np.inf])) is None


@pytest.mark.parametrize("mean", [-3.0, -0.5, 0.0, 2.5, 5.0])
def test_one_coordinate_is_the_normal_that_is_cut_off(mean: float) -> None:
    found = cut_off(np.array([mean]), np.array([[4.0]]), np.array([0.0]))
    assert found is not None
    known = stats.truncnorm(-mean / 2.0, np.inf, loc=mean, scale=2.0)
    assert found.std[0] == pytest.approx(known.std(), rel=0.02)
    inside = known.cdf(found.high[0]) - known.cdf(found.low[0])
    assert inside == pytest.approx(0.95, abs=0.004)
    if mean <= 2.5:
        # the shortest interval begins at the bound while the density there is the larger
        assert found.low[0] == 0.0
        assert found.high[0] == pytest.approx(known.ppf(0.95), rel=0.02)
    else:
        assert known.pdf(found.low[0]) == pytest.approx(known.pdf(found.high[0]), rel=0.35)


def test_a_bound_moves_what_goes_with_it() -> None:
    """Two bounded coordinates and a free one, against the density summed up on a grid."""
    mean = np.array([-0.5, 0.6, 0.2])
    covariance = np.array([[1.0, -0.8, 0.5], [-0.8, 1.0, -0.3], [0.5, -0.3, 0.7]])
    found = cut_off(mean, covariance, np.array([0.0, 0.0, -np.inf]))
    assert found is not None
    a, b, c = np.meshgrid(
        np.linspace(0, 4, 81), np.linspace(0, 5, 101), np.linspace(-4, 4, 161), indexing="ij"
    )
    points = np.stack([a, b, c], axis=-1)
    density = np.array(stats.multivariate_normal(mean, covariance).pdf(points))
    # half weight on the faces of the bounds
    density[0] *= 0.5
    density[:, 0] *= 0.5
    density /= density.sum()
    for i, grid in enumerate((a, b, c)):
        centre = np.sum(density * grid)
        assert found.std[i] == pytest.approx(
            np.sqrt(np.sum(density * (grid - centre) ** 2)), rel=0.03
        )
        inside = (grid >= found.low[i]) & (grid <= found.high[i])
        assert density[inside].sum() == pytest.approx(0.95, abs=0.02)


def test_intervals_at_the_bound_cover() -> None:
    """Truth half normal, as the prior where the file says nothing; measured with noise of one."""
    generator = np.random.default_rng(3)
    truth = np.abs(generator.standard_normal(300))
    measured = truth + generator.standard_normal(300)
    inside = 0
    for true, seen in zip(truth, measured, strict=True):
        # prior N(0, 1) and reading N(truth, 1): posterior N(seen / 2, 1 / 2), cut off at zero
        found = cut_off(np.array([seen / 2]), np.array([[0.5]]), np.array([0.0]))
        if found is None:
            low, high = seen / 2 - 1.96 * np.sqrt(0.5), seen / 2 + 1.96 * np.sqrt(0.5)
        else:
            low, high = found.low[0], found.high[0]
        inside += int(low <= true <= high)
    assert stats.binomtest(inside, 300, 0.95).pvalue > 0.01
