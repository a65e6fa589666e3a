"""A pool run in memory: arrays, not JSON. Axes are SNAME, units those of the column names.

Identification, reports and the diagnosis take runs in this form, whatever log they came from.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.records.pool_run import ChannelRead, ClockRead, RunNotes, TopicRead
from pipeline.types import BoolArray, FloatArray, IntArray

#: Mark of a reading -> what it says.
MARKS: Mapping[str, str] = {
    "broken": "the message could not be decoded",
    "not_a_number": "a value is not a number, or beyond 1e15",
    "no_stamp": "the message has no time of its own",
    "clock_jump": "its clock jumped here",
    "out_of_order": "an earlier message has a later time",
    "duplicate": "the same time and the same values as the message before",
    "same_stamp": "the same time as the message before, other values",
    "late": "logged much later after its stamp than usual",
    "after_gap": "readings are missing before it",
    "reset": "the clock of the board began anew here",
    "dropout": "one number that stands for no reading, such as 0 or -999",
    "frozen": "the values do not change although the sensor is noisy",
    "saturated": "at the end of the range",
    "spike": "far from the readings before and after it, which agree",
    "outside_range": "beyond the range of the drive or the sensor",
}
#: Readings with these marks say nothing of the order and the rhythm of the others.
WITHOUT_TIME = ("no_stamp", "clock_jump")
#: Readings with these marks take no part in a table on a common time base.
LEFT_OUT_OF_TABLES = (
    "broken",
    "not_a_number",
    "no_stamp",
    "clock_jump",
    "out_of_order",
    "duplicate",
    "dropout",
    "spike",
)


@dataclass(frozen=True)
class RunChannel:
    """Readings of one quantity in the order of the file, none removed; k readings of m columns.

    `quantity` as in the vehicle file, Euler angles have become an attitude quaternion, pressure a
    depth; `columns` are names with units (``p_radps``, ``command.upper``); `time_ns` (k,) when a
    reading was stamped on the clock of the log, its age `delay_s` not yet taken off, `log_time_ns`
    (k,) when the recorder received it [ns since 1970]; `values` (k, m) SNAME, not a number where a
    message lacks it; `marks` by name (see `MARKS`) which readings have it (k,), marks that no
    reading has are absent; `holds`: a value holds until the next one (commands); `period_s` the
    median time between readings, NaN for fewer than two; `is_regular`: readings come at a steady
    rate, not on change.
    """

    quantity: str
    topic: str
    columns: tuple[str, ...]
    time_ns: IntArray
    log_time_ns: IntArray
    values: FloatArray
    marks: Mapping[str, BoolArray]
    clock: ClockRead
    read: ChannelRead
    delay_s: float = 0.0
    holds: bool = False
    period_s: float = float("nan")
    is_regular: bool = True

    def timely(self) -> BoolArray:
        """Tell which readings have a time to go by (k,)."""
        return self._without(WITHOUT_TIME)

    def usable(self) -> BoolArray:
        """Tell which readings go into a table (k,)."""
        return self._without(LEFT_OUT_OF_TABLES)

    def _without(self, names: Sequence[str]) -> BoolArray:
        kept = np.ones(self.time_ns.size, np.bool_)
        for name in names:
            if name in self.marks:
                kept &= ~self.marks[name]
        return kept


@dataclass(frozen=True)
class PoolRun:
    """All mapped channels of one log.

    `channels` by name: the quantity, or quantity and thruster where each thruster has a topic.
    `start_time_ns`, `end_time_ns` are log times of the first and last message of any of them.
    `thrusters` are those of the vehicle file in its order, `notes` what a person wrote of the run.
    """

    vehicle: str
    file: str
    channels: Mapping[str, RunChannel]
    topics: tuple[TopicRead, ...]
    problems: tuple[Problem, ...]
    start_time_ns: int
    end_time_ns: int
    complete: bool
    read_bytes: int
    size_bytes: int
    writer: str = ""
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    thrusters: tuple[str, ...] = ()
    notes: RunNotes | None = None

    @property
    def place(self) -> Place:
        """Where it is, for messages."""
        return Place(self.file)

    @property
    def duration_s(self) -> float:
        """Seconds from the first to the last message of a mapped channel."""
        return (self.end_time_ns - self.start_time_ns) / 1e9


@dataclass(frozen=True)
class RecordedTopic:
    """A topic with the definition of its messages, whatever their encoding."""

    topic: str
    message_encoding: str
    metadata: Mapping[str, str]
    schema_name: str = ""
    schema_encoding: str = ""
    schema_data: bytes = b""


class RecordedMessage(NamedTuple):
    """One message; `number` is that of its topic. Times [ns since 1970]."""

    number: int
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    data: bytes


class RecordedLog(Protocol):
    """What the writer of an overlay takes; `pipeline.ingest.mcap_file` reads one from a file."""

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata records by name."""
        ...

    def topic(self, number: int) -> RecordedTopic | None:
        """Topic of a number that a message had; None where the log does not describe it."""
        ...

    def messages(self) -> Iterator[RecordedMessage]:
        """All messages in the order of the file."""
        ...
