"""Every topic of a log: what it is used for, or why it is not."""

import re
from collections.abc import Mapping, Sequence

from pipeline.ingest.pool_run_choice import ChannelSource
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.ingest.pool_run_rules import NOT_MEASURED
from pipeline.records.pool_run import TopicRead
from pipeline.records.run_arrays import RunChannel
from pipeline.vehicle.schema import Vehicle


def topics_read(
    topics: Sequence[TopicFound],
    channels: Mapping[str, RunChannel],
    groups: Sequence[Sequence[ChannelSource]],
    vehicle: Vehicle,
) -> tuple[TopicRead, ...]:
    """Return all topics by name: what was taken from them, and else what else would have fitted."""
    used: dict[str, list[str]] = {}
    for name, channel in channels.items():
        used.setdefault(channel.topic, []).append(name)
    instead: dict[str, list[str]] = {}
    for group in groups:
        taken = next((one.channel for one in group if channels.get(one.name) is one.channel), None)
        for one in group:
            if taken is None or one.channel.topic != taken.topic:
                said = f"{one.channel.quantity} has no valid reading"
                if taken is not None:
                    said = f"{one.channel.quantity} is taken from {taken.topic}"
                instead.setdefault(one.channel.topic, []).append(said)
    return tuple(
        TopicRead(
            topic=topic.name,
            message_type=topic.message_type,
            encoding=topic.encoding,
            messages=topic.messages,
            used_for=tuple(used.get(topic.name, ())),
            why_not="" if topic.name in used else _why_not(topic, instead, vehicle),
        )
        for topic in sorted(topics, key=lambda topic: topic.name)
    )


def _why_not(topic: TopicFound, instead: Mapping[str, list[str]], vehicle: Vehicle) -> str:
    known = (
        (topic.why_not, bool(topic.why_not)),
        ("it has no messages", not topic.messages),
        (", ".join(dict.fromkeys(instead.get(topic.name, ()))), topic.name in instead),
        (
            "the vehicle file says so (ignore_topics)",
            topic.name in vehicle.pool.ignore_topics,
        ),
        (
            "the vehicle file does not state it, and wants no defaults",
            not vehicle.pool.defaults,
        ),
        (
            "by its name it was wanted, simulated or put together from others, not measured",
            re.search(NOT_MEASURED, topic.name, re.IGNORECASE) is not None,
        ),
    )
    nothing = "no field of it is known to hold a quantity that is still wanted"
    return next((text for text, applies in known if applies), nothing)
