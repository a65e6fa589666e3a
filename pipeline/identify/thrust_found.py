"""What a fit found of the thrust: the factor of each thruster, the curves, the thrust deduction."""

import numpy as np

from pipeline.identify.output_error import FitSolution
from pipeline.identify.parameter_intervals import Posterior
from pipeline.identify.standing import Halves
from pipeline.identify.thrust_uncertainty import ThrustUncertainty
from pipeline.records.identification import ThrustFound
from pipeline.records.intervals import NORMAL_95
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def thrust_found(
    doubt: ThrustUncertainty, steps: FloatArray, posterior: Posterior, halves: Halves | None = None
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
        half = NORMAL_95 * scale * float(deviations[i])
        found.append(
            ThrustFound(
                name=name,
                unit=unit,
                value=value,
                ci95=(value - half, value + half),
                prior_std=scale,
                widths=abs(moved),
                halves=None
                if halves is None
                else (
                    stated + scale * float(halves.first[begin + i]),
                    stated + scale * float(halves.second[begin + i]),
                ),
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
