"""The motion of a measured run on its rows: state, acceleration, and which of it was measured."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import g as standard_gravity
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.physics.complementary_filter import followed
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Imu, Sensors

#: Readings that a smoothed value and its slope are made of, and the least time they span. [s]
_READINGS, _LEAST_S = 5, 0.3
#: Times that an attitude wanders in over which its drift from the rates is a straight line.
_WANDER_TIMES = 3.0
_STATE = 13


@dataclass(frozen=True)
class MeasuredMotion:
    """What a run tells of its motion.

    `state` (m, 13): position NED [m], quaternion body to NED, velocity over ground and rates in
    body axes; `nu_dot` (m, 6) their rates of change. `measured` (6,) tells of each velocity whether
    the run shows it; one that it does not show stands at zero. `placed` tells whether the position
    was measured, `follows` whether the linear velocity follows accelerations. `sunk_m` (m,) is how
    deep the origin is, where heave follows from that.
    """

    time_s: FloatArray
    state: FloatArray
    nu_dot: FloatArray
    measured: BoolArray
    placed: bool
    follows: bool = False
    sunk_m: FloatArray | None = None

    @property
    def upright(self) -> FloatArray:
        """Share (m,) of heave that is vertical."""
        return _upright(Rotation.from_quat(self.state[:, [4, 5, 6, 3]]))

    @property
    def nu(self) -> FloatArray:
        """Velocity over ground and rates, body axes (m, 6) [m/s, rad/s]."""
        return self.state[:, 7:13]


def measured_motion(run: RunTable, sensors: Sensors | None = None) -> MeasuredMotion:
    """Smooth what was measured of a run's motion: local parabolas through five readings.

    Without a measured velocity, heave follows from the depth and the attitude, and surge and sway
    are not known.

    Parameters
    ----------
    run : RunTable
        On an even time base.
    sensors : Sensors, optional
        Where the DVL and the depth sensor sit.

    Raises `CannotComputeError` without rates of turn or attitude.
    """
    rates, attitude = channel_of(run, "angular_velocity"), channel_of(run, "attitude")
    if rates is None or attitude is None:
        raise CannotComputeError(
            f"{run.name}: rates of turn and attitude are needed to tell how it moved; "
            f"it has {', '.join(sorted(run.values))}."
        )
    period = run.period_s
    state, nu_dot = np.zeros((run.time_s.size, _STATE)), np.zeros((run.time_s.size, 6))
    turn = Rotation.from_quat(attitude[:, [1, 2, 3, 0]])
    if sensors and sensors.imu and _rates_are_steadier(sensors.imu):
        turn = _steadied(turn, rates, period, _WANDER_TIMES * sensors.imu.attitude_wander_s)
    state[:, 3:7] = turn.as_quat()[:, [3, 0, 1, 2]]
    state[:, 10:13], nu_dot[:, 3:] = smoothed(rates, window_of(run, "angular_velocity"), period)
    known, follows = np.array([False, False, False, True, True, True]), False
    down = None
    depth = channel_of(run, "depth")
    linear = _linear(run, sensors, turn, state[:, 10:13])
    if linear is not None:
        state[:, 7:10], nu_dot[:, :3], follows = linear
        known[:3] = True
    elif depth is not None:
        place = np.array(sensors.depth.position_m) if sensors and sensors.depth else np.zeros(3)
        down = depth[:, 0] - turn.apply(place)[:, 2]
        window = 2 * window_of(run, "depth") + 1
        _, sinking = smoothed(down[:, None], window, period)
        # heave of a vehicle whose surge and sway are not known
        heave = sinking[:, 0] / _upright(turn)
        state[:, 9:10], nu_dot[:, 2:3] = smoothed(heave[:, None], window, period)
        known[2] = True
    position = channel_of(run, "position")
    if position is not None:
        state[:, :3] = position
    if depth is not None:
        state[:, 2] = depth[:, 0]
    return MeasuredMotion(run.time_s, state, nu_dot, known, position is not None, follows, down)


def velocity_of(run: RunTable, sensors: Sensors | None, motion: MeasuredMotion) -> FloatArray:
    """Velocity over ground (m, 3) by other readings of it; as it was where these are too few."""
    turn = Rotation.from_quat(motion.state[:, [4, 5, 6, 3]])
    linear = _linear(run, sensors, turn, motion.state[:, 10:13])
    return motion.nu[:, :3] if linear is None else linear[0]


def _linear(
    run: RunTable, sensors: Sensors | None, turn: Rotation, omega: FloatArray
) -> tuple[FloatArray, FloatArray, bool] | None:
    """Velocity of the origin and its rate (m, 3), and whether it follows accelerations."""
    velocity = channel_of(run, "velocity")
    if velocity is None:
        return None
    place = np.array(sensors.dvl.position_m) if sensors and sensors.dvl else np.zeros(3)
    at_origin = velocity - np.cross(omega, place)
    value, rate = smoothed(at_origin, window_of(run, "velocity"), run.period_s)
    along = _along_accelerations(run, sensors, turn, at_origin, np.hstack([value, omega]))
    if along is None:
        return value, rate, False
    return along, smoothed(along, window_of(run, "specific_force"), run.period_s)[1], True


def reckoned(motion: MeasuredMotion) -> MeasuredMotion:
    """Add where dead reckoning leads from the origin, where no place was measured."""
    if motion.placed or not motion.measured[:3].all():
        return motion
    turn = Rotation.from_quat(motion.state[:, [4, 5, 6, 3]])
    state, step_s = motion.state.copy(), np.diff(motion.time_s, prepend=motion.time_s[0])
    state[:, :2] = np.cumsum(turn.apply(motion.nu[:, :3])[:, :2] * step_s[:, None], axis=0)
    return replace(motion, state=state)


def _upright(turn: Rotation) -> FloatArray:
    """Share (m,) of heave that is vertical, of a vehicle that is level enough for heave."""
    return np.asarray(np.maximum(turn.as_matrix()[:, 2, 2], 0.5))


def _along_accelerations(
    run: RunTable,
    sensors: Sensors | None,
    turn: Rotation,
    readings: FloatArray,
    nu: FloatArray,
) -> FloatArray | None:
    """Follow accelerations at the level of readings of the velocity (m, 3), if that is better."""
    force = channel_of(run, "specific_force")
    if force is None or "velocity" not in run.reading:
        return None
    place = np.array(sensors.imu.position_m) if sensors and sensors.imu else np.zeros(3)
    omega = nu[:, 3:]
    turning = np.cross(omega, np.cross(omega, place) + nu[:, :3])
    change = force + standard_gravity * turn.as_matrix()[:, 2] - turning
    # up to a row, not half a step beyond it
    summed = (np.cumsum(change, axis=0) - 0.5 * change) * run.period_s - np.cross(omega, place)
    read = run.reading["velocity"] & run.trusted("velocity")
    return followed(readings, read, summed, run.period_s)


def _rates_are_steadier(imu: Imu) -> bool:
    """Whether the sum of the rates walks less at random than the attitude wanders.

    Both are variances that grow with time [rad^2/s]: of white noise of rates, and of a first-order
    Gauss-Markov process over times short beside its own.
    """
    by_rates = imu.rate_noise_radps**2 / imu.rate_hz
    return by_rates < 2.0 * imu.attitude_wander_rad**2 / imu.attitude_wander_s


def _steadied(turn: Rotation, rates: FloatArray, period_s: float, window_s: float) -> Rotation:
    """Follow the rates, and the attitude as far as it drifts from them in a straight line.

    A vehicle that hardly rolls does not answer to what its attitude only seems to do, and would
    pass for heavier. Rates drift from it by their bias, slowly.
    """
    # as in `lagging`
    from scipy.signal import savgol_filter

    between = 0.5 * (rates[1:] + rates[:-1]) * period_s
    followed = turn[0] * _turns(Rotation.from_rotvec(between))
    off = (turn * followed.inv()).as_rotvec()
    window = min(2 * round(window_s / period_s / 2.0) + 1, 2 * ((len(rates) - 1) // 2) + 1)
    drift = Rotation.from_rotvec(savgol_filter(off, window, min(1, window - 1), axis=0))
    return drift * followed


def _turns(steps: Rotation) -> Rotation:
    """Products of all turns up to each row, from none: of twice as many each time."""
    found = np.concatenate([[[0.0, 0.0, 0.0, 1.0]], steps.as_quat()])
    reach = 1
    while reach < len(found):
        found[reach:] = _product(found[:-reach], found[reach:])
        reach *= 2
    return Rotation.from_quat(found)


def _product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Products of quaternions (m, 4), scalar last: those of `Rotation`, without its overhead."""
    a, b = first[:, :3], second[:, :3]
    v, w = first[:, 3:], second[:, 3:]
    scalar = v * w - np.sum(a * b, axis=1, keepdims=True)
    return np.concatenate([v * b + w * a + np.cross(a, b), scalar], axis=1)


def channel_of(run: RunTable, quantity: str) -> FloatArray | None:
    """Values on every row: what is not valid lies on the line between what is."""
    if quantity not in run.values:
        return None
    values = np.array(run.values[quantity], float)
    good = run.trusted(quantity)
    if good.sum() < _READINGS:
        return None
    if not good.all():
        rows = np.arange(values.shape[0])
        for column in range(values.shape[1]):
            values[:, column] = np.interp(rows, rows[good], values[good, column])
    return values


def window_of(run: RunTable, quantity: str) -> int:
    """Rows, odd, that a smoothed value is made of."""
    pause_s = run.pause_s(quantity)
    half = round(max((_READINGS - 1) * pause_s, _LEAST_S) / 2.0 / run.period_s)
    return 2 * max(half, 2) + 1


def smoothed(values: FloatArray, window: int, period_s: float) -> tuple[FloatArray, FloatArray]:
    """Value and slope of the parabola through each row's neighbourhood."""
    # as in `lagging`
    from scipy.signal import savgol_filter

    window = min(window, 2 * ((len(values) - 1) // 2) + 1)
    value = savgol_filter(values, window, 2, axis=0)
    slope = savgol_filter(values, window, 2, deriv=1, delta=period_s, axis=0)
    return np.asarray(value), np.asarray(slope)
