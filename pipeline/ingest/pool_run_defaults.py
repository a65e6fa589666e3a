"""Which topic carries which quantity, where the vehicle file does not say it.

A rule looks at the fields of a topic's first message (so it serves every encoding), at its name and
at its type. Of several topics that fit, the rule of the highest rank decides, then the number of
messages; one with few messages goes after all others. What was chosen, and what else would have
fitted, is told.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.ingest.mcap_types import parse_path
from pipeline.ingest.pool_run_codec import numbers_below, value_at
from pipeline.ingest.pool_run_frames import is_earth
from pipeline.ingest.pool_run_plan import (
    PER_THRUSTER,
    NotThereError,
    Plan,
    TopicFound,
    plan_channel,
)
from pipeline.ingest.pool_run_rules import NOT_MEASURED, RULES, Rule
from pipeline.vehicle.pool_schema import COMPONENTS, PoolChannel

#: A quantity is not looked for where one that gives the same is stated or found.
_SAME = (
    ("attitude_quaternion", "attitude_euler"),
    ("depth", "pressure"),
    ("velocity", "velocity_earth"),
)
#: What decides between topics, the topic, and the rule that it fits.
_Candidate = tuple[tuple[bool, int, int], TopicFound, Rule]
#: A sensor writes more; a point that a person clicked on a map is written once.
_FEW_MESSAGES = 10


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
        and not re.search(NOT_MEASURED, topic.name, re.IGNORECASE)
    ]
    candidates: dict[str, list[_Candidate]] = {}
    for topic in open_topics:
        for rule in RULES:
            if rule.quantity not in taken and _fits(rule, topic):
                candidates.setdefault(rule.quantity, []).append((_order(rule, topic), topic, rule))
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
        if quantity in PER_THRUSTER and not new:
            grouped, said = _one_topic_each(found, thrusters)
            plans += grouped
            notes += said
    return Chosen(tuple(plans), tuple(notes))


def _order(rule: Rule, topic: TopicFound) -> tuple[bool, int, int]:
    """Return what decides between topics, the largest wins; a command may be given once."""
    is_running = topic.messages >= _FEW_MESSAGES or rule.quantity in PER_THRUSTER
    return is_running, rule.rank, topic.messages


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
    found: Sequence[_Candidate], thrusters: Sequence[str]
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
            if rule.quantity not in PER_THRUSTER:
                said.append(f"{topic.name} was not taken for {rule.quantity}: {error}.")
    if plan is None:
        return [], said
    if not others:
        return [plan], []  # the channel itself says where it is from
    fields = ", ".join(plan.fields)
    what = f"{plan.quantity} is taken from {plan.topic} ({fields}, {plan.mapped_by})."
    return [plan], [f"{what} Also fitting: {', '.join(others[:6])}."]


def _one_topic_each(
    found: Sequence[_Candidate], thrusters: Sequence[str]
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
