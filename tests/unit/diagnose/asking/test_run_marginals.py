"""Own and shared unknowns integrated out, against the dense Gaussian that they stand for."""

import numpy as np
import pytest

from pipeline.diagnose.asking.run_marginals import (
    RunGrams,
    factored,
    force_energy,
    marginals,
    solve,
    together,
    with_other_readings,
    without_scatter,
)
from pipeline.diagnose.linear.elimination import ForcePrior, Marginal
from pipeline.types import FloatArray

ROWS, SHARED, DEPARTURES = 40, 2, 3
FORCES = 6


def force_prior() -> ForcePrior:
    return ForcePrior(np.eye(FORCES) / 4.0, FORCES * np.log(4.0))


class Dense:
    """Two windows of two runs, with all columns at hand."""

    def __init__(self, seed: int = 3) -> None:
        rng = np.random.default_rng(seed)
        self.local = rng.standard_normal((2, ROWS, 12 + FORCES))
        self.shared = rng.standard_normal((2, ROWS, SHARED))
        self.columns = rng.standard_normal((2, ROWS, DEPARTURES))
        self.readings = 3.0 * rng.standard_normal((2, ROWS))

    def grams(self) -> RunGrams:
        every = np.concatenate(
            [self.local, self.shared, self.columns, self.readings[:, :, None]], axis=2
        )
        products = np.swapaxes(every, 1, 2) @ every
        own = self.local.shape[2]
        return RunGrams(
            products[:, :own, :own],
            products[:, :own, own:],
            products[:, own:, own:],
            np.array([[0, 1], [2, 3]]),
            np.eye(2 * SHARED),
            np.array([0, 1]),
            np.array([0, 0, 1, 1]),
        )

    def covariance(self, window: int) -> FloatArray:
        prior = np.concatenate([np.ones(12), np.full(FORCES, 4.0)])
        local, shared = self.local[window], self.shared[window]
        return np.asarray(np.eye(ROWS) + (local * prior) @ local.T + shared @ shared.T)

    def expected(self, window: int) -> Marginal:
        inverse = np.linalg.inv(self.covariance(window))
        columns, readings = self.columns[window], self.readings[window]
        return Marginal(
            columns.T @ inverse @ columns,
            columns.T @ inverse @ readings,
            float(readings @ inverse @ readings),
            float(np.linalg.slogdet(self.covariance(window))[1]),
        )


def assert_same(found: Marginal, wanted: Marginal) -> None:
    np.testing.assert_allclose(found.information, wanted.information, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.score, wanted.score, rtol=1e-9, atol=1e-9)
    assert found.misfit == pytest.approx(wanted.misfit, rel=1e-9)
    assert found.log_determinant == pytest.approx(wanted.log_determinant, rel=1e-9)


def test_each_run_says_what_the_dense_gaussian_says() -> None:
    dense = Dense()
    grams = dense.grams()
    for window, found in enumerate(marginals(grams, factored(grams, force_prior()))):
        assert_same(found, dense.expected(window))


def test_a_window_that_does_not_speak_says_nothing() -> None:
    dense = Dense()
    grams = dense.grams()
    found = marginals(grams, factored(grams, force_prior()), np.array([True, False]))
    assert_same(found[0], dense.expected(0))
    assert not found[1].information.any()
    assert found[1].log_determinant == pytest.approx(0.0, abs=1e-12)


def test_scatter_between_runs_is_a_wider_covariance() -> None:
    dense, scatter = Dense(), np.array([0.7, 0.0, 0.2])
    grams = dense.grams()
    own = marginals(grams, factored(grams, force_prior()))
    for window, one in enumerate(own):
        columns = dense.columns[window]
        wide = dense.covariance(window) + (columns * scatter**2) @ columns.T
        inverse = np.linalg.inv(wide)
        found = without_scatter(one, scatter)
        np.testing.assert_allclose(found.information, columns.T @ inverse @ columns, atol=1e-9)
        assert found.log_determinant == pytest.approx(float(np.linalg.slogdet(wide)[1]))
    both = together(own)
    np.testing.assert_allclose(both.score, own[0].score + own[1].score)


def test_other_readings_change_the_score_alone() -> None:
    dense, other = Dense(), Dense()
    other.readings = other.readings + 1.0
    before = factored(dense.grams(), force_prior())
    renewed = with_other_readings(before, other.grams())
    for window, found in enumerate(marginals(other.grams(), renewed)):
        assert_same(found, other.expected(window))


def test_the_most_probable_unknowns_are_those_of_least_squares() -> None:
    dense = Dense()
    grams = dense.grams()
    x = np.array([[0.3, -0.2, 0.1], [-0.1, 0.4, 0.0]])
    found = solve(grams, factored(grams, force_prior()), x)
    prior = np.concatenate([np.ones(12), np.full(FORCES, 0.25), np.ones(SHARED)])
    for window in range(2):
        design = np.concatenate([dense.local[window], dense.shared[window]], axis=1)
        left = dense.readings[window] - dense.columns[window] @ x[window]
        wanted = np.linalg.solve(design.T @ design + np.diag(prior), design.T @ left)
        mine = np.concatenate(
            [found.starts[window], found.forces[window], found.shared[2 * window : 2 * window + 2]]
        )
        np.testing.assert_allclose(mine, wanted, atol=1e-9)


def test_energy_of_unseen_forces_is_that_of_their_prior() -> None:
    dense = Dense()
    dense.local[:, :, 12:] = 0.0
    grams = dense.grams()
    found = force_energy(grams, factored(grams, force_prior()), np.zeros(DEPARTURES), np.eye(1))
    np.testing.assert_allclose(found, 4.0, rtol=1e-9)
