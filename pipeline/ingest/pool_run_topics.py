"""Topics of a log, and what is taken from each: the vehicle file first, then the defaults."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.mcap_chunk import ChunkBlock
from pipeline.ingest.message_definitions import BrokenMessageError, DefinitionError
from pipeline.ingest.message_definitions import Path as FieldPath
from pipeline.ingest.pool_run_codec import Codec, codec_of, is_packed, numbers_below, packed
from pipeline.ingest.pool_run_defaults import choose_by_default
from pipeline.ingest.pool_run_extract import Request
from pipeline.ingest.pool_run_plan import NotThereError, Plan, TopicFound, plan_channel
from pipeline.ingest.quantities import QUANTITIES, same_quantities
from pipeline.records.pool_schema import PoolChannel
from pipeline.vehicle.schema import Vehicle

if TYPE_CHECKING:
    from pipeline.ingest.log_source import LogFacts, MessageLog

#: First messages that are larger are not decoded to see what is in them (pictures, clouds).
_MAX_PROBE_BYTES = 1_000_000
#: So many blocks of messages that cannot be decoded, and a channel is given up.
_MOST_TRIES = 30
#: So many messages of a JSON topic are looked at to see what is in them.
_FIRST_MESSAGES = 20
#: And so many where a field is null in all of them.
_FIRST_OF_JSON = 2_000
#: And so many where they hold no number at all.
_FIRST_WITHOUT_NUMBERS = 300
#: The record by which rig2sea's own logs are known.
_OWN_RECORD = "rig2sea.log"


def topics_of(log: "MessageLog") -> tuple[dict[int, Codec], list[TopicFound]]:
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
    probes = _Probes(log, codecs, why_not)
    probes.read()
    of_rig2sea = _OWN_RECORD in directory.metadata
    found: dict[str, TopicFound] = {}
    for number, channel in sorted(directory.channels.items()):
        schema = directory.schemas.get(channel.schema_id)
        kind = "" if schema is None else schema.name
        known = found.get(channel.topic)
        here = directory.counts.get(number, 0)
        messages = here + (known.messages if known else 0)
        probe = probes.found.get(number)
        if known is not None and known.probe is not None:
            same = probe is None or list(known.probe) == list(probe)
            numbers = (*known.channels, number) if same else known.channels
            found[channel.topic] = replace(known, channels=numbers, messages=messages)
            continue
        found[channel.topic] = TopicFound(
            channel.topic,
            (number,),
            kind.replace("/", "/msg/") if channel.message_encoding == "ros1" else kind,
            channel.message_encoding,
            messages,
            probe,
            why_not.get(number, ""),
            of_rig2sea,
            codecs[number].packed if number in codecs else False,
        )
    return codecs, list(found.values())


class _Probes:
    """Decodes the first message of every channel that can be decoded."""

    def __init__(
        self, log: "MessageLog", codecs: dict[int, Codec], why_not: dict[int, str]
    ) -> None:
        self._log, self._codecs, self._why_not = log, codecs, why_not
        self.found: dict[int, dict[str, Any]] = {}
        self._tried = dict.fromkeys(codecs, 0)
        self._wanted = set(codecs)

    def read(self) -> None:
        """Read as much of the log as it takes."""
        before: set[int] = set()
        while self._wanted != before:
            before = set(self._wanted)
            for block in self._log.blocks(frozenset(before)):
                for number in before & self._wanted & set(block.messages):
                    self._look_at(block, number)
                # begin anew when some are done: chunks without the others are then passed over
                if len(self._wanted) < len(before):
                    break
        for number, probe in self.found.items():
            nothing = [name for name, value in probe.items() if value is None]
            if nothing and not _has_number(probe):
                self._why_not[number] = (
                    f"{', '.join(nothing)} is null in its first {self._tried[number]} messages"
                )

    def _look_at(self, block: ChunkBlock, number: int) -> None:
        messages = block.messages[number]
        is_json = self._log.directory.channels[number].message_encoding == "json"
        # several of JSON: what one lacks another may have
        most, enough = _FIRST_OF_JSON if is_json else 3, False
        for begin, size in zip(
            messages.start[:most].tolist(), messages.size[:most].tolist(), strict=True
        ):
            if size > _MAX_PROBE_BYTES:
                self._why_not[number] = f"its messages of {size} bytes are no readings"
                self._wanted.discard(number)
                return
            self._tried[number] += 1
            self._decode(number, block.data[begin : begin + size].tobytes())
            probe, tried = self.found.get(number), self._tried[number]
            # of JSON a field has been null so far, or there has been no number, for a while
            enough = probe is not None and not (
                is_json
                and (_lacks(probe) or (tried < _FIRST_WITHOUT_NUMBERS and not _has_number(probe)))
            )
            if enough and (not is_json or tried >= _FIRST_MESSAGES):
                break
        most = _FIRST_OF_JSON if number in self.found else _MOST_TRIES
        if enough or self._tried[number] >= most:
            self._wanted.discard(number)

    def _decode(self, number: int, data: bytes) -> None:
        if is_packed(data) and not self._codecs[number].packed:
            self._codecs[number] = packed(self._codecs[number])
        try:
            later = self._codecs[number].decode(data)
        except BrokenMessageError as error:
            if number not in self.found:
                self._why_not[number] = f"its messages cannot be decoded: {error}"
            return
        self._why_not.pop(number, None)
        self.found[number] = _with(self.found.get(number, {}), later)


def _has_number(probe: Mapping[str, Any]) -> bool:
    return any(numbers_below(probe, (name,)) for name in probe)


def _lacks(probe: Mapping[str, Any]) -> bool:
    """Tell whether a field of a message has been null so far."""
    return any(
        value is None or (isinstance(value, dict) and _lacks(value)) for value in probe.values()
    )


def _with(probe: dict[str, Any], later: Mapping[str, Any]) -> dict[str, Any]:
    """Add what a message lacks and a later one has: JSON may leave fields away, or null."""
    whole = dict(probe)
    for name, value in later.items():
        known = whole.get(name)
        if known is None:
            whole[name] = value
        elif isinstance(known, dict) and isinstance(value, dict):
            whole[name] = _with(known, value)
    return whole


@dataclass(frozen=True)
class Plans:
    """What is read of a log: what is settled, and groups of which one each is taken."""

    settled: tuple[Plan, ...]
    groups: tuple[tuple[Plan, ...], ...]

    @property
    def every(self) -> tuple[Plan, ...]:
        """All of them."""
        return (*self.settled, *(plan for group in self.groups for plan in group))


def plans_of(
    vehicle: Vehicle,
    topics: Sequence[TopicFound],
    facts: "LogFacts",
    problems: list[Problem],
    by_notes: Sequence[PoolChannel],
) -> Plans:
    """Make the plans that are stated, those usual for the recorder, those of the defaults.

    Channels of the notes of the run replace those of the vehicle file. At most one of a quantity is
    settled, or one for each of its thrusters.
    """
    place = facts.place
    names = [thruster.name for thruster in vehicle.thrusters]
    by_name = {_bare(topic.name): topic for topic in topics}
    replaced = {same for one in by_notes for same in same_quantities(one.quantity)}
    stated = [
        (one, f"channels: entry {at} of the notes ({one.quantity}, {one.topic})")
        for at, one in enumerate(by_notes, 1)
    ]
    stated += [
        (one, f"pool: channels: entry {at} ({one.quantity}, {one.topic})")
        for at, one in enumerate(vehicle.pool.channels, 1)
        if one.quantity not in replaced
    ]
    settled: dict[str, Plan] = {}
    for number, (channel, entry) in enumerate(stated):
        topic = by_name.get(_bare(channel.topic))
        mapped_by = "notes of the run" if number < len(by_notes) else "vehicle file"
        try:
            if topic is None:
                have = ", ".join(topic.name for topic in topics[:12])
                raise NotThereError(f"there is no such topic. The log has {have}")  # noqa: TRY301  said below
            plan = plan_channel(channel, topic, names, mapped_by)
        except NotThereError as error:
            what = f"{entry}: {error}; the channel was left out."
            problems.append(place.warning(what, remedy="Correct it in vehicle.yaml."))
            continue
        name = channel_name(plan)
        first = settled.setdefault(name, plan)
        if first is not plan:
            both = f"{first.topic} and {plan.topic}"
            what = f"{name} is stated twice, from {both}; the first is taken."
            problems.append(place.warning(what, remedy="Delete one in vehicle.yaml."))
    plans = tuple(settled.values())
    problems += _two_clocks(plans, place)
    if not vehicle.pool.defaults:
        return Plans(plans, ())
    known: set[str] = {one.quantity for one, _ in stated}
    groups: dict[str, dict[tuple[str, str], Plan]] = {}
    each: dict[str, Plan] = {}
    for channel in facts.usual:
        topic = by_name.get(_bare(channel.topic))
        if topic is None or known & set(same_quantities(channel.quantity)):
            continue
        with suppress(NotThereError):
            plan = plan_channel(channel, topic, names, f"default: {facts.recorder}")
            if plan.of_one:
                each.setdefault(channel_name(plan), plan)
            else:
                group = groups.setdefault(same_quantities(plan.quantity)[0], {})
                group.setdefault(key_of(plan), plan)
    usual = [tuple(group.values()) for group in groups.values()]
    known |= {one.quantity for group in (*usual, tuple(each.values())) for one in group}
    notes: list[str] = []
    found, singles, warning = choose_by_default(topics, known, vehicle, notes)
    problems += [*map(place.note, notes), *([place.warning(warning)] if warning else [])]
    return Plans((*plans, *each.values(), *singles), (*usual, *found))


def _bare(topic: str) -> str:
    """Topics are compared without the leading slash, which some recorders leave out."""
    return topic.lstrip("/")


def _two_clocks(plans: Sequence[Plan], place: Place) -> Iterator[Problem]:
    """Warn of entries that state different clocks for one topic: its messages have one time."""
    first: dict[str, Plan] = {}
    for plan in plans:
        known = plan if plan.clock is None else first.setdefault(plan.topic, plan)
        if (plan.clock, plan.stamp) != (known.clock, known.stamp):
            yield place.warning(
                f"two clocks are stated for {plan.topic}, with {channel_name(known)} and with "
                f"{channel_name(plan)}; the first is taken for both.",
                remedy="Delete one in vehicle.yaml.",
            )


def channel_name(plan: Plan) -> str:
    """Name of the channel that a plan makes: the quantity, and the thruster if it is one's own."""
    if plan.of_one:
        return f"{plan.quantity}.{plan.thrusters[0]}"
    return QUANTITIES[plan.quantity].channel or plan.quantity


def key_of(plan: Plan) -> tuple[str, str]:
    """Return what tells the plans of a run apart; a table may have a depth and a pressure."""
    return plan.topic, f"{channel_name(plan)} {plan.quantity} {plan.fields}"


def nothing_mapped(
    place: Place, topics: Sequence[TopicFound], problems: Sequence[Problem]
) -> InputError:
    """Make the error that says what the log holds, where nothing of it can be used."""
    listed = []
    for topic in topics[:20]:
        why = f": {topic.why_not}" if topic.why_not else ""
        kind = f"{topic.message_type}, " if topic.message_type else ""
        listed.append(f"  {topic.name} ({kind}{topic.encoding}, {topic.messages} messages){why}")
    listed += [f"  and {len(topics) - 20} more"] if len(topics) > 20 else []
    listed += [f"  {problem.what}" for problem in problems]
    return InputError.at(
        place,
        "none of its topics is known to carry a command or a reading:\n" + "\n".join(listed),
        expected="thruster commands, and readings such as angular velocity, attitude or depth.",
        remedy="State where they are under pool: channels in vehicle.yaml.",
    )


def requests_of(
    plans: Sequence[Plan],
) -> tuple[dict[str, Request], dict[tuple[str, str], tuple[int, int]]]:
    """Put the plans of one topic together; return where each finds its numbers."""
    requests: dict[str, Request] = {}
    where: dict[tuple[str, str], tuple[int, int]] = {}
    for topic in dict.fromkeys(plan.topic for plan in plans):
        own = [plan for plan in plans if plan.topic == topic]
        numbers: list[FieldPath] = []
        for plan in own:
            begin = len(numbers)
            numbers += plan.request.numbers
            where[key_of(plan)] = (begin, len(numbers))
        timed = [plan for plan in own if plan.clock is not None] or own
        requests[topic] = Request(
            tuple(numbers),
            next((plan.stamp for plan in timed if plan.stamp is not None), None),
            next((plan.names for plan in own if plan.names is not None), None),
            frozenset[FieldPath]().union(*(plan.request.flags for plan in own)),
        )
    return requests, where
