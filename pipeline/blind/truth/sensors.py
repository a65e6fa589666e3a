"""What the instruments of the truth read: coloured noise, biases, wander, drop-outs.

Sizes are those of the vehicle file; the colour is the truth's own, within the stated deviation.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft, DvlFault
from pipeline.blind.truth.flight import TruthFlight
from pipeline.blind.truth.kernel_flight import CONTROL_S, SAMPLES
from pipeline.blind.truth.kernel_forces import SHARE
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Dvl, Imu, Sensor, Sensors

#: Nothing is drawn further out than this many standard uncertainties.
FURTHEST = 2.5
#: Half of the variance of the thrust's error is common to all thrusters: one rig measured them.
COMMON_SHARE = 0.5
#: Standard deviation of the background force as a share of the largest thrust of one thruster,
#: its arm for the moment [m], and its correlation times [s].
DISTURBANCE_SHARE = 0.003
DISTURBANCE_ARM_M = 0.06
DISTURBANCE_S = (0.8, 6.0)

#: Share of the noise's variance that is coloured, and its correlation time in readings.
COLOURED = 0.25
COLOUR_READINGS = 3.0


def _bounded(rng: np.random.Generator, size: int | tuple[int, ...] = 1) -> FloatArray:
    return np.asarray(np.clip(rng.standard_normal(size), -FURTHEST, FURTHEST))


def drawn(craft: Craft, known: Uncertainty, rng: np.random.Generator) -> Craft:
    """Return a healthy vehicle of this kind: every parameter off by a draw of its uncertainty."""
    n = len(craft.names)
    common, own = _bounded(rng), _bounded(rng, n)
    thrust = np.sqrt(COMMON_SHARE) * common + np.sqrt(1.0 - COMMON_SHARE) * own
    water = np.sqrt(np.maximum(1.0 + known.added_mass * _bounded(rng, 6), 0.2))
    linear = np.sqrt(np.maximum(1.0 + known.damping * _bounded(rng, 6), 0.2))
    quadratic = np.maximum(1.0 + known.damping * _bounded(rng, 6), 0.2)
    buoyancy = known.buoyancy_n * float(_bounded(rng)[0])
    return craft.changed(
        gain=craft.gain * np.maximum(1.0 + known.thrust * thrust, 0.1),
        added=craft.added * np.outer(water, water),
        linear=craft.linear * np.outer(linear, linear),
        quadratic=craft.quadratic * quadratic,
        buoyancy_n=craft.buoyancy_n + buoyancy,
        centre_g=craft.centre_g + known.centre_of_mass_m * _bounded(rng, 3),
    )


@dataclass(frozen=True)
class Weather:
    """How restless the water and how noisy the instruments are, as factors on the usual size."""

    disturbance: float = 1.0
    noise: float = 1.0


def some_weather(rng: np.random.Generator) -> Weather:
    """Draw a day: disturbances within a factor of two, sensors within 15 % of their statement."""
    return Weather(float(np.exp(rng.uniform(-0.7, 0.7))), float(rng.uniform(0.85, 1.15)))


def wander(
    rng: np.random.Generator, count: int, columns: int, tau_steps: float | FloatArray
) -> FloatArray:
    """First-order Gauss-Markov noise of unit variance (count, columns)."""
    from scipy.signal import lfilter

    keep = np.broadcast_to(np.exp(-1.0 / np.maximum(np.asarray(tau_steps, float), 1e-3)), columns)
    white = rng.standard_normal((count, columns))
    out = np.empty((count, columns))
    for k in range(columns):
        drive = white[:, k] * np.sqrt(1.0 - keep[k] ** 2)
        drive[:1] = white[:1, k]
        out[:, k] = lfilter([1.0], [1.0, -keep[k]], drive)
    return out


def background(
    craft: Craft, weather: Weather, count: int, step_s: float, rng: np.random.Generator
) -> FloatArray:
    """Force from outside at the commands' times (count, 9): NED force, body force and moment.

    Eddies shed by the hull and stirred by the thrusters: a fast and a slow part on every axis.
    """
    size = DISTURBANCE_SHARE * weather.disturbance * max(law.most_n[0] for law in craft.laws)
    out = np.zeros((count, 9))
    for tau_s in DISTURBANCE_S:
        out[:, 3:] += wander(rng, count, 6, tau_s / step_s) / np.sqrt(len(DISTURBANCE_S))
    out[:, 3:6] *= size
    # the moment's arm grows with the vehicle, its inertia with the arm
    arm = DISTURBANCE_ARM_M * float(np.clip((craft.mass_kg / 50.0) ** (1.0 / 3.0), 0.5, 2.0))
    arms = np.array([0.3 * arm, arm, arm])
    out[:, 6:] *= size * arms
    return out


@dataclass(frozen=True)
class SensorReading:
    """Readings of one instrument: claimed times, times of logging (k,), values (k, m)."""

    stamp_s: FloatArray
    logged_s: FloatArray
    values: FloatArray


Log = dict[str, SensorReading]


def noise(
    rng: np.random.Generator, count: int, columns: int, deviation: float, weather: Weather
) -> FloatArray:
    """White and coloured noise together, of the stated deviation (count, columns)."""
    white = np.sqrt(1.0 - COLOURED) * rng.standard_normal((count, columns))
    coloured = np.sqrt(COLOURED) * wander(rng, count, columns, COLOUR_READINGS)
    return np.asarray(weather.noise * deviation * (white + coloured))


def at_times(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """Values of the motion's samples at other times, on a line between."""
    place = np.clip(time_s * SAMPLES / CONTROL_S, 0.0, len(values) - 1.0)
    low = np.minimum(place.astype(int), len(values) - 2)
    part = (place - low).reshape(-1, *([1] * (values.ndim - 1)))
    return np.asarray(values[low] + part * (values[low + 1] - values[low]))


def _turn_at(flight: TruthFlight, time_s: FloatArray) -> FloatArray:
    """Rotation matrices between samples, made orthonormal to first order (k, 3, 3)."""
    mixed = at_times(flight.turn, time_s)
    return np.asarray(1.5 * mixed - 0.5 * mixed @ mixed.transpose(0, 2, 1) @ mixed)


def _times(
    flight: TruthFlight, sensor: Sensor, late_s: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the times that readings show, and those at which they are logged."""
    end = flight.time_s[-1]
    logged = np.arange(int(end * sensor.rate_hz + 1e-9) + 1) / sensor.rate_hz
    shown = logged - sensor.delay_s - late_s
    kept = (shown >= -1e-9) & (shown <= end + 1e-9)
    return np.clip(shown[kept], 0.0, end), logged[kept]


def dvl_velocity(
    flight: TruthFlight, time_s: FloatArray, dvl: Dvl, fault: DvlFault, current: FloatArray
) -> FloatArray:
    """Velocity without noise, in the axes that the DVL is believed to have, turned into body axes.

    The mount's stated turn is taken out, as whoever reads the log does.
    """
    from scipy.spatial.transform import Rotation

    ground = at_times(flight.ground, time_s)
    place = np.array(dvl.position_m) + np.array(fault.place_m)
    velocity = ground[:, :3] + np.cross(ground[:, 3:], place)
    if dvl.water_track:
        velocity = velocity - np.einsum("kji,j->ki", _turn_at(flight, time_s), current)
    stated = Rotation.from_euler("ZYX", np.radians(dvl.rotation_deg)[::-1])
    wrong = Rotation.from_euler("ZYX", np.radians(fault.turn_deg)[::-1])
    read = fault.scale * (stated * wrong).inv().apply(velocity)
    return np.asarray(stated.apply(read))


def read_all(
    flight: TruthFlight,
    craft: Craft,
    sensors: Sensors,
    *,
    weather: Weather,
    rng: np.random.Generator,
    supply: FloatArray,
) -> Log:
    """Read every instrument that the vehicle file states.

    "command", and of "imu", "dvl" (body axes), "depth", "position", "shaft_speed", "voltage" those
    on board. The IMU's columns: rate 3, specific force 3, quaternion w x y z. `weather` says how
    noisy the day is, `supply` (m,) is the share of the nominal voltage at each command; each
    instrument takes a stream of its own of `rng`.
    """
    streams = rng.spawn(6)
    end = flight.time_s[-1]
    times = np.arange(int(end * sensors.command_rate_hz + 1e-9) + 1) / sensors.command_rate_hz
    log: Log = {"command": SensorReading(times, times, held(flight.commands, times))}
    if sensors.imu is not None:
        log["imu"] = _imu(flight, craft, sensors.imu, weather, streams[0])
    if sensors.dvl is not None:
        dvl = sensors.dvl
        shown, logged = _times(flight, dvl, craft.dvl.delay_s)
        values = dvl_velocity(flight, shown, dvl, craft.dvl, craft.current)
        values = values + noise(streams[1], len(shown), 3, dvl.noise_mps, weather)
        log["dvl"] = SensorReading(logged - dvl.delay_s, logged, values)
    if sensors.depth is not None:
        depth = sensors.depth
        shown, logged = _times(flight, depth)
        values = depth_of(flight, shown, np.array(depth.position_m))
        values = values + depth.bias_m * streams[2].standard_normal()
        values = values + noise(streams[2], len(shown), 1, depth.noise_m, weather)[:, 0]
        log["depth"] = SensorReading(shown, logged, values[:, None])
    if sensors.position is not None:
        shown, logged = _times(flight, sensors.position)
        values = at_times(flight.place, shown)
        values = values + noise(streams[3], len(shown), 3, sensors.position.noise_m, weather)
        log["position"] = SensorReading(shown, logged, values)
    if sensors.shaft_speed is not None and all(law.mode != SHARE for law in craft.laws):
        shown, logged = _times(flight, sensors.shaft_speed)
        values = 60.0 * at_times(flight.shafts, shown)
        deviation = sensors.shaft_speed.noise_rpm
        values = values + noise(streams[4], len(shown), values.shape[1], deviation, weather)
        log["shaft_speed"] = SensorReading(shown, logged, values)
    if sensors.voltage is not None:
        shown, logged = _times(flight, sensors.voltage)
        values = sensors.voltage.nominal_v * held(supply[:, None], shown)
        values = values + noise(streams[5], len(shown), 1, sensors.voltage.noise_v, weather)
        log["voltage"] = SensorReading(shown, logged, values)
    return log


def held(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """Value of the last command at or before a time (k, n)."""
    index = np.floor(time_s / CONTROL_S + 1e-6).astype(int)
    return np.asarray(values[np.clip(index, 0, len(values) - 1)])


def depth_of(flight: TruthFlight, time_s: FloatArray, place: FloatArray) -> FloatArray:
    """Depth of a place of the body (k,) [m]."""
    down = flight.place[:, 2] + flight.turn[:, 2] @ place
    return at_times(down, time_s)


def _imu(
    flight: TruthFlight, craft: Craft, imu: Imu, weather: Weather, rng: np.random.Generator
) -> SensorReading:
    from scipy.spatial.transform import Rotation

    shown, logged = _times(flight, imu)
    ground, rate = flight.ground, flight.rate
    spin, gain = ground[:, 3:], rate[:, 3:]
    place = np.array(imu.position_m)
    force = rate[:, :3] + np.cross(spin, ground[:, :3]) + np.cross(gain, place)
    force += np.cross(spin, np.cross(spin, place)) - craft.gravity * flight.turn[:, 2]
    count = len(shown)
    force = at_times(force, shown)
    spin = at_times(spin, shown)
    # biases of a run, which creep by a tenth of their size
    creep = wander(rng, count, 6, 60.0 * imu.rate_hz)
    bias = rng.standard_normal(6) + 0.1 * creep
    spin = spin + imu.rate_bias_radps * bias[:, :3]
    spin = spin + noise(rng, count, 3, imu.rate_noise_radps, weather)
    force = force + imu.force_bias_mps2 * bias[:, 3:]
    force = force + noise(rng, count, 3, imu.force_noise_mps2, weather)
    slow = imu.attitude_wander_rad * wander(rng, count, 3, imu.attitude_wander_s * imu.rate_hz)
    error = slow + noise(rng, count, 3, imu.attitude_noise_rad, weather)
    turn = Rotation.from_matrix(_turn_at(flight, shown)) * Rotation.from_rotvec(error)
    x, y, z, w = turn.as_quat().T
    return SensorReading(shown, logged, np.column_stack([spin, force, w, x, y, z]))
