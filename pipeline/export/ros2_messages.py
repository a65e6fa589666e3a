"""The ROS 2 message definitions that a log is written with, as ``.msg`` text.

Fields, their order and their constants are those of common_interfaces and rcl_interfaces in ROS 2
Humble, unchanged since for the messages used here; only the comments are left out.
"""

import re
from dataclasses import dataclass

_SEPARATOR = "=" * 80
_ARRAY = re.compile(r"^(?P<base>[A-Za-z0-9_/]+)(?P<array>\[(?P<length>[0-9]*)\])?$")

_DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation",
    "geometry_msgs/PoseWithCovariance": "Pose pose\nfloat64[36] covariance",
    "geometry_msgs/Twist": "Vector3 linear\nVector3 angular",
    "geometry_msgs/TwistWithCovariance": "Twist twist\nfloat64[36] covariance",
    "geometry_msgs/TwistStamped": "std_msgs/Header header\nTwist twist",
    "geometry_msgs/PointStamped": "std_msgs/Header header\nPoint point",
    "geometry_msgs/Wrench": "Vector3 force\nVector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\nWrench wrench",
    "nav_msgs/Odometry": (
        "std_msgs/Header header\n"
        "string child_frame_id\n"
        "geometry_msgs/PoseWithCovariance pose\n"
        "geometry_msgs/TwistWithCovariance twist"
    ),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\n"
        "string[] name\n"
        "float64[] position\n"
        "float64[] velocity\n"
        "float64[] effort"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header\n"
        "geometry_msgs/Quaternion orientation\n"
        "float64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\n"
        "float64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\n"
        "float64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/FluidPressure": (
        "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance"
    ),
    "sensor_msgs/BatteryState": (
        "uint8 POWER_SUPPLY_STATUS_UNKNOWN = 0\n"
        "uint8 POWER_SUPPLY_STATUS_CHARGING = 1\n"
        "uint8 POWER_SUPPLY_STATUS_DISCHARGING = 2\n"
        "uint8 POWER_SUPPLY_STATUS_NOT_CHARGING = 3\n"
        "uint8 POWER_SUPPLY_STATUS_FULL = 4\n"
        "uint8 POWER_SUPPLY_HEALTH_UNKNOWN = 0\n"
        "uint8 POWER_SUPPLY_HEALTH_GOOD = 1\n"
        "uint8 POWER_SUPPLY_HEALTH_OVERHEAT = 2\n"
        "uint8 POWER_SUPPLY_HEALTH_DEAD = 3\n"
        "uint8 POWER_SUPPLY_HEALTH_OVERVOLTAGE = 4\n"
        "uint8 POWER_SUPPLY_HEALTH_UNSPEC_FAILURE = 5\n"
        "uint8 POWER_SUPPLY_HEALTH_COLD = 6\n"
        "uint8 POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE = 7\n"
        "uint8 POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE = 8\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_UNKNOWN = 0\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_NIMH = 1\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_LION = 2\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_LIPO = 3\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_LIFE = 4\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_NICD = 5\n"
        "uint8 POWER_SUPPLY_TECHNOLOGY_LIMN = 6\n"
        "std_msgs/Header header\n"
        "float32 voltage\n"
        "float32 temperature\n"
        "float32 current\n"
        "float32 charge\n"
        "float32 capacity\n"
        "float32 design_capacity\n"
        "float32 percentage\n"
        "uint8 power_supply_status\n"
        "uint8 power_supply_health\n"
        "uint8 power_supply_technology\n"
        "bool present\n"
        "float32[] cell_voltage\n"
        "float32[] cell_temperature\n"
        "string location\n"
        "string serial_number"
    ),
}


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    `type` is a primitive's name or a message's full one; `length` is None for a single value, 0
    for a sequence of any length, else the length of a fixed array.
    """

    name: str
    type: str
    length: int | None


def fields(message_type: str) -> tuple[MessageField, ...]:
    """Fields of a message in the order in which they are serialised; constants left out.

    Parameters
    ----------
    message_type : str
        ``package/Name`` or ``package/msg/Name``.

    Raises
    ------
    KeyError
        For a message that is not defined here.

    Examples
    --------
    >>> [field.name for field in fields("sensor_msgs/msg/FluidPressure")]
    ['header', 'fluid_pressure', 'variance']
    """
    name = _short(message_type)
    found = []
    for line in _DEFINITIONS[name].splitlines():
        if "=" in line:
            continue
        kind, field = line.split()[:2]
        match = _ARRAY.match(kind)
        if match is None:
            raise ValueError(f"{name}: the line {line!r} is not a field")
        base = _resolve(match["base"], name)
        length = None if match["array"] is None else int(match["length"] or 0)
        found.append(MessageField(field, base, length))
    return tuple(found)


def is_message(field_type: str) -> bool:
    """Whether a field's type is a message, not a primitive.

    >>> is_message("geometry_msgs/Vector3"), is_message("float64")
    (True, False)
    """
    return field_type in _DEFINITIONS


def schema_text(message_type: str) -> str:
    """Definition with those of all messages in it appended, as MCAP's ``ros2msg`` wants it.

    Parameters
    ----------
    message_type : str
        ``package/Name`` or ``package/msg/Name``.

    Examples
    --------
    >>> print(schema_text("std_msgs/msg/Header"))  # doctest: +ELLIPSIS
    builtin_interfaces/Time stamp
    string frame_id
    =====...
    MSG: builtin_interfaces/Time
    int32 sec
    uint32 nanosec
    <BLANKLINE>
    """
    needed = _with_parts(_short(message_type))
    first, *others = (_DEFINITIONS[name] + "\n" for name in needed)
    parts = [
        f"{_SEPARATOR}\nMSG: {name}\n{text}" for name, text in zip(needed[1:], others, strict=True)
    ]
    return "".join([first, *parts])


def _with_parts(name: str) -> list[str]:
    """Return the message and every message in it, each once, in the order of their first use."""
    needed = [name]
    for field in fields(name):
        if is_message(field.type):
            needed += [part for part in _with_parts(field.type) if part not in needed]
    return needed


def _short(message_type: str) -> str:
    return message_type.replace("/msg/", "/")


def _resolve(base: str, inside: str) -> str:
    """Full name of a field's type: a bare message name belongs to the package it is used in."""
    same_package = f"{inside.split('/', maxsplit=1)[0]}/{base}"
    return same_package if same_package in _DEFINITIONS else base
