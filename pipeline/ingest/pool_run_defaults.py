"""Which topic carries which quantity, where the vehicle file does not say it.

A rule looks at the fields of a topic's first message, at its name and its type. Of several topics
that fit, the rule of the highest rank decides, then the number of messages; one with few goes last.
"""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from pipeline.ingest.data_files import data_of
from pipeline.ingest.message_definitions import Path as FieldPath
from pipeline.ingest.message_definitions import parse_path
from pipeline.ingest.message_fields import is_earth
from pipeline.ingest.pool_run_codec import numbers_below, value_at
from pipeline.ingest.pool_run_plan import (
    NotThereError,
    Plan,
    TopicFound,
    is_through_water,
    plan_channel,
)
from pipeline.ingest.quantities import PER_THRUSTER, same_quantities
from pipeline.ingest.thruster_names import in_number_order, thrusters_named
from pipeline.records.pool_schema import COMPONENTS, PoolChannel, Quantity
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class Rule:
    """A rule of ``topics.toml``: a field, or several with commas between, holds a quantity.

    Its name must fit `topic` and not `but_not`, its type end in `message_type`.
    """

    rank: int
    quantity: Quantity
    field: str
    says: str
    topic: str = ""
    but_not: str = ""
    message_type: str = ""
    thrusters: tuple[str, ...] | None = None
    """The thrusters that its fields are named after."""

    @property
    def fields(self) -> tuple[str, ...]:
        """The field, or the fields of its components."""
        return tuple(self.field.split(", "))

    def numbers(self, topic: TopicFound) -> list[FieldPath]:
        """Return the numbers that a topic's first message has there."""
        return [
            number
            for text in self.fields
            for number in numbers_below(topic.probe, parse_path(text)[0])
        ]


def _pattern(text: str) -> str:
    """Return a pattern, which may be called by its name: "@command"."""
    if text.startswith("@"):
        return str(data_of("topics")["patterns"][text.removeprefix("@")])
    return text


#: What was wanted, simulated or put together from other topics is not measured.
NOT_MEASURED = _pattern("@not_measured")
RULES = tuple(
    Rule(**(one | {key: _pattern(one[key]) for key in ("topic", "but_not") if key in one}))
    for one in data_of("topics")["rules"]["by_rank"]
)
#: What decides between topics, the topic, and the rule that it fits.
_Candidate = tuple[tuple[bool, bool, bool, int, int], TopicFound, Rule]
#: A sensor writes more; a point that a person clicked on a map is written once.
_FEW_MESSAGES = 10
#: What the parts of one vehicle are called.
_SENSORS = (
    r"imu|ahrs|dvl|gps|ins|depth|baro|pressure|battery|thruster|motor|esc|sensor|board|front|rear|"
    r"left|right|ekf|ukf|odom|filter|estimat|nav|local|slam|usbl|camera|mocap|mavros"
)
#: So many topics are read to see which of them says the truth of a quantity.
_MOST_CANDIDATES = 4


def choose_by_default(
    topics: Sequence[TopicFound], stated: Collection[str], vehicle: Vehicle, notes: list[str]
) -> tuple[list[tuple[Plan, ...]], list[Plan], str]:
    """Find the quantities that are not `stated`, and note what a person should know of the choice.

    Returns for each quantity the plans that fit, the likeliest first; plans of topics that serve
    one thruster each; a warning, if any.
    """
    groups: list[tuple[Plan, ...]] = []
    each: list[Plan] = []
    thrusters = [thruster.name for thruster in vehicle.thrusters]
    taken = set(stated) | {same for quantity in stated for same in same_quantities(quantity)}
    fits = [
        (topic, rule)
        for topic in topics
        if topic.probe is not None
        and topic.name not in vehicle.pool.ignore_topics
        and not re.search(NOT_MEASURED, topic.name, re.IGNORECASE)
        for rule in (*RULES, *_named_after_thrusters(topic, thrusters))
        if rule.quantity not in taken and _fits(rule, topic)
    ]
    not_ours, warning = _other_vehicles(fits, vehicle.name)
    candidates: dict[str, list[_Candidate]] = {}
    for topic, rule in fits:
        found = candidates.setdefault(same_quantities(rule.quantity)[0], [])
        # the largest wins; a command may be given once
        is_running = topic.messages >= _FEW_MESSAGES or rule.quantity in PER_THRUSTER
        is_wanted = not is_through_water(rule.quantity, topic.name)
        is_ours = not_ours.isdisjoint(_parts(topic.name))
        order = (is_ours, is_running, is_wanted, rule.rank, topic.messages)
        found.append((order, topic, rule))
    for quantity, found in candidates.items():
        found.sort(key=lambda one: (one[0], one[1].name), reverse=True)
        plans = _plans(found, thrusters, notes)
        if parts := _parts_of_all(plans, found, thrusters, notes):
            each += parts
        elif plans:
            groups.append(plans)
        elif quantity in PER_THRUSTER:
            each += _one_topic_each(found, thrusters, notes)
    return groups, each, warning


def _named_after_thrusters(topic: TopicFound, thrusters: Sequence[str]) -> list[Rule]:
    """Return a rule for a message of commands whose fields are named after thrusters."""
    of = thrusters_named(list(topic.probe or ()), thrusters)
    if len(of) < 2:
        return []
    where = {"topic": _pattern("@command"), "but_not": _pattern("@not_command")}
    names = tuple(of.values())
    return [Rule(88, "thruster_command", ", ".join(of), "its names", thrusters=names, **where)]


def _other_vehicles(fits: Sequence[tuple[TopicFound, Rule]], vehicle: str) -> tuple[set[str], str]:
    """Find what the topics of other vehicles in one log are called after, and warn of several.

    Two topics that differ in one part alone and carry a quantity, ``/rov/imu/data`` and
    ``/asv/imu/data``, are of two vehicles; where it is not the first part, two such pairs are. Ours
    is the one with commands, else the one that is called as the vehicle file is.
    """
    by_rest: dict[tuple[str, ...], set[str]] = {}
    for topic, rule in fits:
        parts = _parts(topic.name)
        for at in range(len(parts) if rule.quantity not in PER_THRUSTER else min(len(parts), 1)):
            by_rest.setdefault((*parts[:at], "", *parts[at + 1 :]), set()).add(parts[at])
    vehicles = {
        rest: {one for one in names if not re.search(_SENSORS, one, re.IGNORECASE)}
        for rest, names in by_rest.items()
        if len(rest) > 1
    }
    pairs = {rest: names for rest, names in vehicles.items() if len(names) > 1}
    contexts = Counter(name for names in pairs.values() for name in names)
    firsts = {name for rest, names in pairs.items() if not rest[0] for name in names}
    twins = {name for name, count in contexts.items() if name in firsts or count > 1}
    commanded = {
        part
        for topic, rule in fits
        if rule.quantity == "thruster_command"
        for part in twins.intersection(_parts(topic.name))
    }
    named = {one for one in twins if one.lower() == vehicle.lower()}
    homes = commanded if len(commanded) == 1 else named
    # several sensors of one vehicle, /imu_1/data and /imu_2/data, are none
    bare = {re.sub(r"[\d_]+$", "", one.lower()) for one in twins}
    if not twins or (len(bare) == 1 and len(twins) > 1 and len(pairs) == 1):
        return set(), _mixed(fits)
    home = next(iter(homes)) if len(homes) == 1 else ""
    listed = " and ".join(f"/{one}" for one in sorted(twins))
    if home:
        why = "has the commands" if commanded == homes else "is called as the vehicle is"
        said = f"the log has topics of {listed}: those of /{home} are taken, which {why}."
        return twins - {home}, said
    return set(), (
        f"the log has topics of {listed}, and nothing says which is this vehicle: topics of "
        "several may be mixed. State those of the others under pool: ignore_topics."
    )


def _mixed(fits: Sequence[tuple[TopicFound, Rule]]) -> str:
    """Warn of topics of two namespaces, each with some quantities, one with the commands."""
    quantities: dict[str, set[str]] = {}
    for topic, rule in fits:
        if len(parts := _parts(topic.name)) > 1 and not re.search(_SENSORS, parts[0]):
            quantities.setdefault(parts[0], set()).add(rule.quantity)
    homes = [one for one, every in quantities.items() if "thruster_command" in every]
    several = [one for one, every in quantities.items() if len(every.difference(PER_THRUSTER)) > 1]
    if len(homes) != 1 or homes[0] not in several or len(several) < 2:
        return ""
    return (
        f"the log has topics of {' and '.join(f'/{one}' for one in sorted(several))}, and the "
        f"commands are of /{homes[0]}: if the others are another vehicle's, topics of both may be "
        "mixed. State those of the others under pool: ignore_topics."
    )


def _parts(topic: str) -> tuple[str, ...]:
    return tuple(topic.strip("/").split("/"))


def _fits(rule: Rule, topic: TopicFound) -> bool:
    if rule.message_type and not topic.message_type.endswith(rule.message_type):
        return False
    if rule.topic and not re.search(rule.topic, topic.name, re.IGNORECASE):
        return False
    over_earth = {"velocity": False, "velocity_earth": True}.get(rule.quantity)
    # a stamped twist is in the frame of its header, that of nav_msgs/Odometry in its child frame
    has_child = value_at(topic.probe, ("child_frame_id",)) is not None
    if over_earth is not None and (not has_child and is_earth(topic.frame)) != over_earth:
        return False
    if rule.but_not and re.search(rule.but_not, topic.name, re.IGNORECASE):
        return False
    numbers = rule.numbers(topic)
    count = COMPONENTS[rule.quantity]
    return bool(numbers) and (count is None or len(numbers) == count)


def _plans(
    found: Sequence[_Candidate], thrusters: Sequence[str], notes: list[str]
) -> tuple[Plan, ...]:
    plans: dict[str, Plan] = {}
    for _, topic, rule in found:
        if topic.name in plans or len(plans) == _MOST_CANDIDATES:
            continue
        channel = PoolChannel(
            quantity=rule.quantity, topic=topic.name, field=rule.fields, thrusters=rule.thrusters
        )
        try:
            plans[topic.name] = plan_channel(channel, topic, thrusters, f"default: {rule.says}")
        except NotThereError as error:
            if rule.quantity not in PER_THRUSTER:
                notes.append(f"{topic.name} was not taken for {rule.quantity}: {error}.")
    return tuple(plans.values())


def _parts_of_all(
    plans: Sequence[Plan],
    found: Sequence[_Candidate],
    thrusters: Sequence[str],
    notes: list[str],
) -> list[Plan]:
    """Return plans whose messages name thrusters of which each topic has other ones."""
    # of the first kind alone: those of other vehicles, or of too few messages, come later
    probes = {one.name: one.probe for order, one, _ in found if order[:3] == found[0][0][:3]}
    parts: dict[str, Plan] = {}
    own: list[Plan] = []
    for plan in plans:
        texts = value_at(probes.get(plan.topic), plan.names or ()) if plan.names else None
        named = {*thrusters_named(texts or (), thrusters).values()}
        if named and named.isdisjoint(parts):
            parts |= dict.fromkeys(named, plan)
            own.append(replace(plan, is_part=True))
    if len(own) < 2:
        return []
    pairs = ", ".join(f"{one} {parts[one].topic}" for one in thrusters if one in parts)
    notes.append(f"{plans[0].quantity} is taken from a topic for each thruster: {pairs}.")
    return own


def _one_topic_each(
    found: Sequence[_Candidate], thrusters: Sequence[str], notes: list[str]
) -> list[Plan]:
    """Take a topic for each thruster: named after it, or numbered in the order of the file."""
    singles: dict[str, tuple[TopicFound, Rule]] = {}
    for _, topic, rule in found:
        if len(rule.numbers(topic)) == 1:
            singles.setdefault(topic.name, (topic, rule))
    by_name = {one: topic for topic, one in thrusters_named(list(singles), thrusters).items()}
    names = list(singles)
    alike = (one for one in in_number_order(names) if len(one) == len(thrusters))
    in_order = [names[at] for at in next(alike, ())]
    by_thruster = by_name or dict(zip(thrusters, in_order, strict=False))
    plans = []
    for thruster, name in by_thruster.items():
        topic, rule = singles[name]
        channel = PoolChannel(
            quantity=rule.quantity, topic=name, field=rule.fields, thrusters=(thruster,)
        )
        with suppress(NotThereError):
            rule_says = "default: a topic for each thruster"
            plans.append(plan_channel(channel, topic, thrusters, rule_says))
    quantity = found[0][2].quantity
    if plans:
        pairs = ", ".join(f"{plan.thrusters[0]} {plan.topic}" for plan in plans)
        notes.append(f"{plans[0].quantity} is taken from a topic for each thruster: {pairs}.")
    else:
        fitting = ", ".join(list(dict.fromkeys(topic.name for _, topic, _ in found))[:6])
        notes.append(
            f"{fitting} may carry {quantity}, but the elements do not fit the {len(thrusters)} "
            "thrusters of the vehicle file; state it under pool: channels."
        )
    return plans
