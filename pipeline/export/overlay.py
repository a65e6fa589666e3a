"""Write a measured log once more with a simulation of the same commands beside it.

Every recorded message is copied byte for byte, chunk after chunk; the simulated ones are merged in
by log time under ``/sim``, so that a log viewer shows both on one axis.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

from pipeline.export.log_topics import Topic, WaterConstants, topics_of_log, topics_of_truth
from pipeline.export.mcap_log import (
    LIBRARY,
    PROFILE,
    SIMULATED_PREFIX,
    messages_in_order,
    register_topics,
    write_whole,
)
from pipeline.records.run_arrays import RecordedLog, RecordedMessage

if TYPE_CHECKING:  # the simulator brings the compiler along; writing a log does not need it
    from mcap.writer import Writer

    from pipeline.simulate.run import Trajectory
    from pipeline.simulate.sensors import Log

_ROOT = SIMULATED_PREFIX + "/"
#: What made this file, and what made the recorded one where that was simulated, too.
_RUN, _RECORDED_RUN = "rig2sea.run", "rig2sea.recorded_run"
Simulated = tuple[int, int, int, bytes]


def write_overlay(
    path: Path,
    recorded: RecordedLog,
    simulated: "Log",
    *,
    vehicle_name: str,
    density_kgpm3: float,
    gravity_mps2: float,
    start_time_ns: int,
    truth: "Trajectory | None" = None,
    more: Sequence[Topic] = (),
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write a recorded log with simulated channels; the file is there complete or not at all.

    It may be the recorded file: that is read to its end first. Topics of the recorded log under
    ``/sim`` are of an earlier simulation and left out; all of `simulated`, what the sensors would
    have logged, goes there. A log that states density and gravity of its own keeps them for both
    sides, so that a reader turns pressure back alike. `start_time_ns` is time zero of the simulated
    run on the clock of the log [ns since 1970]; the rest is as of `write_run_log`.

    Raises
    ------
    CannotComputeError
        When the simulated side cannot be written as messages, or the file cannot be written.
    InputError
        When the recorded log cannot be read.
    """
    density_kgpm3, gravity_mps2 = _water_of(recorded, density_kgpm3, gravity_mps2)
    topics = topics_of_log(simulated, WaterConstants(density_kgpm3, gravity_mps2), SIMULATED_PREFIX)
    if truth is not None:
        topics += topics_of_truth(truth, simulated["command"].columns, SIMULATED_PREFIX)
    topics += more
    made = dict(sorted((metadata or {}).items()))

    def write(stream: IO[bytes]) -> None:
        _write(stream, recorded, topics, made, start_time_ns)

    write_whole(path, write, f"the log of {vehicle_name}")


def _write(
    stream: IO[bytes],
    recorded: RecordedLog,
    topics: Sequence[Topic],
    made: dict[str, str],
    start_time_ns: int,
) -> None:
    from mcap.writer import CompressionType, Writer

    writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(PROFILE, LIBRARY)
    ours = register_topics(writer, topics)
    simulated = messages_in_order(topics, start_time_ns)
    waiting = next(simulated, None)
    known: dict[int, int | None] = {}
    for message in recorded.messages():
        waiting = _up_to(writer, ours, simulated, waiting, message.log_time_ns)
        if message.number not in known:
            known[message.number] = _register(writer, recorded, message)
        channel = known[message.number]
        if channel is not None:
            writer.add_message(
                channel,
                message.log_time_ns,
                message.data,
                message.publish_time_ns,
                message.sequence,
            )
    _up_to(writer, ours, simulated, waiting, None)
    # last: a log without an index tells its metadata as it is read
    for name, entries in recorded.metadata.items():
        writer.add_metadata(_RECORDED_RUN if name == _RUN else name, dict(entries))
    writer.add_metadata(_RUN, made)
    writer.finish()  # type: ignore[no-untyped-call]  # mcap has no annotations


def _up_to(
    writer: "Writer",
    channels: Sequence[int],
    simulated: Iterator[Simulated],
    waiting: Simulated | None,
    until_ns: int | None,
) -> Simulated | None:
    """Write the simulated messages up to a log time, all without one; return the next."""
    while waiting is not None and (until_ns is None or waiting[2] <= until_ns):
        source, row, time_ns, data = waiting
        writer.add_message(channels[source], time_ns, data, time_ns, row)
        waiting = next(simulated, None)
    return waiting


def _register(writer: "Writer", recorded: RecordedLog, message: RecordedMessage) -> int | None:
    """Describe a recorded topic in the new file; None for one that is left out."""
    topic = recorded.topic(message.number)
    if topic is None or topic.topic.startswith(_ROOT):
        return None
    schema = 0
    if topic.schema_name or topic.schema_data:
        schema = writer.register_schema(topic.schema_name, topic.schema_encoding, topic.schema_data)
    return writer.register_channel(
        topic.topic, topic.message_encoding, schema, dict(topic.metadata)
    )


def _water_of(
    recorded: RecordedLog, density_kgpm3: float, gravity_mps2: float
) -> tuple[float, float]:
    """Density and gravity that the log states for its pressure, else those given."""
    stated = recorded.metadata.get("rig2sea.log", {})
    try:
        own = float(stated["density_kgpm3"]), float(stated["gravity_mps2"])
    except (KeyError, ValueError):
        return density_kgpm3, gravity_mps2
    # a log may state anything: "0", "nan" and "-9" are numbers, too
    possible = all(math.isfinite(one) and one > 0.0 for one in own)
    return own if possible else (density_kgpm3, gravity_mps2)
