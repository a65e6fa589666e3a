r"""Does a fitted parameter stand? Told by the runs, come to rest, and alike in halves of them.

The runs (the windows of one run) are parted in two, and each half makes its own estimate, one
Gauss-Newton step from the joint one. With G = (I + P)^{-1} of each half, I its information and P
the prior, the two differ by chance with the covariance

.. math:: G_1 + G_2 - G_1 P G_2 - G_2 P G_1,

widened as the intervals are. Runs of another vehicle state (ballast, supply, a pilot's gain) or a
model that lacks a term make them contradict each other. What does not stand is held at what the
vehicle file says while the rest is fitted again, for the corrected file.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.output_error import FitSolution
from pipeline.identify.parameter_intervals import Posterior
from pipeline.identify.thrust_uncertainty import ThrustUncertainty
from pipeline.identify.vehicle_parameters import FreeParameter
from pipeline.identify.window_outputs import WindowStack
from pipeline.records.fit_values import NORMAL_95
from pipeline.records.identification import IdentifiedParameter, ThrustFound
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

#: Share of its standard deviation that the last step may still move what is at rest.
AT_REST = 0.3
#: Halves of the runs further apart than this many standard deviations contradict each other.
APART = 3.0


@dataclass(frozen=True)
class Halves:
    """Estimates (p + q,) of two halves, in prior standard deviations, and how far they are apart.

    `apart` is counted in standard deviations of the difference.
    """

    first: FloatArray
    second: FloatArray
    apart: FloatArray


def at_rest(solution: FitSolution, posterior: Posterior) -> BoolArray:
    """Tell which unknowns (p + q,) the fit has come to rest in."""
    if solution.converged:
        return np.ones(solution.problem.size, bool)
    wide = posterior.inflation * np.sqrt(np.diag(posterior.covariance))
    return np.asarray(np.abs(solution.last_step) <= AT_REST * wide)


def halves_of(solution: FitSolution, posterior: Posterior) -> Halves:
    """Estimate everything from each half of the runs."""
    problem, reduced = solution.problem, solution.reduced
    size, count, prior = len(reduced.prior), problem.size, reduced.prior
    now = np.concatenate([solution.point.steps, solution.point.shared])
    in_first = _first_half(problem.stack)
    gains, moved = [], []
    for wanted in (True, False):
        information, score = np.zeros((size, size)), np.zeros(size)
        for piece, first in zip(reduced.pieces, in_first, strict=True):
            if first == wanted:
                information[np.ix_(piece.index, piece.index)] += piece.information
                score[piece.index] += piece.score
        gain = np.linalg.inv(information + prior)
        gains.append((gain + gain.T) / 2)
        moved.append(gains[-1] @ (score - prior @ now))
    one, other = gains
    crossed = np.einsum("ij,jk,ki->i", one, prior, other)
    variance = np.maximum(np.diag(one) + np.diag(other) - 2.0 * crossed, 1e-300)
    apart = np.abs(moved[0] - moved[1]) / np.sqrt(variance)
    steps, lowest = solution.point.steps, problem.lowest
    first, second = (np.maximum(steps + one[:count], lowest) for one in moved)
    return Halves(first, second, apart[:count] / posterior.inflation)


def _first_half(stack: WindowStack) -> list[bool]:
    """Which windows are in the first half: whole runs, each to the half that has fewer windows."""
    runs = [window.run for window in stack.windows]
    different = list(dict.fromkeys(runs))
    if len(different) == 1:
        return [2 * number < len(runs) for number in range(len(runs))]
    halves: tuple[set[int], set[int]] = (set(), set())
    sizes = [0, 0]
    for run in sorted(different, key=lambda one: -runs.count(one)):
        smaller = int(sizes[1] < sizes[0])
        halves[smaller].add(run)
        sizes[smaller] += runs.count(run)
    return [run in halves[0] for run in runs]


def with_standing(
    parameters: Sequence[FreeParameter],
    found: Sequence[IdentifiedParameter],
    rest: BoolArray,
    halves: Halves,
) -> tuple[IdentifiedParameter, ...]:
    """Add to what was found of each parameter whether it stands, and if not, why.

    `rest` (p + q,) tells which of the unknowns are at rest.
    """
    judged = []
    for i, (parameter, one) in enumerate(zip(parameters, found, strict=True)):
        first, second = (
            parameter.nominal + parameter.prior_std * float(half[i])
            for half in (halves.first, halves.second)
        )
        stands, reason = one.identified, one.reason
        if stands and not rest[i]:
            stands, reason = False, "the fit did not come to rest in it"
        elif stands and halves.apart[i] > APART:
            stands = False
            reason = (
                f"halves of the runs contradict each other: {first:.3g} and {second:.3g} "
                f"{parameter.unit}, {halves.apart[i]:.1f} standard deviations apart"
            )
        update = {"stands": stands, "reason": reason, "halves": (first, second)}
        judged.append(one.model_copy(update=update))
    return tuple(judged)


def thrust_found(
    doubt: ThrustUncertainty, steps: FloatArray, posterior: Posterior, halves: Halves
) -> tuple[ThrustFound, ...]:
    """List what the fit made of the thrust: factors [1], and errors of the curves at knots [N].

    `steps` (p + q,) are all unknowns at the solution; those of the thrust come last.
    """
    begin = steps.size - doubt.size
    deviations = np.sqrt(np.diag(posterior.covariance))[begin:] * posterior.inflation[begin:]
    found = []
    for i, (name, unit, scale) in enumerate(
        zip(doubt.names, doubt.units, doubt.scales.tolist(), strict=True)
    ):
        moved = float(steps[begin + i] + posterior.middle[begin + i])
        stated = 1.0 if i < doubt.gains else 0.0
        value = stated + scale * moved
        first, second = (
            stated + scale * float(one[begin + i]) for one in (halves.first, halves.second)
        )
        half = NORMAL_95 * scale * float(deviations[i])
        found.append(
            ThrustFound(
                name=name,
                unit=unit,
                value=value,
                ci95=(value - half, value + half),
                prior_std=scale,
                widths=abs(moved),
                halves=(first, second),
            )
        )
    return tuple(found)


def deduction_found(
    packed: PackedVehicle, solution: FitSolution, posterior: Posterior
) -> ThrustFound | None:
    """Thrust deduction, mean over the thrusters, from their factors; None where those are known."""
    doubt = solution.problem.thrust
    if not doubt.gains:
        return None
    begin = solution.point.steps.size - doubt.size
    own = slice(begin, begin + doubt.gains)
    scale, mean = packed.context.thrust_share * doubt.share, 1.0 / doubt.gains
    wide = posterior.covariance * np.outer(posterior.inflation, posterior.inflation)
    moved = float((solution.point.steps + posterior.middle)[own].sum()) * mean
    half = NORMAL_95 * scale * mean * float(np.sqrt(max(wide[own, own].sum(), 0.0)))
    prior = mean * float(np.sqrt(doubt.correlation[: doubt.gains, : doubt.gains].sum()))
    value = 1.0 - packed.context.thrust_share - scale * moved
    return ThrustFound(
        name="thrust_deduction",
        unit="1",
        value=value,
        ci95=(value - half, value + half),
        prior_std=scale * prior,
        widths=abs(moved) / prior,
    )
