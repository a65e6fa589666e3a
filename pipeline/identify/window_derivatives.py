"""What the whole-vehicle fit solves: residuals of all windows, and their derivatives."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from pipeline.identify.run_nuisance import RunNuisance, run_nuisance
from pipeline.identify.thrust_uncertainty import EXACT_THRUST, ThrustUncertainty
from pipeline.identify.vehicle_parameters import FreeParameter, values_from_steps, vector_with
from pipeline.identify.window_outputs import WindowStack, innovations, whitened
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

#: Prior standard deviations of a window's first state about what was measured there: position
#: [m], attitude [rad], linear and angular velocity [m/s, rad/s]. Wide: the readings decide.
START_POSITION, START_ATTITUDE, START_VELOCITY, START_RATE = 5.0, 0.2, 0.5, 0.2
#: The same where the velocity was not measured and the model's own is taken.
BLIND_VELOCITY = 0.2
#: Steps of the forward differences, in prior standard deviations. Small: a factor on all forces is
#: the same as one on all masses, so hundreds of standard deviations of single parameters have to
#: cancel along that direction, and what a long step leaves would pass for knowledge of it.
_PARAMETER_STEP, _START_STEP = 1e-5, 1e-6


@dataclass(frozen=True, eq=False)
class Shift:
    """By what some runs may differ: `direction` (p + q,) is one `unit` of it in x."""

    kind: str
    name: str
    unit: str
    runs: tuple[int, ...]
    direction: FloatArray


@dataclass(frozen=True)
class FitProblem:
    """What is fitted: windows, free parameters, what the windows of a run share, and the thrust.

    The unknowns x of a point are the parameters (p,), those of the thrust (q,), sizes of shifts.
    Windows are of so many `runs`; `offsets` False leaves the constant ones of sensors at zero.
    """

    stack: WindowStack
    parameters: tuple[FreeParameter, ...]
    nominal: FloatArray
    runs: int = 1
    threads: int = 2
    thrust: ThrustUncertainty = EXACT_THRUST
    held: frozenset[int] = frozenset()
    """Which of x stay at what the vehicle file says."""
    offsets: bool = True
    shifts: tuple[Shift, ...] = ()
    """By what some runs differ from the others; their sizes (k,) are the last of x."""

    @cached_property
    def shared(self) -> RunNuisance:
        """What the windows of a run share."""
        return run_nuisance(self.stack, self.runs, offsets=self.offsets)

    @property
    def size(self) -> int:
        """Number of the unknowns x."""
        return len(self.parameters) + self.thrust.size + len(self.shifts)

    def free(self, count: int) -> BoolArray:
        """Which of the first unknowns of (x, s) are not held, (count,)."""
        found = np.ones(count, bool)
        found[list(self.held)] = False
        return found

    @cached_property
    def precision(self) -> FloatArray:
        """Prior precision of x; a shift may have any size."""
        flat = 1e-9 * np.eye(len(self.shifts))
        own = np.eye(len(self.parameters))
        return np.asarray(block_diag(own, self.thrust.precision, flat))

    @cached_property
    def lowest(self) -> FloatArray:
        """Smallest value (p + q,) that each of x may have; -inf where there is none."""
        found = np.full(self.size, -np.inf)
        for i, parameter in enumerate(self.parameters):
            if parameter.lowest is not None:
                found[i] = (parameter.lowest - parameter.nominal) / parameter.prior_std
        gains = slice(len(self.parameters), len(self.parameters) + self.thrust.gains)
        found[gains] = self.thrust.lowest_step
        return found

    @property
    def start_scales(self) -> FloatArray:
        """Prior standard deviations of the first states (windows, 12)."""
        scales = np.zeros((len(self.stack.windows), 12))
        # north, east, down that show in the readings
        read = {rows.channel.quantity for rows in self.stack.rows}
        scales[:, :3] = START_POSITION * ("position" in read)
        scales[:, 2] = START_POSITION * bool({"position", "depth"} & read)
        scales[:, 3:6] = START_ATTITUDE
        known = np.array([window.known for window in self.stack.windows])
        scales[:, 6:9] = np.where(known[:, :3], START_VELOCITY, BLIND_VELOCITY)
        scales[:, 9:12] = START_RATE
        return scales

    def vector(self, steps: FloatArray) -> FloatArray:
        """Parameter vector for x in prior standard deviations; of each window where runs differ."""
        count, common = len(self.parameters), steps[: self.size - len(self.shifts)]

        def of_run(run: int) -> FloatArray:
            own = common.copy()
            for shift, size in zip(self.shifts, steps[common.size :], strict=True):
                own += size * shift.direction * (run in shift.runs)
            values = values_from_steps(self.parameters, own[:count])
            vector = vector_with(self.nominal, self.parameters, values)
            self.thrust.write(vector, own[count:])
            return vector

        if not self.shifts:
            return of_run(0)
        by_run = [of_run(run) for run in range(self.runs)]
        return np.stack([by_run[window.run] for window in self.stack.windows])

    def packed(self, steps: FloatArray) -> PackedVehicle:
        """Return the vehicle with the thrust curves of x."""
        count = len(self.parameters)
        return self.thrust.packed(self.stack.packed, steps[count : count + self.thrust.size])

    def starts(self, moved: FloatArray) -> FloatArray:
        """First states (windows, STATE) for starts (windows, 12) in prior deviations."""
        return moved_starts(self.stack.starts, moved * self.start_scales)

    def origin(self) -> "FitPoint":
        """Nominal parameters, no offsets or wander, first states as measured."""
        return FitPoint(
            np.zeros(self.size), np.zeros(self.shared.size), np.zeros((len(self.stack.windows), 12))
        )


@dataclass(frozen=True)
class FitPoint:
    """Where the fit stands: x (p + q,), shared unknowns (s,), starts (windows, 12)."""

    steps: FloatArray
    shared: FloatArray
    starts: FloatArray


@dataclass(frozen=True)
class Derivatives:
    """Whitened residuals (rows,) and derivatives of the predictions at a point.

    `parameters` (rows, p + q + k) by x, `starts` (rows, 12) by the window's own start. Those by the
    shared unknowns are constant and lie with the problem.
    """

    residual: FloatArray
    parameters: FloatArray
    starts: FloatArray


def moved_starts(starts: FloatArray, by: FloatArray) -> FloatArray:
    """Move first states (w, STATE) by position, body rotation and velocity (w, 12)."""
    moved = starts.copy()
    moved[:, 0:3] += by[:, 0:3]
    moved[:, 7:13] += by[:, 6:12]
    angle = np.linalg.norm(by[:, 3:6], axis=1)
    half = np.sinc(angle / (2 * np.pi)) / 2
    turn = np.column_stack([np.cos(angle / 2), half[:, None] * by[:, 3:6]])
    q = starts[:, 3:7]
    moved[:, 3] = q[:, 0] * turn[:, 0] - np.sum(q[:, 1:] * turn[:, 1:], axis=1)
    moved[:, 4:7] = (
        q[:, :1] * turn[:, 1:] + turn[:, :1] * q[:, 1:] + np.cross(q[:, 1:], turn[:, 1:])
    )
    return moved


def residuals(problem: FitProblem, point: FitPoint) -> FloatArray:
    """Whitened residuals of all windows, one vector (rows,)."""
    return _unshared(problem, point) - problem.shared.whitened(point.shared)


def _unshared(problem: FitProblem, point: FitPoint) -> FloatArray:
    """Return the residuals with what the windows of a run share left at zero."""
    raw = innovations(
        problem.stack.of(problem.packed(point.steps)),
        problem.vector(point.steps),
        problem.starts(point.starts),
    )
    return whitened(problem.stack, raw)


def derivatives(problem: FitProblem, point: FitPoint) -> Derivatives:
    """Forward differences, one simulation of all windows a column, over threads."""
    base = _unshared(problem, point)
    count = problem.size - len(problem.shifts)
    used = np.flatnonzero(problem.start_scales.any(axis=0))

    def column(index: int) -> FloatArray:
        if index < count:
            steps = point.steps.copy()
            steps[index] += _PARAMETER_STEP
            moved = _unshared(problem, FitPoint(steps, point.shared, point.starts))
            return np.asarray((base - moved) / _PARAMETER_STEP)
        starts = point.starts.copy()
        starts[:, used[index - count]] += _START_STEP
        moved = _unshared(problem, FitPoint(point.steps, point.shared, starts))
        return np.asarray((base - moved) / _START_STEP)

    with ThreadPoolExecutor(problem.threads) as pool:
        columns = list(pool.map(column, range(count + used.size)))
    # a window that runs away as soon as it is touched says nothing about where to go
    columns = [np.where(np.isfinite(one), one, 0.0) for one in columns]
    by_start = np.zeros((base.size, 12))
    by_start[:, used] = np.stack(columns[count:], axis=1)
    by_x = np.stack(columns[:count], axis=1) if count else np.zeros((base.size, 0))
    run = np.array([window.run for window in problem.stack.windows])[problem.shared.window]
    by_size = [by_x @ one.direction * np.isin(run, one.runs) for one in problem.shifts]
    return Derivatives(
        base - problem.shared.whitened(point.shared), np.column_stack([by_x, *by_size]), by_start
    )
