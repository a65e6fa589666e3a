"""What to take from which topic: a plan for each channel, from the vehicle file or a default."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

from pipeline.ingest.data_files import data_of
from pipeline.ingest.message_definitions import Path, parse_path, path_text
from pipeline.ingest.message_fields import Flag, Stamp, points_down, validity_of
from pipeline.ingest.pool_run_codec import numbers_below, value_at
from pipeline.ingest.pool_run_extract import Request
from pipeline.ingest.quantities import (
    NO_UNIT,
    PER_THRUSTER,
    QUANTITIES,
    known_unit,
    same_quantities,
)
from pipeline.ingest.thruster_names import in_number_order, thrusters_named
from pipeline.records.pool_run import UnitFrom
from pipeline.records.pool_schema import (
    CLOCK_UNITS_NS,
    COMPONENTS,
    UNITS,
    BodyAxes,
    EarthAxes,
    PoolChannel,
    Quantity,
)

Clock = Literal["header", "log", "field"]
#: What maps the channels that the heads of a table's columns tell.
BY_HEADS = "names of columns"
#: What maps a channel -> where a unit that is stated with it stands; else in a recorder's map.
_STATED_BY: Mapping[str, UnitFrom] = {
    "vehicle file": "vehicle file",
    "notes of the run": "notes of the run",
    f"default: {BY_HEADS}": "head of the column",
}


class NotThereError(ValueError):
    """A topic does not have what a channel asks for; the text says what it has."""


#: Where messages name the elements of an array, and what in the elements themselves does.
_NAMES = ("name", "names", "joint_names", "thrusters", "thruster_names", "labels", "motors")
_LABELS = frozenset({*_NAMES, "label", "id", "index", "number", "channel", "thruster", "motor"})


#: Where the names of elements stand, or their thrusters; and the numbers to take.
_Elements = tuple[Path | None, tuple[str, ...], list[Path]]


def _elements(  # noqa: PLR0917  one caller
    stated: PoolChannel,
    probe: Mapping[str, Any],
    numbers: list[Path],
    thrusters: Sequence[str],
    notes: list[str],
    doubts: list[str],
) -> _Elements:
    """Say which elements of an array are of which thrusters."""
    if stated.thrusters is not None:
        if len(stated.thrusters) != len(numbers):
            raise NotThereError(
                f"thrusters names {len(stated.thrusters)} elements, the field has "
                f"{len(numbers)} numbers"
            )
        return None, stated.thrusters, numbers
    if stated.index is None:
        is_array = len(stated.field or ("",)) == 1
        named = _named_elements(probe, numbers, thrusters, notes, is_array=is_array)
        if isinstance(named, tuple):
            return named
        if named:
            doubts.append(
                f"its elements are named {', '.join(named[:12])}, not as the thrusters of the "
                "vehicle; they are taken in the order of the vehicle file"
            )
    if not thrusters:
        return None, tuple(f"{number + 1}" for number in range(len(numbers))), numbers
    if len(numbers) < len(thrusters):
        raise NotThereError(
            f"the field has {len(numbers)} numbers for {len(thrusters)} thrusters; name them with "
            "thrusters"
        )
    if len(numbers) > len(thrusters):
        notes.append(f"the first {len(thrusters)} of {len(numbers)} elements are taken")
    if len(thrusters) > 1:
        notes.append("elements are assumed to be in the order of the thrusters of the vehicle file")
    return None, tuple(thrusters), numbers


def _named_elements(
    probe: Mapping[str, Any],
    numbers: list[Path],
    thrusters: Sequence[str],
    notes: list[str],
    *,
    is_array: bool,
) -> _Elements | list[str]:
    """Return what the names of elements tell of them; the names alone where they tell nothing."""
    lists = {(one,): value_at(probe, (one,)) for one in _NAMES}
    where = next((one for one, found in lists.items() if _are_texts(found, len(numbers))), None)
    texts = lists[where] if where else []
    if texts and (not thrusters or thrusters_named(texts, thrusters)):
        # another message may name more of them
        most = len(numbers) + len(thrusters)
        more = [(*numbers[0][:-1], number) for number in range(len(numbers), most)]
        return where, (), [*numbers, *more]
    if not texts and is_array:
        numbers, texts = _labelled(probe, numbers)
    if where is None and (named := thrusters_named(texts, thrusters)):
        at = {named[text]: path for text, path in zip(texts, numbers, strict=True) if text in named}
        notes.append(f"elements by the thrusters in their names: {', '.join(named)}")
        return None, tuple(at), list(at.values())
    order = next((one for one in in_number_order(texts) if len(one) == len(texts)), None)
    if texts and order is not None and len(texts) == len(thrusters):
        listed = ", ".join(texts[index] for index in order)
        notes.append(f"elements by the numbers in their names: {listed}")
        return None, tuple(thrusters), [numbers[index] for index in order]
    return list(texts)


def _are_texts(found: object, count: int) -> bool:
    is_list = isinstance(found, list) and len(found) == count
    return is_list and all(isinstance(one, str) for one in cast("list[object]", found))


def _labelled(probe: Mapping[str, Any], numbers: list[Path]) -> tuple[list[Path], list[str]]:
    """Return numbers with the names of the fields that they stand in, or of a label beside each."""
    steps = [path[-1] for path in numbers]
    of_elements = [path for path in numbers if len(path) > 1 and isinstance(path[-2], int)]
    if of_elements == numbers and all(isinstance(one, str) for one in steps):
        kept = [path for path in numbers if path[-1] not in _LABELS]
        labels = [
            next((f"{beside[one]}" for one in sorted(_LABELS & beside.keys())), "")
            for path in kept
            if isinstance(beside := value_at(probe, path[:-1]), dict)
        ]
        if len({path[-1] for path in kept}) == 1 and len(set(labels)) == len(kept):
            return kept, labels
    elif len(numbers) > 1 and all(isinstance(one, str) for one in steps):
        return numbers, list(map(str, steps))
    return numbers, []


@dataclass(frozen=True)
class TopicFound:
    """A topic of the log: its channels (ids), type, number of messages, its first message."""

    name: str
    channels: tuple[int, ...]
    message_type: str
    encoding: str
    messages: int
    probe: Mapping[str, Any] | None = None
    why_not: str = ""
    """Why its messages cannot be decoded."""
    of_rig2sea: bool = False
    """Whether rig2sea wrote it, whose commands are codes."""
    packed: bool = False
    """Its messages are compressed one by one."""

    @property
    def frame(self) -> str:
        """The frame that its first message names."""
        if self.probe is None:
            return ""
        for path in (("header", "frame_id"), ("frame_id",)):
            found = value_at(self.probe, path)
            if isinstance(found, str):
                return found
        return ""


@dataclass(frozen=True)
class Plan:
    """One channel: numbers of a topic's messages, and what they mean, as `stated` or by default."""

    stated: PoolChannel
    topic: str
    mapped_by: str
    numbers: tuple[Path, ...]
    fields: tuple[str, ...]
    unit: str | None
    unit_from: UnitFrom
    sign: tuple[int, ...]
    order: Literal["xyzw", "wxyz"]
    body_axes: BodyAxes
    earth_axes: EarthAxes
    clock: Clock | None
    stamp: Stamp | None
    thrusters: tuple[str, ...]
    """Names of the elements; empty where the messages name them (`names`) or there are none."""
    names: Path | None
    notes: tuple[str, ...] = ()
    flags: tuple[Flag, ...] = ()
    """What in a message says whether its numbers are valid."""
    doubts: tuple[str, ...] = ()
    """What was assumed and may be wrong without a sign of it."""
    is_part: bool = False
    """Whether other topics have the other thrusters: then each thruster stands for itself."""

    @property
    def quantity(self) -> Quantity:
        """What it measures."""
        return self.stated.quantity

    @property
    def of_one(self) -> bool:
        """Whether it is of a single thruster, and stands for itself."""
        return self.quantity in PER_THRUSTER and len(self.thrusters) == 1 and self.names is None

    @property
    def wanted(self) -> int:
        """How many of the numbers are taken; a field may have more than there are thrusters."""
        is_each = self.quantity in PER_THRUSTER and self.names is None
        return len(self.thrusters) if is_each else len(self.numbers)

    @property
    def request(self) -> Request:
        """What it needs of the topic."""
        flags = tuple(flag.path for flag in self.flags)
        return Request((*self.numbers, *flags), self.stamp, self.names, frozenset(flags))


def plan_channel(
    stated: PoolChannel, topic: TopicFound, thrusters: Sequence[str], mapped_by: str
) -> Plan:
    """Work out what a channel takes from a topic, by its first message; raises `NotThereError`.

    `mapped_by` is "vehicle file", or the rule that chose it.
    """
    probe = topic.probe
    if probe is None:
        raise NotThereError(topic.why_not or "the topic has no messages")
    notes: list[str] = []
    fields, numbers = _numbers(stated, probe)
    beyond = [number for number in stated.index or () if number >= len(numbers)]
    if beyond:
        raise NotThereError(
            f"index {beyond[0]} is beyond the {len(numbers)} numbers of {', '.join(fields)}"
        )
    if stated.index is not None:
        numbers = [numbers[number] for number in stated.index]
    doubts: list[str] = []
    names: Path | None = None
    columns: tuple[str, ...] = ()
    if stated.quantity in PER_THRUSTER:
        names, columns, numbers = _elements(stated, probe, numbers, thrusters, notes, doubts)
    if mapped_by.startswith("default") and is_through_water(stated.quantity, topic.name):
        doubts.append(
            "by its name it is the velocity through the water, and is taken for the one over ground"
        )
    count = COMPONENTS[stated.quantity]
    if count is not None and len(numbers) != count:
        raise NotThereError(
            f"{', '.join(fields)} gives {len(numbers)} numbers, {stated.quantity} has {count}"
        )
    if len(stated.sign) not in (1, len(numbers)):
        raise NotThereError(f"sign has {len(stated.sign)} entries for {len(numbers)} numbers")
    body, earth = _axes(stated, topic, notes)
    stamp, clock = _stamp(stated, probe)
    unit: tuple[str | None, UnitFrom] = stated.unit, _STATED_BY.get(mapped_by, "usual map")
    named = [str(path[-1]).lower()[-1:] for path in numbers] == ["x", "y", "z", "w"]
    return Plan(
        stated,
        topic.name,
        mapped_by,
        tuple(numbers),
        tuple(fields),
        *(unit if stated.unit is not None else _usual_unit(stated.quantity, topic, numbers)),
        tuple(stated.sign) * (len(numbers) if len(stated.sign) == 1 else 1),
        # components that are named have an order
        "xyzw" if named else stated.order,
        body,
        earth,
        clock,
        stamp,
        columns,
        names,
        tuple(notes),
        validity_of(stated.quantity, probe, numbers),
        tuple(doubts),
    )


def is_through_water(quantity: str, topic: str) -> bool:
    """Tell whether a topic is called a velocity through the water.

    >>> is_through_water("velocity", "/dvl/water_track"), is_through_water("velocity", "/dvl/wtf")
    (True, False)
    """
    pattern = data_of("topics")["patterns"]["through_water"]
    is_velocity = quantity in same_quantities("velocity")
    return is_velocity and re.search(pattern, topic, re.IGNORECASE) is not None


def _numbers(stated: PoolChannel, probe: Mapping[str, Any]) -> tuple[tuple[str, ...], list[Path]]:
    if stated.field is not None:
        numbers: list[Path] = []
        for text in stated.field:
            found = [number for path in parse_path(text) for number in numbers_below(probe, path)]
            if not found:
                raise NotThereError(f'no number at "{text}"; its messages have {outline(probe)}')
            numbers += found
        return tuple(stated.field), numbers
    count = COMPONENTS[stated.quantity]
    for text in data_of("topics")["fields"][stated.quantity]:
        numbers = numbers_below(probe, parse_path(text)[0])
        if numbers and (count is None or len(numbers) == count or stated.index is not None):
            return (text,), numbers
    raise NotThereError(
        f"none of its fields is known to hold {stated.quantity}; its messages have "
        f"{outline(probe)}. State field"
    )


def _axes(stated: PoolChannel, topic: TopicFound, notes: list[str]) -> tuple[BodyAxes, EarthAxes]:
    """Axes of the readings: stated, stated by the frame's name, or usual for the message."""
    frames = f"{topic.frame} {value_at(topic.probe, ('child_frame_id',)) or ''}"
    is_ros = "/msg/" in topic.message_type and not topic.message_type.startswith("std_msgs/")
    body, earth, why = "flu", "enu", "as REP 103 has it"
    if not is_ros or points_down(frames):
        body, earth, why = "frd", "ned", "stated by the frame" if is_ros else "assumed"
    axes = QUANTITIES[stated.quantity].axes
    said = [f"body axes {body}"] if "body" in axes and stated.body_axes is None else []
    said += [f"earth axes {earth}"] if "earth" in axes and stated.earth_axes is None else []
    if said:
        notes.append(f"{', '.join(said)} ({why})")
    return stated.body_axes or cast("BodyAxes", body), stated.earth_axes or cast("EarthAxes", earth)


def _stamp(stated: PoolChannel, probe: Mapping[str, Any]) -> tuple[Stamp | None, Clock | None]:
    if stated.clock == "log":
        return None, "log"
    if stated.clock_field is not None and stated.clock_unit is not None:
        path = parse_path(stated.clock_field)[0]
        if not isinstance(value_at(probe, path), int | float):
            raise NotThereError(
                f'no number at clock_field "{stated.clock_field}"; its messages have '
                f"{outline(probe)}"
            )
        return Stamp(path, CLOCK_UNITS_NS[stated.clock_unit]), "field"
    for first, second in data_of("topics")["times"]["stamps"]:
        path, nanoseconds = parse_path(first)[0], parse_path(second)[0]
        if value_at(probe, path) is not None and value_at(probe, nanoseconds) is not None:
            return Stamp(path, nanoseconds=nanoseconds), stated.clock
    return None, stated.clock


def _usual_unit(
    quantity: str, topic: TopicFound, numbers: Sequence[Path]
) -> tuple[str | None, UnitFrom]:
    """Return the unit that the message states or prescribes; None where the values must tell."""
    for name in ("unit", "units"):
        told = value_at(topic.probe, (*numbers[0][:-1], name)) if numbers else None
        if isinstance(told, str) and told.strip() not in NO_UNIT:
            if known_unit(told.strip()) not in UNITS[quantity]:
                raise NotThereError(f'its messages have the unit "{told}", which is none of it')
            return known_unit(told.strip()), "message"
    joints = topic.message_type.endswith("JointState")
    if quantity == "thruster_command":
        # a position of JointState has no unit for thrusters: the numbers must tell
        return ("code", "message") if topic.of_rig2sea else (None, "values")
    if quantity == "shaft_speed":
        return ("rad/s", "message") if joints else ("rpm", "assumed")
    usual = next(iter(UNITS[quantity]))
    if quantity == "attitude_euler":
        return None, "values"
    standard = topic.message_type.split("/")[0] in ("sensor_msgs", "geometry_msgs", "nav_msgs")
    return usual, "message" if standard else "assumed"


def outline(tree: Mapping[str, Any], most: int = 14) -> str:
    """List the fields of a message with numbers, as paths.

    >>> outline({"data": [1, 2], "layout": {"data_offset": 0}})
    'data[0:2], layout.data_offset'
    """
    counts: Counter[Path] = Counter()
    for name in tree:
        for path in numbers_below(tree, (name,)):
            counts[path[:-1] if isinstance(path[-1], int) else path] += 1
    lists = {path for path in counts if isinstance(value_at(tree, path), list)}
    found = [
        f"{path_text(path)}[0:{count}]" if path in lists else path_text(path)
        for path, count in counts.items()
    ]
    return (", ".join(found[:most]) + (" ..." if len(found) > most else "")) or "no numbers"
