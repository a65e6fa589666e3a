"""What the runs cannot identify, and which manoeuvre would.

The information that a manoeuvre would bring is computed, not measured: it is flown in simulation
with the identified vehicle, its windows give the same matrix that the fit has, and the two add up.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.bounds import cut_std
from pipeline.identify.channel_noise import channel_noise
from pipeline.identify.output_error import FitSolution, reduce_windows
from pipeline.identify.parameter_intervals import NOT_IDENTIFIED, prior_share
from pipeline.identify.thrust_uncertainty import EXACT_THRUST, ThrustUncertainty
from pipeline.identify.vehicle_parameters import FreeParameter
from pipeline.identify.window_derivatives import FitProblem, derivatives
from pipeline.identify.window_outputs import stack_windows
from pipeline.identify.windows import cut
from pipeline.records.identification import IdentifiedParameter, ManoeuvreGain
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.sensors import Log, measure
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: A suggested run is computed for this long at most. [s]
LONGEST_TRIAL_S = 60.0
#: Below this share of the present standard deviation a manoeuvre counts as a help.
HELPS = 0.8


def information_of_run(
    packed: PackedVehicle,
    sensors: Sensors,
    log: Log,
    parameters: tuple[FreeParameter, ...],
    *,
    steps: FloatArray | None = None,
    threads: int = 2,
    thrust: ThrustUncertainty = EXACT_THRUST,
    scale: dict[str, float] | None = None,
) -> FloatArray:
    """Information on the parameters and the thrust (p + q, p + q) that a simulated run holds.

    Counted in prior standard deviations, the priors left out; offsets of the run and first states
    of its windows are projected out. At `steps` (p + q,), or the vehicle file; `scale` multiplies
    the stated noise of a quantity, as the fit found it.

    Raises
    ------
    CannotComputeError
        If the run cannot be simulated.
    """
    table = table_of_log(log, sensors)
    channels = channel_noise(sensors, [table])
    stack = stack_windows(packed, cut(packed, [table], channels), channels, scale=scale)
    problem = FitProblem(stack, parameters, packed.vector, threads=threads, thrust=thrust)
    point = problem.origin()
    if steps is not None:
        point = replace(point, steps=steps)
    found = derivatives(problem, point)
    if not np.isfinite(found.parameters).all():
        raise CannotComputeError("the run cannot be simulated over its windows")
    reduced = reduce_windows(problem, found, point, np.ones(found.residual.size))
    return reduced.of_parameters(problem.size)


def best_manoeuvres(
    packed: PackedVehicle,
    sensors: Sensors,
    solution: FitSolution,
    found: Sequence[IdentifiedParameter],
    threads: int = 2,
) -> tuple[ManoeuvreGain, ...]:
    """For each parameter that was not identified the manoeuvre that would tell most about it.

    Autopilot and allocator believe the vehicle of the file, `packed`; `found` are the verdicts.
    """
    missing = [i for i, parameter in enumerate(found) if not parameter.identified]
    if not missing:
        return ()
    problem = solution.problem
    parameters = problem.parameters
    present = solution.reduced.of_parameters(problem.size) + problem.precision
    now = _left(present, parameters, found)
    best: dict[int, ManoeuvreGain] = {}
    for name, manoeuvre in MANOEUVRES.items():
        duration = min(manoeuvre.duration_s, LONGEST_TRIAL_S)
        try:
            # autopilot and allocator believe the file, the vehicle moves as it was found to
            flown = fly(packed, manoeuvre.plan(packed, 1.0, duration), vector=solution.vector)
            more = information_of_run(
                packed,
                sensors,
                measure(flown, packed, sensors, vector=solution.vector),
                parameters,
                steps=solution.point.steps,
                threads=threads,
                thrust=problem.thrust,
                scale=problem.stack.scale,
            )
        except CannotComputeError:
            continue
        then = _left(present + more, parameters, found)
        for i in missing:
            if then[i] < HELPS * now[i] and (
                i not in best or then[i] < best[i].posterior_over_prior
            ):
                best[i] = ManoeuvreGain(
                    parameter=parameters[i].name,
                    manoeuvre=name,
                    duration_s=duration,
                    posterior_over_prior=float(then[i]),
                )
    return tuple(best[i] for i in missing if i in best)


def _left(
    information: FloatArray,
    parameters: Sequence[FreeParameter],
    found: Sequence[IdentifiedParameter],
) -> FloatArray:
    """Return standard deviations over the prior's (p,), bounds counted in both, as the fit does.

    Residuals that go together widened them; those of one more run of the vehicle will, too.
    """
    uncut = np.sqrt(np.diag(np.linalg.inv(information)))
    left = []
    for parameter, one, std in zip(parameters, found, uncut[: len(parameters)], strict=True):
        own = one.inflation * float(std)
        if parameter.lowest is not None:
            wide = own * parameter.prior_std
            own = cut_std(one.value, wide, parameter.lowest) / parameter.prior_std
        left.append(own / prior_share(parameter))
    return np.array(left)


def cannot_identify(
    found: Sequence[IdentifiedParameter], gains: Sequence[ManoeuvreGain] | None
) -> tuple[str, ...]:
    """One sentence for each parameter that does not stand; `gains` None: none were sought."""
    if gains is None:
        return tuple(f"{one.name}: {one.reason}." for one in found if not one.stands)
    by_name = {gain.parameter: gain for gain in gains}
    sentences = []
    for parameter in found:
        if parameter.stands:
            continue
        if parameter.identified:
            # told, and contradicted: another manoeuvre is not what lacks
            sentences.append(f"{parameter.name}: {parameter.reason}.")
            continue
        gain = by_name.get(parameter.name)
        if gain is None:
            advice = "no manoeuvre of the library would"
        else:
            would = 100 * gain.posterior_over_prior
            verdict = "would" if gain.posterior_over_prior <= NOT_IDENTIFIED else "would help"
            advice = (
                f"{gain.duration_s:g} s of {gain.manoeuvre} {verdict} "
                f"({would:.0f} % of the prior's standard deviation left)"
            )
        sentences.append(f"{parameter.name}: {parameter.reason}; {advice}.")
    return tuple(sentences)
