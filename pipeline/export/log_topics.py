"""Which topic and message carries which quantity of a run, in which field, unit and frame.

Body axes are x forward, y starboard, z down; earth axes are north, east, down. REP 103 of ROS has
the body forward, left, up in an earth of east, north, up, so the frames are named otherwise here:
names that end in ``_frd`` are forward, right, down, and ``ned`` is the earth.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.export.cdr import Filling
from pipeline.types import FloatArray, IntArray

if TYPE_CHECKING:  # the simulator brings the compiler along; writing a log does not need it
    from pipeline.simulate.run import Trajectory
    from pipeline.simulate.sensors import Channel, Log

BODY_FRAME = "base_link_frd"
EARTH_FRAME = "ned"
#: Standard atmosphere at the surface. [Pa]
ATMOSPHERIC_PRESSURE_PA = 101325.0
#: What is not measured, as sensor_msgs/BatteryState defines it.
_NOT_MEASURED = float("nan")
_NO_BATTERY = ("temperature", "current", "charge", "capacity", "design_capacity", "percentage")
#: builtin_interfaces/Time holds the seconds in a signed 32-bit integer.
_LAST_NS = (2**31 - 1) * 1_000_000_000
_RATE = ("p_radps", "q_radps", "r_radps")
_FORCE = ("fx_mps2", "fy_mps2", "fz_mps2")
#: In the order of geometry_msgs/Quaternion.
_ATTITUDE = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class Topic:
    """A topic with all its messages.

    `valid_s`, `logged_s` (k,) are times of the run; `values` fills the fields as `serialise` takes
    them, but for the stamp; `meaning` is written to the log beside the topic.
    """

    name: str
    message_type: str
    meaning: str
    valid_s: FloatArray
    logged_s: FloatArray
    values: Mapping[str, Filling]

    def rows(self, rows: IntArray, start_time_ns: int) -> dict[str, Filling]:
        """Return what fills some of the messages, stamps included."""
        seconds, nanoseconds = np.divmod(
            nanoseconds_of_run(self.valid_s[rows], start_time_ns, self.name), 1_000_000_000
        )
        chosen: dict[str, Filling] = {
            path: filling[rows] if isinstance(filling, np.ndarray) else filling
            for path, filling in self.values.items()
        }
        return chosen | {"header.stamp.sec": seconds, "header.stamp.nanosec": nanoseconds}


@dataclass(frozen=True)
class WaterConstants:
    """What turns depth into pressure."""

    density_kgpm3: float
    gravity_mps2: float


def nanoseconds_of_run(time_s: FloatArray, start_time_ns: int, topic: str) -> IntArray:
    """Convert times of a run to nanoseconds since 1970, rounded.

    Raises
    ------
    CannotComputeError
        For a time that a ROS 2 stamp cannot hold, or that is not a number.

    >>> nanoseconds_of_run(np.array([0.3 - 0.1]), 5, "/imu/data").tolist()
    [200000005]
    """
    if not np.isfinite(time_s).all():
        raise CannotComputeError(f"{topic}: a time of the run is not a number")
    time_ns = np.rint(time_s * 1e9) + start_time_ns
    if time_s.size and (time_ns.min() < 0 or time_ns.max() > _LAST_NS):
        raise CannotComputeError(
            f"{topic}: with a start at {start_time_ns} ns the run lies outside what a ROS 2 stamp "
            "holds, the years 1970 to 2038; give another start time"
        )
    return np.asarray(np.rint(time_s * 1e9).astype(np.int64) + start_time_ns)


def topics_of_log(log: "Log", water: WaterConstants, prefix: str = "") -> list[Topic]:
    """Topics of a sensor log; `prefix` ``/sim`` gives ``/sim/imu/data``.

    Raises
    ------
    CannotComputeError
        For a channel that has no topic, lacks a column, holds arrays of unequal length or a value
        that is not a finite number.
    """
    unknown = set(log) - set(_TOPICS)
    if unknown:
        raise CannotComputeError(
            f"no topic is defined for {', '.join(sorted(unknown))}; the channels of a log are "
            f"{', '.join(_TOPICS)}"
        )
    found = []
    for channel, (name, message, meaning, fill) in _TOPICS.items():
        if channel in log:
            one = log[channel]
            values = fill(one, water)
            topic = Topic(f"{prefix}{name}", message, meaning, one.valid_s, one.logged_s, values)
            found.append(checked(topic))
    return found


def topics_of_truth(
    truth: "Trajectory", thruster_names: tuple[str, ...], prefix: str
) -> list[Topic]:
    """Topics of the true motion and of the thrusters' thrust, at every step of the run.

    Raises
    ------
    CannotComputeError
        Where the trajectory has another number of thrusters than there are names, or holds a value
        that is not a finite number.
    """
    if truth.thrust_n.shape[1] != len(thruster_names):
        raise CannotComputeError(
            f"the run has the thrust of {truth.thrust_n.shape[1]} thrusters, but the names of "
            f"{len(thruster_names)}"
        )
    odometry, thrust = f"{prefix}/odometry", f"{prefix}/thrusters/thrust"
    motion: dict[str, Filling] = {
        "header.frame_id": EARTH_FRAME,
        "child_frame_id": BODY_FRAME,
        "pose.pose.position": truth.position_ned_m,
        "pose.pose.orientation": truth.quaternion[:, [1, 2, 3, 0]],
        "twist.twist.linear": truth.nu[:, :3],
        "twist.twist.angular": truth.nu[:, 3:],
    }
    effort: dict[str, Filling] = {"name": thruster_names, "effort": truth.thrust_n}
    return [
        step_topic(
            odometry,
            "nav_msgs/msg/Odometry",
            "true motion: pose.pose body to NED [m], twist.twist of the body origin over "
            "ground, body axes [m/s, rad/s]",
            truth.time_s,
            motion,
        ),
        step_topic(
            thrust,
            "sensor_msgs/msg/JointState",
            "effort: true thrust of each thruster, positive along its direction [N]",
            truth.time_s,
            effort,
        ),
    ]


def step_topic(
    name: str, kind: str, meaning: str, time_s: FloatArray, values: Mapping[str, Filling]
) -> Topic:
    """Return a topic of what a simulation knows at the steps of a run; raises as `checked`."""
    return checked(Topic(name, kind, meaning, time_s, time_s, values))


def _depth_pa(channel: "Channel", water: WaterConstants) -> FloatArray:
    depth_m = _columns(channel, "depth", ("depth_m",))[:, 0]
    return np.asarray(ATMOSPHERIC_PRESSURE_PA + water.density_kgpm3 * water.gravity_mps2 * depth_m)


_Fill = Callable[["Channel", WaterConstants], dict[str, Filling]]
#: Channel of a log -> topic, message, meaning, and what fills the message's fields.
_TOPICS: dict[str, tuple[str, str, str, _Fill]] = {
    "command": (
        "/thrusters/command",
        "sensor_msgs/msg/JointState",
        "position: commanded code of each thruster [1]",
        lambda channel, _: {"name": channel.columns, "position": channel.values},
    ),
    "imu": (
        "/imu/data",
        "sensor_msgs/msg/Imu",
        (
            "orientation: body to NED; angular_velocity [rad/s] and linear_acceleration, which is "
            "the specific force [m/s^2], in body axes at the place of the IMU"
        ),
        lambda channel, _: {
            "header.frame_id": "imu_frd",
            "orientation": _columns(channel, "imu", _ATTITUDE),
            "angular_velocity": _columns(channel, "imu", _RATE),
            "linear_acceleration": _columns(channel, "imu", _FORCE),
        },
    ),
    "dvl": (
        "/dvl/velocity",
        "geometry_msgs/msg/TwistStamped",
        (
            "twist.linear: velocity in the DVL's own axes at its place [m/s]; twist.angular: not "
            "measured"
        ),
        lambda channel, _: {
            "header.frame_id": "dvl_frd",
            "twist.linear": _columns(channel, "dvl", ("vx_mps", "vy_mps", "vz_mps")),
        },
    ),
    "depth": (
        "/depth",
        "sensor_msgs/msg/FluidPressure",
        "fluid_pressure: 101325 Pa + density x gravity x depth of the sensor [Pa]",
        lambda channel, water: {
            "header.frame_id": "depth_frd",
            "fluid_pressure": _depth_pa(channel, water),
        },
    ),
    "position": (
        "/position",
        "geometry_msgs/msg/PointStamped",
        "point: north, east, down of the body origin [m]",
        lambda channel, _: {
            "header.frame_id": EARTH_FRAME,
            "point": _columns(channel, "position", ("north_m", "east_m", "down_m")),
        },
    ),
    "shaft_speed": (
        "/thrusters/state",
        "sensor_msgs/msg/JointState",
        "velocity: shaft speed of each thruster [rad/s]",
        lambda channel, _: {"name": channel.columns, "velocity": channel.values * (np.pi / 30.0)},
    ),
    "voltage": (
        "/battery",
        "sensor_msgs/msg/BatteryState",
        "voltage: supply at the thrusters, single precision [V]",
        lambda channel, _: {
            "voltage": _columns(channel, "voltage", ("supply_v",))[:, 0],
            "present": 1.0,
            **dict.fromkeys(_NO_BATTERY, _NOT_MEASURED),
        },
    ),
}


def checked(topic: Topic) -> Topic:
    """Return a topic that can be written.

    Raises
    ------
    CannotComputeError
        For what would become a broken log: unequal lengths, numbers that are none.
    """
    count = topic.valid_s.size
    if topic.logged_s.shape != (count,):
        raise CannotComputeError(
            f"{topic.name}: {count} times of validity and {topic.logged_s.size} times of logging"
        )
    for path, filling in topic.values.items():
        if not isinstance(filling, np.ndarray):
            continue
        if len(filling) != count:
            raise CannotComputeError(
                f"{topic.name}: {path} has {len(filling)} readings and {count} times"
            )
        if not np.isfinite(filling).all():
            row = int(np.argwhere(~np.isfinite(filling))[0][0])
            raise CannotComputeError(
                f"{topic.name}: {path} is not a number at {topic.valid_s[row]:.3f} s of the run"
            )
    return topic


def _columns(channel: "Channel", what: str, wanted: tuple[str, ...]) -> FloatArray:
    missing = set(wanted) - set(channel.columns)
    if missing:
        raise CannotComputeError(
            f"the {what} channel has no column {', '.join(sorted(missing))}; it has "
            f"{', '.join(channel.columns)}"
        )
    return channel.values[:, [channel.columns.index(name) for name in wanted]]
