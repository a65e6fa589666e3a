r"""Parameters that cannot be negative: steps that stay inside, and intervals that end at the bound.

A hull takes energy out of its motion, so linear and quadratic damping of an axis are not negative.
A normal posterior N(m, C) knows nothing of that. With the bound it is the same density, zero
outside and normalised anew (Gelfand, Smith and Lee 1992, Bayesian analysis of constrained parameter
and truncated data problems, J. Am. Stat. Assoc. 87:523), and is computed as there: by Gibbs
sampling, each bounded coordinate drawn from its normal conditional cut off at the bound, the others
from their normal conditional given those. Where every bound is more than `FAR_INSIDE` standard
deviations off nothing of this is needed, and nothing is done.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import erfcx

from pipeline.types import BoolArray, FloatArray

#: A bound further off than this many standard deviations cuts nothing off.
FAR_INSIDE = 4.0
_CHAINS, _SWEEPS, _FORGOTTEN = 512, 240, 40
_INSIDE, _AS_SHORT = 0.95, 1.01


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

    All coordinates without a bound are eliminated; what is left, a distance in the metric of the
    bounded ones' own information, is a least-squares problem with bounds (Stark and Parker 1995).
    Returns the step (n,), and how far the step without bounds lies from it (n,), zero where no
    bound holds.
    """
    free = np.asarray(np.linalg.solve(matrix, pull), float)
    if (free >= lowest).all():
        return free, np.zeros(free.size)
    from scipy.optimize import lsq_linear

    bounded = np.flatnonzero(np.isfinite(lowest))
    columns = np.linalg.solve(matrix, np.eye(len(matrix))[:, bounded])
    covariance = columns[bounded]
    root = np.linalg.cholesky(np.linalg.inv((covariance + covariance.T) / 2)).T
    found = lsq_linear(
        root, root @ free[bounded], bounds=(lowest[bounded], np.inf), method="bvls", tol=1e-12
    ).x
    moved = found - free[bounded]
    step = free + columns @ np.linalg.solve(covariance, moved)
    step[bounded] = np.maximum(found, lowest[bounded])
    return np.asarray(step, float), np.asarray(free - step, float)


def cut_std(mean: float, std: float, lowest: float) -> float:
    """Return the standard deviation of one normal density that is zero below its bound.

    `mean` and `std` are of the density without the bound; `lowest` is -inf where there is none.
    """
    if mean - FAR_INSIDE * std >= lowest:
        return std
    cut = (lowest - mean) / std
    # density over what is left of it; `scipy.stats` takes a second to import
    hazard = np.sqrt(2.0 / np.pi) / erfcx(cut / np.sqrt(2.0))
    return std * float(np.sqrt(1.0 + hazard * (cut - hazard)))


def cut_off(mean: FloatArray, covariance: FloatArray, lowest: FloatArray) -> Cut | None:
    """Take standard deviations and intervals from a normal density that is zero below its bounds.

    Intervals of bounded coordinates are the shortest that hold 95 %: at the bound they begin there.
    Those of the others leave 2.5 % on either side. `mean` (p,) and `covariance` (p, p) are without
    bounds, `lowest` (p,) is -inf where there is none; None where no bound is near enough to matter.
    """
    deviation = np.sqrt(np.diag(covariance))
    # bounds that are far off cut nothing, and would only make the draws follow each other slowly
    bounded = mean - FAR_INSIDE * deviation < lowest
    if not bounded.any():
        return None
    draws = _drawn(mean, covariance, lowest, bounded)
    std, low, high = (np.empty(mean.size) for _ in range(3))
    for i in range(mean.size):
        own = np.sort(draws[:, i])
        std[i] = own.std()
        if bounded[i]:
            count = int(np.ceil(_INSIDE * own.size))
            length = own[count - 1 :] - own[: own.size - count + 1]
            at = int(np.argmin(length))
            # one that begins at the bound is as short, but for the chance of the draws
            at = 0 if own[count - 1] - lowest[i] <= _AS_SHORT * length[at] else at
            low[i], high[i] = own[at] if at else lowest[i], own[at + count - 1]
        else:
            low[i], high[i] = np.quantile(own, [(1 - _INSIDE) / 2, (1 + _INSIDE) / 2])
    return Cut(std, low, high)


def _drawn(
    mean: FloatArray, covariance: FloatArray, lowest: FloatArray, bounded: BoolArray
) -> FloatArray:
    """Draw from the density, (draws, p); the same draws every time."""
    from scipy.special import ndtr, ndtri

    generator = np.random.default_rng(0)
    centre, own = mean[bounded], covariance[np.ix_(bounded, bounded)]
    edge = lowest[bounded]
    precision = np.linalg.inv(own)
    spread = 1.0 / np.sqrt(np.diag(precision))
    x = np.tile(np.maximum(centre, edge), (_CHAINS, 1))
    kept = []
    for sweep in range(_SWEEPS):
        for j in range(centre.size):
            pull = (x - centre) @ precision[j] - (x[:, j] - centre[j]) * precision[j, j]
            middle = centre[j] - pull * spread[j] ** 2
            # upper tail: accurate where the bound is far above the middle
            beyond = ndtr((middle - edge[j]) / spread[j])
            uniform = 1.0 - generator.random(_CHAINS)
            drawn = middle - spread[j] * ndtri(np.maximum(uniform * beyond, 1e-300))
            x[:, j] = np.maximum(drawn, edge[j])
        if sweep >= _FORGOTTEN:
            kept.append(x.copy())
    inside = np.concatenate(kept)
    found = np.empty((len(inside), mean.size))
    found[:, bounded] = inside
    rest = ~bounded
    if rest.any():
        follow = np.linalg.solve(own, covariance[np.ix_(bounded, rest)])
        left = covariance[np.ix_(rest, rest)] - covariance[np.ix_(rest, bounded)] @ follow
        noise = np.sqrt(np.maximum(np.diag(left), 0.0)) * generator.standard_normal(
            (len(inside), int(rest.sum()))
        )
        found[:, rest] = mean[rest] + (inside - centre) @ follow + noise
    return found
