"""The fit itself: short windows first, then windows of the wanted length.

Over short windows the motion is nearly linear in the parameters, so that the fit finds its way from
a poor start even where the vehicle is unstable.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise, channel_noise
from pipeline.identify.output_error import MOST_STEPS, SMALLEST_GAIN, FitSolution, solve
from pipeline.identify.parameter_intervals import Posterior, identified_parameters, posterior_of
from pipeline.identify.standing import Halves, at_rest, halves_of, with_standing
from pipeline.identify.thrust_uncertainty import thrust_uncertainty
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.window_derivatives import FitPoint, FitProblem, residuals
from pipeline.identify.window_outputs import WindowStack, simulate_windows, stack_windows
from pipeline.identify.windows import Window, cut
from pipeline.records.identification import IdentifiedParameter
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: One window in so many is kept from the fit to judge it, where no hold-out run is given.
HOLDOUT_EVERY = 6
#: Of so many windows one is kept all the same.
FEWEST_WINDOWS = 3
#: Windows of the first stage are so much shorter, but not below `SHORTEST_WINDOW_S`.
SHORTER, SHORTEST_WINDOW_S = 4.0, 2.0
#: Residuals beyond this times the stated noise widen it; the fit is then repeated.
NOISE_TOLERANCE = 1.15
SETTLED = 1.05
_MOST_REPEATS = 3
#: Until the noise has settled, a step that promises less than this times the readings is the last.
ROUGH_GAIN = 0.001
#: Correlation of residuals from which they count as going together, and the most that is believed.
TOGETHER, MOST_TOGETHER = 0.3, 0.9
#: A velocity above this at the end of a window is not handed to the next. [m/s, rad/s]
FASTEST_CHAIN = 3.0


@dataclass(frozen=True)
class VehicleFit:
    """A finished fit with what it was made from."""

    solution: FitSolution
    posterior: Posterior
    channels: tuple[ChannelNoise, ...]
    held_out: tuple[Window, ...]
    window_s: float
    steps: int
    """Gauss-Newton steps in all."""
    found: tuple[IdentifiedParameter, ...]
    halves: Halves
    settled: bool
    """Whether it came to rest in everything."""
    out_of_steps: bool = False
    """Whether it was stopped because the steps that it was given were used up."""


class _Steps:
    """Gauss-Newton steps that are left: what a fit costs, whatever the machine does meanwhile."""

    def __init__(self, most: int | None) -> None:
        self.left, self.taken = most, 0

    def solve(self, problem: FitProblem, point: FitPoint, smallest_gain: float) -> FitSolution:
        """Solve within the steps that are left; one at least, so that there is a solution."""
        left = MOST_STEPS if self.left is None else max(min(MOST_STEPS, self.left - self.taken), 1)
        solution = solve(problem, point, smallest_gain=smallest_gain, most_steps=left)
        self.taken += solution.iterations
        return solution

    @property
    def used_up(self) -> bool:
        """Whether none is left."""
        return self.left is not None and self.taken >= self.left


def fit_vehicle(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    *,
    uncertainty: Uncertainty,
    only: Sequence[str] | None = None,
    hold_out: bool = True,
    window_s: float | None = None,
    threads: int = 2,
    most_steps: int | None = None,
) -> VehicleFit:
    """Fit alone, without judging it; parameters as `identify_vehicle`."""
    steps = _Steps(most_steps)
    channels = channel_noise(sensors, runs)
    parameters = free_parameters(packed, uncertainty, only)
    if not parameters:
        raise CannotComputeError(
            f"no parameter is left to identify: {', '.join(only or ())} name none of the vehicle's"
        )
    windows = cut(packed, runs, channels, window_s)
    length = max(window.duration_s for window in windows)
    count = len(windows)
    held = [one for k, one in enumerate(windows) if hold_out and _is_kept(k, count)]
    short = max(length / SHORTER, SHORTEST_WINDOW_S)
    shorter = cut(packed, runs, channels, short)
    first = [one for one in shorter if not any(_overlap(one, other) for other in held)]
    stack = stack_windows(packed, chained_windows(packed, packed.vector, first), channels)
    thrust = thrust_uncertainty(packed, uncertainty)
    problem = FitProblem(stack, parameters, packed.vector, len(runs), threads, thrust)
    rough = ROUGH_GAIN * stack.order.size
    solution = _settled(problem, channels, {}, steps, smallest_gain=rough)
    # once more with what is known now: thrusters' states, speeds that were not measured
    vector, found = solution.vector, solution.packed
    windows = chained_windows(found, vector, cut(packed, runs, channels, window_s, vector=vector))
    held_at = {(w.run, w.begin_s) for w in held}
    kept = [w for w in windows if (w.run, w.begin_s) not in held_at]
    stack = stack_windows(packed, kept, channels)
    problem = replace(problem, stack=stack)
    scale = solution.problem.stack.scale
    begin = replace(problem.origin(), steps=solution.point.steps)
    solution = _settled(problem, channels, scale, steps, begin)
    posterior = posterior_of(solution)
    halves, rest = halves_of(solution, posterior), at_rest(solution, posterior)
    told = identified_parameters(parameters, solution.point.steps, posterior)
    return VehicleFit(
        solution,
        posterior,
        channels,
        tuple(w for w in windows if (w.run, w.begin_s) in held_at),
        length,
        steps.taken,
        with_standing(parameters, told, rest, halves),
        halves,
        bool(rest.all()),
        steps.used_up and solution.out_of_steps,
    )


def _is_kept(number: int, count: int) -> bool:
    """Whether a window is kept from the fit; of few windows it is one in the middle."""
    if count >= HOLDOUT_EVERY:
        return number % HOLDOUT_EVERY == 3
    return count >= FEWEST_WINDOWS and number == count // 2


def fit_for_file(fit: VehicleFit) -> FitSolution:
    """Fit again what a vehicle file can say: parameters that stand, factors of the thrust.

    The rest is held at what the file says: the shape of the thrust curves has no key.
    """
    solution = fit.solution
    problem, thrust, count = solution.problem, solution.problem.thrust, len(fit.found)
    aside = {i for i, one in enumerate(fit.found) if not one.stands}
    aside |= set(range(count + thrust.gains, count + thrust.size))
    if not aside:
        return solution
    held = replace(problem, held=frozenset(aside))
    own = np.where(held.free(held.size), solution.point.steps, 0.0)
    begin = replace(solution.point, steps=own)
    return _settled(held, fit.channels, problem.stack.scale, _Steps(None), begin)


def _settled(
    problem: FitProblem,
    channels: Sequence[ChannelNoise],
    scale: dict[str, float],
    steps: _Steps,
    point: FitPoint | None = None,
    *,
    smallest_gain: float = SMALLEST_GAIN,
) -> FitSolution:
    """Solve, widen the noise to what the residuals show, and solve again until it agrees.

    Roughly until the noise has settled, and to the end with the noise that was found. Each goes on
    from where the one before ended: windows and unknowns are the same.
    """
    windows, packed = problem.stack.windows, problem.stack.packed
    rough = max(smallest_gain, ROUGH_GAIN * problem.stack.order.size)
    for _ in range(_MOST_REPEATS):
        stack = stack_windows(packed, windows, channels, scale=scale)
        problem = replace(problem, stack=stack)
        if point is None or not np.isfinite(residuals(problem, point)).all():
            # what short windows found runs away over long ones
            point = problem.origin()
        solution = steps.solve(problem, point, rough)
        point, found = solution.point, widened(stack, solution.residual)
        if _alike(found, scale) or steps.used_up:
            break
        scale = found
    if rough > smallest_gain and not steps.used_up:
        solution = steps.solve(problem, solution.point, smallest_gain)
    return solution


def _overlap(one: Window, other: Window) -> bool:
    return (
        one.run == other.run
        and one.begin_s < other.begin_s + other.duration_s - 1e-9
        and other.begin_s < one.begin_s + one.duration_s - 1e-9
    )


def chained_windows(
    packed: PackedVehicle, vector: FloatArray, windows: list[Window]
) -> list[Window]:
    """Let windows whose first velocity was not measured begin with where the one before ended."""
    if all(window.known.all() for window in windows):
        return windows
    chained: list[Window] = []
    for window in windows:
        before = chained[-1] if chained else None
        follows = (
            before is not None
            and before.run == window.run
            and abs(before.begin_s + before.duration_s - window.begin_s) < 0.5 * window.step_s
        )
        start = window.start.copy()
        if before is not None and follows and not window.known.all():
            stack = WindowStack.unread(packed, [before])
            states, _ = simulate_windows(stack, vector, before.start[None])
            # a poor model runs away; what it then says of the speed is worth nothing
            if np.isfinite(states[-1]).all() and np.abs(states[-1, 7:13]).max() < FASTEST_CHAIN:
                start[7:13] = np.where(window.known, start[7:13], states[-1, 7:13])
        chained.append(replace(window, start=start))
    return chained


def widened(stack: WindowStack, residual: FloatArray, run: int | None = None) -> dict[str, float]:
    """Factors on the stated noise that the residuals, of one run or of all, ask for.

    None where they bear it out.
    Scatter beyond the stated noise, and for residuals that go together the root of the number of
    readings that tell as much as one independent one, (1 + r) / (1 - r) at a correlation r from
    one reading to the next: a model that is wrong is wrong for many readings on end, and each of
    them taken for a new witness would overrule every prior.
    """
    wider = {}
    for number, rows in enumerate(stack.rows):
        own, window = residual[stack.owner == number], rows.window
        if run is not None:
            inside = np.array([one.run == run for one in stack.windows])[window]
            own, window = own.reshape(window.size, -1)[inside].ravel(), window[inside]
        if not own.size:
            continue
        # robust: a few outliers are not the sensor's noise
        scatter = float(np.median(np.abs(own))) / 0.6745
        factor = scatter * stack.scale.get(rows.channel.quantity, 1.0)
        together = _together(own / max(scatter, 1e-12), window)
        if together > TOGETHER:
            believed = min(together, MOST_TOGETHER)
            factor *= np.sqrt((1.0 + believed) / (1.0 - believed))
        if factor > NOISE_TOLERANCE:
            wider[rows.channel.quantity] = factor
    return wider


def _together(residual: FloatArray, window: IntArray) -> float:
    """Correlation of a channel's residuals, of unit scatter, from one reading to the next."""
    by_reading = np.clip(residual.reshape(window.size, -1), -3.0, 3.0)
    same = window[1:] == window[:-1]
    if not same.any():
        return 0.0
    product = np.mean(by_reading[1:][same] * by_reading[:-1][same])
    return float(product / max(np.mean(by_reading**2), 1e-12))


def _alike(one: dict[str, float], other: dict[str, float]) -> bool:
    """Whether no channel's factor has changed by more than `SETTLED`."""
    return all(
        abs(np.log(one.get(name, 1.0) / other.get(name, 1.0))) < np.log(SETTLED)
        for name in {**one, **other}
    )
