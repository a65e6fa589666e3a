"""Parameters that cannot be negative: steps that stay inside, and intervals that end at the bound.

With a bound a normal posterior is the same density, zero outside and normalised anew (Gelfand,
Smith and Lee 1992, J. Am. Stat. Assoc. 87:523). Its marginals are found by expectation propagation
(Minka 2001): every bound is stood for by a normal factor on its coordinate, chosen so that, beside
all others, it has the mean and variance of the density cut off there.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erfcx, ndtr, ndtri

from pipeline.records.fit_values import NORMAL_95
from pipeline.types import FloatArray

#: A bound further off than this many standard deviations cuts nothing off.
FAR_INSIDE = 4.0
_SWEEPS, _SETTLED = 100, 1e-8
_INSIDE = 0.95


@dataclass(frozen=True)
class Cut:
    """Standard deviations (p,) and ends (p,) of 95 % intervals of a normal density cut off."""

    std: FloatArray
    low: FloatArray
    high: FloatArray


def bounded_step(
    matrix: FloatArray, pull: FloatArray, lowest: FloatArray
) -> tuple[FloatArray, FloatArray]:
    r"""Minimise d' H d / 2 - pull' d with d >= lowest, -inf where there is no bound.

    A least-squares problem with bounds in the root of H (Stark and Parker 1995). Returns the step
    (n,), and how far the step without bounds lies from it (n,), zero where no bound holds.
    """
    free = np.asarray(np.linalg.solve(matrix, pull), float)
    if (free >= lowest).all():
        return free, np.zeros(free.size)
    from scipy.optimize import lsq_linear

    root = np.linalg.cholesky(matrix).T
    found = lsq_linear(root, root @ free, bounds=(lowest, np.inf), method="bvls", tol=1e-12)
    step = np.maximum(found.x, lowest)
    return np.asarray(step, float), np.asarray(free - step, float)


def cut_std(mean: float, std: float, lowest: float) -> float:
    """Return the standard deviation of one normal density that is zero below its bound.

    `mean` and `std` are of the density without the bound; `lowest` is -inf where there is none.
    """
    if mean - FAR_INSIDE * std >= lowest:
        return std
    return float(np.sqrt(_cut_moments(mean, std, lowest)[1]))


def _cut_moments(mean: float, std: float, lowest: float) -> tuple[float, float]:
    """Mean and variance of a normal density that is zero below its bound."""
    cut = (lowest - mean) / std
    # density over what is left of it; `scipy.stats` takes a second to import
    hazard = float(np.sqrt(2.0 / np.pi) / erfcx(cut / np.sqrt(2.0)))
    return mean + std * hazard, std**2 * (1.0 + hazard * (cut - hazard))


def cut_off(mean: FloatArray, covariance: FloatArray, lowest: FloatArray) -> Cut | None:
    """Take standard deviations and intervals from a normal density that is zero below its bounds.

    Intervals of bounded coordinates are the shortest that hold 95 %: at the bound they begin there.
    Those of the others leave 2.5 % on either side. `mean` (p,) and `covariance` (p, p) are without
    bounds, `lowest` (p,) is -inf where there is none; None where no bound is near enough to matter.
    """
    bounded = np.flatnonzero(mean - FAR_INSIDE * np.sqrt(np.diag(covariance)) < lowest)
    if not bounded.size:
        return None
    centre, wide = mean.copy(), covariance.copy()
    # natural parameters of each bound's factor, and mean and deviation beside the others
    factors = dict.fromkeys(bounded.tolist(), (0.0, 0.0))
    beside: dict[int, tuple[float, float]] = {}
    for _ in range(_SWEEPS):
        before = centre.copy()
        for i, (precision, pull) in factors.items():
            left = max(1.0 / wide[i, i] - precision, 1e-12)
            own = float((centre[i] / wide[i, i] - pull) / left), float(left**-0.5)
            inside, variance = _cut_moments(*own, float(lowest[i]))
            factors[i] = 1.0 / variance - left, inside / variance - own[0] * left
            beside[i] = own
            more, push = factors[i][0] - precision, factors[i][1] - pull
            along = wide[:, i] / (1.0 + more * wide[i, i])
            centre = centre + along * (push - more * centre[i])
            wide = wide - more * np.outer(along, wide[i])
        if np.abs(centre - before).max() < _SETTLED * np.sqrt(np.diag(covariance)).max():
            break
    std = np.sqrt(np.diag(wide))
    low, high = centre - NORMAL_95 * std, centre + NORMAL_95 * std
    for i, (middle, deviation) in beside.items():
        held = _INSIDE * ndtr((middle - lowest[i]) / deviation)
        half = -deviation * ndtri((1.0 - held) / 2.0)
        if middle - half > lowest[i]:
            low[i], high[i] = middle - half, middle + half
        else:
            low[i] = lowest[i]
            high[i] = middle - deviation * ndtri(held * (1.0 / _INSIDE - 1.0))
    return Cut(std, low, high)
