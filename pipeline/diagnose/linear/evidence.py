r"""How probable the readings are when some departures may be wide: Gaussian marginal likelihood.

With departures x ~ N(m, C) the log evidence is that of x = 0 plus

.. math:: \tfrac12 b_m^T (M + C^{-1})^{-1} b_m - \tfrac12 \log|1 + C M| + b^T m - \tfrac12 m^T M m,
          \qquad b_m = b - M m

(Occam's factor is the determinant). Departures that only make sense on one side of neutral are cut
off there: the evidence is multiplied by the share of the posterior inside over that of the prior.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr

from pipeline.diagnose.linear.elimination import Marginal
from pipeline.types import FloatArray, IntArray


@dataclass(frozen=True)
class Prior:
    """What is believed of the departures before: mean (g,) and covariance (g, g)."""

    mean: FloatArray
    covariance: FloatArray


@dataclass(frozen=True)
class Fit:
    """Log evidence of a hypothesis, and the departures it leads to: mean and covariance (g,)."""

    log_evidence: float
    mean: FloatArray
    std: FloatArray


def widened(prior: Prior, which: IntArray, variance: FloatArray) -> Prior:
    """Let departures `which` vary by further variances (k,)."""
    covariance = prior.covariance.copy()
    covariance[which, which] += variance
    return Prior(prior.mean, covariance)


def held_at(prior: Prior, index: int, value: float) -> Prior:
    """Prior in which one departure is known to have a value: the conditional normal distribution.

    >>> left = held_at(Prior(np.zeros(2), np.array([[1.0, 0.5], [0.5, 1.0]])), 0, 2.0)
    >>> left.mean, left.covariance[1, 1]
    (array([2., 1.]), np.float64(0.75))
    """
    side = prior.covariance[:, index].copy()
    own = max(float(side[index]), 1e-300)
    mean = prior.mean + side / own * (value - prior.mean[index])
    covariance = prior.covariance - np.outer(side, side) / own
    mean[index] = value
    covariance[index], covariance[:, index] = 0.0, 0.0
    return Prior(mean, covariance)


def fit(found: Marginal, prior: Prior) -> Fit:
    """Posterior and log evidence of the readings under a prior."""
    active = np.flatnonzero(np.diag(prior.covariance) > 0.0)
    mean, std = prior.mean.copy(), np.zeros(prior.mean.size)
    score = found.score - found.information @ prior.mean
    log_evidence = -0.5 * (found.misfit + found.log_determinant)
    log_evidence += float(
        found.score @ prior.mean - 0.5 * prior.mean @ found.information @ prior.mean
    )
    if active.size:
        information = found.information[np.ix_(active, active)]
        covariance = prior.covariance[np.ix_(active, active)]
        # symmetric form: C^1/2 of a prior that may be nearly singular
        values, vectors = np.linalg.eigh(covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        inner = np.eye(active.size) + root.T @ information @ root
        solved = np.linalg.solve(inner, root.T @ score[active])
        log_evidence += 0.5 * float(score[active] @ root @ solved)
        log_evidence -= 0.5 * float(np.linalg.slogdet(inner)[1])
        mean[active] += root @ solved
        spread = root @ np.linalg.solve(inner, root.T)
        std[active] = np.sqrt(np.maximum(np.diag(spread), 0.0))
    return Fit(log_evidence, mean, std)


def promise(found: Marginal, prior: Prior, way: FloatArray) -> float:
    """Log evidence by which the end of a way (g,) to the most probable departures is better."""
    active = np.flatnonzero(np.diag(prior.covariance) > 0.0)
    block = np.ix_(active, active)
    believed = np.linalg.pinv(prior.covariance[block], hermitian=True)
    return 0.5 * float(way[active] @ (found.information[block] + believed) @ way[active])


def posterior(found: Marginal, prior: Prior) -> Prior:
    """Compute what the readings leave of a prior: mean and covariance."""
    values, vectors = np.linalg.eigh(prior.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    inner = np.eye(values.size) + root.T @ found.information @ root
    score = found.score - found.information @ prior.mean
    solved = np.linalg.solve(inner, np.column_stack([root.T, (root.T @ score)[:, None]]))
    covariance = root @ solved[:, :-1]
    return Prior(prior.mean + root @ solved[:, -1], (covariance + covariance.T) / 2)


def log_inside(mean: float, std: float, low: float, high: float) -> float:
    """Log of the probability that a normal variable lies between two bounds.

    >>> round(log_inside(0.0, 1.0, -1.959964, 1.959964), 4)
    -0.0513
    """
    std = max(std, 1e-12)
    below, above = (low - mean) / std, (high - mean) / std
    if below > 0:
        below, above = -above, -below
    # Phi(above) - Phi(below), both on the side where the logarithms are accurate
    first, second = float(log_ndtr(above)), float(log_ndtr(below))
    return first + float(np.log1p(-np.exp(min(second - first, -1e-15))))
