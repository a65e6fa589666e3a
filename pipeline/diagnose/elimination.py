r"""Integrate out what is not asked for: starts, outside forces, sensor offsets and wander.

With unknowns of Gaussian priors the readings are y ~ N(G x, S), S = 1 + sum of the columns' outer
products. All that is needed of it is

.. math:: M = G^T S^{-1} G, \quad b = G^T S^{-1} y, \quad c = y^T S^{-1} y, \quad \log|S|

which comes from the windows' normal equations by two Schur complements: first each window's own
unknowns, then those that a run shares.
"""

from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from pipeline.diagnose.linear_model import LinearModel
from pipeline.types import FloatArray, IntArray


@dataclass(frozen=True)
class Grams:
    """Normal equations of each window: own unknowns (a), then shared, departures and readings (r).

    `own` (w, a, a), `cross` (w, a, r), `rest` (w, r, r); `index` (w, k) says which shared unknown
    the first k of the rest are, `precision` (s, s) is the prior of the shared.
    """

    own: FloatArray
    cross: FloatArray
    rest: FloatArray
    index: IntArray
    precision: FloatArray


@dataclass(frozen=True)
class ForcePrior:
    """Precision (6 pieces, 6 pieces) of a window's outside forces, and log |covariance|."""

    precision: FloatArray
    log_determinant: float


@dataclass(frozen=True)
class Marginal:
    """What is left for the departures: information (g, g), score (g,), misfit and log |S|."""

    information: FloatArray
    score: FloatArray
    misfit: float
    log_determinant: float


@dataclass(frozen=True)
class Solution:
    """Best values of everything at given departures."""

    starts: FloatArray
    forces: FloatArray
    shared: FloatArray


def grams(model: LinearModel) -> Grams:
    """Make the normal equations of the windows."""
    setting = model.setting
    count, extra = setting.shared.size, model.extra.shape[1]
    bounds = setting.bench.stack.bounds
    index = np.concatenate(
        [
            setting.shared.index,
            np.broadcast_to(count + np.arange(extra), (len(bounds) - 1, extra)),
        ],
        axis=1,
    )
    precision = np.eye(count + extra)
    precision[:count, :count] = setting.shared.precision
    local = model.local.shape[1]
    columns = (model.local, model.shared, model.extra, model.departures, model.readings[:, None])

    def of_window(first: int, last: int) -> FloatArray:
        every = np.concatenate([one[first:last] for one in columns], axis=1)
        return np.asarray(every.T @ every)

    found = np.stack(
        setting.bench.workers.each([partial(of_window, *one) for one in pairwise(bounds)])
    )
    return Grams(
        found[:, :local, :local],
        found[:, :local, local:],
        found[:, local:, local:],
        index,
        precision,
    )


def with_readings(normal: Grams, model: LinearModel) -> Grams:
    """Renew the normal equations for other readings: only their row and column change."""
    bounds = model.setting.bench.stack.bounds
    columns = (model.local, model.shared, model.extra, model.departures)
    cross, rest = normal.cross.copy(), normal.rest.copy()
    local = model.local.shape[1]
    for number, (a, b) in enumerate(pairwise(bounds)):
        own = model.readings[a:b]
        product = np.concatenate([one[a:b].T @ own for one in columns])
        cross[number, :, -1] = product[:local]
        rest[number, :-1, -1] = rest[number, -1, :-1] = product[local:]
        rest[number, -1, -1] = own @ own
    return replace(normal, cross=cross, rest=rest)


def marginal(found: Grams, forces: ForcePrior) -> Marginal:
    """Integrate out own and shared unknowns.

    Parameters
    ----------
    found : Grams
        Of the windows.
    forces : ForcePrior
        What is believed of the outside forces.
    """
    left, _, log_determinant = _schur(found, forces)
    wide, shared = _assembled(found, left)
    solved = np.linalg.solve(shared, wide[: len(shared), len(shared) :])
    rest = wide[len(shared) :, len(shared) :] - wide[len(shared) :, : len(shared)] @ solved
    log_determinant += float(np.linalg.slogdet(shared)[1] - np.linalg.slogdet(found.precision)[1])
    information = rest[:-1, :-1]
    return Marginal(
        (information + information.T) / 2, rest[:-1, -1], float(rest[-1, -1]), log_determinant
    )


def _schur(found: Grams, forces: ForcePrior) -> tuple[FloatArray, FloatArray, float]:
    """Take every window's own unknowns out: rest (w, r, r), own equations (w, a, a), log |own|."""
    own = _own_equations(found, forces)
    try:
        root = np.linalg.cholesky(own)
    except np.linalg.LinAlgError:
        # readings of a motion that nearly ran away drown the priors
        left = found.rest - np.swapaxes(found.cross, 1, 2) @ np.linalg.solve(own, found.cross)
        log_own = np.linalg.slogdet(own)[1].sum()
    else:
        half = solve_triangular(root, found.cross, lower=True, check_finite=False)
        left = found.rest - np.swapaxes(half, 1, 2) @ half
        log_own = 2.0 * np.log(np.diagonal(root, axis1=1, axis2=2)).sum()
    return left, own, float(log_own + len(own) * forces.log_determinant)


def _own_equations(found: Grams, forces: ForcePrior) -> FloatArray:
    """Windows' own normal equations (w, a, a) with the priors of starts and forces."""
    own = found.own.copy()
    at = np.arange(12)
    own[:, at, at] += 1.0
    own[:, 12:, 12:] += forces.precision
    return own


def _assembled(found: Grams, left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Put the windows together: (s + g + 1, same), and its shared block with the prior."""
    shared, own = len(found.precision), found.index.shape[1]
    size = shared + left.shape[1] - own
    wide = np.zeros((size, size))
    tail = np.arange(shared, size)
    for number, index in enumerate(found.index):
        places = np.concatenate([index, tail])
        wide[np.ix_(places, places)] += left[number]
    wide[:shared, :shared] += found.precision
    return wide, wide[:shared, :shared]


def solve(found: Grams, forces: ForcePrior, departures: FloatArray) -> Solution:
    """Most probable own and shared unknowns at given departures (g,)."""
    left, equations, _ = _schur(found, forces)
    wide, block = _assembled(found, left)
    count = len(block)
    right = wide[:count, -1] - wide[:count, count:-1] @ departures
    shared = np.linalg.solve(block, right)
    own = found.index.shape[1]
    rest = np.concatenate(
        [shared[found.index], np.broadcast_to(departures, (len(left), departures.size))], axis=1
    )
    unknown = found.cross[:, :, : own + departures.size] @ rest[:, :, None]
    local = np.linalg.solve(equations, found.cross[:, :, -1:] - unknown)[:, :, 0]
    return Solution(local[:, :12], local[:, 12:], np.asarray(shared))


def force_posterior(
    found: Grams, forces: ForcePrior, departures: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation of the outside forces (windows, 6 pieces), shared ones known."""
    best = solve(found, forces, departures)
    spread = np.linalg.inv(_own_equations(found, forces))
    spread = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    return best.forces, np.asarray(spread[:, 12:])
