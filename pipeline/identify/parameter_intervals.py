r"""Intervals of the whole-vehicle fit, and which parameters the runs identified.

Fisher information H (starts of the windows projected out, priors added) gives the covariance
H^-1 where residuals are white. Where they go together the sandwich

.. math:: H^{-1} (B + P) H^{-1}, \qquad
    B = \sum_w s_w s_w^T + \tfrac12 \sum_w (s_w s_{w+1}^T + s_{w+1} s_w^T)

of the windows' scores s_w (P the prior; neighbouring windows of one run, Bartlett's weight) is
what the scatter between windows shows (White 1982; Newey and West 1987). It is estimated from a
few dozen windows, so it widens an interval and never narrows it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.output_error import Solution
from pipeline.identify.vehicle_parameters import FreeParameter
from pipeline.records.identification import Correlation, IdentifiedParameter
from pipeline.types import BoolArray, FloatArray

#: Above this ratio of posterior to prior standard deviation the runs say too little.
NOT_IDENTIFIED = 0.7
#: Correlations from here on are listed.
CLOSE_PAIR = 0.9
_NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Posterior:
    """Covariance of the parameters in prior standard deviations, and what widens it.

    `inflation` (p,) factors on the standard deviations; `by_thrust` (p,) shift of each parameter
    for one standard deviation of the thrust factor.
    """

    covariance: FloatArray
    inflation: FloatArray
    by_thrust: FloatArray

    @property
    def std(self) -> FloatArray:
        """Standard deviations (p,) with the inflation, in prior standard deviations."""
        return np.asarray(np.sqrt(np.diag(self.covariance)) * self.inflation)


def posterior_of(solution: Solution, thrust_uncertainty: float) -> Posterior:
    """Posterior of the fitted parameters.

    Parameters
    ----------
    solution : Solution
        The fit.
    thrust_uncertainty : float
        Standard deviation of a common factor on all thrusts. [-]
    """
    problem = solution.problem
    count = len(problem.parameters)
    active = np.concatenate(
        [np.ones(count, bool), np.tile(problem.bias_scales > 0, problem.run_count)]
    )
    size = int(active.sum())
    inverse = np.linalg.inv(solution.reduced.information[np.ix_(active, active)] + np.eye(size))
    inverse = (inverse + inverse.T) / 2
    scores = solution.reduced.scores[:, active]
    run_of = np.array([window.run for window in problem.stack.windows])
    meat = _meat(scores, run_of[1:] == run_of[:-1])
    sandwich = inverse @ (meat + np.eye(size)) @ inverse
    ratio = np.diag(sandwich)[:count] / np.diag(inverse)[:count]
    shift = inverse @ solution.reduced.thrust[active]
    return Posterior(
        inverse[:count, :count],
        np.sqrt(np.maximum(ratio, 1.0)),
        thrust_uncertainty * shift[:count],
    )


def _meat(scores: FloatArray, consecutive: BoolArray) -> FloatArray:
    """Covariance of the summed scores, with the windows next to each other (Bartlett, one lag)."""
    centred = scores - scores.mean(axis=0)
    count = len(centred)
    beside = centred[:-1][consecutive].T @ centred[1:][consecutive]
    correction = count / max(count - 1, 1)
    return np.asarray(correction * (centred.T @ centred + 0.5 * (beside + beside.T)))


def identified_parameters(
    parameters: Sequence[FreeParameter], steps: FloatArray, posterior: Posterior
) -> tuple[IdentifiedParameter, ...]:
    """Values with intervals, and a verdict with its reason for each."""
    deviations = np.sqrt(np.diag(posterior.covariance))
    correlation = posterior.covariance / np.outer(deviations, deviations)
    found = []
    for i, parameter in enumerate(parameters):
        scale = parameter.prior_std
        value = parameter.nominal + scale * float(steps[i])
        std = scale * float(posterior.std[i])
        ratio = float(posterior.std[i])
        wide = scale * float(np.hypot(posterior.std[i], posterior.by_thrust[i]))
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
                ci95=(value - _NORMAL_95 * std, value + _NORMAL_95 * std),
                ci95_with_thrust=(value - _NORMAL_95 * wide, value + _NORMAL_95 * wide),
                prior_value=parameter.nominal,
                prior_std=scale,
                posterior_over_prior=ratio,
                inflation=float(posterior.inflation[i]),
                identified=ratio <= NOT_IDENTIFIED,
                reason=_reason(
                    ratio,
                    float(np.hypot(posterior.std[i], posterior.by_thrust[i])),
                    parameters[partner].name,
                    float(correlation[i, partner]) if others[partner] > 0 else 0.0,
                ),
            )
        )
    return tuple(found)


def _reason(ratio: float, with_thrust: float, partner: str, correlation: float) -> str:
    together = (
        f"; moves together with {partner} (correlation {correlation:+.2f})"
        if abs(correlation) >= CLOSE_PAIR
        else ""
    )
    if ratio > NOT_IDENTIFIED:
        return (
            f"the runs leave {100 * ratio:.0f} % of the prior's standard deviation: they hardly "
            f"excite it{together}"
        )
    if with_thrust > NOT_IDENTIFIED:
        return (
            f"only as far as the thrust of the bench is trusted: its uncertainty makes "
            f"{100 * ratio:.0f} % of the prior's standard deviation {100 * with_thrust:.0f} %"
            f"{together}"
        )
    return f"{100 * ratio:.1f} % of the prior's standard deviation is left{together}"


def close_pairs(
    parameters: Sequence[FreeParameter], posterior: Posterior
) -> tuple[Correlation, ...]:
    """Pairs of parameters whose estimates are correlated by `CLOSE_PAIR` or more."""
    deviations = np.sqrt(np.diag(posterior.covariance))
    matrix = posterior.covariance / np.outer(deviations, deviations)
    rows, columns = np.nonzero(np.triu(np.abs(matrix) >= CLOSE_PAIR, 1))
    pairs = [
        Correlation(
            first=parameters[i].name,
            second=parameters[j].name,
            coefficient=float(matrix[i, j]),
        )
        for i, j in zip(rows, columns, strict=True)
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair.coefficient)))
