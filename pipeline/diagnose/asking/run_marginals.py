r"""Integrate out what is not asked for: starts, outside forces, sensor offsets and wander.

With unknowns of Gaussian priors the readings are y ~ N(G x, S), S = 1 + sum of the columns' outer
products. All that is needed of it is

.. math:: M = G^T S^{-1} G, \quad b = G^T S^{-1} y, \quad c = y^T S^{-1} y, \quad \log|S|

which comes from the windows' normal equations by two Schur complements, each window's own unknowns
and then those that a run shares. What is left of a run are four numbers and arrays (`Marginal`):
all that is asked later, of whichever runs together, is asked of them.

What a model lacks acts from one manoeuvre to the next like other values of its parameters. So the
departures of a run may differ from those of the vehicle, x_r = x + d_r with d_r ~ N(0, D) and D
diagonal (a random-effects model; Laird and Ware 1982, Biometrics 38, 963-974).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_triangular

from pipeline.diagnose.linear.elimination import ForcePrior, Marginal, Solution
from pipeline.diagnose.linear.linear_model import LinearModel, Point, Setting, realisable, vector_of
from pipeline.types import BoolArray, FloatArray, IntArray

#: Share of their trace that is added to equations that rounding has made indefinite.
_DROWNED = 1e-10


@dataclass(frozen=True)
class RunGrams:
    """Normal equations of each window: own unknowns (a), then shared, departures and readings (r).

    `own` (w, a, a), `cross` (w, a, r), `rest` (w, r, r); `index` (w, k) says which shared unknown
    the first k of the rest are, `precision` (s, s) is the prior of the shared. `run` (w,) is that
    of each window, `owner` (s,) that of each shared unknown.
    """

    own: FloatArray
    cross: FloatArray
    rest: FloatArray
    index: IntArray
    precision: FloatArray
    run: IntArray
    owner: IntArray


def departure_count(setting: Setting) -> int:
    """Count the departures: coordinates, forces of the rest, errors of curves."""
    return len(setting.coordinates) + setting.rest.size + int(setting.profiles.shape[2])


def of_rest(setting: Setting) -> slice:
    """Departures that are forces of the rest."""
    first = len(setting.coordinates)
    return slice(first, first + setting.rest.size)


def of_curves(setting: Setting) -> slice:
    """Departures that are errors of the thrusters' curves."""
    return slice(len(setting.coordinates) + setting.rest.size, departure_count(setting))


def point_at(setting: Setting, best: Solution, departures: FloatArray) -> Point:
    """Return the point of a motion and of departures (d,), led by nothing."""
    return Point(
        best.starts,
        best.forces,
        np.concatenate([best.shared, departures[of_curves(setting)]]),
        departures[: len(setting.coordinates)],
        departures[of_rest(setting)],
    )


def possible(setting: Setting, departures: FloatArray) -> FloatArray:
    """Departures (d,) that a vehicle can have; see `realisable`."""
    count = len(setting.coordinates)
    found = departures.copy()
    found[:count] = realisable(setting.coordinates, departures[:count])
    return found


def vector_with(setting: Setting, departures: FloatArray) -> FloatArray:
    """Parameter vector at departures (d,)."""
    return vector_of(setting, departures[: len(setting.coordinates)])


def departures_of(model: LinearModel) -> FloatArray:
    """Columns (rows, d) of all departures: coordinates, forces of the rest, errors of curves."""
    first = model.setting.extra.shape[1]
    return np.concatenate([model.departures, model.rest, model.extra[:, first:]], axis=1)


def grams(model: LinearModel) -> RunGrams:
    """Make the normal equations of the windows."""
    setting = model.setting
    count, extra = setting.shared.size, setting.extra.shape[1]
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
    owner = np.zeros(count + extra, int)
    owner[setting.shared.index] = run[:, None]
    # what is offset of a voltage is so for one run
    owner[count:] = np.arange(extra)
    local = model.local.shape[1]
    columns = (
        model.local,
        model.shared,
        model.extra[:, :extra],
        departures_of(model),
        model.readings[:, None],
    )

    def of_window(first: int, last: int) -> FloatArray:
        every = np.concatenate([one[first:last] for one in columns], axis=1)
        return np.asarray(every.T @ every)

    found = np.stack(
        setting.bench.workers.each([partial(of_window, *one) for one in pairwise(bounds)])
    )
    return RunGrams(
        found[:, :local, :local],
        found[:, :local, local:],
        found[:, local:, local:],
        index,
        precision,
        run,
        owner,
    )


def with_readings(normal: RunGrams, model: LinearModel) -> RunGrams:
    """Renew the normal equations for other readings: only their row and column change."""
    bounds = model.setting.bench.stack.bounds
    extra = model.setting.extra.shape[1]
    columns = (model.local, model.shared, model.extra[:, :extra], departures_of(model))
    cross, rest = normal.cross.copy(), normal.rest.copy()
    local = model.local.shape[1]
    for number, (a, b) in enumerate(pairwise(bounds)):
        own = model.readings[a:b]
        product = np.concatenate([one[a:b].T @ own for one in columns])
        cross[number, :, -1] = product[:local]
        rest[number, :-1, -1] = rest[number, -1, :-1] = product[local:]
        rest[number, -1, -1] = own @ own
    return replace(normal, cross=cross, rest=rest)


@dataclass(frozen=True)
class Factored:
    """Windows' own equations under one force prior: roots (w, a, a), root^-1 cross (w, a, r)."""

    root: FloatArray
    half: FloatArray
    log_own: FloatArray


def factored(found: RunGrams, forces: ForcePrior) -> Factored:
    """Factor the windows' own equations (Cholesky), each with the prior of its unknowns."""
    own = found.own.copy()
    at = np.arange(12)
    own[:, at, at] += 1.0
    own[:, 12:, 12:] += forces.precision
    try:
        root = np.linalg.cholesky(own)
    except np.linalg.LinAlgError:
        # readings of a motion that nearly ran away drown the priors
        size = np.trace(own, axis1=1, axis2=2)[:, None, None] * np.eye(own.shape[1])
        root = np.linalg.cholesky(own + _DROWNED * size)
    half = solve_triangular(root, found.cross, lower=True, check_finite=False)
    log_own = 2.0 * np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
    return Factored(
        np.asarray(root, float),
        np.asarray(half, float),
        np.asarray(log_own + forces.log_determinant),
    )


def with_other_readings(one: Factored, found: RunGrams) -> Factored:
    """Renew what depends on the readings: `found` differs from what was factored in them alone."""
    half = one.half.copy()
    half[:, :, -1:] = solve_triangular(
        one.root, found.cross[:, :, -1:], lower=True, check_finite=False
    )
    return replace(one, half=half)


def marginals(
    found: RunGrams, own: Factored, kept: BoolArray | None = None
) -> tuple[Marginal, ...]:
    """Integrate out own and shared unknowns, run by run in the order of their numbers.

    Parameters
    ----------
    found : RunGrams
        Of the windows.
    own : Factored
        Their own equations.
    kept : ndarray of bool, shape (windows,), optional
        Windows that speak; all otherwise. A run of which none does says nothing.
    """
    left = found.rest - np.swapaxes(own.half, 1, 2) @ own.half
    if kept is not None:
        left = np.where(kept[:, None, None], left, 0.0)
    log_own = own.log_own if kept is None else np.where(kept, own.log_own, 0.0)
    told = []
    for number in np.unique(found.run):
        shared = np.flatnonzero(found.owner == number)
        rest, more = _without(_of_run(found, left, number, shared), shared.size)
        more -= float(np.linalg.slogdet(found.precision[np.ix_(shared, shared)])[1])
        information = rest[:-1, :-1]
        told.append(
            Marginal(
                (information + information.T) / 2,
                rest[:-1, -1],
                float(rest[-1, -1]),
                more + float(log_own[found.run == number].sum()),
            )
        )
    return tuple(told)


def _of_run(found: RunGrams, left: FloatArray, number: int, own: IntArray) -> FloatArray:
    """Put one run together, with the prior of its own unknowns: own, departures, readings."""
    windows = np.flatnonzero(found.run == number)
    count, shared = own.size, found.index.shape[1]
    place = np.full(len(found.precision), -1)
    place[own] = np.arange(count)
    size = count + left.shape[1] - shared
    wide = np.zeros((size, size))
    wide[:count, :count] = found.precision[np.ix_(own, own)]
    wide[count:, count:] = left[windows, shared:, shared:].sum(axis=0)
    for window in windows:
        at = place[found.index[window]]
        # what belongs to another run acts in none of the rows
        mine = np.flatnonzero(at >= 0)
        at = at[mine]
        wide[np.ix_(at, at)] += left[window][np.ix_(mine, mine)]
        wide[at, count:] += left[window, mine, shared:]
    wide[count:, :count] = wide[:count, count:].T
    return wide


def _without(wide: FloatArray, count: int) -> tuple[FloatArray, float]:
    """Take the first unknowns out of normal equations; with the log determinant of their block."""
    solved = np.linalg.solve(wide[:count, :count], wide[:count, count:])
    rest = wide[count:, count:] - wide[count:, :count] @ solved
    return rest, float(np.linalg.slogdet(wide[:count, :count])[1])


def without_scatter(one: Marginal, scatter: FloatArray) -> Marginal:
    """Take out what the departures of a run differ by from the vehicle's: N(0, scatter^2).

    A random-effects model: they have the columns of the departures (Laird and Ware 1982).
    """
    free = np.flatnonzero(scatter)
    if not free.size:
        return one
    side = one.information[:, free] * scatter[free]
    inner = np.eye(free.size) + side[free] * scatter[free, None]
    own = one.score[free] * scatter[free]
    solved = np.linalg.solve(inner, np.column_stack([side.T, own]))
    information = one.information - side @ solved[:, :-1]
    return Marginal(
        (information + information.T) / 2,
        one.score - side @ solved[:, -1],
        one.misfit - float(own @ solved[:, -1]),
        one.log_determinant + float(np.linalg.slogdet(inner)[1]),
    )


def together(several: Sequence[Marginal]) -> Marginal:
    """Add up what several runs say of the same departures."""
    return Marginal(
        np.sum([one.information for one in several], axis=0),
        np.sum([one.score for one in several], axis=0),
        sum(one.misfit for one in several),
        sum(one.log_determinant for one in several),
    )


def solve(found: RunGrams, own: Factored, departures: FloatArray) -> Solution:
    """Most probable own and shared unknowns at given departures, (d,) or of each run (runs, d)."""
    left = found.rest - np.swapaxes(own.half, 1, 2) @ own.half
    numbers = np.unique(found.run)
    each = np.broadcast_to(departures, (numbers.size, departures.shape[-1]))
    shared = np.zeros(len(found.precision))
    for number, at in zip(numbers, each, strict=True):
        mine = np.flatnonzero(found.owner == number)
        wide = _of_run(found, left, number, mine)
        right = wide[: mine.size, -1] - wide[: mine.size, mine.size : -1] @ at
        shared[mine] = np.linalg.solve(wide[: mine.size, : mine.size], right)
    of_window = each[np.searchsorted(numbers, found.run)]
    rest = np.concatenate([shared[found.index], of_window], axis=1)
    side = own.half[:, :, -1:] - own.half[:, :, :-1] @ rest[:, :, None]
    local = solve_triangular(own.root, side, lower=True, trans="T", check_finite=False)[:, :, 0]
    return Solution(local[:, :12], local[:, 12:], shared)


def force_energy(
    found: RunGrams, own: Factored, departures: FloatArray, time: FloatArray
) -> FloatArray:
    """Mean square of the outside forces by window and axis (windows, 6), what is not known counted.

    `time` (pieces, pieces) is their correlation, which is taken out of the mean.
    """
    best = solve(found, own, departures)
    inverse_root = solve_triangular(
        own.root, np.eye(own.root.shape[1])[None], lower=True, check_finite=False
    )
    spread = (np.swapaxes(inverse_root, 1, 2) @ inverse_root)[:, 12:, 12:]
    count, pieces = len(spread), len(time)
    inverse = np.linalg.inv(time)
    mean = best.forces.reshape(count, pieces, 6)
    spread = spread.reshape(count, pieces, 6, pieces, 6)
    energy = np.einsum("wpa,pq,wqa->wa", mean, inverse, mean)
    energy += np.einsum("wpaqa,pq->wa", spread, inverse)
    return np.asarray(energy / pieces)
