r"""Integrate out what is not asked for: starts, outside forces, sensor offsets and wander.

With unknowns of Gaussian priors the readings are y ~ N(G x, S), S = 1 + sum of the columns' outer
products. All that is needed of it is

.. math:: M = G^T S^{-1} G, \quad b = G^T S^{-1} y, \quad c = y^T S^{-1} y, \quad \log|S|

which comes from the windows' normal equations by three Schur complements: each window's own
unknowns, then those that a run shares, then those that all runs share.

What a model lacks acts from one manoeuvre to the next like other values of its parameters. So the
departures of a run may differ from those of the vehicle, x_r = x + d_r with d_r ~ N(0, D) and D
diagonal (a random-effects model; Laird and Ware 1982, Biometrics 38, 963-974). Being sums of
squares over the same columns, the d_r leave with the unknowns of their run.
"""

from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.types import FloatArray, IntArray


@dataclass(frozen=True)
class Grams:
    """Normal equations of each window: own unknowns (a), then shared, departures and readings (r).

    `own` (w, a, a), `cross` (w, a, r), `rest` (w, r, r); `index` (w, k) says which shared unknown
    the first k of the rest are, `precision` (s, s) is the prior of the shared. `run` (w,) is that
    of each window, `owner` (s,) that of each shared unknown, -1 where all runs share it; `scatter`
    (g,) is by how much the departures of a run differ from the vehicle's.
    """

    own: FloatArray
    cross: FloatArray
    rest: FloatArray
    index: IntArray
    precision: FloatArray
    run: IntArray
    owner: IntArray
    scatter: FloatArray


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
    run = np.array([window.run for window in setting.bench.stack.windows])
    owner = np.full(count + extra, -1)
    owner[setting.shared.index] = run[:, None]
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
        run,
        owner,
        setting.scatter,
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
    common = np.flatnonzero(found.owner < 0)
    size = common.size + found.scatter.size + 1
    wide = np.zeros((size, size))
    wide[: common.size, : common.size] = found.precision[np.ix_(common, common)]
    log_determinant -= float(np.linalg.slogdet(wide[: common.size, : common.size])[1])
    for number in np.unique(found.run):
        own = np.flatnonzero(found.owner == number)
        of_run, more = _without(_of_run(found, left, number, own, common), own.size)
        log_determinant += more - float(np.linalg.slogdet(found.precision[np.ix_(own, own)])[1])
        of_run, more = _without_scatter(of_run, found.scatter)
        log_determinant += more
        wide += of_run
    rest, more = _without(wide, common.size)
    information = rest[:-1, :-1]
    return Marginal(
        (information + information.T) / 2,
        rest[:-1, -1],
        float(rest[-1, -1]),
        log_determinant + more,
    )


def _of_run(
    found: Grams, left: FloatArray, number: int, own: IntArray, common: IntArray
) -> FloatArray:
    """Put one run together, with the prior of its own unknowns: own, common, x, readings."""
    ordered = np.concatenate([own, common])
    place = np.full(len(found.precision), -1)
    place[ordered] = np.arange(ordered.size)
    tail = np.arange(ordered.size, ordered.size + left.shape[1] - found.index.shape[1])
    wide = np.zeros((ordered.size + tail.size,) * 2)
    wide[: own.size, : own.size] = found.precision[np.ix_(own, own)]
    for window in np.flatnonzero(found.run == number):
        places = np.concatenate([place[found.index[window]], tail])
        wide[np.ix_(places, places)] += left[window]
    return wide


def _without(wide: FloatArray, count: int) -> tuple[FloatArray, float]:
    """Take the first unknowns out of normal equations; with the log determinant of their block."""
    solved = np.linalg.solve(wide[:count, :count], wide[:count, count:])
    rest = wide[count:, count:] - wide[count:, :count] @ solved
    return rest, float(np.linalg.slogdet(wide[:count, :count])[1])


def _without_scatter(of_run: FloatArray, scatter: FloatArray) -> tuple[FloatArray, float]:
    """Take out what the departures of a run differ by: they have the columns of the departures."""
    free = np.flatnonzero(scatter)
    if not free.size:
        return of_run, 0.0
    at = len(of_run) - 1 - scatter.size + free
    side = of_run[:, at] * scatter[free]
    inner = np.eye(free.size) + side[at] * scatter[free, None]
    return of_run - side @ np.linalg.solve(inner, side.T), float(np.linalg.slogdet(inner)[1])


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
