"""What the sensors on board would have logged of a simulated run.

Every reading has the time it is valid for and the time it was logged: they differ by the sensor's
delay. Noise comes from one seed; the same seed, vehicle and commands give the same log bit for bit.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.simulate.kernel_alone import fill_directions
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Depth, Dvl, Imu, Position, Sensor, Sensors

NED_DOWN = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Channel:
    """Readings of one sensor: `valid_s`, `logged_s` (k,), `values` (k, m), `columns` m names.

    `valid_s` is the time that the sensor claims, its stated delay before `logged_s`; an unstated
    one (`dvl_delay`) is not in it.
    """

    columns: tuple[str, ...]
    valid_s: FloatArray
    logged_s: FloatArray
    values: FloatArray


Log = dict[str, Channel]


def measure(
    trajectory: Trajectory,
    packed: PackedVehicle,
    sensors: Sensors,
    *,
    vector: FloatArray | None = None,
    seed: int = 0,
) -> Log:
    """Sample a run by the sensors of the vehicle.

    `vector` is the true one: its ``dvl_*`` and supply slots make the readings wrong. Each sensor
    has a stream of noise of its own from `seed`, so that adding one changes no other. Returns
    "command", and of "imu", "dvl", "depth", "position", "shaft_speed", "voltage" those on board.
    """
    true = packed.vector if vector is None else vector
    streams = dict(
        zip(
            ("imu", "dvl", "depth", "position", "shaft_speed", "voltage"),
            np.random.default_rng(seed).spawn(6),
            strict=True,
        )
    )
    motion = _Motion(trajectory)
    log: Log = {"command": _command(motion, packed, sensors.command_rate_hz)}
    if sensors.imu is not None:
        log["imu"] = _imu(motion, sensors.imu, packed.context.gravity_mps2, streams["imu"])
    if sensors.dvl is not None:
        log["dvl"] = _dvl(motion, sensors.dvl, true, streams["dvl"])
    if sensors.depth is not None:
        log["depth"] = _depth(motion, sensors.depth, streams["depth"])
    if sensors.position is not None:
        log["position"] = _position(motion, sensors.position, streams["position"])
    if sensors.shaft_speed is not None and packed.shaft_tables is not None:
        log["shaft_speed"] = _shaft_speed(
            motion, packed, true, sensors.shaft_speed, streams["shaft_speed"]
        )
    if sensors.voltage is not None:
        noise = sensors.voltage.noise_v
        valid = motion.times(sensors.voltage)
        share = _supply(motion.command(valid), packed, true)
        values = sensors.voltage.nominal_v * share
        values += noise * streams["voltage"].standard_normal(valid.size)
        log["voltage"] = _channel(("supply_v",), valid, values[:, None], sensors.voltage)
    return log


class _Motion:
    """Trajectory between its samples: linear, slerp for attitude."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory
        self._turn = Slerp(
            trajectory.time_s, Rotation.from_quat(trajectory.quaternion[:, [1, 2, 3, 0]])
        )

    def times(self, sensor: Sensor, extra_delay_s: float = 0.0) -> FloatArray:
        """Return the times of the motion that readings show; none lies outside the run."""
        begin, end = self.trajectory.time_s[0], self.trajectory.time_s[-1]
        count = int(np.floor((end - begin) * sensor.rate_hz + 1e-9)) + 1
        logged = begin + np.arange(count) / sensor.rate_hz
        valid = logged - sensor.delay_s - extra_delay_s
        inside = (valid >= begin - 1e-9) & (valid <= end + 1e-9)
        # round-off must not ask for the attitude outside the run
        return np.asarray(np.clip(valid[inside], begin, end))

    def attitude(self, time_s: FloatArray) -> Rotation:
        return self._turn(time_s)

    def nu(self, time_s: FloatArray) -> FloatArray:
        return self._columns(self.trajectory.nu, time_s)

    def nu_dot(self, time_s: FloatArray) -> FloatArray:
        return self._columns(self.trajectory.nu_dot, time_s)

    def position(self, time_s: FloatArray) -> FloatArray:
        return self._columns(self.trajectory.position_ned_m, time_s)

    def command(self, time_s: FloatArray) -> FloatArray:
        """Codes in force at a time: those of the last sample at or before it."""
        index = np.searchsorted(self.trajectory.time_s, time_s + 1e-9, side="right") - 1
        return self.trajectory.command[np.clip(index, 0, None)]

    def actuator(self, time_s: FloatArray) -> FloatArray:
        return self._columns(self.trajectory.actuator, time_s)

    def _columns(self, values: FloatArray, time_s: FloatArray) -> FloatArray:
        # the step of the simulation is far below every sensor's period: a line is enough
        grid = self.trajectory.time_s
        return np.stack([np.interp(time_s, grid, column) for column in values.T], axis=1)


def _channel(
    columns: tuple[str, ...],
    valid_s: FloatArray,
    values: FloatArray,
    sensor: Sensor,
) -> Channel:
    return Channel(columns, valid_s, valid_s + sensor.delay_s, values)


def _command(motion: _Motion, packed: PackedVehicle, rate_hz: float) -> Channel:
    begin, end = motion.trajectory.time_s[[0, -1]]
    times = begin + np.arange(int(np.floor((end - begin) * rate_hz + 1e-9)) + 1) / rate_hz
    return Channel(packed.thruster_names, times, times, motion.command(times))


def _imu(motion: _Motion, imu: Imu, gravity_mps2: float, generator: np.random.Generator) -> Channel:
    """Angular rate, specific force at the sensor's place, attitude with its slow error."""
    time_s = motion.times(imu)
    nu, nu_dot, turn = motion.nu(time_s), motion.nu_dot(time_s), motion.attitude(time_s)
    velocity, rate = nu[:, :3], nu[:, 3:]
    place = np.array(imu.position_m)
    acceleration = (
        nu_dot[:, :3]
        + np.cross(rate, velocity)
        + np.cross(nu_dot[:, 3:], place)
        + np.cross(rate, np.cross(rate, place))
    )
    force = acceleration - turn.inv().apply(gravity_mps2 * NED_DOWN)
    noise = generator.standard_normal((time_s.size, 9))
    bias = generator.standard_normal(6)
    rate = rate + imu.rate_bias_radps * bias[:3] + imu.rate_noise_radps * noise[:, :3]
    force = force + imu.force_bias_mps2 * bias[3:] + imu.force_noise_mps2 * noise[:, 3:6]
    wander = _gauss_markov(
        generator, time_s.size, imu.attitude_wander_rad, imu.attitude_wander_s * imu.rate_hz
    )
    error = Rotation.from_rotvec(wander + imu.attitude_noise_rad * noise[:, 6:])
    x, y, z, w = (turn * error).as_quat().T
    return _channel(
        (
            *("p_radps", "q_radps", "r_radps"),
            *("fx_mps2", "fy_mps2", "fz_mps2"),
            *("qw", "qx", "qy", "qz"),
        ),
        time_s,
        np.column_stack([rate, force, w, x, y, z]),
        imu,
    )


def _gauss_markov(
    generator: np.random.Generator, count: int, deviation: float, samples: float
) -> FloatArray:
    """First-order Gauss-Markov process (count, 3) with a correlation length in samples."""
    keep = float(np.exp(-1.0 / samples))
    white = generator.standard_normal((count, 3)) * np.sqrt(1.0 - keep**2)
    white[:1] = generator.standard_normal(3)
    # a loop of a few milliseconds: the filters of scipy.signal take a second to import
    x = y = z = 0.0
    rows = []
    for a, b, c in white.tolist():
        x, y, z = a + keep * x, b + keep * y, c + keep * z
        rows.append((x, y, z))
    return np.asarray(deviation * np.array(rows).reshape(-1, 3))


def _dvl(motion: _Motion, dvl: Dvl, true: FloatArray, generator: np.random.Generator) -> Channel:
    """Velocity in the DVL's own axes as they are stated to be; the true slots make it wrong."""
    late = float(read(true, "dvl_delay"))
    time_s = motion.times(dvl, late)
    nu = motion.nu(time_s)
    place = np.array(dvl.position_m) + read(true, "dvl_lever_arm")
    velocity = nu[:, :3] + np.cross(nu[:, 3:], place)
    if dvl.water_track:
        velocity = velocity - motion.attitude(time_s).inv().apply(read(true, "current"))
    stated = Rotation.from_euler("ZYX", np.radians(dvl.rotation_deg)[::-1])
    error = Rotation.from_euler("ZYX", read(true, "dvl_rotation")[::-1])
    values = dvl.scale * float(read(true, "dvl_scale")) * (stated * error).inv().apply(velocity)
    values += dvl.noise_mps * generator.standard_normal(values.shape)
    # the log knows the stated delay only: the reading claims a time that is wrong by the rest
    return _channel(("vx_mps", "vy_mps", "vz_mps"), time_s + late, values, dvl)


def _depth(motion: _Motion, depth: Depth, generator: np.random.Generator) -> Channel:
    time_s = motion.times(depth)
    offset = motion.attitude(time_s).apply(np.array(depth.position_m))[:, 2]
    bias = depth.bias_m * generator.standard_normal()
    values = motion.position(time_s)[:, 2] + offset + bias
    values += depth.noise_m * generator.standard_normal(time_s.size)
    return _channel(("depth_m",), time_s, values[:, None], depth)


def _position(motion: _Motion, position: Position, generator: np.random.Generator) -> Channel:
    time_s = motion.times(position)
    values = motion.position(time_s)
    values = values + position.noise_m * generator.standard_normal(values.shape)
    return _channel(("north_m", "east_m", "down_m"), time_s, values, position)


def _shaft_speed(
    motion: _Motion,
    packed: PackedVehicle,
    true: FloatArray,
    sensor: Sensor,
    generator: np.random.Generator,
) -> Channel:
    """Shaft speeds [rpm]: the state where the balance is solved in time, else the bench's table."""
    time_s = motion.times(sensor)
    count = len(packed.thruster_names)
    actuator = motion.actuator(time_s)
    kinds = read(true, "thruster_type")[:count].astype(int)
    in_time = read(true, "rotor_inertia")[:count] > 0
    nu = motion.nu(time_s)
    water = motion.attitude(time_s).inv().apply(read(true, "current"))
    directions = np.zeros((MOST_THRUSTERS, 3))
    fill_directions(true, directions)
    rpm = np.zeros((time_s.size, count))
    for i in range(count):
        if in_time[i]:
            rpm[:, i] = 60.0 * actuator[:, i]
            continue
        place = read(true, "thruster_position")[i]
        axis = directions[i]
        along = (nu[:, :3] - water + np.cross(nu[:, 3:], place)) @ axis
        along = np.maximum(along * np.sign(actuator[:, i]), 0.0)
        rpm[:, i] = np.sign(actuator[:, i]) * packed.shaft_speed(
            int(kinds[i]), np.abs(actuator[:, i]), along * read(true, "inflow_fraction")[i]
        )
    noise = getattr(sensor, "noise_rpm", 0.0)
    rpm += noise * generator.standard_normal(rpm.shape)
    return _channel(packed.thruster_names, time_s, rpm, sensor)


def _supply(command: FloatArray, packed: PackedVehicle, true: FloatArray) -> FloatArray:
    """Supply voltage over its nominal value, (k,)."""
    count = len(packed.thruster_names)
    load = np.mean((command / read(true, "code_max")[:count]) ** 2, axis=1) if count else 0.0
    return np.asarray(1.0 - read(true, "supply_drop") - read(true, "load_drop") * load)
