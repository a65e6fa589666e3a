"""What is too small to matter, one by one, and is no part of the healthy floor."""

import numpy as np
from diagnosis_cases import small_coordinates

from pipeline.diagnose.judging.nil import stated_alone
from pipeline.diagnose.linear.evidence import Prior


def test_independent_departures_keep_what_is_stated_of_them_and_lose_the_rest() -> None:
    every = small_coordinates()
    stated = np.array([one.ordinary for one in every])
    assert 0 < np.count_nonzero(stated) < stated.size
    prior = Prior(np.zeros(stated.size), np.diag(np.where(stated > 0.0, stated, 0.3) ** 2))
    np.testing.assert_allclose(stated_alone(prior, every).covariance, np.diag(stated**2))


def test_what_healthy_runs_could_not_tell_apart_is_no_uncertainty_of_what_is_stated() -> None:
    """With the others known, what is stated is known as well as the sum of both was."""
    every = small_coordinates()
    stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
    other = next(k for k, one in enumerate(every) if one.ordinary == 0.0)
    covariance = np.zeros((len(every), len(every)))
    pair = np.ix_([stated[0], other], [stated[0], other])
    # each may be anything within 0.2, their sum is known to 0.01
    covariance[pair] = 0.04 * np.array([[1.0, -1.0], [-1.0, 1.0]]) + 0.0001 * np.eye(2)
    mean = np.linspace(-0.1, 0.1, len(every))
    found = stated_alone(Prior(mean, covariance), every)
    np.testing.assert_allclose(found.covariance[stated[0], stated[0]], 0.0002, rtol=0.01)
    assert not found.covariance[other].any()
    np.testing.assert_array_equal(found.mean, mean)
