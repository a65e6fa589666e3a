"""Topics of a log, and what is taken from each: the vehicle file first, then the defaults."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.mcap_chunk import Block
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_types import BrokenMessageError, DefinitionError
from pipeline.ingest.pool_run_codec import Codec, codec_of
from pipeline.ingest.pool_run_defaults import choose_by_default
from pipeline.ingest.pool_run_extract import Request
from pipeline.ingest.pool_run_plan import (
    PER_THRUSTER,
    NotThereError,
    Plan,
    TopicFound,
    plan_channel,
)
from pipeline.ingest.pool_run_stamps import Stamp
from pipeline.vehicle.schema import Vehicle

#: First messages that are larger are not decoded to see what is in them (pictures, clouds).
_MAX_PROBE_BYTES = 1_000_000
#: So many blocks of messages that cannot be decoded, and a channel is given up.
_MOST_TRIES = 30
#: So many messages of a JSON topic are looked at to see what is in them.
_FIRST_MESSAGES = 20
#: Records by which rig2sea's own logs are known: all of it, and what it simulated beside others'.
_RECORDS = ("rig2sea.log", "rig2sea.run")


def topics_of(log: McapFile, prefix: str) -> tuple[dict[int, Codec], list[TopicFound]]:
    """Find the topics of a log, a decoder for each channel, and each topic's first message."""
    directory = log.directory
    codecs: dict[int, Codec] = {}
    why_not: dict[int, str] = {}
    for number, channel in directory.channels.items():
        if not directory.counts.get(number):
            continue
        try:
            codecs[number] = codec_of(channel, directory.schemas.get(channel.schema_id))
        except DefinitionError as error:
            why_not[number] = f"{error}"
    probes = _probes(log, codecs, why_not)
    of_rig2sea = any(name in directory.metadata for name in _RECORDS[: 2 if prefix else 1])
    found: dict[str, TopicFound] = {}
    for number, channel in sorted(directory.channels.items()):
        if prefix and not channel.topic.startswith(prefix):
            continue
        schema = directory.schemas.get(channel.schema_id)
        known = found.get(channel.topic)
        here = directory.counts.get(number, 0)
        messages = here + (known.messages if known else 0)
        if known is not None and known.probe is not None:
            same = probes.get(number) is None or _same_shape(known.probe, probes[number])
            numbers = (*known.channels, number) if same else known.channels
            found[channel.topic] = replace(known, channels=numbers, messages=messages)
            continue
        found[channel.topic] = TopicFound(
            channel.topic,
            (number,),
            schema.name if schema else "",
            channel.message_encoding,
            messages,
            probes.get(number),
            why_not.get(number, ""),
            of_rig2sea,
        )
    return codecs, list(found.values())


def _same_shape(first: Mapping[str, object], second: Mapping[str, object]) -> bool:
    return list(first) == list(second)


def _probes(
    log: McapFile, codecs: Mapping[int, Codec], why_not: dict[int, str]
) -> dict[int, Mapping[str, object]]:
    """Decode the first message of every channel that can be decoded."""
    wanted = set(codecs)
    probes: dict[int, Mapping[str, object]] = {}
    tried: dict[int, int] = {}
    while wanted:
        before = set(wanted)
        for block in log.blocks(frozenset(wanted)):
            for number in list(wanted & set(block.messages)):
                messages = block.messages[number]
                for begin, size in zip(
                    messages.start[:3].tolist(), messages.size[:3].tolist(), strict=True
                ):
                    if size > _MAX_PROBE_BYTES:
                        why_not[number] = f"its messages of {size} bytes are no readings"
                        wanted.discard(number)
                        break
                    try:
                        probes[number] = codecs[number].decode(
                            block.data[begin : begin + size].tobytes()
                        )
                    except BrokenMessageError as error:
                        why_not[number] = f"its messages cannot be decoded: {error}"
                        tried[number] = tried.get(number, 0) + 1
                        continue
                    why_not.pop(number, None)
                    wanted.discard(number)
                    if log.directory.channels[number].message_encoding == "json":
                        probes[number] = _with_later(probes[number], codecs[number], block, number)
                    break
                if tried.get(number, 0) >= _MOST_TRIES:
                    wanted.discard(number)
            if not wanted or wanted != before:
                break  # begin anew: chunks without the others are then passed over
        else:
            break
    return probes


def _with_later(
    probe: Mapping[str, object], codec: Codec, block: Block, number: int
) -> dict[str, object]:
    """Add what the first message lacks and one of the next has: JSON may leave fields away."""
    whole = dict(probe)
    messages = block.messages[number]
    for begin, size in zip(
        messages.start[:_FIRST_MESSAGES].tolist(),
        messages.size[:_FIRST_MESSAGES].tolist(),
        strict=True,
    ):
        if size > _MAX_PROBE_BYTES:
            continue
        try:
            later = codec.decode(block.data[begin : begin + size].tobytes())
        except BrokenMessageError:
            continue
        for name, value in later.items():
            if whole.get(name) is None:
                whole[name] = value
    return whole


def plans_of(
    vehicle: Vehicle,
    topics: Sequence[TopicFound],
    place: Place,
    problems: list[Problem],
    prefix: str,
) -> list[Plan]:
    """Make the plans of the vehicle file, then those of the defaults."""
    names = [thruster.name for thruster in vehicle.thrusters]
    by_name = {_bare(topic.name): topic for topic in topics}
    plans: list[Plan] = []
    for number, stated in enumerate(vehicle.pool.channels):
        topic = by_name.get(_bare(prefix + stated.topic))
        said = f"pool: channels: entry {number + 1} ({stated.quantity}, {stated.topic})"
        if topic is None:
            have = ", ".join(topic.name for topic in topics[:12])
            what = f"{said}: there is no such topic. The log has {have}."
            problems.append(
                Problem("warning", place, what, "", "Correct the topic in vehicle.yaml.")
            )
            continue
        try:
            plans.append(plan_channel(stated, topic, names, "vehicle file"))
        except NotThereError as error:
            what = f"{said}: {error}; the channel was left out."
            problems.append(Problem("warning", place, what, "", "Correct it in vehicle.yaml."))
    plans = _no_quantity_twice(plans, place, problems)
    problems += _two_clocks(plans, place)
    if vehicle.pool.defaults:
        stated_quantities = [channel.quantity for channel in vehicle.pool.channels]
        unprefixed = [replace(topic, name=topic.name.removeprefix(prefix)) for topic in topics]
        chosen = choose_by_default(unprefixed, stated_quantities, names, vehicle.pool.ignore_topics)
        problems += [Problem("note", place, note) for note in chosen.notes]
        plans += [replace(plan, topic=prefix + plan.topic) for plan in chosen.plans]
    return plans


def _bare(topic: str) -> str:
    """Topics are compared without the leading slash, which some recorders leave out."""
    return topic.lstrip("/")


def _no_quantity_twice(plans: Sequence[Plan], place: Place, problems: list[Problem]) -> list[Plan]:
    kept: dict[str, Plan] = {}
    for plan in plans:
        name = channel_name(plan)
        if name in kept:
            what = (
                f"{name} is stated twice, from {kept[name].topic} and {plan.topic}; the first is "
                "taken."
            )
            problems.append(Problem("warning", place, what, "", "Delete one in vehicle.yaml."))
            continue
        kept[name] = plan
    return list(kept.values())


def _two_clocks(plans: Sequence[Plan], place: Place) -> list[Problem]:
    """Warn of entries that state different clocks for one topic: its messages have one time."""
    first: dict[str, Plan] = {}
    found = []
    for plan in plans:
        if plan.clock is None:
            continue
        known = first.setdefault(plan.topic, plan)
        if (plan.clock, plan.stamp) != (known.clock, known.stamp):
            what = (
                f"two clocks are stated for {plan.topic}, with {channel_name(known)} and with "
                f"{channel_name(plan)}; the first is taken for both."
            )
            found.append(Problem("warning", place, what, "", "Delete one in vehicle.yaml."))
    return found


def channel_name(plan: Plan) -> str:
    """Name of the channel that a plan makes: the quantity, and the thruster if it is one's own."""
    if plan.quantity in ("attitude_quaternion", "attitude_euler"):
        return "attitude"
    if plan.quantity == "pressure":
        return "depth"
    if plan.quantity in PER_THRUSTER and len(plan.thrusters) == 1 and plan.names is None:
        return f"{plan.quantity}.{plan.thrusters[0]}"
    return plan.quantity


def key_of(plan: Plan) -> tuple[str, str]:
    """Return what tells the plans of a run apart."""
    return plan.topic, channel_name(plan)


def nothing_mapped(
    place: Place, topics: Sequence[TopicFound], problems: Sequence[Problem]
) -> InputError:
    """Make the error that says what the log holds, where nothing of it can be used."""
    listed = []
    for topic in topics[:20]:
        why = f": {topic.why_not}" if topic.why_not else ""
        kind = f"{topic.message_type}, {topic.encoding}" if topic.message_type else topic.encoding
        listed.append(f"  {topic.name} ({kind}, {topic.messages} messages){why}")
    more = f"\n  and {len(topics) - 20} more" if len(topics) > 20 else ""
    said = "\n".join(f"  {problem.what}" for problem in problems)
    said = f"\n{said}" if said else ""
    return InputError.at(
        place,
        "none of its topics is known to carry a command or a reading:\n"
        + "\n".join(listed)
        + more
        + said,
        expected="thruster commands, and readings such as angular velocity, attitude or depth.",
        remedy="State where they are under pool: channels in vehicle.yaml.",
    )


def _stamp_of(topic: str, plans: Sequence[Plan]) -> Stamp | None:
    """Return where the messages of a topic say their time: as stated for any of its channels."""
    own = [plan for plan in plans if plan.topic == topic]
    stated = [plan for plan in own if plan.clock is not None]
    return next((plan.stamp for plan in stated or own if plan.stamp is not None), None)


def requests_of(
    plans: Sequence[Plan],
) -> tuple[dict[str, Request], dict[tuple[str, str], tuple[int, int]]]:
    """Put the plans of one topic together; return where each finds its numbers."""
    requests: dict[str, Request] = {}
    where: dict[tuple[str, str], tuple[int, int]] = {}
    for plan in plans:
        new = plan.request
        known = requests.get(plan.topic)
        begin = 0 if known is None else len(known.numbers)
        numbers = new.numbers if known is None else known.numbers + new.numbers
        names = new.names if known is None or known.names is None else known.names
        requests[plan.topic] = Request(numbers, _stamp_of(plan.topic, plans), names)
        where[key_of(plan)] = (begin, len(numbers))
    return requests, where
