"""Read the commands of a run back from a log with the layout that rig2sea writes.

Two topics are read: the commanded codes (sensor_msgs/JointState, `position`) and, for the state
to start from, the first message of the true motion (nav_msgs/Odometry) where a log has it.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.errors import InputError, Place
from pipeline.types import FloatArray

COMMAND_TOPIC = "/thrusters/command"
MOTION_TOPIC = "/sim/odometry"


@dataclass(frozen=True)
class StartOfRun:
    """Position NED (3,) [m], quaternion w x y z (4,), nu (6,) [m/s, rad/s] of the first sample."""

    position_ned_m: FloatArray
    quaternion: FloatArray
    nu: FloatArray


@dataclass(frozen=True)
class CommandLog:
    """Commanded codes of a run: `time_s` (m,) from 0, `codes` (m, n), one column a name."""

    start_time_ns: int
    names: tuple[str, ...]
    time_s: FloatArray
    codes: FloatArray
    start: StartOfRun | None


class _Cdr:
    """Reader of one message in plain CDR; positions count from after the four-byte header."""

    def __init__(self, message: bytes) -> None:
        if len(message) < 4 or message[0] != 0 or message[1] not in {0, 1}:
            raise ValueError("not plain CDR")
        self._order = "<" if message[1] else ">"
        self._body, self._at = message[4:], 0

    def number(self, code: str) -> int | float:
        size = struct.calcsize(code)
        self._at += -self._at % size
        (value,) = struct.unpack_from(self._order + code, self._body, self._at)
        self._at += size
        return value  # type: ignore[no-any-return]

    def text(self) -> str:
        length = int(self.number("I"))
        raw = self._body[self._at : self._at + length]
        self._at += length
        return raw.rstrip(b"\0").decode()

    def numbers(self, count: int | None = None) -> list[float]:
        size = int(self.number("I")) if count is None else count
        if size > len(self._body):
            raise ValueError("a length beyond the message")
        return [float(self.number("d")) for _ in range(size)]

    def header(self) -> int:
        """Time stamp [ns]."""
        stamp = int(self.number("i")) * 1_000_000_000 + int(self.number("I"))
        self.text()
        return stamp


def read_command_log(path: Path) -> CommandLog:
    """Read the commands of a log.

    Parameters
    ----------
    path : Path
        An MCAP file with CDR messages, as `rig2sea simulate` writes it.

    Returns
    -------
    CommandLog
        In the order of time; the first name list holds for the whole log.

    Raises
    ------
    InputError
        When the file is no whole MCAP log, or holds no commands that can be read.
    """
    from mcap.exceptions import McapError
    from zstandard import ZstdError

    place = Place(str(path))
    stamps: list[int] = []
    codes: list[list[float]] = []
    names: tuple[str, ...] = ()
    start: StartOfRun | None = None
    try:
        for topic, data in _messages(path):
            if topic == MOTION_TOPIC:
                start = _motion(data) if start is None else start
                continue
            reader = _Cdr(data)
            stamp = reader.header()
            here = tuple(reader.text() for _ in range(int(reader.number("I"))))
            names = names or here
            row = reader.numbers()
            if here != names or len(row) != len(names):
                raise InputError.at(
                    place,
                    f"{COMMAND_TOPIC}: the names of the thrusters change within the log.",
                    expected=f"{', '.join(names)} in every message.",
                )
            stamps.append(stamp)
            codes.append(row)
    except OSError as error:
        raise InputError.at(place, f"cannot be read: {error.strerror or error}.") from None
    except (McapError, ZstdError, ValueError, struct.error, RuntimeError) as error:
        first = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError.at(
            place,
            f"is not a whole MCAP log with CDR messages ({first}).",
            expected="a log as rig2sea simulate writes it.",
        ) from None
    if len(stamps) < 2:
        raise InputError.at(
            place,
            f"holds {'one message' if stamps else 'no messages'} on {COMMAND_TOPIC}.",
            expected="the commanded codes of the run, sensor_msgs/JointState, at least two.",
        )
    order = np.argsort(np.array(stamps), kind="stable")
    time_ns = np.array(stamps)[order]
    return CommandLog(
        start_time_ns=int(time_ns[0]),
        names=names,
        time_s=(time_ns - time_ns[0]) * 1e-9,
        codes=np.array(codes, float)[order],
        start=start,
    )


def _messages(path: Path) -> Iterator[tuple[str, bytes]]:
    from mcap.reader import make_reader

    with path.open("rb") as stream:
        reader = make_reader(stream)
        for _, channel, message in reader.iter_messages(
            topics=[COMMAND_TOPIC, MOTION_TOPIC], log_time_order=False
        ):
            yield channel.topic, message.data


def _motion(data: bytes) -> StartOfRun:
    reader = _Cdr(data)
    reader.header()
    reader.text()
    place, turn = reader.numbers(3), reader.numbers(4)
    reader.numbers(36)
    twist = reader.numbers(6)
    x, y, z, w = turn
    return StartOfRun(np.array(place), np.array([w, x, y, z]), np.array(twist))
