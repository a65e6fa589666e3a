"""Read a pool-run log: every mapped channel as arrays, with what is wrong marked and told."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.bench_file import source_name
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.pool_run_channel import Found, channel_of, timings_of, water_of
from pipeline.ingest.pool_run_convert import Names, convert, guess_units
from pipeline.ingest.pool_run_extract import TopicData, extract
from pipeline.ingest.pool_run_health import rhythm_of
from pipeline.ingest.pool_run_plan import Plan, TopicFound
from pipeline.ingest.pool_run_resample import resample
from pipeline.ingest.pool_run_suspicions import suspicions
from pipeline.ingest.pool_run_told import (
    broken_messages,
    each_once,
    told_of,
    told_of_commands,
    told_of_coverage,
    told_of_recorder,
    told_of_velocity,
)
from pipeline.ingest.pool_run_topics import (
    channel_name,
    key_of,
    nothing_mapped,
    plans_of,
    requests_of,
    topics_of,
)
from pipeline.records.pool_run import ChannelSummary, PoolRunRecord, TopicRead
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_notes import RunNotes
from pipeline.types import FloatArray
from pipeline.vehicle.run_notes import notes_file, read_run_notes
from pipeline.vehicle.schema import Vehicle

#: Log times further than this from the median one are damage. [ns]
_LONGEST_RUN_NS = 7 * 86_400 * 1e9

__all__ = ["read_pool_run", "resample", "summarize"]


def read_pool_run(
    path: Path, vehicle: Vehicle, raw_root: Path, *, prefix: str = "", fast: bool = True
) -> PoolRun:
    """Read the mapped channels of a log.

    Parameters
    ----------
    path : Path
        The MCAP file.
    vehicle : Vehicle
        Its ``pool:`` section maps channels; standard messages have defaults.
    raw_root : Path
        For the names in messages.
    prefix : str
        Read only topics that begin with it, as if they did not: ``/sim`` reads the simulated side
        of a log that has both.
    fast : bool
        Gather numbers of CDR messages at once. The slow way decodes each message and gives the
        same arrays; it is there to check the fast one.

    Returns
    -------
    PoolRun
        What is wrong with a channel is in `problems` and `marks`; the other channels are read.

    Raises
    ------
    InputError
        If the file is no MCAP file, holds no messages, or none of its topics can be used.
    """
    shown_as = source_name(path, raw_root)
    log = McapFile(path, shown_as)
    place = Place(shown_as)
    problems: list[Problem] = []
    codecs, topics = topics_of(log, prefix)
    if not any(topic.messages for topic in topics):
        what = "the log holds no messages"
        if not log.directory.complete:
            what = f"the log was cut off after {log.size} bytes and holds no messages"
        elif log.problems:
            what += f" that can be read: {log.problems[0].what.rstrip('.')}"
        raise InputError.at(
            place,
            what + (f" under {prefix}." if prefix else "."),
            expected="messages of thrusters and sensors.",
            remedy="Check that the recorder ran.",
        )
    plans = plans_of(vehicle, topics, place, problems, prefix)
    if not plans:
        raise nothing_mapped(place, topics, problems)
    requests, where = requests_of(plans)
    data = extract(log, codecs, requests, fast=fast)
    problems += broken_messages(place, data)
    timings = timings_of(plans, data, vehicle, place, problems)
    water = water_of(vehicle, log)
    channels: dict[str, RunChannel] = {}
    by_name = {topic.name: topic for topic in topics}
    units = guess_units(
        {
            key_of(plan): _taken(plan, data, where)
            for plan in plans
            if plan.quantity == "thruster_command" and plan.unit is None and plan.names is None
        }
    )
    for plan in plans:
        name = channel_name(plan)
        taken = data[plan.topic]
        end = where[key_of(plan)][0] + len(plan.numbers)
        invalid = None if plan.valid is None else taken.values[:, end] == 0.0
        names = None if taken.name_list is None else Names(taken.names, taken.name_list)
        with np.errstate(over="ignore", invalid="ignore"):  # damaged bytes are any number
            numbers = _taken(plan, data, where)
            guessed = units.get(key_of(plan))
            converted = convert(plan, numbers, vehicle, water, names, guessed=guessed)
        if converted.values.shape[0] and converted.columns:
            topic = by_name[plan.topic]
            found = Found(plan, converted, taken, timings[plan.topic], topic, invalid)
            channels[name] = channel_of(found, vehicle)
    extent_ns = _extent(channels)
    told: set[tuple[str, str]] = set()
    for name, channel in channels.items():
        problems += told_of(name, channel, place, extent_ns[0], told)
    problems += log.problems
    run = _run(vehicle, log, channels, topics, extent_ns)
    run = replace(run, notes=_notes_of(path, raw_root, problems))
    problems += told_of_commands(run, vehicle, place)
    problems += suspicions(run, vehicle)
    problems += [*told_of_recorder(run, place), *told_of_velocity(run, place)]
    problems += told_of_coverage(run, place)
    return replace(run, problems=tuple(each_once(problems)))


def _taken(
    plan: Plan,
    data: Mapping[str, TopicData],
    where: Mapping[tuple[str, str], tuple[int, int]],
) -> FloatArray:
    """Return what was taken from the messages for a plan (k, m)."""
    begin = where[key_of(plan)][0]
    return data[plan.topic].values[:, begin : begin + len(plan.numbers)]


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
    """Summarise a run for ``processed/``: channels, clocks, counts of marks, problems.

    Parameters
    ----------
    run : PoolRun
        The run.

    Returns
    -------
    PoolRunRecord
        Without the arrays.
    """
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
    extremes = [_extremes(column) for column in channel.values.T]
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
        lowest=tuple(lowest for lowest, _ in extremes),
        highest=tuple(highest for _, highest in extremes),
    )


def _extremes(column: FloatArray) -> tuple[float | None, float | None]:
    """Return the lowest and the highest of the finite values."""
    finite = column[np.isfinite(column)]
    return (float(finite.min()), float(finite.max())) if finite.size else (None, None)


def _extent(channels: Mapping[str, RunChannel]) -> tuple[int, int]:
    """Return the first and the last log time [ns], without those that damage made wild."""
    times = [channel.log_time_ns for channel in channels.values() if channel.log_time_ns.size]
    if not times:
        return 0, 0
    every = np.concatenate(times)
    middle = int(np.sort(every)[every.size // 2])
    # as floats: the difference of two wild times may not fit into 64 bits
    near = every[np.abs(every.astype(float) - float(middle)) <= _LONGEST_RUN_NS]
    return int(near.min()), int(near.max())


def _run(
    vehicle: Vehicle,
    log: McapFile,
    channels: Mapping[str, RunChannel],
    topics: Sequence[TopicFound],
    extent_ns: tuple[int, int],
) -> PoolRun:
    """Put the channels of a run together; its problems come later."""
    start_ns, end_ns = extent_ns
    used: dict[str, list[str]] = {}
    for name, channel in channels.items():
        used.setdefault(channel.topic, []).append(name)
    directory = log.directory
    return PoolRun(
        vehicle.name,
        log.place.file,
        channels,
        tuple(
            TopicRead(
                topic=topic.name,
                message_type=topic.message_type,
                encoding=topic.encoding,
                messages=topic.messages,
                used_for=tuple(used.get(topic.name, ())),
                why_not=topic.why_not,
            )
            for topic in sorted(topics, key=lambda topic: topic.name)
        ),
        (),
        start_ns,
        end_ns,
        directory.complete,
        log.read_bytes,
        log.size,
        directory.library,
        dict(directory.metadata),
        tuple(thruster.name for thruster in vehicle.thrusters),
    )
