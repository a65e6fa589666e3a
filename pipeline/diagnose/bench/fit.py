r"""Fit of an effect to a mooring table, and how probable the table is under it (Laplace).

With residual r(theta), covariance C and a normal prior N(m, P), a simplex search (Nelder and
Mead 1965) finds the most probable theta, and with H = J^T C^{-1} J + P^{-1}

.. math:: \log p(y) = \log N(r; 0, C) + \log N(\theta; m, P) + \tfrac{k}{2} \log 2\pi
          - \tfrac12 \log |H| + \tfrac12 \sum_b g_b^2 / H_{bb}
          + \log\frac{\Phi_{post}}{\Phi_{prior}}

(MacKay 2003, chapters 27 and 28). The sum is over parameters held at a bound, where the gradient g
is not zero; Phi are the shares of posterior and prior inside the bounds. C grows with the effect
(its law is not exact).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from pipeline.diagnose.bench.effects import BenchPrior, predict, priors
from pipeline.diagnose.bench.model import ThrusterAtRest
from pipeline.diagnose.bench.noise import Stack, anything, departures, healthy, law_error
from pipeline.diagnose.bench.table import BenchTable
from pipeline.diagnose.normal import log_inside
from pipeline.types import FloatArray

_STEP = 1e-4
#: Where the search looks first, in prior standard deviations from the prior mean.
_STARTS = (-3.0, -2.0, -1.4, -0.9, -0.5, -0.2, 0.2, 0.5, 0.9, 1.4, 2.0, 3.0)
#: The same for the second parameter of an effect.
_SECOND = (0.0, 0.7)
_EVALUATIONS = 90


@dataclass(frozen=True)
class BenchFit:
    """A hypothesis after the fit.

    `values` and `std` by (effect, parameter); `misfit` is r^T C^-1 r, `readings` its expectation
    for the truth; `linearisations` counts the steps.
    """

    effects: tuple[str, ...]
    log_evidence: float
    values: dict[tuple[str, str], float]
    std: dict[tuple[str, str], float]
    misfit: float
    readings: int
    linearisations: int = 0


class BenchComparison:
    """A model, a table, and what does not change between hypotheses."""

    def __init__(self, model: ThrusterAtRest, table: BenchTable) -> None:
        self.model, self.table, self.stack = model, table, Stack.of(table)
        self.nominal = predict(model, {}, table.code, table.channels)
        self.departure = departures(table, self.nominal)
        self.healthy = healthy(model, table)

    def prediction(self, chosen: Sequence[BenchPrior], theta: FloatArray) -> dict[str, FloatArray]:
        """Predict readings by channel with parameters at theta."""
        return predict(self.model, values_of(chosen, theta), self.table.code, self.table.channels)

    def covariances(
        self, values: Mapping[tuple[str, str], float], after: dict[str, FloatArray]
    ) -> dict[str, FloatArray]:
        """Covariance of each channel under effects at `values` that lead to `after`."""
        more = law_error(
            self.model, self.table, values, self.nominal, after, departure=self.departure
        )
        return {name: self.healthy[name] + more[name] for name in self.stack.channels}

    def whitened(
        self, covariance: dict[str, FloatArray], vectors: FloatArray
    ) -> tuple[FloatArray, float]:
        """Return L^-1 vectors, (n, k), and log |C|, channel by channel."""
        parts, log_determinant = [], 0.0
        for name in self.stack.channels:
            rows = vectors[self.stack.slices[name]]
            lower = np.linalg.cholesky(covariance[name])
            parts.append(np.linalg.solve(lower, rows))
            log_determinant += 2.0 * float(np.sum(np.log(np.diag(lower))))
        return np.concatenate(parts), log_determinant


def values_of(chosen: Sequence[BenchPrior], theta: FloatArray) -> dict[tuple[str, str], float]:
    """Parameters by (effect, name)."""
    return {(p.effect, p.parameter): float(v) for p, v in zip(chosen, theta, strict=True)}


def fit_nothing(
    problem: BenchComparison, *, unknown: bool = False, beside: BenchFit | None = None
) -> BenchFit:
    """Evidence of the nominal thruster, or of a departure of any smooth shape.

    Parameters
    ----------
    problem : BenchComparison
        Model and table.
    unknown : bool
        Allow the departure of any shape.
    beside : BenchFit, optional
        An effect that is at work as well, as it was fitted.
    """
    covariance, after = problem.healthy, problem.nominal
    if beside is not None:
        after = predict(problem.model, beside.values, problem.table.code, problem.stack.channels)
    if unknown:
        more = anything(problem.model, problem.table)
        covariance = {name: covariance[name] + more[name] for name in covariance}
    residual = problem.stack.measured - problem.stack.join(after)
    white, log_determinant = problem.whitened(covariance, residual[:, None])
    misfit = float(np.sum(white**2))
    n = residual.size
    log_evidence = -0.5 * (misfit + log_determinant + n * np.log(2.0 * np.pi))
    return BenchFit(("unknown" if unknown else "none",), log_evidence, {}, {}, misfit, n)


def fit_effects(
    problem: BenchComparison,
    wanted: Sequence[str],
    start: dict[tuple[str, str], float] | None = None,
) -> BenchFit:
    """Fit one effect, or several together.

    Parameters
    ----------
    problem : BenchComparison
        Model and table.
    wanted : sequence of str
        Ids of the library, among `bench_effects.CANDIDATES`.
    start : dict, optional
        Parameters to begin from instead of a grid.
    """
    effects = tuple(wanted)
    chosen = [one for effect in effects for one in priors(effect, problem.model.code_max)]
    ends = [one.bounds for one in chosen]
    mean, std = np.array([one.mean for one in chosen]), np.array([one.std for one in chosen])
    low, high = np.array(ends).T
    best = _start(problem, chosen, start)

    def height(theta: FloatArray) -> float:
        return -_local(problem, chosen, np.clip(theta, low, high)).height

    simplex = np.clip(best + 0.15 * np.vstack([np.zeros(len(chosen)), np.diag(std)]), low, high)
    stuck = np.all(simplex[1:] == best, axis=1)
    simplex[1:][stuck] = np.clip(best - 0.15 * np.diag(std), low, high)[stuck]
    found = minimize(
        height,
        best,
        method="Nelder-Mead",
        bounds=ends,
        options={
            "initial_simplex": simplex,
            "maxfev": _EVALUATIONS * len(chosen),
            "xatol": 1e-4,
            "fatol": 1e-3,
        },
    )
    theta = np.clip(np.asarray(found.x), low, high)
    # half a step from a bound is on it
    theta = np.where(np.abs(theta - low) < 1e-3 * std, low, theta)
    theta = np.where(np.abs(theta - high) < 1e-3 * std, high, theta)
    at = _local(problem, chosen, theta, slopes=True)
    n = problem.stack.measured.size
    spread = np.sqrt(np.diag(np.linalg.inv(at.hessian)))
    log_evidence = at.height - 0.5 * n * np.log(2.0 * np.pi) - float(np.sum(np.log(std)))
    log_evidence -= 0.5 * float(np.linalg.slogdet(at.hessian)[1])
    # at a bound the posterior is the tail of a normal whose centre lies beyond it
    outward = ((theta <= low) & (at.gradient < 0.0)) | ((theta >= high) & (at.gradient > 0.0))
    centre = np.where(outward, theta + at.gradient / np.diag(at.hessian), theta)
    if outward.any():
        beyond = at.gradient[outward] ** 2 / np.diag(at.hessian)[outward]
        log_evidence += 0.5 * float(np.sum(beyond))
    for i in range(len(chosen)):
        log_evidence += log_inside(float(centre[i]), float(spread[i]), low[i], high[i])
        log_evidence -= log_inside(float(mean[i]), float(std[i]), low[i], high[i])
    return BenchFit(
        effects,
        log_evidence,
        values_of(chosen, theta),
        {(one.effect, one.parameter): float(spread[i]) for i, one in enumerate(chosen)},
        at.misfit,
        n,
        int(found.nfev),
    )


@dataclass(frozen=True)
class _Local:
    """Log posterior (without constants) at one theta, with its slope and curvature if wanted."""

    height: float
    misfit: float
    gradient: FloatArray
    hessian: FloatArray


def _local(
    problem: BenchComparison,
    chosen: Sequence[BenchPrior],
    at: FloatArray,
    *,
    slopes: bool = False,
) -> _Local:
    mean, std = np.array([one.mean for one in chosen]), np.array([one.std for one in chosen])
    after = problem.prediction(chosen, at)
    base = problem.stack.join(after)
    columns = [problem.stack.measured - base]
    if slopes:
        for i, one in enumerate(chosen):
            step = _STEP * one.std * (1.0 if at[i] + _STEP * one.std <= one.bounds[1] else -1.0)
            moved = at.copy()
            moved[i] += step
            columns.append((problem.stack.join(problem.prediction(chosen, moved)) - base) / step)
    covariance = problem.covariances(values_of(chosen, at), after)
    white, log_determinant = problem.whitened(covariance, np.stack(columns, axis=1))
    misfit = float(np.sum(white[:, 0] ** 2))
    off = (at - mean) / std
    height = -0.5 * (misfit + log_determinant + float(np.sum(off**2)))
    jacobian = white[:, 1:]
    hessian = jacobian.T @ jacobian + np.diag(1.0 / std**2) if slopes else np.zeros((0, 0))
    gradient = jacobian.T @ white[:, 0] - off / std if slopes else np.zeros(0)
    return _Local(height, misfit, gradient, hessian)


def _start(
    problem: BenchComparison,
    chosen: Sequence[BenchPrior],
    start: dict[tuple[str, str], float] | None,
) -> FloatArray:
    """Best of a coarse grid over the first two parameters, and of what single fits found."""
    low, high = np.array([one.bounds for one in chosen]).T
    mean, std = np.array([one.mean for one in chosen]), np.array([one.std for one in chosen])
    trials = [np.clip(mean, low, high)]
    if start:
        here = [start.get((one.effect, one.parameter), one.mean) for one in chosen]
        trials += [np.clip(np.array(here), low, high)]
    else:
        grid = np.meshgrid(_STARTS, *[_SECOND] * (len(chosen) - 1))
        for offsets in np.stack([axis.ravel() for axis in grid], axis=1):
            trials.append(np.clip(mean + offsets * std, low, high))
    unique = np.unique(np.array(trials), axis=0)
    heights = [_local(problem, chosen, trial).height for trial in unique]
    return np.asarray(unique[int(np.argmax(heights))])
