"""What one run says of the force of each thruster on each axis, by regression of its motion.

The equation of motion of an axis, integrated over short intervals one after another, regressed on
the model's thrust of each thruster beside what was known before (docs/methods/gains.md). What comes
out of an axis is not an estimate but its likelihood as far as it depends on beta: commands that
always go together leave a direction without information, and whoever combines axes and runs loses
nothing.

References
----------
Sagara and Zhao 1990, Automatica 26(1), 63-74. Ljung 1999, System Identification, section 13.4.
"""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from pipeline.effects.effect import AXES
from pipeline.errors import CannotComputeError
from pipeline.identify.run_motion import RunMotion, run_motion
from pipeline.physics.parameters import read
from pipeline.physics.window_sums import sums_over
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import actuator_states, hull_wrench, levers, thruster_wrench
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: A row whose leverage is so many times the mean counts less.
_LEVERAGE = 3.0


def _solved(
    known: FloatArray, held: FloatArray, both: FloatArray, weight: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray, float, FloatArray]:
    """Solve response = thrust beta + known terms of prior deviations `held` for beta.

    `known` (k, t) have unit size, `both` (k, n + 1) are thrusts and response, `noise` a variance.
    The thrusts less what the terms explain (k, n), beta (n,), the variance it leaves, and that.
    """
    weighted = weight[:, None] * known
    normal = known.T @ weighted
    # a whisker for terms that go together: what each of them gets is of no account
    normal[np.diag_indices_from(normal)] += noise / held**2 + 1e-9 * len(both)
    both = both - known @ np.linalg.solve(normal, weighted.T @ both)
    partial, rest = both[:, :-1], both[:, -1]
    weighted = weight[:, None] * partial
    beta = np.linalg.solve(_lifted(partial.T @ weighted), weighted.T @ rest)
    error = rest - partial @ beta
    degrees = max(float(weight.sum()) - partial.shape[1] - held.size, 1.0)
    left = max(float((weight * error**2).sum()) / degrees, 1e-300)
    return partial, np.asarray(beta, float), left, error


def _lifted(normal: FloatArray) -> FloatArray:
    """Return normal equations that can be solved where regressors go together."""
    normal[np.diag_indices_from(normal)] += 1e-9 * max(float(np.trace(normal)), 1e-300)
    return normal


def _bounded(partial: FloatArray) -> FloatArray:
    """Weights (k,) of rows that bound how much of the answer rests on a single one."""
    spread = np.linalg.solve(_lifted(partial.T @ partial), partial.T).T
    leverage = np.maximum(np.sum(partial * spread, axis=1), 1e-300)
    return np.asarray(np.minimum(1.0, _LEVERAGE * np.mean(leverage) / leverage), float)


def _widened(information: FloatArray, scores: FloatArray, label: IntArray) -> FloatArray:
    """Take from each direction what its scores vary more over blocks than independent ones do."""
    _, where = np.unique(label, return_inverse=True)
    blocks = int(where.max()) + 1
    size, axes = np.linalg.eigh(0.5 * (information + information.T))
    sums = np.zeros((blocks, scores.shape[1]))
    np.add.at(sums, where, scores)
    more = np.sum((sums @ axes) ** 2, axis=0) * blocks / max(blocks - 1, 1)
    ratio = np.maximum(more / np.maximum(size, 1e-12 * max(float(size[-1]), 1e-300)), 1.0)
    return np.asarray((axes * (np.maximum(size, 0.0) / ratio)) @ axes.T)


#: Shortest interval; never shorter than the pause between readings. [s]
_INTERVAL_S = 0.2
#: Delays beyond the model's own lag that are tried. [s]
DELAYS_S = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
#: By what factor and difference another delay has to tell more than the file's lag alone.
_FILE_LAG = (1.25, 20.0)
#: Seconds at the start that take no part. [s]
SETTLING_S = 3.0
#: Intervals before, of the thrusts and of the left side.
_BEFORE_THRUST, _BEFORE_LEFT = 3, 3
#: Sums of scores over blocks of this length tell what correlation is left. [s]
_BLOCK_S = 2.0
#: Prior standard deviation of a term: in those of the left side; of a thrust before, in levers.
_TERM_STD, _BEFORE_STD = 5.0, 1.0
#: Rows this many robust standard deviations off count less.
_HUBER, _PASSES = 3.0, 3
#: What the model's thrust is wrong by in its own course, as a share of its size. [1]
_COURSE = 0.001
#: Fewest rows beyond the terms that an axis is asked with.
_FEWEST_SPARE = 20
#: A thruster whose thrust varies by less than this share of the largest was hardly commanded.
_LEAST_EXCITED = 0.003


@dataclass(frozen=True)
class AxisLikelihood:
    """Gaussian likelihood of beta (n,) along an axis: exp(-b' information b / 2 + vector' b).

    Per newton of the model's thrust, so that beta is a lever, [1] or [m]; `degrees` of freedom of
    the residual, `rows` how many intervals, `noise` its standard deviation [N, N m].
    """

    axis: int
    information: FloatArray
    vector: FloatArray
    degrees: float
    rows: int
    noise: float
    source: str

    @property
    def name(self) -> str:
        """Name of the axis."""
        return AXES[self.axis]


@dataclass(frozen=True)
class RunLikelihood:
    """All axes of a run that say something.

    `thrust_std` (n,) is how much each thrust of the model varied [N], `excited` (n,) whether that
    is enough to be judged by.
    """

    run: str
    axes: tuple[AxisLikelihood, ...]
    delay_s: float
    thrust_std: FloatArray
    excited: BoolArray
    why_not: dict[str, str]
    """Axis -> why it says nothing."""


@dataclass(frozen=True)
class _Fixed:
    """What does not depend on the delay: an equation for each interval.

    `start` (k,) first rows, `left` (k, 6), `known` (k, 6), `terms` for each axis (k, t).
    """

    start: IntArray
    width: int
    left: FloatArray
    known: BoolArray
    terms: tuple[FloatArray, ...]


#: The likelihood of an axis, and what the thrusts of now take off the cost.
_Solved = tuple[AxisLikelihood, float]


def run_likelihood(packed: PackedVehicle, sensors: Sensors, run: RunTable) -> RunLikelihood:
    """Regress a run's motion on the thrusts of its commands.

    Raises
    ------
    CannotComputeError
        Without commands, for a run that is too short or tells no acceleration.
    """
    if "command" not in run.values or not run.valid["command"].any():
        raise CannotComputeError(f"{run.name}: no thruster commands were recorded")
    # many small systems: threads of the linear algebra would wait for each other
    with threadpool_limits(1, user_api="blas"):
        return _run_likelihood(packed, run_motion(packed, sensors, run), run)


def _run_likelihood(packed: PackedVehicle, motion: RunMotion, run: RunTable) -> RunLikelihood:
    fixed = _fixed(packed, motion, run)
    arms = levers(packed)
    tried = []
    for delay in DELAYS_S:
        thrust = _thrust(packed, motion, run, delay)
        solved = _all_axes(fixed, thrust, arms, motion)
        told = sum(one for _, one in solved)
        # the file's lag stands unless another tells clearly more
        told = told if delay else _FILE_LAG[0] * told + _FILE_LAG[1]
        tried.append((told, -delay, thrust, solved))
    _, late, thrust, solved = max(tried, key=lambda one: one[:2])
    solved = _all_axes(fixed, thrust, arms, motion, _PASSES)
    axes = tuple(one for one, _ in solved)
    names = {one.axis for one in axes}
    spread = np.std(_means(thrust, fixed.start, fixed.width), axis=0)
    why_not = {
        AXES[axis]: _why_not(motion, axis, moved=bool(spread.any()))
        for axis in range(6)
        if axis not in names
    }
    excited = spread > _LEAST_EXCITED * _largest_thrust(packed)
    return RunLikelihood(run.name, axes, -late, spread, excited, why_not)


def _why_not(motion: RunMotion, axis: int, *, moved: bool) -> str:
    if not motion.sources[axis]:
        return "no acceleration along it was measured"
    few = "too little of the run has all that its equation needs"
    return few if moved else "no thruster was commanded"


def _largest_thrust(packed: PackedVehicle) -> FloatArray:
    kind = read(packed.vector, "thruster_type")[: len(packed.thruster_names)].astype(int)
    return np.asarray(np.abs(packed.thrust_tables).max(axis=(1, 2, 3))[kind], float)


def _fixed(packed: PackedVehicle, motion: RunMotion, run: RunTable) -> _Fixed:
    """Integrate all that does not depend on the delay over the intervals."""
    period = motion.period_s
    width = max(round(max(_INTERVAL_S, motion.reading_s) / period), 1)
    start = np.arange(0, run.time_s.size - width, width)
    hull = hull_wrench(packed, motion.attitude, motion.measured_nu)
    matrix = mass_of(packed.vector)
    mean_hull = 0.5 * (_means(hull, start, width) + _means(hull, start + 1, width))
    gained = (motion.run_up[start + width] - motion.run_up[start]) / (width * period)
    left = gained @ matrix.T - mean_hull
    known = motion.known & run.valid["command"][:, None]
    measured = np.array([source != "" for source in motion.sources])
    for axis in range(6):
        # the equation holds the accelerations of the axes that its mass is coupled to
        for other in np.flatnonzero((np.abs(matrix[axis]) > 1e-9) & measured):
            known[:, axis] &= motion.known[:, other]
    whole = _means(known.astype(float), start, width) > 1.0 - 0.5 / width
    whole &= known[start + width]
    whole[run.time_s[start] - run.time_s[0] < SETTLING_S] = False
    terms = tuple(_terms(motion, axis)[start] for axis in range(6))
    return _Fixed(start, width, left, whole, terms)


def _terms(motion: RunMotion, axis: int) -> FloatArray:
    """Terms (m, t) of an axis that are known at each row, beside the thrusters."""
    nu = motion.nu
    columns = [np.ones(len(nu)), nu[:, axis], np.abs(nu[:, axis]) * nu[:, axis]]
    if motion.has_attitude:
        columns += list(motion.down.T)
    p, q = (k for k in range(3) if k != axis % 3)
    if axis >= 3:
        columns.append(nu[:, 3 + p] * nu[:, 3 + q])
        if motion.has_velocity.all():
            columns.append(nu[:, p] * nu[:, q])
    elif motion.has_velocity.all():
        columns += [nu[:, p] * nu[:, 3 + q], nu[:, q] * nu[:, 3 + p]]
    return np.stack(columns, axis=1)


def _thrust(packed: PackedVehicle, motion: RunMotion, run: RunTable, delay_s: float) -> FloatArray:
    """Thrust (m, n) of the model for the commands of a run, later by a delay."""
    command = np.nan_to_num(run.values["command"])
    late = np.maximum(np.arange(len(command)) - round(delay_s / motion.period_s), 0)
    actuator = actuator_states(packed, command[late], motion.period_s)
    return thruster_wrench(packed, 0.5 * (actuator[:-1] + actuator[1:]), motion.measured_nu)[1]


def _means(signal: FloatArray, start: IntArray, width: int) -> FloatArray:
    """Means (k, ...) of a signal (m, ...) over `width` rows from each start."""
    return sums_over(signal, start, np.minimum(start + width, len(signal))) / width


def _all_axes(
    fixed: _Fixed, thrust: FloatArray, arms: FloatArray, motion: RunMotion, passes: int = 1
) -> list[_Solved]:
    now = _means(thrust, fixed.start, fixed.width)
    solved = [_axis(fixed, now, axis, arms[axis], motion, passes) for axis in range(6)]
    return [one for one in solved if one is not None]


def _axis(  # noqa: PLR0917  one equation
    fixed: _Fixed, now: FloatArray, axis: int, lever: FloatArray, motion: RunMotion, passes: int
) -> _Solved | None:
    """Regress one axis on the thrusts of now, given all that was known before."""
    count = now.shape[1]
    moved = np.flatnonzero(np.ptp(now, axis=0) > 0.0)
    before = max(_BEFORE_THRUST, _BEFORE_LEFT)
    rows = np.arange(before, len(now))
    kept = fixed.known[:, axis]
    for k in range(before + 1):
        rows = rows[kept[rows - k]]
    left = fixed.left[:, axis]
    terms = [fixed.terms[axis][rows]]
    terms += [left[rows - k, None] for k in range(1, _BEFORE_LEFT + 1)]
    plain = sum(part.shape[1] for part in terms)
    terms += [now[rows - k][:, moved] for k in range(1, _BEFORE_THRUST + 1)]
    known = np.concatenate(terms, axis=1)
    if not moved.size or len(rows) < known.shape[1] + moved.size + _FEWEST_SPARE:
        return None
    response, signal = left[rows], float(np.std(left[rows]))
    if signal == 0.0:
        return None
    size = np.maximum(np.sqrt(np.mean(known**2, axis=0)), 1e-12)
    held = np.full(known.shape[1], _BEFORE_STD * max(float(np.abs(lever).max()), 1e-3))
    held[:plain] = _TERM_STD * signal / size[:plain]
    weight = np.ones(len(rows))
    system = known / size, held * size, np.column_stack([now[rows][:, moved], response])
    partial, beta, noise, error = _solved(*system, weight, float(np.var(response)))
    for _ in range(passes - 1):
        scale = float(np.median(np.abs(error))) / 0.6745
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(error), 1e-300))
        weight *= _bounded(partial)
        partial, beta, noise, error = _solved(*system, weight, noise)
    information, vector = np.zeros((count, count)), np.zeros(count)
    block = rows // max(round(_BLOCK_S / (fixed.width * motion.period_s)), 1)
    part = (weight[:, None] * partial).T @ partial / noise
    # no run is so long that a curve or an inflow that is off would average out
    course = _COURSE**2 * float(np.mean((now[rows] * lever) ** 2, axis=0).sum())
    course = 1.0 + float(weight.sum()) * course / noise
    part = _widened(part, (weight * error / noise)[:, None] * partial, block) / course
    information[np.ix_(moved, moved)] = part
    vector[moved] = part @ beta
    blocks = int(np.unique(block).size)
    likelihood = AxisLikelihood(
        axis, information, vector, max(blocks - 1, 1), len(rows), noise**0.5, motion.sources[axis]
    )
    return likelihood, float(beta @ part @ beta)
