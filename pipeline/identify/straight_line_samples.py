"""Straight stretches of a run, and its readings filtered for acceleration against thrust.

Acceleration is the smoothed derivative of the velocity's readings. The same filter is applied to
the integral of the thrust (and of every further term) at the times of the readings: differences of
speed and of the impulse then belong to the same intervals, and no delay or smoothing of one side
alone bends the slope.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import was_measured
from pipeline.identify.smoothing import (
    Method,
    Smoother,
    moving_average,
    smooth,
    smoother_of_bandwidth,
    white_noise_std,
)
from pipeline.identify.windows import readings_of
from pipeline.physics.parameters import read
from pipeline.records.identification import StraightSegment
from pipeline.records.run_table import RunTable, angles, down_axis, stretches
from pipeline.simulate.applied_wrench import actuator_states, thruster_wrench
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: Largest angular rate about any axis, after a mean over so long. [rad/s], [s]
TURN_RATE_RADPS, MEAN_S = 0.03, 0.5
#: Largest speed across the axis over that along it, or the speed, if that is more. [1], [m/s]
DRIFT, DRIFT_MPS = 0.10, 0.03
#: Largest roll and pitch. [rad]
TILT_RAD = 0.10
#: Shorter stretches are left out. [s]
SHORTEST_S = 4.0
WEIGHT, WALLS = "weight along the axis", "nearness of walls x thrust"
#: Units of the coefficients that are no plain ratio.
UNITS = {"linear drag": "1/s", "quadratic drag": "1/m", WEIGHT: "m/s^2", WALLS: "1/kg"}
_ROTATION = (
    (("sway speed x yaw rate", 1, 2, 1.0), ("heave speed x pitch rate", 2, 1, -1.0)),
    (("surge speed x yaw rate", 0, 2, -1.0), ("heave speed x roll rate", 2, 0, 1.0)),
    (("sway speed x roll rate", 1, 0, -1.0), ("surge speed x pitch rate", 0, 1, 1.0)),
)


@dataclass(frozen=True)
class Samples:
    """Filtered readings of one run: acceleration [m/s^2], thrust along the axis [N], terms.

    All (k,) at the readings' times; `stretch` is the number of the straight stretch, -1 outside;
    `valid` is False where a gap of what the terms are made of is within the filter's length.
    `noise` is that of the acceleration [m/s^2], `segments` are the straight stretches.
    """

    acceleration: FloatArray
    thrust: FloatArray
    terms: dict[str, FloatArray]
    stretch: IntArray
    valid: BoolArray
    noise: float
    smoother: Smoother
    segments: tuple[StraightSegment, ...]


def filtered_samples(  # noqa: PLR0917 - as `straight_line` takes them
    packed: PackedVehicle,
    sensors: Sensors,
    run: RunTable,
    along: int,
    method: Method,
    bandwidth_hz: float,
) -> Samples:
    """Filter one run's readings and find its straight stretches; arguments as of `straight_line`.

    Raises
    ------
    CannotComputeError
        Without velocity or angular velocity, or where its readings are too far apart.
    """
    for quantity in ("velocity", "angular_velocity"):
        if quantity not in run.values or not run.valid[quantity].any():
            raise CannotComputeError(
                f"{run.name}: no {quantity.replace('_', ' ')} was measured, and the slope of "
                "acceleration against thrust needs it; the whole-vehicle fit does without"
            )
    place = np.array(sensors.dvl.position_m if sensors.dvl is not None else (0.0, 0.0, 0.0))
    index = readings_of(run, "velocity", np.inf)
    omega = np.nan_to_num(run.values["angular_velocity"])
    origin = run.values["velocity"] - np.cross(omega, place)
    slot, period = _slots(run.time_s[index])
    readings = np.full((slot[-1] + 1, 3), np.nan)
    readings[slot] = origin[index]
    # the table's period need not divide the sensor's: speed and impulse are both taken at the very
    # samples that hold the readings
    time_s = run.time_s[index[0]] + period * np.arange(len(readings))
    time_s[slot] = run.time_s[index]
    smoother = smoother_of_bandwidth(method, bandwidth_hz, period)
    single = sensors.dvl.noise_mps if sensors.dvl is not None else 0.0
    smoothed = smooth(readings, smoother)
    noise = single or white_noise_std(readings[:, along])
    velocity = np.stack(
        [np.interp(run.time_s, run.time_s[index], column) for column in origin[index].T], axis=1
    )
    command = np.nan_to_num(run.values["command"])
    step = run.period_s
    actuator = actuator_states(packed, command, step)[:-1]
    wrench, _ = thruster_wrench(packed, actuator, np.column_stack([velocity, omega]))
    force = run.force_over(slice(None))
    if force is not None:
        # a cable pulls as a thruster pushes
        wrench = wrench + force

    def filtered(signal: FloatArray) -> FloatArray:
        impulse = np.concatenate([[0.0], np.cumsum(step * (signal[1:] + signal[:-1]) / 2)])
        at_readings = np.interp(time_s, run.time_s, impulse)
        return smooth(at_readings, smoother).derivative

    trusted = np.where(run.valid["velocity"][:, None], velocity, np.nan)
    straight = straight_stretches(run, trusted, along)
    half = smoother.length_s / 2
    number = np.full(len(readings), -1)
    for k, one in enumerate(straight):
        inside = (time_s >= one.from_s + half) & (time_s <= one.to_s - half)
        number[inside & smoothed.valid] = k
    terms, there = omitted_terms(packed, run, velocity, wrench[:, along], along)
    # the filter spreads the zeros that the terms have in gaps
    return Samples(
        smoothed.derivative[:, along],
        filtered(wrench[:, along]),
        {name: filtered(signal) for name, signal in terms.items()},
        number,
        smoothed.valid & _all_within(there, run.time_s, time_s, half),
        noise * smoother.derivative_noise_gain,
        smoother,
        tuple(straight),
    )


def _all_within(known: BoolArray, time_s: FloatArray, at_s: FloatArray, half_s: float) -> BoolArray:
    """Whether all rows (m,) within `half_s` of times (k,) are known, (k,)."""
    unknown = np.concatenate([[0], np.cumsum(~known)])
    first = np.searchsorted(time_s, at_s - half_s, side="left")
    last = np.searchsorted(time_s, at_s + half_s, side="right")
    return np.asarray(unknown[last] == unknown[first])


def _slots(time_s: FloatArray) -> tuple[IntArray, float]:
    """Count the readings in periods of the sensor, missing ones too, and find the period."""
    if time_s.size < 3:
        raise CannotComputeError(f"{time_s.size} readings of the velocity are too few")
    usual = float(np.median(np.diff(time_s)))
    slot = np.concatenate([[0], np.cumsum(np.maximum(np.round(np.diff(time_s) / usual), 1))])
    period = float(np.polyfit(slot, time_s, 1)[0])
    return slot.astype(int), period


def straight_stretches(run: RunTable, velocity: FloatArray, axis: int) -> list[StraightSegment]:
    """Find stretches along one axis, in the order of time.

    `velocity` (m, 3) is that of the body origin, body axes, NaN where unknown [m/s]. Roll and pitch
    are judged where attitude was measured.
    """
    period = run.period_s
    samples = 2 * max(round(MEAN_S / period / 2), 1) + 1
    rate = np.where(run.valid["angular_velocity"][:, None], run.values["angular_velocity"], np.nan)
    steady = smooth(rate, moving_average(samples, period))
    turning = np.max(np.abs(steady.value), axis=1)
    known = np.where(np.isfinite(velocity).all(axis=1, keepdims=True), velocity, 0.0)
    along = np.abs(known[:, axis])
    across = np.max(np.abs(np.delete(known, axis, axis=1)), axis=1)
    straight = (
        run.valid["command"]
        & steady.valid
        & np.isfinite(velocity).all(axis=1)
        & (turning <= TURN_RATE_RADPS)
        & (across <= np.maximum(DRIFT * along, DRIFT_MPS))
        & _level(run)
    )
    found = []
    for begin, end in stretches(straight):
        if (end - begin) * period < SHORTEST_S:
            continue
        moving = along[begin:end] > DRIFT_MPS
        drift = across[begin:end][moving] / along[begin:end][moving]
        found.append(
            StraightSegment(
                run=run.name,
                from_s=float(run.time_s[begin]),
                to_s=float(run.time_s[end - 1]),
                largest_turn_rate_radps=float(turning[begin:end].max()),
                largest_drift=float(drift.max(initial=0.0)),
            )
        )
    return found


def _level(run: RunTable) -> BoolArray:
    if "attitude" not in run.values:
        return np.ones(run.time_s.size, bool)
    tilt = np.abs(angles(run.values["attitude"])[:, :2]).max(axis=1)
    return np.asarray(run.valid["attitude"] & (tilt <= TILT_RAD))


def omitted_terms(
    packed: PackedVehicle, run: RunTable, velocity: FloatArray, thrust: FloatArray, along: int
) -> tuple[dict[str, FloatArray], BoolArray]:
    """Regressors (m,) of one axis at every row of a run, and where all of them are known (m,).

    Rotation: the parts of -(omega x v), each with its own coefficient, as the added masses of the
    other axes are not this one's. Drag: -v and -v|v|. Buoyancy: the component of "down" along the
    axis. Walls: the nearness sum (R / distance)^3 times the thrust, where the vehicle file states
    walls and the run has a position: 1 / (m + A (1 + c s)) is 1 / M - s c A / M^2 to first order.
    `velocity` (m, 3) is that of the body origin [m/s], `thrust` (m,) goes along the axis [N].
    Where something is not known a term holds zeros, and whatever is taken over such a row is not to
    be used.
    """
    omega, known = np.nan_to_num(run.values["angular_velocity"]), run.valid["angular_velocity"]
    v = velocity[:, along]
    terms = {
        name: sign * velocity[:, speed] * omega[:, rate]
        for name, speed, rate, sign in _ROTATION[along]
    }
    terms["linear drag"] = -v
    terms["quadratic drag"] = -v * np.abs(v)
    if was_measured(run, "attitude"):
        terms[WEIGHT] = down_axis(np.nan_to_num(run.values["attitude"]))[:, along]
        known = known & run.valid["attitude"]
    walls = int(read(packed.vector, "wall_count"))
    if walls and was_measured(run, "position"):
        points = read(packed.vector, "wall_point")[:walls]
        normals = read(packed.vector, "wall_normal")[:walls]
        radius = float(read(packed.vector, "wall_radius"))
        place = np.nan_to_num(run.values["position"])
        distance = np.einsum("mkj,kj->mk", place[:, None, :] - points, normals)
        near = np.sum((radius / np.maximum(distance, radius)) ** 3, axis=1)
        # a vehicle beyond a wall: the walls of the file are not those of this run
        if distance[run.valid["position"]].min(initial=np.inf) > 0.0:
            terms[WALLS] = near * thrust
            known = known & run.valid["position"]
    return terms, known
