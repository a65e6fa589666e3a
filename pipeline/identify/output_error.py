r"""Windowed output error: Gauss-Newton on the compiled kernel, starts of windows projected out.

With whitened residuals r_w of window w, its first state n_w, the parameters x and the offsets of
each run b (all counted in prior standard deviations), the fit minimises

.. math::

    \sum_w \rho(r_w(x, b, n_w)) + \sum_w |n_w|^2 + |x|^2 + |b|^2

rho is Huber's. The first states enter their own window alone: each window's are eliminated from the
normal equations (variable projection; Golub and Pereyra 2003), so the system that is solved has the
size of (x, b) whatever the number of windows.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.window_derivatives import (
    Derivatives,
    Point,
    Problem,
    derivatives,
    residuals,
)
from pipeline.identify.window_outputs import Stack
from pipeline.types import BoolArray, FloatArray

#: Beyond this many standard deviations a residual counts linearly (Huber).
HUBER = 3.0
_MOST_ITERATIONS, _MOST_HALVINGS = 20, 8
#: Stop when a step is to lower the cost, a sum of squares of unit variance, by less than this.
SMALLEST_GAIN = 0.02


@dataclass(frozen=True)
class Reduced:
    """Normal equations of (x, b) after the starts are taken out, without the priors of (x, b).

    `information` (p + b, p + b), `gradient` (p + b,); `window_information` and `scores` are what
    each window adds to them; `thrust` (p + b,) is the cross product with the column of a common
    factor on all thrusts.
    """

    information: FloatArray
    window_information: FloatArray
    gradient: FloatArray
    scores: FloatArray
    thrust: FloatArray


@dataclass(frozen=True)
class Solution:
    """The fit: the point, the normal equations there, and how it went."""

    problem: Problem
    point: Point
    reduced: Reduced
    residual: FloatArray
    cost: float
    iterations: int
    converged: bool

    @property
    def vector(self) -> FloatArray:
        """Parameter vector at the solution."""
        return self.problem.vector(self.point.steps)


def huber_limits(stack: Stack, residual: FloatArray) -> FloatArray:
    """Size from which each residual counts linearly, (rows,).

    `HUBER` standard deviations; while a channel as a whole is still far off, so many of its
    present scatter (median absolute residual over 0.6745): far from the solution every residual
    is large, and none of them an outlier.
    """
    limits = np.empty(residual.size)
    for number in range(len(stack.rows)):
        own = stack.owner == number
        size = np.abs(residual[own])
        limits[own] = HUBER * max(float(np.median(size)) / 0.6745, 1.0)
    return limits


def reduce_windows(
    problem: Problem, found: Derivatives, point: Point, weights: FloatArray
) -> tuple[Reduced, list[tuple[FloatArray, FloatArray]]]:
    """Project every window's start out of the normal equations.

    Returns
    -------
    Reduced
        The equations.
    list of (ndarray, ndarray)
        Per window how its start moves with a step s of (x, b): first - second @ s.
    """
    columns = (
        np.concatenate([found.parameters, found.biases, found.thrust[:, None]], axis=1)
        * np.sqrt(weights)[:, None]
    )
    starts = found.starts * np.sqrt(weights)[:, None]
    residual = found.residual * np.sqrt(weights)
    size = columns.shape[1]
    products, scores, back = [], [], []
    bounds = problem.stack.bounds
    for number, (begin, end) in enumerate(pairwise(bounds)):
        own = np.column_stack([starts[begin:end], columns[begin:end], residual[begin:end]])
        # einsum, not matmul: BLAS would start threads of its own for these small products
        gram = np.einsum("ki,kj->ij", own, own)
        begun, shared, right = slice(0, 12), slice(12, 12 + size), 12 + size
        alone = gram[begun, begun] + np.eye(12)
        beside = np.column_stack([gram[begun, shared], gram[begun, right] - point.starts[number]])
        solved = np.linalg.solve(alone, beside)
        products.append(gram[shared, shared] - gram[shared, begun] @ solved[:, :-1])
        scores.append(gram[shared, right] - gram[shared, begun] @ solved[:, -1])
        back.append((solved[:, -1], solved[:, :-2]))
    rows = np.array(scores)[:, :-1]
    blocks = np.array(products)
    total = blocks.sum(axis=0)
    return (
        Reduced(total[:-1, :-1], blocks[:, :-1, :-1], rows.sum(axis=0), rows, total[:-1, -1]),
        back,
    )


def total_cost(residual: FloatArray, limits: FloatArray, point: Point) -> float:
    """Huber's cost with the priors; infinite where a simulation failed."""
    if not np.isfinite(residual).all():
        return float("inf")
    size = np.abs(residual)
    robust = np.where(size <= limits, size**2, limits * (2 * size - limits))
    priors = point.steps @ point.steps + np.sum(point.biases**2) + np.sum(point.starts**2)
    return float(np.sum(robust) + priors)


def solve(
    problem: Problem, begin: Point | None = None, *, smallest_gain: float = SMALLEST_GAIN
) -> Solution:
    """Minimise the cost by Gauss-Newton with step halving.

    Parameters
    ----------
    problem : Problem
        Windows and parameters.
    begin : Point, optional
        Where to start; the nominal vehicle and the measured first states otherwise.
    smallest_gain : float
        Stop when a step promises less than this off the cost.

    Raises
    ------
    CannotComputeError
        If the vehicle cannot be simulated over the windows from where it starts.
    """
    point = problem.origin() if begin is None else begin
    free_bias = np.tile(problem.bias_scales > 0, problem.run_count)
    active = np.concatenate([np.ones(len(problem.parameters), bool), free_bias])
    if not np.isfinite(residuals(problem, point)).all():
        raise CannotComputeError(
            f"the model of {problem.stack.packed.name} cannot be simulated from what was measured "
            "at the start of the windows; check units and signs of the channels"
        )
    iteration, gain = 0, np.inf
    while iteration < _MOST_ITERATIONS:
        iteration += 1
        found = derivatives(problem, point)
        limits = huber_limits(problem.stack, found.residual)
        weights = limits / np.maximum(np.abs(found.residual), limits)
        reduced, back = reduce_windows(problem, found, point, weights)
        step, gain = _shared_step(reduced, point, active)
        before = total_cost(found.residual, limits, point)
        point, cost = _search(problem, point, before, limits, step, back)
        # a step that promises little was the last one; so was one that led nowhere
        if cost >= before or (before - cost < smallest_gain and gain < 2 * smallest_gain):
            break
    converged = iteration < _MOST_ITERATIONS and gain < max(1.0, smallest_gain)
    return Solution(problem, point, reduced, found.residual, cost, iteration, converged)


def _shared_step(reduced: Reduced, point: Point, active: BoolArray) -> tuple[FloatArray, float]:
    """Gauss-Newton step of (x, b) with their priors, and what it promises off the cost."""
    pull = reduced.gradient - np.concatenate([point.steps, point.biases.ravel()])
    step = np.zeros(active.size)
    matrix = reduced.information + np.eye(active.size)
    step[active] = np.linalg.solve(matrix[np.ix_(active, active)], pull[active])
    return step, float(step @ pull)


def _search(  # noqa: PLR0917 - the state of one iteration
    problem: Problem,
    point: Point,
    cost: float,
    limits: FloatArray,
    step: FloatArray,
    back: Sequence[tuple[FloatArray, FloatArray]],
) -> tuple[Point, float]:
    """Halve the step until the cost falls; the old point where it never does."""
    count = len(problem.parameters)
    move = np.array([first - second @ step for first, second in back])
    share = 1.0
    for _ in range(_MOST_HALVINGS):
        trial = Point(
            point.steps + share * step[:count],
            point.biases + share * step[count:].reshape(point.biases.shape),
            point.starts + share * move,
        )
        trial_cost = total_cost(residuals(problem, trial), limits, trial)
        if trial_cost < cost:
            return trial, trial_cost
        share /= 2
    return point, cost
