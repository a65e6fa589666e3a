"""Which topic carries which quantity, where the vehicle file does not say it.

A rule looks at the fields of a topic's first message (so it serves every encoding), at its name and
at its type. Of several topics that fit, the rule of the highest rank decides, then the number of
messages. What was chosen, and what else would have fitted, is told.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.ingest.mcap_types import parse_path
from pipeline.ingest.pool_run_codec import numbers_below, value_at
from pipeline.ingest.pool_run_frames import is_earth
from pipeline.ingest.pool_run_plan import NotThereError, Plan, TopicFound, plan_channel
from pipeline.vehicle.pool_schema import COMPONENTS, PoolChannel, Quantity

_COMMAND = r"thruster|motor|pwm|esc\b|servo_?out|rc/?_?out|actuator|propul"
_NOT_COMMAND = (
    r"state|status|feedback|telemetry|rpm|speed|temperature|current|thrust$|/rc/in|overrid"
)
_SHAFT = r"rpm|shaft|tacho|(thruster|motor|esc|propul)\w*/?\w*(state|status|feedback|telemetry)"
#: What was wanted, simulated or put together from other topics is not measured.
_NOT_MEASURED = r"(^|/)sim/|reference|setpoint|set_point|target|desired|(^|/)goal|cmd_vel|(^|/)tf"


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


_RULES = (
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
    Rule(95, "depth", "depth", "its name"),
    Rule(92, "depth", "data", "the topic's name", "depth", _NOT_DEPTH),
    Rule(80, "pressure", "data", "the topic's name", "pressure", _NOT_WATER),
    Rule(90, "voltage", "voltage", "its name"),
    Rule(80, "voltage", "data", "the topic's name", "volt|battery", _NOT_VOLTAGE),
    Rule(90, "current", "current", "its name"),
    Rule(80, "current", "data", "the topic's name", _CURRENT, _NOT_CURRENT),
    Rule(95, "thruster_command", "position", "joints of thrusters", _COMMAND, _NOT_COMMAND),
    Rule(90, "thruster_command", "channels", "outputs to the motors", _COMMAND, _NOT_COMMAND),
    Rule(85, "thruster_command", "command", "its name", _COMMAND, _NOT_COMMAND),
    Rule(85, "thruster_command", "commands", "its name", _COMMAND, _NOT_COMMAND),
    Rule(80, "thruster_command", "data", "the topic's name", _COMMAND, _NOT_COMMAND),
    Rule(95, "shaft_speed", "velocity", "joints of thrusters", _SHAFT),
    Rule(90, "shaft_speed", "rpm", "its name"),
    Rule(80, "shaft_speed", "data", "the topic's name", _SHAFT),
)
#: A quantity is not looked for where one that gives the same is stated or found.
_SAME = (
    ("attitude_quaternion", "attitude_euler"),
    ("depth", "pressure"),
    ("velocity", "velocity_earth"),
)


@dataclass(frozen=True)
class Chosen:
    """Plans of the defaults, and what a person should know of the choice."""

    plans: tuple[Plan, ...]
    notes: tuple[str, ...]


def choose_by_default(
    topics: Sequence[TopicFound],
    stated: Sequence[str],
    thrusters: Sequence[str],
    ignored: Sequence[str] = (),
) -> Chosen:
    """Find the quantities that the vehicle file does not state.

    Parameters
    ----------
    topics : sequence of TopicFound
        Of the log.
    stated : sequence of str
        Quantities that the vehicle file states.
    thrusters : sequence of str
        Names, in the order of the vehicle file.
    ignored : sequence of str
        Topics to leave alone.

    Returns
    -------
    Chosen
        At most one plan a quantity, except that thrusters may have a topic each.
    """
    plans: list[Plan] = []
    notes: list[str] = []
    taken = set(stated)
    for first, second in _SAME:
        if taken & {first, second}:
            taken |= {first, second}
    open_topics = [
        topic
        for topic in topics
        if topic.probe is not None
        and topic.name not in ignored
        and not re.search(_NOT_MEASURED, topic.name, re.IGNORECASE)
    ]
    candidates: dict[str, list[tuple[tuple[int, int], TopicFound, Rule]]] = {}
    for topic in open_topics:
        for rule in _RULES:
            if rule.quantity not in taken and _fits(rule, topic):
                candidates.setdefault(rule.quantity, []).append(
                    ((rule.rank, topic.messages), topic, rule)
                )
    notes += _without_attitude(open_topics, taken | set(candidates))
    for first, second in _SAME:
        if first in candidates and second in candidates:
            weaker = min((first, second), key=lambda name: max(c[0] for c in candidates[name]))
            del candidates[weaker]
    for quantity, found in candidates.items():
        found.sort(key=lambda one: (one[0], one[1].name), reverse=True)
        new, said = _first_that_fits(found, thrusters)
        plans += new
        notes += said
        if quantity in ("thruster_command", "shaft_speed") and not new:
            grouped, said = _one_topic_each(found, thrusters)
            plans += grouped
            notes += said
    return Chosen(tuple(plans), tuple(notes))


def _fits(rule: Rule, topic: TopicFound) -> bool:
    if rule.message_type and not topic.message_type.endswith(rule.message_type):
        return False
    if rule.topic and not re.search(rule.topic, topic.name, re.IGNORECASE):
        return False
    over_earth = {"velocity": False, "velocity_earth": True}.get(rule.quantity)
    if over_earth is not None and _is_over_earth(topic) != over_earth:
        return False
    if rule.but_not and re.search(rule.but_not, topic.name, re.IGNORECASE):
        return False
    numbers = numbers_below(topic.probe, parse_path(rule.field)[0])
    count = COMPONENTS[rule.quantity]
    if not numbers or (count is not None and len(numbers) != count):
        return False
    return not _is_absent(rule, topic)


def _is_over_earth(topic: TopicFound) -> bool:
    """Tell whether a twist is in the axes of the earth.

    A stamped twist is in the frame of its header (mavros: velocity_local in "map", velocity_body in
    "base_link"); that of nav_msgs/Odometry in its child frame, whatever the frame of its pose.
    """
    return value_at(topic.probe, ("child_frame_id",)) is None and is_earth(topic.frame)


def _is_absent(rule: Rule, topic: TopicFound) -> bool:
    """Whether the message itself says that it does not have the quantity.

    sensor_msgs/Imu: the first element of the covariance is -1 where there is no estimate;
    BatteryState: not a number where it is not measured. An orientation of four zeros is none.
    """
    covariance = value_at(topic.probe, (f"{rule.field}_covariance", 0))
    if covariance == -1:
        return True
    values = [value_at(topic.probe, path) for path in numbers_below(topic.probe, (rule.field,))]
    if rule.quantity in ("voltage", "current"):
        return any(value != value for value in values)  # noqa: PLR0124  not a number
    if rule.quantity == "attitude_quaternion":
        return bool(values) and not any(values)
    return False


def _without_attitude(topics: Sequence[TopicFound], found: set[str]) -> list[str]:
    """Say which IMUs give no attitude because their first one is four zeros."""
    if found & {"attitude_quaternion", "attitude_euler"}:
        return []
    return [
        f"no attitude is taken from {topic.name}, whose first orientation is four zeros. If later "
        "ones are not, state attitude_quaternion under pool: channels in vehicle.yaml."
        for topic in topics
        if _begins_with_none(topic)
    ]


def _begins_with_none(topic: TopicFound) -> bool:
    """Tell whether an IMU's first orientation is four zeros, and not said to be none."""
    stated_none = value_at(topic.probe, ("orientation_covariance", 0)) == -1
    values = [value_at(topic.probe, path) for path in numbers_below(topic.probe, ("orientation",))]
    return len(values) == 4 and not any(values) and not stated_none


def _first_that_fits(
    found: Sequence[tuple[tuple[int, int], TopicFound, Rule]], thrusters: Sequence[str]
) -> tuple[list[Plan], list[str]]:
    others: list[str] = []
    plan: Plan | None = None
    said: list[str] = []
    for _, topic, rule in found:
        if plan is not None:
            if topic.name != plan.topic and topic.name not in others:
                others.append(topic.name)
            continue
        channel = PoolChannel(quantity=rule.quantity, topic=topic.name, field=(rule.field,))
        try:
            plan = plan_channel(channel, topic, thrusters, f"default: {rule.says}")
        except NotThereError as error:
            if rule.quantity not in ("thruster_command", "shaft_speed"):
                said.append(f"{topic.name} was not taken for {rule.quantity}: {error}.")
    if plan is None:
        return [], said
    if not others:
        return [plan], []  # the channel itself says where it is from
    fields = ", ".join(plan.fields)
    what = f"{plan.quantity} is taken from {plan.topic} ({fields}, {plan.mapped_by})."
    return [plan], [f"{what} Also fitting: {', '.join(others[:6])}."]


def _one_topic_each(
    found: Sequence[tuple[tuple[int, int], TopicFound, Rule]], thrusters: Sequence[str]
) -> tuple[list[Plan], list[str]]:
    """Take a topic for each thruster: named after it, or numbered in the order of the file."""
    singles: dict[str, tuple[TopicFound, Rule]] = {}
    for _, topic, rule in found:
        if len(numbers_below(topic.probe, parse_path(rule.field)[0])) == 1:
            singles.setdefault(topic.name, (topic, rule))
    by_thruster = _by_name(list(singles), thrusters) or _by_number(list(singles), thrusters)
    plans = []
    for thruster, name in by_thruster.items():
        topic, rule = singles[name]
        channel = PoolChannel(
            quantity=rule.quantity, topic=name, field=(rule.field,), thrusters=(thruster,)
        )
        try:
            plans.append(
                plan_channel(channel, topic, thrusters, "default: a topic for each thruster")
            )
        except NotThereError:
            continue
    if not plans:
        names = ", ".join(list(dict.fromkeys(topic.name for _, topic, _ in found))[:6])
        quantity = found[0][2].quantity
        said = (
            f"{names} may carry {quantity}, but the elements do not fit the {len(thrusters)} "
            "thrusters of the vehicle file; state it under pool: channels."
        )
        return [], [said]
    pairs = ", ".join(f"{plan.thrusters[0]} {plan.topic}" for plan in plans)
    return plans, [f"{plans[0].quantity} is taken from a topic for each thruster: {pairs}."]


def _by_name(topics: Sequence[str], thrusters: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for thruster in thrusters:
        pattern = rf"(^|[^A-Za-z0-9]){re.escape(thruster)}([^A-Za-z0-9]|$)"
        fitting = [name for name in topics if re.search(pattern, name)]
        if len(fitting) == 1:
            found[thruster] = fitting[0]
    return found


def _by_number(topics: Sequence[str], thrusters: Sequence[str]) -> dict[str, str]:
    groups: dict[str, list[tuple[int, str]]] = {}
    for name in topics:
        match = re.search(r"([0-9]+)(?!.*[0-9])", name)
        if match is not None:
            key = name[: match.start()] + "#" + name[match.end() :]
            groups.setdefault(key, []).append((int(match[1]), name))
    for members in groups.values():
        if thrusters and len(members) == len(thrusters):
            ordered = [name for _, name in sorted(members)]
            return dict(zip(thrusters, ordered, strict=True))
    return {}
