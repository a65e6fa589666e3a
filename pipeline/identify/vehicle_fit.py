"""The fit itself: short windows first, then windows of the wanted length.

Over short windows the motion is nearly linear in the parameters, so that the fit finds its way from
a poor start even where the vehicle is unstable.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise, channel_noise
from pipeline.identify.output_error import Solution, solve
from pipeline.identify.parameter_intervals import Posterior, posterior_of
from pipeline.identify.vehicle_parameters import FreeParameter, PriorWidths, free_parameters
from pipeline.identify.window_derivatives import Problem
from pipeline.identify.window_outputs import (
    Stack,
    offset_scales,
    simulate_windows,
    stack_windows,
)
from pipeline.identify.windows import Window, cut
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: One window in so many is kept from the fit to judge it, where no hold-out run is given.
HOLDOUT_EVERY = 6
#: Windows of the first stage are so much shorter, but not below `SHORTEST_WINDOW_S`.
SHORTER, SHORTEST_WINDOW_S = 4.0, 2.0
#: Residuals beyond this times the stated noise widen it; the fit is then repeated.
NOISE_TOLERANCE = 1.15
_MOST_REPEATS = 3


@dataclass(frozen=True)
class Fit:
    """A finished fit with what it was made from."""

    solution: Solution
    posterior: Posterior
    parameters: tuple[FreeParameter, ...]
    channels: tuple[ChannelNoise, ...]
    held_out: tuple[Window, ...]
    window_s: float


def fit_vehicle(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    *,
    uncertainty: Uncertainty,
    widths: PriorWidths | None = None,
    only: Sequence[str] | None = None,
    hold_out: bool = True,
    window_s: float | None = None,
    threads: int = 2,
) -> Fit:
    """Fit alone, without judging it; parameters as `identify_vehicle`."""
    channels = channel_noise(sensors, runs)
    parameters = free_parameters(packed, uncertainty, widths, only)
    if not parameters:
        raise CannotComputeError(
            f"no parameter is left to identify: {', '.join(only or ())} name none of the vehicle's"
        )
    windows = cut(packed, runs, channels, window_s)
    length = max(window.duration_s for window in windows)
    held = [
        window
        for number, window in enumerate(windows)
        if hold_out and len(windows) >= HOLDOUT_EVERY and number % HOLDOUT_EVERY == 3
    ]
    short = max(length / SHORTER, SHORTEST_WINDOW_S)
    first = [
        window
        for window in cut(packed, runs, channels, short)
        if not any(_overlap(window, other) for other in held)
    ]
    problem = Problem(
        stack_windows(packed, chained_windows(packed, packed.vector, first), channels),
        parameters,
        packed.vector,
        len(runs),
        offset_scales(channels),
        threads,
    )
    solution = solve(problem, smallest_gain=0.001 * problem.stack.order.size)
    vector = solution.vector
    followed = chained_windows(packed, vector, windows)
    held_numbers = {(w.run, w.begin_s) for w in held}
    kept = [w for w in followed if (w.run, w.begin_s) not in held_numbers]
    held = [w for w in followed if (w.run, w.begin_s) in held_numbers]
    scale = _widened(solution)
    for _ in range(_MOST_REPEATS):
        stack = stack_windows(packed, kept, channels, scale=scale)
        problem = replace(problem, stack=stack)
        solution = solve(
            problem,
            replace(problem.origin(), steps=solution.point.steps, biases=solution.point.biases),
        )
        found = _widened(solution)
        settled = _alike(found, scale)
        scale = found
        if settled:
            break
    return Fit(
        solution,
        posterior_of(solution, uncertainty.thrust),
        parameters,
        channels,
        tuple(held),
        length,
    )


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
            stack = Stack(
                packed, (before,), (), np.zeros(0, int), np.zeros(1, int), np.zeros(0, int)
            )
            states, _ = simulate_windows(stack, vector, before.start[None])
            if np.isfinite(states[-1]).all():
                start[7:13] = np.where(window.known, start[7:13], states[-1, 7:13])
        chained.append(replace(window, start=start))
    return chained


def _widened(solution: Solution) -> dict[str, float]:
    """Factors on the stated noise that the residuals ask for; none where they bear it out."""
    stack = solution.problem.stack
    wider = {}
    for number, rows in enumerate(stack.rows):
        own = solution.residual[stack.owner == number]
        # robust: a few outliers are not the sensor's noise
        scatter = float(np.median(np.abs(own))) / 0.6745
        factor = scatter * stack.scale.get(rows.channel.quantity, 1.0)
        if factor > NOISE_TOLERANCE:
            wider[rows.channel.quantity] = factor
    return wider


def _alike(one: dict[str, float], other: dict[str, float]) -> bool:
    """Whether no channel's factor has changed by more than the tolerance."""
    return all(
        abs(np.log(one.get(name, 1.0) / other.get(name, 1.0))) < np.log(NOISE_TOLERANCE)
        for name in {**one, **other}
    )
