"""Logs for the tests of the pool-run reader; a module of the tests, not a test."""

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from mcap.writer import CompressionType, Writer
from mcap_ros2._dynamic import serialize_dynamic

from pipeline.export.cdr import schema_text
from pipeline.ingest.pool_run_codec import codec_of
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

START_NS = 1_700_000_000_000_000_000
SECOND_NS = 1_000_000_000


@dataclass
class Topic:
    """Messages of one topic: log times and contents."""

    name: str
    schema_name: str
    schema_encoding: str
    schema: bytes
    encoding: str
    times_ns: Sequence[int]
    messages: Sequence[bytes]
    options: Mapping[str, str] = field(default_factory=dict)


def log_bytes(
    topics: Sequence[Topic],
    *,
    chunk_size: int = 20_000,
    compression: CompressionType = CompressionType.ZSTD,
    metadata: Mapping[str, dict[str, str]] | None = None,
    by_time: bool = True,
    **options: Any,  # noqa: ANN401  of the writer
) -> bytes:
    """A log as bytes, messages in the order of their log times; else topic by topic."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=chunk_size, compression=compression, **options)
    writer.start(profile="ros2", library="tests")
    for name, entries in (metadata or {}).items():
        writer.add_metadata(name, entries)
    rows = []
    for topic in topics:
        schema = 0
        if topic.schema_encoding:
            schema = writer.register_schema(topic.schema_name, topic.schema_encoding, topic.schema)
        channel = writer.register_channel(topic.name, topic.encoding, schema, dict(topic.options))
        rows += [
            (time, channel, message)
            for time, message in zip(topic.times_ns, topic.messages, strict=True)
        ]
    for time, channel, message in sorted(rows, key=lambda row: row[0]) if by_time else rows:
        writer.add_message(channel, time, message, time)
    writer.finish()
    return stream.getvalue()


def write_log(path: Path, topics: Sequence[Topic], **options: Any) -> Path:  # noqa: ANN401
    """A log as a file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(log_bytes(topics, **options))
    return path


def ros_topic(
    name: str, message_type: str, times_ns: Sequence[int], contents: Sequence[Any], text: str = ""
) -> Topic:
    """A topic of ROS 2 messages, encoded by a library that is not ours."""
    definition = text or schema_text(message_type)
    encode = serialize_dynamic(message_type, definition)[message_type]
    messages = [bytes(encode(content)) for content in contents]
    return Topic(name, message_type, "ros2msg", definition.encode(), "cdr", times_ns, messages)


def json_topic(name: str, times_ns: Sequence[int], contents: Sequence[Any]) -> Topic:
    """A topic of JSON messages without a schema."""
    messages = [json.dumps(content).encode() for content in contents]
    return Topic(name, "", "", b"", "json", times_ns, messages)


def stamp(time_ns: int) -> dict[str, int]:
    """A stamp of ROS 2."""
    return {"sec": int(time_ns) // SECOND_NS, "nanosec": int(time_ns) % SECOND_NS}


def vector(values: Sequence[float]) -> dict[str, float]:
    """A message with x, y, z (and w)."""
    return dict(zip("xyzw", map(float, values), strict=False))


def imu_topic(
    times_ns: Sequence[int],
    rates: FloatArray,
    *,
    name: str = "/imu/data",
    frame: str = "imu_frd",
    stamps_ns: Sequence[int] | None = None,
    forces: FloatArray | None = None,
) -> Topic:
    """An IMU without attitude: rates (k, 3), specific force (k, 3), at rest if not given."""
    stated = times_ns if stamps_ns is None else stamps_ns
    at_rest = np.tile([0.0, 0.0, -9.81], (len(times_ns), 1)) + 1e-3 * np.asarray(rates)
    felt = at_rest if forces is None else forces
    contents = [
        {
            "header": {"stamp": stamp(time), "frame_id": frame},
            "orientation": vector((0.0, 0.0, 0.0, 0.0)),
            "orientation_covariance": [-1.0] + [0.0] * 8,
            "angular_velocity": vector(rate),
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration": vector(force),
            "linear_acceleration_covariance": [0.0] * 9,
        }
        for time, rate, force in zip(stated, rates, felt, strict=True)
    ]
    return ros_topic(name, "sensor_msgs/msg/Imu", times_ns, contents)


def joints_topic(
    name: str,
    times_ns: Sequence[int],
    names: Sequence[Sequence[str]],
    values: FloatArray,
    which: str = "position",
) -> Topic:
    """Joint states with one array filled; `names` for each message."""
    contents = [
        {
            "header": {"stamp": stamp(time), "frame_id": ""},
            "name": list(texts),
            "position": [],
            "velocity": [],
            "effort": [],
        }
        | {which: [float(value) for value in row]}
        for time, texts, row in zip(times_ns, names, values, strict=True)
    ]
    return ros_topic(name, "sensor_msgs/msg/JointState", times_ns, contents)


def array_topic(name: str, times_ns: Sequence[int], values: Sequence[Sequence[float]]) -> Topic:
    """std_msgs/Float64MultiArray."""
    text = (
        "std_msgs/MultiArrayLayout layout\nfloat64[] data\n"
        + "=" * 80
        + "\nMSG: std_msgs/MultiArrayLayout\nstd_msgs/MultiArrayDimension[] dim\n"
        + "uint32 data_offset\n"
        + "=" * 80
        + "\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
    )
    contents = [
        {"layout": {"dim": [], "data_offset": 0}, "data": list(map(float, row))} for row in values
    ]
    return ros_topic(name, "std_msgs/msg/Float64MultiArray", times_ns, contents, text)


def ticks(count: int, rate_hz: float, start_ns: int = START_NS) -> IntArray:
    """Evenly spaced times."""
    return start_ns + np.rint(np.arange(count) * (SECOND_NS / rate_hz)).astype(np.int64)


def rov(**pool: object) -> Vehicle:
    """A vehicle of four thrusters with distinct moments and the given ``pool:`` section."""
    thrusters = [
        ("port", (-0.3, -0.2, 0.0), (1.0, 0.0, 0.0)),
        ("starboard", (-0.3, 0.2, 0.0), (1.0, 0.0, 0.0)),
        ("bow", (0.4, 0.0, 0.0), (0.0, 0.0, -1.0)),
        ("side", (0.0, 0.0, 0.15), (0.0, 1.0, 0.0)),
    ]
    return Vehicle.model_validate(
        {
            "name": "trial",
            "title": "A vehicle for tests",
            "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
            "propellers": {"screw": {"diameter_m": 0.14}},
            "drives": {"drive": {"code_min": -100, "code_max": 100}},
            "thrusters": [
                {
                    "name": name,
                    "propeller": "screw",
                    "drive": "drive",
                    "position_m": position,
                    "direction": direction,
                }
                for name, position, direction in thrusters
            ],
            "tables": {"propeller": "screw", "drive": "drive"},
            "pool": pool,
        }
    )


NAMES = ("port", "starboard", "bow", "side")


@contextmanager
def messages_one_by_one() -> Iterator[None]:
    """Let every message be decoded by itself, as those without a definition are: an oracle."""
    with patch(
        "pipeline.ingest.pool_run_topics.codec_of",
        lambda *of: replace(codec_of(*of), definition=None),
    ):
        yield
