"""Normal equations of one run of several that are fitted together.

Offsets and starts are the run's own and are taken out; they follow a step of the parameters that
all runs share.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.identify.output_error import HUBER, reduce_windows, softness_of
from pipeline.identify.window_derivatives import Derivatives, FitPoint, FitProblem, residuals
from pipeline.types import FloatArray


@dataclass(frozen=True)
class RunEquations:
    """Information (n, n) and score (n,) of a run, and of each window (w, n, n), (w, n)."""

    information: FloatArray
    score: FloatArray
    windows: FloatArray
    scores: FloatArray
    follow: FloatArray
    aside: FloatArray
    back: list[tuple[FloatArray, FloatArray]]


@dataclass
class FittedRun:
    """A run, where its fit stands, and its derivatives there or nearby."""

    problem: FitProblem
    point: FitPoint
    known: Derivatives | None = None

    def equations(self, steps: FloatArray, wider: Mapping[str, float]) -> RunEquations:
        """Return the normal equations of x at the run's parameters, offsets and starts taken out.

        `wider` are factors on the noise of quantities.
        """
        assert self.known is not None  # noqa: S101 - `differentiate` came first
        self.point = replace(self.point, steps=steps)
        found = replace(self.known, residual=residuals(self.problem, self.point))
        stack = self.problem.stack
        soft = softness_of(stack, found.residual)
        for number, rows in enumerate(stack.rows):
            own = stack.owner == number
            soft[own] = np.maximum(soft[own], wider.get(rows.channel.quantity, 1.0))
        weights = HUBER / np.maximum(np.abs(found.residual) / soft, HUBER) / soft**2
        reduced, back = reduce_windows(self.problem, found, self.point, weights)
        count = self.problem.size
        whole = reduced.information.copy()
        whole[count:, count:] += reduced.prior[count:, count:]
        score = reduced.gradient.copy()
        score[count:] -= reduced.prior[count:, count:] @ self.point.shared
        taken = np.linalg.solve(whole[count:, count:], whole[count:, :count])
        offset = np.linalg.solve(whole[count:, count:], score[count:])
        # x moves, and the offsets follow: (x, s) = follow x + aside
        follow = np.vstack([np.eye(count), -taken])
        aside = np.concatenate([np.zeros(count), offset])
        ways = [(piece, follow[piece.index], aside[piece.index]) for piece in reduced.pieces]
        return RunEquations(
            whole[:count, :count] - whole[:count, count:] @ taken,
            score[:count] - whole[:count, count:] @ offset,
            np.array([way.T @ one.information @ way for one, way, _ in ways]),
            np.array([(one.score - one.information @ rest) @ way for one, way, rest in ways]),
            follow,
            aside,
            back,
        )

    def move(self, equations: RunEquations, step: FloatArray, share: float) -> None:
        """Move offsets and starts with a step of the run's parameters."""
        count = self.problem.size
        whole = equations.follow @ step + equations.aside
        x, columns = np.arange(count), self.problem.shared.index + count
        moves = [
            first - second @ whole[np.concatenate([x, index])]
            for index, (first, second) in zip(columns, equations.back, strict=True)
        ]
        self.point = FitPoint(
            self.point.steps,
            self.point.shared + share * whole[count:],
            self.point.starts + share * np.array(moves),
        )
