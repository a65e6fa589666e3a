"""By what fields, names of topics and types the quantities of a log are known."""

from dataclasses import dataclass

from pipeline.records.pool_schema import Quantity

_COMMAND = r"thruster|motor|pwm|esc\b|servo_?out|rc/?_?out|actuator|propul"
_NOT_COMMAND = (
    r"state|status|feedback|telemetry|rpm|speed|temperature|current|thrust$|force|wrench|newton"
    r"|/rc/in|overrid"
)
_SHAFT = r"rpm|shaft|tacho|(thruster|motor|esc|propul)\w*/?\w*(state|status|feedback|telemetry)"
_TENSION = r"(cable|tether)[^/]*(tension|force|load)|(^|[/_])tension"
_MEASURED_THRUST = r"measured_?thrust|thrust_?measured|load_?cells?"
#: What was wanted, simulated or put together from other topics is not measured.
NOT_MEASURED = r"(^|/)sim/|reference|setpoint|set_point|target|desired|(^|/)goal|cmd_vel|(^|/)tf"

#: Velocities over the earth by the name of the topic: mavros calls them local, whatever the frame.
OVER_EARTH = r"velocity_(local|ned|enu|earth|world)|local_position/velocity$"


def _last(*words: str) -> str:
    """Return a pattern of words in the last part of a topic's name."""
    return rf"(^|[/_])({'|'.join(words)})(_[^/]*)?$"


#: What else is published of a quantity under its name, as a number that does not say what it is.
_NOT_DEPTH = _last("error", "rate", "enabled?", "output", "effort", "gain", "hold", "pid", "mode")
_NOT_VOLTAGE = _last(
    *("percent", "percentage", "temp", "temperature", "charge", "soc", "capacity", "health"),
    *("level", "state", "status", "current", "amps?", "power"),
)
_CURRENT = r"current|(^|[/_])amp(s|eres?|erage)?($|[/_])"
_NOT_CURRENT = _last(
    "velocity", "speed", "direction", "mode", "state", "mission", "waypoint", "index"
)
#: Pressures that are none of the water. mavros: /mavros/imu/static_pressure is the barometer
#: inside of the autopilot.
_NOT_WATER = r"air|baro|static_pressure|internal|inside|enclosure"


@dataclass(frozen=True)
class Rule:
    """A field that holds a quantity if the topic's name (and not the other pattern) agrees."""

    rank: int
    quantity: Quantity
    field: str
    says: str
    topic: str = ""
    but_not: str = ""
    message_type: str = ""


RULES = (
    Rule(90, "angular_velocity", "angular_velocity", "an IMU's field"),
    Rule(90, "specific_force", "linear_acceleration", "an IMU's field"),
    Rule(90, "attitude_quaternion", "orientation", "an IMU's field"),
    Rule(80, "attitude_quaternion", "pose.pose.orientation", "a pose"),
    Rule(80, "attitude_quaternion", "pose.orientation", "a pose"),
    Rule(90, "position", "point", "a point"),
    Rule(85, "position", "pose.pose.position", "a pose"),
    Rule(85, "position", "pose.position", "a pose"),
    Rule(95, "velocity", "twist.linear", "a twist of a DVL", "dvl"),
    Rule(95, "velocity", "twist.twist.linear", "a twist of a DVL", "dvl"),
    Rule(95, "velocity", "velocity", "velocity of a DVL", "dvl"),
    Rule(85, "velocity", "twist.linear", "a twist"),
    Rule(80, "velocity", "twist.twist.linear", "a twist, in the child frame"),
    Rule(75, "velocity_earth", "twist.linear", "a twist in a frame of the earth"),
    Rule(70, "velocity_earth", "twist.twist.linear", "a twist in a frame of the earth"),
    Rule(50, "angular_velocity", "twist.twist.angular", "a twist", message_type="Odometry"),
    Rule(90, "pressure", "fluid_pressure", "a pressure", but_not=_NOT_WATER),
    Rule(85, "pressure", "pressure", "its name", but_not=_NOT_WATER),
    Rule(95, "depth", "depth", "its name"),
    Rule(92, "depth", "data", "the topic's name", "depth", _NOT_DEPTH),
    Rule(80, "pressure", "data", "the topic's name", "pressure", _NOT_WATER),
    Rule(90, "voltage", "voltage", "its name"),
    Rule(80, "voltage", "data", "the topic's name", "volt|battery", _NOT_VOLTAGE),
    Rule(90, "current", "current", "its name"),
    Rule(80, "current", "data", "the topic's name", _CURRENT, _NOT_CURRENT),
    Rule(90, "cable_tension", "tension", "its name"),
    Rule(85, "cable_tension", "data", "the topic's name", _TENSION),
    Rule(85, "cable_tension", "force", "the topic's name", _TENSION),
    Rule(90, "thrust", "thrust", "the topic's name", _MEASURED_THRUST),
    Rule(85, "thrust", "data", "the topic's name", _MEASURED_THRUST),
    Rule(95, "thruster_command", "position", "joints of thrusters", _COMMAND, _NOT_COMMAND),
    Rule(90, "thruster_command", "channels", "outputs to the motors", _COMMAND, _NOT_COMMAND),
    Rule(85, "thruster_command", "command", "its name", _COMMAND, _NOT_COMMAND),
    Rule(85, "thruster_command", "commands", "its name", _COMMAND, _NOT_COMMAND),
    Rule(80, "thruster_command", "data", "the topic's name", _COMMAND, _NOT_COMMAND),
    Rule(95, "shaft_speed", "velocity", "joints of thrusters", _SHAFT),
    Rule(90, "shaft_speed", "rpm", "its name"),
    Rule(80, "shaft_speed", "data", "the topic's name", _SHAFT),
)
