"""Read a pool-run log: every mapped channel as arrays, with what is wrong marked and told."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.bench_file import source_name
from pipeline.ingest.command_units import guess_units
from pipeline.ingest.log_source import LogFacts, open_log
from pipeline.ingest.log_times import LONGEST_RUN_NS, mend_log_times
from pipeline.ingest.pool_run_channel import Found, channel_of, parts_of, timings_of, water_of
from pipeline.ingest.pool_run_choice import ChannelSource, choose_sources, topics_read
from pipeline.ingest.pool_run_clocks import Timing
from pipeline.ingest.pool_run_convert import WaterOfRun, convert
from pipeline.ingest.pool_run_extract import TopicData
from pipeline.ingest.pool_run_health import rhythm_of
from pipeline.ingest.pool_run_messages import (
    broken_messages,
    each_once,
    miscounted,
    told_of,
    told_of_run,
)
from pipeline.ingest.pool_run_plan import Plan, TopicFound
from pipeline.ingest.pool_run_resample import resample
from pipeline.ingest.pool_run_topics import (
    channel_name,
    key_of,
    nothing_mapped,
    plans_of,
    requests_of,
)
from pipeline.records.pool_run import ChannelSummary, PoolRunRecord, RunNotes
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.types import FloatArray
from pipeline.vehicle.run_notes import notes_file, read_run_notes
from pipeline.vehicle.schema import Vehicle

__all__ = ["read_pool_run", "resample", "summarize"]


def read_pool_run(path: Path, vehicle: Vehicle, raw_root: Path) -> PoolRun:
    """Read the channels of a log that the vehicle's ``pool:`` section or a default maps.

    What is wrong with a channel is in `problems` and `marks`; the other channels are read. Names in
    messages are relative to `raw_root`. Raises `InputError` if the file is no log, holds no
    messages, or none of its topics can be used.
    """
    shown_as = source_name(path, raw_root)
    place = Place(shown_as)
    problems: list[Problem] = []
    log = open_log(path, shown_as)
    notes = _notes_of(path, raw_root, problems)
    topics = log.topics()
    _check_messages(topics, log.facts())
    facts = log.facts()
    plans = plans_of(vehicle, topics, facts, problems, () if notes is None else notes.channels)
    if not plans.every:
        raise nothing_mapped(place, topics, problems)
    requests, where = requests_of(plans.every)
    taken = log.extract(requests)
    problems += broken_messages(place, taken)
    problems += miscounted(place, topics, taken)
    data = mend_log_times(taken, place, problems)
    timings = timings_of(plans.every, data, vehicle, place, problems)
    reading = _Reading(
        vehicle, place, {topic.name: topic for topic in topics}, data, where, timings
    )
    facts = log.facts()
    channels = reading.channels(plans.settled, water_of(vehicle, facts.metadata))
    read = (
        [reading.channels((plan,), water_of(vehicle, facts.metadata)) for plan in group]
        for group in plans.groups
    )
    groups = [[one for one in group if one] for group in read]
    run = PoolRun(
        vehicle.name,
        place.file,
        channels,
        (),
        (),
        *_extent(channels, groups),
        facts.complete,
        facts.read_bytes,
        facts.size,
        facts.writer,
        dict(facts.metadata),
        tuple(thruster.name for thruster in vehicle.thrusters),
        notes,
    )
    # in the order of the quantities, as the plans have them
    channels = channels | choose_sources(groups, run, vehicle, problems)
    told: set[tuple[str, str]] = set()
    begin_ns, end_ns = _extent(channels, [])
    for name, channel in channels.items():
        problems += told_of(name, channel, place, begin_ns, told)
    problems += [*reading.doubts(channels), *reading.refused, *facts.problems]
    run = replace(
        run,
        channels=channels,
        topics=topics_read(topics, channels, groups, vehicle),
        start_time_ns=begin_ns,
        end_time_ns=end_ns,
    )
    problems += told_of_run(run, topics, vehicle)
    return replace(run, problems=tuple(each_once(problems)))


def _check_messages(topics: Sequence[TopicFound], facts: LogFacts) -> None:
    if any(topic.messages for topic in topics):
        return
    what = "the log holds no messages"
    if not facts.complete:
        what = f"the log was cut off after {facts.size} bytes and holds no messages"
    elif facts.problems:
        what += f" that can be read: {facts.problems[0].what.rstrip('.')}"
    what += "."
    expected, remedy = "messages of thrusters and sensors.", "Check that the recorder ran."
    raise InputError(facts.place.error(what, expected, remedy))


@dataclass(frozen=True)
class _Reading:
    """What was taken from a log, to be made into channels."""

    vehicle: Vehicle
    place: Place
    topics: Mapping[str, TopicFound]
    data: Mapping[str, TopicData]
    where: Mapping[tuple[str, str], tuple[int, int]]
    timings: Mapping[str, Timing]
    refused: list[Problem] = field(default_factory=list)
    """Channels that may mean two things."""
    _doubts: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def channels(self, plans: Sequence[Plan], water: WaterOfRun) -> dict[str, RunChannel]:
        """Convert what was taken for these plans; one is left out that gives nothing."""
        commands = [
            plan for plan in plans if plan.quantity == "thruster_command" and plan.names is None
        ]
        units = guess_units(
            {key_of(plan): self._numbers(plan) for plan in commands},
            self.vehicle.pool.pwm_range,
            {key_of(plan): plan.unit for plan in commands},
            one_way=all(drive.code_min >= 0 for drive in self.vehicle.drives.values()),
        )
        found: dict[str, RunChannel] = {}
        for plan in plans:
            taken = self.data[plan.topic]
            begin = self.where[key_of(plan)][0] + len(plan.numbers)
            flags = taken.values[:, begin : begin + len(plan.flags)].T
            numbers = self._numbers(plan)
            invalid = [
                flag.invalid(one, numbers) for flag, one in zip(plan.flags, flags, strict=True)
            ]
            with np.errstate(over="ignore", invalid="ignore"):  # damaged bytes are any number
                guessed = units.get(key_of(plan))
                converted = convert(plan, numbers, self.vehicle, water, taken, guessed=guessed)
            if converted.unclear:
                self.refused.append(
                    self.place.error(
                        f"{channel_name(plan)} ({plan.topic}): {converted.unclear}. So it was left "
                        "out.",
                        "commands whose rest is known.",
                        "State it under pool: channels in vehicle.yaml.",
                    )
                )
            if not converted.values.shape[0] or not converted.columns:
                continue
            topic = self.topics[plan.topic]
            whole = Found(plan, converted, taken, self.timings[plan.topic], topic, invalid)
            for name, part in parts_of(whole, channel_name(plan)):
                found[name] = channel_of(part, self.vehicle)
                self._doubts[f"{name} {plan.topic}"] = (
                    *plan.doubts,
                    *filter(None, [converted.doubt]),
                    *self._spare(plan),
                )
        return found

    def doubts(self, channels: Mapping[str, RunChannel]) -> Iterator[Problem]:
        """Say what was assumed of the channels that were taken and may be wrong."""
        yield from (
            self.place.warning(
                f"{name} ({channel.topic}): {text}.",
                remedy="State it under pool: channels in vehicle.yaml.",
            )
            for name, channel in channels.items()
            for text in self._doubts.get(f"{name} {channel.topic}", ())
        )

    def _numbers(self, plan: Plan) -> FloatArray:
        """Return what was taken from the messages for a plan (k, m)."""
        return self._elements(plan)[:, : plan.wanted]

    def _elements(self, plan: Plan) -> FloatArray:
        """Return all numbers of the field, those beyond the last thruster, too."""
        begin = self.where[key_of(plan)][0]
        return self.data[plan.topic].values[:, begin : begin + len(plan.numbers)]

    def _spare(self, plan: Plan) -> Iterator[str]:
        """Say where elements move that no thruster was left for, and some that are taken do not."""
        moves = np.array([np.nanmax(one, initial=-np.inf) > np.nanmin(one, initial=np.inf)
                          for one in self._elements(plan).T])  # fmt: skip
        if moves[plan.wanted :].any() and not moves[: plan.wanted].all():
            still, alive = (np.flatnonzero(one).tolist() for one in (~moves[: plan.wanted], moves))
            spare = [at for at in alive if at >= plan.wanted]
            yield (
                f"its elements {', '.join(map(str, still))} (from 0) never change, and "
                f"{', '.join(map(str, spare))}, which change, were not read: thrusters may be "
                "other elements"
            )


def _notes_of(path: Path, raw_root: Path, problems: list[Problem]) -> RunNotes | None:
    """Read the notes beside a log; what is wrong with them does not stop the run."""
    file = notes_file(path)
    if file is None:
        return None
    try:
        return read_run_notes(file, source_name(file, raw_root))
    except InputError as error:
        problems.append(error.problem)
        return None


def summarize(run: PoolRun) -> PoolRunRecord:
    """Summarise a run for ``processed/``: channels, clocks, counts of marks, problems."""
    return PoolRunRecord(
        vehicle=run.vehicle,
        file=run.file,
        start_time_ns=run.start_time_ns,
        duration_s=run.duration_s,
        complete=run.complete,
        read_bytes=run.read_bytes,
        size_bytes=run.size_bytes,
        writer=run.writer,
        channels=tuple(
            _summary(name, channel, run.start_time_ns) for name, channel in run.channels.items()
        ),
        topics=run.topics,
        metadata={name: dict(entries) for name, entries in run.metadata.items()},
        notes=run.notes,
        problems=run.problems,
    )


def _summary(name: str, channel: RunChannel, start_ns: int) -> ChannelSummary:
    timely = channel.timely()
    time_ns = channel.time_ns[timely if timely.any() else slice(None)]
    rhythm = rhythm_of(time_ns)
    rate = 1.0 / channel.period_s if channel.period_s > 0 else None
    finite = [column[np.isfinite(column)] for column in channel.values.T]
    return ChannelSummary(
        name=name,
        read=channel.read,
        clock=channel.clock,
        columns=channel.columns,
        readings=int(channel.time_ns.size),
        rate_hz=rate,
        is_regular=channel.is_regular,
        delay_s=channel.delay_s,
        first_s=(int(time_ns.min()) - start_ns) / 1e9,
        last_s=(int(time_ns.max()) - start_ns) / 1e9,
        longest_gap_s=rhythm.longest_gap_s,
        marks={mark: int(rows.sum()) for mark, rows in channel.marks.items()},
        lowest=tuple(float(one.min()) if one.size else None for one in finite),
        highest=tuple(float(one.max()) if one.size else None for one in finite),
    )


def _extent(
    channels: Mapping[str, RunChannel], groups: Sequence[Sequence[ChannelSource]]
) -> tuple[int, int]:
    """Return the first and the last log time [ns], without those that damage made wild."""
    every = [
        *channels.values(),
        *(one for group in groups for each in group for one in each.values()),
    ]
    times = [channel.log_time_ns for channel in every if channel.log_time_ns.size]
    if not times:
        return 0, 0
    logged = np.concatenate(times)
    middle = int(np.partition(logged, logged.size // 2)[logged.size // 2])
    # as floats: the difference of two wild times may not fit into 64 bits
    near = logged[np.abs(logged.astype(float) - float(middle)) <= LONGEST_RUN_NS]
    return int(near.min()), int(near.max())
