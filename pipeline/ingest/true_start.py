"""The state in which a simulated run began: the first message of its true motion."""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.ingest.mcap_file import McapFile
from pipeline.types import FloatArray

MOTION_TOPIC = "/sim/odometry"
_MESSAGE = "nav_msgs/msg/Odometry"
_LONGEST_TEXT = 1000


@dataclass(frozen=True)
class StartOfRun:
    """Position NED (3,) [m], quaternion w x y z (4,), nu (6,) [m/s, rad/s] of the first sample."""

    position_ned_m: FloatArray
    quaternion: FloatArray
    nu: FloatArray


def read_true_start(path: Path) -> StartOfRun | None:
    """Read the first true motion of a log in the layout of docs/formats_log.md, None for others.

    Raises `InputError` if the file is no MCAP file.
    """
    if path.suffix.lower() != ".mcap":
        return None  # another recorder's
    log = McapFile(path, path.name)
    directory = log.directory
    wanted = {
        number
        for number, channel in directory.channels.items()
        if channel.topic == MOTION_TOPIC
        and channel.message_encoding == "cdr"
        and channel.schema_id in directory.schemas
        and directory.schemas[channel.schema_id].name == _MESSAGE
    }
    if not wanted:
        return None
    for block in log.blocks(frozenset(wanted)):
        for number in wanted & set(block.messages):
            part = block.messages[number]
            begin, size = int(part.start[0]), int(part.size[0])
            return _motion(block.data[begin : begin + size].tobytes())
    return None


def _motion(data: bytes) -> StartOfRun | None:
    """Decode pose and twist of an Odometry in plain CDR; None for other bytes."""
    if len(data) < 4 or data[0] != 0 or data[1] not in {0, 1}:
        return None
    order, body = ("<" if data[1] else ">"), data[4:]
    at = 8  # after the stamp
    try:
        for _ in range(2):  # frame_id, child_frame_id
            at += -at % 4
            (length,) = struct.unpack_from(order + "I", body, at)
            if length > _LONGEST_TEXT:
                return None
            at += 4 + length
        at += -at % 8
        numbers = np.array(struct.unpack_from(order + "49d", body, at))
    except struct.error:
        return None
    place, (x, y, z, w), twist = numbers[:3], numbers[3:7], numbers[43:49]
    turn = np.array([w, x, y, z])
    sound = np.isfinite(numbers).all() and abs(float(np.linalg.norm(turn)) - 1.0) < 1e-3
    return StartOfRun(place, turn, twist) if sound else None
