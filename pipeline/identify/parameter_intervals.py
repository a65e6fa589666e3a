r"""Intervals of the whole-vehicle fit, and which parameters the runs identified.

Fisher information H (starts of the windows projected out, priors added) gives the covariance
H^-1 where residuals are white. Where they go together the sandwich

.. math:: H^{-1} (B + P) H^{-1}, \qquad
    B = \sum_w s_w s_w^T + \tfrac12 \sum_w (s_w s_{w+1}^T + s_{w+1} s_w^T)

of the windows' scores s_w (P the prior; Bartlett's weight; White 1982; Newey and West 1987) takes
the place of the Fisher variance where it exceeds that by more than chance would (5 %).

The unknowns of the thrust are part of H and integrated out. With a thrust that is larger by a
factor g all forces of the hull are: the data leave the k parameters that they tell of a volume that
grows as g^k, so the posterior of the factors leans towards larger thrust, a shift of all that goes
with them of C_{.g} k u (Laplace's method with the volume as a factor; Tierney and Kadane 1986).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv, stdtrit

from pipeline.identify.bounds import cut_off, cut_std
from pipeline.identify.output_error import FitSolution
from pipeline.identify.vehicle_parameters import FreeParameter
from pipeline.identify.window_derivatives import FitProblem
from pipeline.records.fit_values import NORMAL_95
from pipeline.records.identification import IdentifiedParameter
from pipeline.types import BoolArray, FloatArray

#: Above this ratio of posterior to prior standard deviation the runs say too little.
NOT_IDENTIFIED = 0.7
#: Correlations from here on are told.
CLOSE_PAIR = 0.9
#: Share of the unknowns whose windows scatter by more than chance from which all are so widened.
MANY = 0.25
#: A standard deviation beyond this many of the prior's has been widened; less is rounding.
_WIDENED = 1.001


@dataclass(frozen=True)
class Posterior:
    """What is known of the unknowns x, parameters (p,) first and then the thrust's (q,).

    `covariance` (p + q, p + q) in prior standard deviations, `inflation` (p + q,) factors on the
    standard deviations, `middle` (p + q,) how far the middle lies from the likeliest point; `std`,
    `low`, `high` (p,) standard deviations and ends of the 95 % intervals of the parameters with
    all of them and with their bounds, `known_std` (p,) standard deviations if the thrust were known
    to be what the fit made of it.
    """

    covariance: FloatArray
    inflation: FloatArray
    middle: FloatArray
    std: FloatArray
    low: FloatArray
    high: FloatArray
    known_std: FloatArray


def posterior_of(solution: FitSolution) -> Posterior:
    """Posterior of the fitted parameters."""
    problem, reduced = solution.problem, solution.reduced
    count = problem.size
    inverse = np.linalg.inv(reduced.information + reduced.prior)
    inverse = (inverse + inverse.T) / 2
    shares, influences = [], []
    for piece in reduced.pieces:
        own = inverse[:count, piece.index]
        shares.append(np.einsum("ij,jk,ik->i", own, piece.information, own))
        influences.append(own @ piece.score)
    run_of = np.array([window.run for window in problem.stack.windows])
    share = np.array(shares)
    scatter = _scatter(np.array(influences), run_of[1:] == run_of[:-1])
    variance = np.diag(inverse)[:count]
    wider = variance - share.sum(axis=0) + scatter
    degrees = _degrees(share)
    # the 95 % quantile of scattered over expected variance
    by_chance = 2.0 * gammaincinv(0.5 * degrees, 0.95) / degrees
    believed = scatter > share.sum(axis=0) * by_chance
    if believed.mean() > MANY:
        # not by chance in so many: residuals go together, also where one alone does not show it
        believed = np.ones_like(believed)
    # what so few windows show is itself uncertain: Student's quantile in place of the normal one
    few = stdtrit(degrees, 0.975) / NORMAL_95
    ratio = np.where(believed, np.maximum(few**2 * wider / variance, 1.0), 1.0)
    return _with_intervals(solution, inverse[:count, :count], np.sqrt(ratio))


def _with_intervals(
    solution: FitSolution, covariance: FloatArray, inflation: FloatArray
) -> Posterior:
    """Intervals of the parameters from the covariance of all unknowns."""
    own = len(solution.problem.parameters)
    aside = covariance[:own, own:]
    known = covariance[:own, :own]
    if aside.shape[1]:
        known = known - aside @ np.linalg.solve(covariance[own:, own:], aside.T)
    middle = _middle(solution.problem, covariance, np.diag(known))
    lowest = solution.problem.lowest[:own]
    steps = np.maximum(solution.point.steps[:own] + middle[:own], lowest)
    wide = (covariance * np.outer(inflation, inflation))[:own, :own]
    std = np.sqrt(np.diag(wide))
    low, high = steps - NORMAL_95 * std, steps + NORMAL_95 * std
    free = solution.point.steps + solution.beyond + middle
    cut = cut_off(free[:own], wide, lowest)
    if cut is not None:
        # an estimate at the bound is the likeliest value: its interval holds it
        std, low, high = cut.std, np.minimum(cut.low, steps), np.maximum(cut.high, steps)
    known_std = inflation[:own] * np.sqrt(np.maximum(np.diag(known), 0.0))
    return Posterior(covariance, inflation, middle, std, low, high, np.minimum(known_std, std))


def _middle(problem: FitProblem, covariance: FloatArray, known: FloatArray) -> FloatArray:
    """How far the middle of the posterior (p + q,) lies from its likeliest point.

    `known` (p,) is the variance that is left of each parameter if the thrust is known: one less it
    is what the data tell of it. All but the lag of the thrusters and the share of their inflow are
    in proportion to the thrust.
    """
    thrust = problem.thrust
    if not thrust.gains:
        return np.zeros(len(covariance))
    begin = len(problem.parameters)
    forces = np.array([parameter.unit not in {"s", "1"} for parameter in problem.parameters])
    told = float(np.sum((1.0 - known)[forces]))
    lean = told * thrust.share / thrust.gains
    moved = covariance[:, begin : begin + thrust.gains].sum(axis=1) * lean
    return np.asarray(moved)


def _degrees(shares: FloatArray) -> FloatArray:
    """Degrees of freedom (p,) of the scatter between windows, from each one's share of it (w, p).

    A sum of squares over m alike windows; m = (sum s)^2 / sum s^2, less a third for the products
    with the neighbour.
    """
    alike = shares.sum(axis=0) ** 2 / np.maximum(np.sum(shares**2, axis=0), 1e-300)
    return np.asarray(np.maximum(alike / 1.5, 1.0))


def _scatter(influences: FloatArray, consecutive: BoolArray) -> FloatArray:
    """Variance (p,) of the sum over windows (w, p), neighbours included (Bartlett, one lag)."""
    centred = influences - influences.mean(axis=0)
    count = len(centred)
    beside = np.sum(centred[:-1][consecutive] * centred[1:][consecutive], axis=0)
    alone = np.sum(centred**2, axis=0)
    return np.asarray(count / max(count - 1, 1) * np.maximum(alone + beside, 0.0))


def prior_share(parameter: FreeParameter) -> float:
    """Return the prior's standard deviation inside the bound over that without the bound."""
    if parameter.lowest is None:
        return 1.0
    return cut_std(0.0, 1.0, (parameter.lowest - parameter.nominal) / parameter.prior_std)


def identified_parameters(
    parameters: Sequence[FreeParameter], steps: FloatArray, posterior: Posterior
) -> tuple[IdentifiedParameter, ...]:
    """Values with intervals, and a verdict with its reason for each."""
    own = posterior.covariance[: len(parameters), : len(parameters)]
    correlation = own / np.sqrt(np.outer(np.diag(own), np.diag(own)))
    found = []
    for i, parameter in enumerate(parameters):
        scale = parameter.prior_std
        value = parameter.nominal + scale * float(steps[i] + posterior.middle[i])
        std = scale * float(posterior.std[i])
        # both are cut off at the bound: where the file says zero, the prior alone has 60 % left
        left = prior_share(parameter)
        ratio = float(posterior.std[i]) / left
        uncut = float(posterior.inflation[i] * np.sqrt(posterior.covariance[i, i]))
        known = NORMAL_95 * scale * float(posterior.known_std[i])
        low, high = (
            parameter.nominal + scale * float(end[i]) for end in (posterior.low, posterior.high)
        )
        if parameter.lowest is not None:
            # what rounding leaves below the bound
            value, low = max(value, parameter.lowest), max(low, parameter.lowest)
        others = np.abs(correlation[i])
        others[i] = 0.0
        partner = int(np.argmax(others))
        found.append(
            IdentifiedParameter(
                name=parameter.name,
                unit=parameter.unit,
                meaning=parameter.meaning,
                value=value,
                std=std,
                ci95=(low, high),
                ci95_thrust_known=(max(value - known, low), min(value + known, high)),
                prior_value=parameter.nominal,
                prior_std=scale,
                posterior_over_prior=ratio,
                inflation=float(posterior.inflation[i]),
                identified=ratio <= NOT_IDENTIFIED,
                reason=_reason(
                    ratio,
                    uncut,
                    float(posterior.known_std[i]) / left,
                    parameters[partner].name,
                    float(correlation[i, partner]) if others[partner] > 0 else 0.0,
                ),
            )
        )
    return tuple(found)


def _reason(ratio: float, uncut: float, known: float, partner: str, correlation: float) -> str:
    """Say why a parameter is identified or not.

    `ratio` and `known` (with the thrust known) are posterior over prior, bounds counted in both;
    `uncut` is that without bounds: beyond 1 the scatter between windows has widened it.
    """
    close = abs(correlation) >= CLOSE_PAIR
    together = f"; moves together with {partner} (correlation {correlation:+.2f})" if close else ""
    if ratio > NOT_IDENTIFIED and uncut > _WIDENED:
        return (
            f"the windows of these runs contradict each other by more than the prior leaves open"
            f"{together}"
        )
    if ratio > NOT_IDENTIFIED >= known:
        return (
            f"only as far as the thrust of the bench is trusted: {100 * ratio:.0f} % of the "
            f"prior's standard deviation is left, {100 * known:.0f} % if the thrust were known"
            f"{together}"
        )
    if ratio > NOT_IDENTIFIED:
        return (
            f"the runs leave {100 * ratio:.0f} % of the prior's standard deviation: they hardly "
            f"excite it{together}"
        )
    return f"{100 * ratio:.1f} % of the prior's standard deviation is left{together}"
