"""The regression under every fit, against certified values and against hand-made outliers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import fit_linear, jackknife_covariance

# NIST Statistical Reference Datasets, linear regression: load cell calibration (Pontius, 1968)
LOAD = np.tile(np.arange(1, 21) * 150000.0, 2)
DEFLECTION = np.array(
    [
        *(0.11019, 0.21956, 0.32949, 0.43899, 0.54803, 0.65694, 0.76562, 0.87487, 0.98292, 1.09146),
        *(1.20001, 1.30822, 1.41599, 1.52399, 1.63194, 1.73947, 1.84646, 1.95392, 2.06128, 2.16844),
        *(0.11052, 0.22018, 0.32939, 0.43886, 0.54798, 0.65739, 0.76596, 0.87474, 0.98300, 1.09150),
        *(1.20004, 1.30818, 1.41613, 1.52408, 1.63159, 1.73965, 1.84696, 1.95445, 2.06177, 2.16829),
    ]
)


def test_pontius_certified_values() -> None:
    fit = fit_linear(np.vander(LOAD, 3, increasing=True), DEFLECTION)
    certified = [0.673565789473684e-03, 0.732059160401003e-06, -0.316081871345029e-14]
    errors = [0.107938612033077e-03, 0.157817399981659e-09, 0.486652849992036e-16]
    assert not fit.outlier.any()
    np.testing.assert_allclose(fit.coefficients, certified, rtol=1e-8)
    np.testing.assert_allclose(np.sqrt(np.diag(fit.covariance)), errors, rtol=1e-8)
    assert fit.residual_std == pytest.approx(0.205177424076185e-03, rel=1e-8)
    assert fit.r_squared == pytest.approx(0.999999900178537, rel=1e-12)


def test_wampler1_certified_values() -> None:
    """NIST Wampler1: the exact quintic with unit coefficients."""
    x = np.arange(21.0)
    design = np.vander(x, 6, increasing=True)
    fit = fit_linear(design, design.sum(axis=1))
    np.testing.assert_allclose(fit.coefficients, np.ones(6), rtol=1e-6)


def test_interval_holds_the_truth_as_often_as_it_says() -> None:
    generator = np.random.default_rng(7)
    design = np.vander(np.linspace(0, 1, 25), 3, increasing=True)
    truth = np.array([0.14, -0.15, -0.06])
    inside = np.zeros(3)
    trials = 400
    for _ in range(trials):
        fit = fit_linear(design, design @ truth + generator.normal(0, 0.001, 25))
        inside += (fit.ci95[:, 0] <= truth) & (truth <= fit.ci95[:, 1])
    # 99.9 % binomial band about 0.95 for 400 trials
    assert np.all(np.abs(inside / trials - 0.95) < 0.04)


def test_clustered_errors_widen_the_interval() -> None:
    """A shared offset a sweep is not averaged out by more points of the same sweep."""
    generator = np.random.default_rng(3)
    x = np.tile(np.linspace(0, 1, 30), 12)
    sweep = np.repeat(np.arange(12), 30)
    y = 1 - x + generator.normal(0, 0.05, 12)[sweep] + generator.normal(0, 0.005, x.size)
    design = np.vander(x, 2, increasing=True)
    plain = fit_linear(design, y)
    clustered = fit_linear(design, y, clusters=sweep)
    width = clustered.ci95[0, 1] - clustered.ci95[0, 0]
    assert width > 2 * (plain.ci95[0, 1] - plain.ci95[0, 0])
    assert clustered.ci95[0, 0] <= 1.0 <= clustered.ci95[0, 1]


def test_interval_of_few_sweeps_holds_the_truth_almost_as_often_as_it_says() -> None:
    """Twelve codes, one sweep each, eight terms: with residuals as they are it is 0.83 and 0.67."""
    generator = np.random.default_rng(1)
    codes = np.array([20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127]) / 127.0
    points = 15
    sweep = np.repeat(np.arange(codes.size), points)
    x, y = np.tile(np.linspace(-1, 1, points), codes.size), codes[sweep]
    powers = [(i, j) for i in range(2) for j in range(4)]
    design = np.stack([x**i * y**j for i, j in powers], axis=1)
    at_centre = np.stack([(i == 0) * codes**j for i, j in powers], axis=1)
    truth = np.array([0.0, 0.7, 0.0, 0.0, -0.1, 0.0, 0.0, 0.0])
    inside, trials = np.zeros(codes.size), 200
    for _ in range(trials):
        errors = generator.normal(0, 0.01, codes.size)[sweep] + generator.normal(0, 0.003, x.size)
        fit = fit_linear(design, design @ truth + errors, clusters=sweep)
        std = np.sqrt(np.einsum("ij,jk,ik->i", at_centre, fit.covariance, at_centre))
        half = stats.t.ppf(0.975, fit.degrees_of_freedom) * std
        inside += np.abs(at_centre @ (fit.coefficients - truth)) <= half
    assert fit.degrees_of_freedom == 11
    assert inside[1:-1].mean() / trials >= 0.90
    assert inside[[0, -1]].mean() / trials >= 0.85


def test_jackknife_is_that_of_fits_without_a_cluster() -> None:
    generator = np.random.default_rng(5)
    design = np.vander(generator.uniform(0, 1, 60), 3, increasing=True)
    response = generator.normal(0, 1, 60)
    label = np.repeat(np.arange(6), 10)

    def solved(keep: np.ndarray) -> np.ndarray:
        return np.asarray(np.linalg.lstsq(design[keep], response[keep], rcond=None)[0])

    whole = solved(label >= 0)
    changes = np.array([solved(label != one) - whole for one in range(6)])
    found = jackknife_covariance(design, response - design @ whole, label)
    np.testing.assert_allclose(found, 5 / 6 * changes.T @ changes, rtol=1e-8)


def test_a_coefficient_that_rests_on_one_cluster_has_no_scatter_between_clusters() -> None:
    label = np.repeat(np.arange(5), 8)
    design = np.column_stack([np.ones(40), label == 4])
    assert jackknife_covariance(design, np.linspace(-1, 1, 40), label) is None
    fit = fit_linear(design, np.linspace(-1, 1, 40), clusters=label)
    assert not fit.clustered
    assert fit.degrees_of_freedom == 38


@given(
    index=st.integers(0, 39),
    jump=st.floats(15, 1000) | st.floats(-1000, -15),
)
def test_one_outlier_is_named_and_moves_nothing(index: int, jump: float) -> None:
    generator = np.random.default_rng(11)
    x = np.linspace(-1, 1, 40)
    design = np.vander(x, 3, increasing=True)
    noise = generator.normal(0, 1e-3, 40)
    clean = fit_linear(design, design @ [1.0, 2.0, 3.0] + noise)
    noise[index] += jump * 1e-3
    spoiled = fit_linear(design, design @ [1.0, 2.0, 3.0] + noise)
    assert spoiled.outlier[index]
    assert np.abs(spoiled.coefficients - clean.coefficients).max() < 2e-3


@pytest.mark.parametrize(("points", "width"), [(6, 3), (8, 4), (10, 4), (15, 4)])
def test_good_points_are_kept_where_there_are_few(points: int, width: int) -> None:
    """The scale of an M-estimate of so few is that of the points which it happens to pass by."""
    generator = np.random.default_rng(21)
    design = np.vander(np.linspace(0, 1, points), width, increasing=True)
    truth = np.array([1.0, -1.0, -0.4, 0.2])[:width]
    lost, inside = 0, np.zeros(width)
    for _ in range(200):
        fit = fit_linear(design, design @ truth + generator.normal(0, 0.01, points))
        lost += int(fit.outlier.sum())
        inside += (fit.ci95[:, 0] < truth) & (truth < fit.ci95[:, 1])
    assert lost <= 1
    # 95 % of 200, less three standard deviations
    assert inside.min() >= 180


@pytest.mark.parametrize("index", [0, 5, 11])
def test_a_torn_reading_among_few_is_still_named(index: int) -> None:
    x = np.linspace(0, 0.6, 12)
    design = np.vander(x, 3, increasing=True)
    y = design @ [0.139, -0.155, -0.061] + np.random.default_rng(4).normal(0, 0.0005, 12)
    y[index] += 0.05
    assert np.flatnonzero(fit_linear(design, y).outlier).tolist() == [index]


def test_points_that_alone_hold_a_coefficient_are_no_outliers() -> None:
    """Left out, they would leave the others at two places, which carry no parabola."""
    x = np.array([0.0] * 6 + [1.0] * 6 + [0.5])
    design = np.vander(x, 3, increasing=True)
    y = np.where(x == 0.5, 9.0, x) + np.random.default_rng(2).normal(0, 1e-3, 13)
    fit = fit_linear(design, y)
    assert not fit.outlier.any()
    assert fit.fitted[-1] == pytest.approx(9.0, abs=0.01)


def test_too_few_points_say_so() -> None:
    with pytest.raises(CannotComputeError, match="3 points cannot carry 3 coefficients"):
        fit_linear(np.vander([1.0, 2.0, 3.0], 3), np.ones(3))


def test_points_all_at_one_place_say_so() -> None:
    with pytest.raises(CannotComputeError, match="do not determine"):
        fit_linear(np.vander(np.ones(9), 3), np.ones(9))
