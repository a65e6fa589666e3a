r"""Windowed output error: Gauss-Newton on the compiled kernel, starts of windows projected out.

With whitened residuals r_w of window w, its first state n_w, the parameters and the unknowns of the
thrust x (prior precision Q) and what the windows of a run share, s (offsets and wander of sensors,
of prior precision P), all counted in prior standard deviations, the fit minimises

.. math::

    \sum_w \rho(r_w(x, s, n_w)) + \sum_w |n_w|^2 + x^T Q x + s^T P s, \qquad x \ge l

rho is Huber's, l the bounds (damping is not negative; `bounds`). The first states enter their own
window alone: each window's are eliminated from the normal equations (variable projection; Golub and
Pereyra 2003), so the system that is solved has the size of (x, s), and only what a window shares
enters its part of it.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.bounds import bounded_step
from pipeline.identify.window_derivatives import (
    Derivatives,
    FitPoint,
    FitProblem,
    derivatives,
    residuals,
)
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray

#: Beyond this many standard deviations a residual counts linearly (Huber).
HUBER = 3.0
#: A channel whose residuals scatter by more than this times their noise is far from its fit.
FAR = 1.5
MOST_STEPS, _MOST_HALVINGS = 30, 8
#: Stop when a step is to lower the cost, a sum of squares of unit variance, by less than this.
SMALLEST_GAIN = 0.02
#: A step that keeps less than this share of what it promised is the last one.
STALLED = 0.01
#: Longest step of a parameter, in prior standard deviations.
LONGEST_STEP = 3.0


@dataclass(frozen=True)
class Piece:
    """What one window adds to the normal equations: at `index`, after its start is eliminated.

    Its start moves with a step d of (x, s) by first - second @ d[index].
    """

    index: IntArray
    information: FloatArray
    score: FloatArray
    first: FloatArray
    second: FloatArray


@dataclass(frozen=True)
class Reduced:
    """Normal equations of (x, s) after the starts are taken out.

    `information` (p + s, p + s) without the priors, `prior` (p + s, p + s) their precision,
    `gradient` (p + s,); `pieces` are what each window adds. p counts the thrust's unknowns too.
    """

    information: FloatArray
    prior: FloatArray
    gradient: FloatArray
    pieces: tuple[Piece, ...]

    def start_moves(self, step: FloatArray) -> FloatArray:
        """How the starts (windows, 12) move with a step of (x, s)."""
        return np.array([one.first - one.second @ step[one.index] for one in self.pieces])

    def of_parameters(self, count: int) -> FloatArray:
        """Information on x (count, count), what the windows share eliminated, without its prior."""
        shared = self.information[count:, count:] + self.prior[count:, count:]
        cross = self.information[:count, count:]
        own = self.information[:count, :count] - cross @ np.linalg.solve(shared, cross.T)
        return np.asarray(own, float)


@dataclass(frozen=True)
class FitSolution:
    """The fit: the point, the normal equations there, and how it went."""

    problem: FitProblem
    point: FitPoint
    reduced: Reduced
    residual: FloatArray
    """Whitened residuals (rows,)."""
    cost: float
    iterations: int
    converged: bool
    beyond: FloatArray
    """(p,) how far beyond the bounds the unbounded optimum of the last step lies; zero inside."""
    last_step: FloatArray
    """(p,) the last step before it was shortened, in prior standard deviations."""
    out_of_steps: bool = False
    """Whether the steps were used up before the fit had settled."""

    @property
    def vector(self) -> FloatArray:
        """Parameter vector at the solution."""
        return self.problem.vector(self.point.steps)

    @property
    def packed(self) -> PackedVehicle:
        """The vehicle with the thrust curves at the solution."""
        return self.problem.packed(self.point.steps)


def softness_of(residual: FloatArray) -> float:
    """Factor on the noise of a channel while it is still far off, from its residuals (rows,).

    Their present scatter (median absolute residual over 0.6745) where that exceeds `FAR`, 1
    otherwise. Far from the solution the model's error is no sensor noise: taken for it, it would
    outweigh the priors by orders of magnitude and drive the parameters to where nothing makes
    sense. As the fit closes in, the factors fall to 1 and with them the cost to its own form.
    """
    scatter = float(np.median(np.abs(residual))) / 0.6745 if residual.size else 1.0
    return scatter if scatter > FAR else 1.0


def huber_weights(residual: FloatArray, soft: FloatArray) -> FloatArray:
    """Weights (rows,) of Huber's cost, by factors on the noise."""
    return np.asarray(HUBER / np.maximum(np.abs(residual) / soft, HUBER) / soft**2)


def reduce_windows(
    problem: FitProblem, found: Derivatives, point: FitPoint, weights: FloatArray
) -> Reduced:
    """Eliminate every window's start from the normal equations."""
    count = found.parameters.shape[1]
    size = count + problem.shared.size
    columns = (found.starts, found.parameters, problem.shared.columns, found.residual)
    design = np.column_stack(columns) * np.sqrt(weights)[:, None]
    information, gradient = np.zeros((size, size)), np.zeros(size)
    pieces = []
    for number, (begin, end) in enumerate(pairwise(problem.stack.bounds)):
        own = design[begin:end]
        # einsum, not matmul: BLAS would start threads of its own for these small products
        gram = np.einsum("ki,kj->ij", own, own)
        index = np.concatenate([np.arange(count), count + problem.shared.index[number]])
        alone = gram[:12, :12] + np.eye(12)
        beside = gram[:12, 12:].copy()
        beside[:, -1] -= point.starts[number]
        solved = np.linalg.solve(alone, beside)
        left = gram[12:, 12:] - gram[12:, :12] @ solved
        piece = Piece(index, left[:-1, :-1], left[:-1, -1], solved[:, -1], solved[:, :-1])
        information[np.ix_(index, index)] += piece.information
        gradient[index] += piece.score
        pieces.append(piece)
    prior = np.zeros((size, size))
    prior[:count, :count] = problem.precision
    prior[count:, count:] = problem.shared.precision
    return Reduced(information, prior, gradient, tuple(pieces))


def total_cost(
    problem: FitProblem, residual: FloatArray, soft: FloatArray, point: FitPoint
) -> float:
    """Huber's cost with the priors; infinite where a simulation failed."""
    if not np.isfinite(residual).all():
        return float("inf")
    size = np.abs(residual) / soft
    robust = np.where(size <= HUBER, size**2, HUBER * (2 * size - HUBER))
    priors = point.steps @ problem.precision @ point.steps + np.sum(point.starts**2)
    return float(np.sum(robust) + priors + problem.shared.cost(point.shared))


def solve(
    problem: FitProblem,
    begin: FitPoint | None = None,
    *,
    smallest_gain: float = SMALLEST_GAIN,
    most_steps: int = MOST_STEPS,
) -> FitSolution:
    """Minimise the cost by Gauss-Newton with step halving.

    From `begin`, or the nominal vehicle and the measured first states; until a step promises less
    than `smallest_gain` off the cost, or so many were made.

    Raises
    ------
    CannotComputeError
        If the vehicle cannot be simulated over the windows from where it starts.
    """
    point = problem.origin() if begin is None else begin
    if not np.isfinite(residuals(problem, point)).all():
        raise CannotComputeError(
            f"the model of {problem.stack.packed.name} cannot be simulated from what was measured "
            "at the start of the windows; check units and signs of the channels"
        )
    iteration, gain, out_of_steps = 0, np.inf, False
    # what is held stays at what the file says
    point = replace(point, steps=np.where(problem.free(problem.size), point.steps, 0.0))
    while iteration < most_steps:
        iteration += 1
        found = derivatives(problem, point)
        channels = problem.stack.owner
        each = [softness_of(found.residual[channels == k]) for k in range(len(problem.stack.rows))]
        soft = np.array(each)[channels]
        reduced = reduce_windows(problem, found, point, huber_weights(found.residual, soft))
        step, gain, beyond, whole = _shared_step(problem, reduced, point)
        before = total_cost(problem, found.residual, soft, point)
        point, cost = _search(problem, point, before, soft, step, reduced.start_moves(step))
        # a step that promises little was the last one; so was one that led nowhere
        if cost >= before or (before - cost < smallest_gain and gain < 2 * smallest_gain):
            break
        # the model is so wrong that its derivatives lead nowhere; more such steps are for nothing
        if before - cost < STALLED * gain:
            break
    else:
        out_of_steps = True
    # settled is what promises less than one unit of a cost of so many
    converged = gain < max(1.0, 0.0 if out_of_steps else smallest_gain)
    went = (found.residual, cost, iteration, converged, beyond, whole, out_of_steps)
    return FitSolution(problem, point, reduced, *went)


def _shared_step(
    problem: FitProblem, reduced: Reduced, point: FitPoint
) -> tuple[FloatArray, float, FloatArray, FloatArray]:
    """Gauss-Newton step of (x, s) with their priors and bounds, and what it promises off the cost.

    Third comes how far the step of x without bounds lies from it, last that of x before it was
    shortened.
    """
    now = np.concatenate([point.steps, point.shared])
    pull = reduced.gradient - reduced.prior @ now
    matrix = reduced.information + reduced.prior
    count = point.steps.size
    lowest = np.full(now.size, -np.inf)
    lowest[:count] = problem.lowest - point.steps
    step, beyond, free = np.zeros(now.size), np.zeros(now.size), problem.free(now.size)
    step[free], beyond[free] = bounded_step(matrix[np.ix_(free, free)], pull[free], lowest[free])
    whole = step[:count].copy()
    longest = float(np.abs(whole).max(initial=0.0))
    # far from the solution the linear model is not to be believed for long ways
    step *= min(1.0, LONGEST_STEP / max(longest, 1e-12))
    # einsum, not matmul: BLAS would start threads of its own
    gain = float(2.0 * step @ pull - np.einsum("i,ij,j->", step, matrix, step))
    return step, gain, beyond[:count], whole


def _search(  # noqa: PLR0917 - the state of one iteration
    problem: FitProblem,
    point: FitPoint,
    cost: float,
    soft: FloatArray,
    step: FloatArray,
    moves: FloatArray,
) -> tuple[FitPoint, float]:
    """Halve the step until the cost falls; the old point where it never does."""
    count = problem.size
    share = 1.0
    for _ in range(_MOST_HALVINGS):
        trial = FitPoint(
            point.steps + share * step[:count],
            point.shared + share * step[count:],
            point.starts + share * moves,
        )
        trial_cost = total_cost(problem, residuals(problem, trial), soft, trial)
        if trial_cost < cost:
            return trial, trial_cost
        share /= 2
    return point, cost
