"""Departures beyond where they have a meaning."""

import numpy as np

from pipeline.diagnose.asking.held import held_within
from pipeline.diagnose.linear.evidence import Prior


def test_what_is_beyond_is_held_and_moves_the_others() -> None:
    prior = Prior(np.array([2.0, 0.0]), np.array([[1.0, 0.5], [0.5, 1.0]]))
    found = held_within(prior, np.array([[-1.0, 1.0]]))
    np.testing.assert_allclose(found.mean, [1.0, -0.5])
    np.testing.assert_allclose(np.diag(found.covariance), [0.0, 0.75])


def test_what_is_within_stays() -> None:
    prior = Prior(np.array([0.5, 9.0]), np.eye(2))
    found = held_within(prior, np.array([[-1.0, 1.0]]))
    np.testing.assert_array_equal(found.mean, prior.mean)
    np.testing.assert_array_equal(found.covariance, prior.covariance)
