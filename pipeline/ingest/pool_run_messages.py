"""What a person is told of a run: marks in words, missing commands, channels that end early."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.pool_run_choice import consistency_problems
from pipeline.ingest.pool_run_extract import TopicData
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.records.run_arrays import MARKS, PoolRun, RunChannel
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Marks that belong to the messages of a topic, not to one of its channels.
_TIME_MARKS = ("clock_jump", "reset", "out_of_order", "after_gap", "late", "no_stamp")
_OF_CLOCKS = (
    "Check clock and driver; state clock: log under pool: channels if its stamps are wrong."
)
_OF_SENSORS = "Check sensor, cable and driver; what is marked does not count."
#: Marks in the order in which they are told; broken messages are told of by topic.
_GRAVEST_FIRST = (
    *("not_a_number", "clock_jump", "reset", "out_of_order", "after_gap", "dropout", "frozen"),
    *("outside_range", "saturated", "spike", "duplicate", "same_stamp", "late", "no_stamp"),
)
#: Marks that are notes as long as few readings have them.
_PLAIN_MARKS = ("saturated", "same_stamp", "late", "frozen")
#: The times of a log are in order but for messages that waited together. [s]
_SET_BACK_S = 1.0
#: A topic of fewer messages is told in its line alone.
_MANY_MESSAGES = 10
#: Types of messages that no state of a vehicle is read from.
_NO_READINGS = re.compile(r"Image|Cloud|Scan|Log$|Event|Marker|String|Map|Camera|Transform|TFMess")


def broken_messages(place: Place, data: Mapping[str, TopicData]) -> Iterator[Problem]:
    """Say which topics have messages that cannot be decoded."""
    for topic, taken in data.items():
        if count := int(taken.broken.sum()):
            yield place.warning(
                f"{topic}: {count} of {taken.broken.size} messages cannot be decoded: "
                f"{taken.why_broken}.",
                remedy="They are marked and left out.",
            )


def miscounted(
    place: Place, topics: Sequence[TopicFound], data: Mapping[str, TopicData]
) -> Iterator[Problem]:
    """Say which topics have other numbers of messages than the log's summary says."""
    counts = {topic.name: topic.messages for topic in topics}
    yield from (
        place.warning(
            f"{topic}: the log's summary counts {counts[topic]} messages, "
            f"{taken.log_time_ns.size} were found."
        )
        for topic, taken in data.items()
        if counts[topic] != taken.log_time_ns.size
    )


def told_of_run(run: PoolRun, topics: Sequence[TopicFound], vehicle: Vehicle) -> Iterator[Problem]:
    """Say what is wrong with a run as a whole, and what its channels say of each other."""
    yield from _told_of_topics(topics, run)
    yield from _told_of_commands(run, vehicle)
    yield from consistency_problems(run, vehicle)
    for tell in (_told_of_recorder, _told_of_velocity, _told_of_coverage, _told_of_thrust):
        yield from tell(run)


def _told_of_topics(topics: Sequence[TopicFound], run: PoolRun) -> Iterator[Problem]:
    """Say which topics cannot be decoded although they may carry readings, and how others can."""
    lost = [
        f"{topic.name} ({topic.message_type or topic.encoding}): {topic.why_not}"
        for topic in topics
        if topic.why_not
        and topic.messages >= _MANY_MESSAGES
        and topic.probe is None
        and not _NO_READINGS.search(topic.message_type)
    ]
    # where there are no commands, the error that says so lists all topics
    if lost and any(one.quantity == "thruster_command" for one in run.channels.values()):
        yield run.place.warning(f"topics with messages that cannot be read: {'; '.join(lost[:6])}.")
    if packed := [topic.name for topic in topics if topic.packed]:
        yield run.place.note(
            f"the messages of {', '.join(packed[:6])} are zstd-compressed one by one (ros2 bag, "
            "compression mode message); they were unpacked one by one.",
            remedy="For other programs: ros2 bag convert, compression_mode file or none.",
        )
    ros1 = [topic.name for topic in topics if topic.encoding == "ros1" and topic.probe is not None]
    if ros1 and run.file.lower().endswith(".mcap"):
        what = f"the messages of {', '.join(ros1[:6])} are encoded as in ROS 1."
        yield run.place.note(what, remedy="For programs of ROS 2: rosbags-convert.")


def told_of(
    name: str, channel: RunChannel, place: Place, run_start_ns: int, told: set[tuple[str, str]]
) -> Iterator[Problem]:
    """Say what is marked in a channel, the gravest first; marks of times once a topic."""
    counts = {mark: int(rows.sum()) for mark, rows in channel.marks.items()}
    for mark in _GRAVEST_FIRST:
        if not counts.get(mark) or (channel.topic, mark) in told:
            continue
        if mark == "outside_range" and channel.quantity == "thruster_command":
            continue  # said of each thruster with its range
        if mark in _TIME_MARKS:
            told.add((channel.topic, mark))
        first = int(np.argmax(channel.marks[mark]))
        at = (int(channel.log_time_ns[first]) - run_start_ns) / 1e9
        share = 100.0 * counts[mark] / channel.time_ns.size
        share_text = f"{share:.2g}" if share < 10.0 else f"{share:.0f}"
        what = (
            f"{name} ({channel.topic}): {counts[mark]} of {channel.time_ns.size} readings "
            f"({share_text} %) are marked {mark.replace('_', ' ')}: {MARKS[mark]}; the "
            f"first at {at:.3f} s."
        )
        plain = mark in _PLAIN_MARKS and share < 5.0
        severity: Literal["note", "warning"] = "note" if plain else "warning"
        yield Problem(severity, place, what, "", _OF_CLOCKS if mark in _TIME_MARKS else _OF_SENSORS)
    constant = [
        column
        for column, values in zip(channel.columns, channel.values.T, strict=True)
        if values.size >= 10 and _is_constant(values)
    ]
    all_constant = len(constant) == len(channel.columns)
    if all_constant and channel.quantity != "thruster_command":
        what = f"{name} ({channel.topic}) never changes: the sensor is dead or not connected."
        yield place.warning(what, remedy="Check the sensor.")
    elif constant and not channel.holds and channel.quantity != "attitude":
        yield place.warning(f"{name} ({channel.topic}): {', '.join(constant)} never changes.")


def _is_constant(values: FloatArray) -> bool:
    finite = values[np.isfinite(values)]
    return bool(finite.size and finite.min() == finite.max())


def _told_of_commands(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where commands are missing, beyond the drives, or never given."""
    commands = [one for one in run.channels.values() if one.quantity == "thruster_command"]
    if not commands:
        have = ", ".join(
            f"{topic.topic} ({topic.why_not})" if topic.why_not else topic.topic
            for topic in run.topics[:12]
        )
        yield run.place.error(
            f"there are no thruster commands; the run cannot be simulated. The log has {have}.",
            "a topic with the command of each thruster.",
            "State it under pool: channels with quantity: thruster_command in vehicle.yaml.",
        )
        return
    drives = {thruster.name: vehicle.drives[thruster.drive] for thruster in vehicle.thrusters}
    present = {column.removeprefix("command.") for part in commands for column in part.columns}
    missing = [name for name in drives if name not in present]
    if missing:
        what = f"there are no commands for {', '.join(missing)}."
        yield run.place.warning(what, "", "Map them, or they count as zero.")
    for channel in commands:
        beyond: dict[tuple[int, int], list[str]] = {}
        for column, values in zip(channel.columns, channel.values.T, strict=True):
            name = column.removeprefix("command.")
            drive = drives.get(name, vehicle.drive)
            finite = values[np.isfinite(values)]
            count = int(((finite > drive.code_max + 0.5) | (finite < drive.code_min - 0.5)).sum())
            if not finite.size:
                yield run.place.warning(f"{name}: no command is a number.")
            if count:
                said = f"{name} {count} ({finite.min():g} to {finite.max():g})"
                beyond.setdefault((drive.code_min, drive.code_max), []).append(said)
        for (least, most), thrusters in beyond.items():
            what = (
                f"commands ({channel.topic}) lie outside of the drive's range, {least} to {most}: "
                f"{', '.join(thrusters)}."
            )
            remedy = "Check unit and pwm_range of the channel, or the drive's range."
            yield run.place.warning(what, "", remedy)
    if all(_is_constant(values) for part in commands for values in part.values.T):
        yield run.place.warning(
            "no command ever changes: of the thrusters nothing can be learned from this run."
        )


def _told_of_recorder(run: PoolRun) -> Iterator[Problem]:
    """Say where the times of the log go back, and which readings they date far from the others."""
    topics = {channel.topic: channel.log_time_ns for channel in run.channels.values()}
    beyond = {
        topic: int(((logged < run.start_time_ns) | (logged > run.end_time_ns)).sum())
        for topic, logged in topics.items()
    }
    counts = [
        f"{count} of {topics[topic].size} of {topic}" for topic, count in beyond.items() if count
    ]
    if counts:
        yield run.place.warning(
            "readings are dated days away from most others, and are no part of the run: "
            f"{', '.join(counts)}.",
            "",
            "If the recorder's clock was set during the run, cut the log there.",
        )
    busiest = max(topics.values(), key=lambda logged: logged.size, default=np.zeros(0, np.int64))
    logged = busiest[(busiest >= run.start_time_ns) & (busiest <= run.end_time_ns)]
    step_s = np.diff(logged) / 1e9
    back = np.flatnonzero(step_s < -_SET_BACK_S)
    if back.size:
        at = (int(logged[back[0]]) - run.start_time_ns) / 1e9
        more = f" (and {back.size - 1} more times)" if back.size > 1 else ""
        yield run.place.warning(
            f"the times of the log go back by {-step_s[back[0]]:.3f} s after {at:.3f} s{more}: the "
            "recorder's clock was set, or the log was put together out of order. What follows is "
            "left out until they are later than before.",
            "",
            "Cut the log there, into two runs.",
        )


def _told_of_velocity(run: PoolRun) -> Iterator[Problem]:
    """Say where a velocity over the earth cannot become one of the body."""
    over_earth = run.channels.get("velocity_earth")
    if over_earth is not None and not {"velocity", "attitude"} & set(run.channels):
        yield run.place.warning(
            f"the velocity ({over_earth.topic}) is in the axes of the earth, and without an "
            "attitude it cannot be turned into those of the body: it is not used.",
            "",
            "Record the attitude; or, if it is in body axes, state quantity: velocity under pool: "
            "channels in vehicle.yaml.",
        )


def _told_of_thrust(run: PoolRun) -> Iterator[Problem]:
    """Say what a measured thrust is of use for."""
    topics = {one.topic for one in run.channels.values() if one.quantity == "thrust"}
    if topics:
        yield run.place.note(
            f"thrust was measured ({', '.join(sorted(topics))}). It is shown here and changes no "
            "table.",
            "",
            "For tables that follow it, put a copy of the log into mooring/.",
        )


def _told_of_coverage(run: PoolRun) -> Iterator[Problem]:
    """Say where a channel covers less than the run."""
    for name, channel in run.channels.items():
        if not channel.time_ns.size or run.duration_s < 1.0:
            continue
        late = (int(channel.log_time_ns.min()) - run.start_time_ns) / 1e9
        early = (run.end_time_ns - int(channel.log_time_ns.max())) / 1e9
        least = max(1.0, 0.05 * run.duration_s, 5.0 * np.nan_to_num(channel.period_s))
        if channel.holds and not channel.is_regular:
            early = 0.0
        if late > least or early > least:
            yield run.place.warning(
                f"{name} ({channel.topic}) covers {late:.1f} s to {run.duration_s - early:.1f} s "
                f"of the run of {run.duration_s:.1f} s."
            )


def each_once(problems: Sequence[Problem]) -> list[Problem]:
    """Errors first, then warnings, then notes; nothing twice."""
    order = {"error": 0, "warning": 1, "note": 2}
    return sorted(dict.fromkeys(problems), key=lambda problem: order[problem.severity])
