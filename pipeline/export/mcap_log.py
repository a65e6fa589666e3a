"""Write a simulated run as an MCAP log with standard ROS 2 messages.

The same run gives the same bytes: every time in the file comes from the run, none from a clock.
"""

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from pipeline.errors import CannotComputeError, writing_remedy
from pipeline.export.cdr import schema_text, serialise
from pipeline.export.log_topics import (
    ATMOSPHERIC_PRESSURE_PA,
    Topic,
    WaterConstants,
    nanoseconds_of_run,
    topics_of_log,
    topics_of_truth,
)
from pipeline.whole_file import whole_file

if TYPE_CHECKING:  # the simulator brings the compiler along; writing a log does not need it
    from mcap.writer import Writer

    from pipeline.simulate.run import Trajectory
    from pipeline.simulate.sensors import Log

#: Time zero of a run where the caller states none: 14 November 2023, 22:13:20 UTC.
DEFAULT_START_TIME_NS = 1_700_000_000_000_000_000
#: Prefix of what was not measured on board.
SIMULATED_PREFIX = "/sim"
#: Version of the layout that docs/formats_log.md describes.
LAYOUT_VERSION = "1"
PROFILE = "ros2"
#: Name of the program without its version: bytes change only with the content.
LIBRARY = "rig2sea"
#: How a log of this program begins: magic, opcode and length of the header, and its two texts.
_OWN_HEAD = (
    struct.pack("<8sBQ", b"\x89MCAP0\r\n", 1, 8 + len(PROFILE) + len(LIBRARY))
    + struct.pack(f"<I{len(PROFILE)}s", len(PROFILE), PROFILE.encode())
    + struct.pack(f"<I{len(LIBRARY)}s", len(LIBRARY), LIBRARY.encode())
)
#: Messages that are serialised at a time: bounds the memory.
_BLOCK = 20_000


def write_run_log(
    path: Path,
    log: "Log",
    *,
    vehicle_name: str,
    density_kgpm3: float,
    gravity_mps2: float,
    truth: "Trajectory | None" = None,
    simulated: "Log | None" = None,
    more: Sequence[Topic] = (),
    metadata: Mapping[str, str] | None = None,
    start_time_ns: int = DEFAULT_START_TIME_NS,
) -> None:
    """Write a run, ``*.mcap``; the file is there complete or not at all.

    `log` is what the sensors on board logged, its "command" channel names the thrusters; density
    and gravity turn depth into pressure. [kg/m^3], [m/s^2] The true motion, and the same channels
    from a simulation, are written under ``/sim``, so that a log viewer shows both on one axis;
    `more` topics have their own prefix. `metadata` says what else a reader should know (manoeuvre,
    effects, seed, versions, digests), `start_time_ns` is time zero of the run since 1970 [ns].

    Raises
    ------
    CannotComputeError
        When the log cannot be written as messages (see `topics_of_log`), the thrusters of `truth`
        have no names, or the file cannot be written.
    """
    water = WaterConstants(density_kgpm3, gravity_mps2)
    topics = topics_of_log(log, water)
    if simulated is not None:
        topics += topics_of_log(simulated, water, SIMULATED_PREFIX)
    if truth is not None:
        if "command" not in log:
            raise CannotComputeError(
                f"the log of {vehicle_name} has no command channel, so the thrusters of the true "
                "run have no names"
            )
        topics += topics_of_truth(truth, log["command"].columns, SIMULATED_PREFIX)
    topics += more
    records = {
        "rig2sea.log": {
            "layout": LAYOUT_VERSION,
            "vehicle": vehicle_name,
            "start_time_ns": str(start_time_ns),
            "density_kgpm3": repr(float(density_kgpm3)),
            "gravity_mps2": repr(float(gravity_mps2)),
            "atmospheric_pressure_pa": repr(ATMOSPHERIC_PRESSURE_PA),
        },
        "rig2sea.run": dict(sorted((metadata or {}).items())),
    }

    def write(stream: IO[bytes]) -> None:
        _write(stream, topics, records, start_time_ns)

    write_whole(path, write, f"the log of {vehicle_name}")


def is_of_others(path: Path) -> bool:
    """Tell whether a file is there that is no log of this program, by its first bytes.

    A file that is empty or cannot be opened is not lost when a log is written in its place.
    """
    try:
        with path.open("rb") as stream:
            return stream.read(len(_OWN_HEAD)) not in (b"", _OWN_HEAD)
    except OSError:
        return False


def write_whole(path: Path, write: Callable[[IO[bytes]], None], what: str) -> None:
    """Write a file that is there complete or not at all; `what` it is, for the message.

    Raises
    ------
    CannotComputeError
        When it cannot be written.
    """
    try:
        with whole_file(path) as stream:
            write(stream)
    except OSError as error:
        raise CannotComputeError(
            f"{path}: {what} cannot be written: {error.strerror or error}.\n"
            + writing_remedy(error, "Make the folder writable, or name another file.")
        ) from error


def _write(
    stream: IO[bytes],
    topics: list[Topic],
    records: Mapping[str, dict[str, str]],
    start_time_ns: int,
) -> None:
    from mcap.writer import CompressionType, Writer

    writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(PROFILE, LIBRARY)
    for name, entries in records.items():
        writer.add_metadata(name, entries)
    channels = register_topics(writer, topics)
    for source, row, time_ns, message in messages_in_order(topics, start_time_ns):
        writer.add_message(channels[source], time_ns, message, time_ns, row)
    writer.finish()  # type: ignore[no-untyped-call]  # mcap has no annotations


def register_topics(writer: "Writer", topics: Sequence[Topic]) -> list[int]:
    """Describe topics in a file that is being written; returns their numbers there."""
    schemas: dict[str, int] = {}
    channels = []
    for topic in topics:
        kind = topic.message_type
        if kind not in schemas:
            schemas[kind] = writer.register_schema(kind, "ros2msg", schema_text(kind).encode())
        description = {"meaning": topic.meaning, "offered_qos_profiles": ""}
        channels.append(writer.register_channel(topic.name, "cdr", schemas[kind], description))
    return channels


def messages_in_order(
    topics: Sequence[Topic], start_time_ns: int
) -> Iterator[tuple[int, int, int, bytes]]:
    """Messages of all topics as they were logged: index of topic, number in it, time, bytes."""
    logged = [nanoseconds_of_run(topic.logged_s, start_time_ns, topic.name) for topic in topics]
    none = np.empty(0, np.int64)
    times = np.concatenate([none, *logged])
    sources = np.repeat(np.arange(len(topics)), [part.size for part in logged])
    rows = np.concatenate([none, *(np.arange(part.size) for part in logged)])
    order = np.lexsort((rows, sources, times))
    for begin in range(0, order.size, _BLOCK):
        block = order[begin : begin + _BLOCK]
        messages = [b""] * block.size
        for source, topic in enumerate(topics):
            places = np.flatnonzero(sources[block] == source)
            chosen = topic.rows(rows[block[places]], start_time_ns)
            matrix = serialise(topic.message_type, places.size, chosen)
            size, content = matrix.shape[1], matrix.tobytes()
            for i, place in enumerate(places.tolist()):
                messages[place] = content[i * size : (i + 1) * size]
        yield from zip(
            sources[block].tolist(),
            rows[block].tolist(),
            times[block].tolist(),
            messages,
            strict=True,
        )
