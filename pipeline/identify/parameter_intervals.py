r"""Intervals of the whole-vehicle fit, and which parameters the runs identified.

Fisher information H (starts of the windows projected out, priors added) gives the covariance
H^-1 where residuals are white. Where they go together the sandwich

.. math:: H^{-1} (B + P) H^{-1}, \qquad
    B = \sum_w s_w s_w^T + \tfrac12 \sum_w (s_w s_{w+1}^T + s_{w+1} s_w^T)

of the windows' scores s_w (P the prior; neighbouring windows of one run, Bartlett's weight) is
what the scatter between windows shows (White 1982; Newey and West 1987). It rests on the few dozen
windows that tell of a parameter, and is itself uncertain by sqrt(2 / windows): it takes the place
of the Fisher variance where it exceeds that by more than chance would (5 %), and never narrows.
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
    problem, reduced = solution.problem, solution.reduced
    count = len(problem.parameters)
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
    believed = scatter > share.sum(axis=0) * _by_chance(share)
    ratio = np.where(believed, np.maximum(wider / variance, 1.0), 1.0)
    shift = inverse @ reduced.thrust
    return Posterior(inverse[:count, :count], np.sqrt(ratio), thrust_uncertainty * shift[:count])


def _by_chance(shares: FloatArray) -> FloatArray:
    """95 % quantile of scattered over expected variance, from each window's share of it (w, p).

    A sum of squares over m alike windows; m = (sum s)^2 / sum s^2, less a third for the products
    with the neighbour.
    """
    from scipy import stats

    alike = shares.sum(axis=0) ** 2 / np.maximum(np.sum(shares**2, axis=0), 1e-300)
    degrees = np.maximum(alike / 1.5, 1.0)
    return np.asarray(stats.chi2.ppf(0.95, degrees) / degrees)


def _scatter(influences: FloatArray, consecutive: BoolArray) -> FloatArray:
    """Variance (p,) of the sum over windows (w, p), neighbours included (Bartlett, one lag)."""
    centred = influences - influences.mean(axis=0)
    count = len(centred)
    beside = np.sum(centred[:-1][consecutive] * centred[1:][consecutive], axis=0)
    alone = np.sum(centred**2, axis=0)
    return np.asarray(count / max(count - 1, 1) * np.maximum(alone + beside, 0.0))


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
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair.coefficient)))
