"""What was read from one pool-run log: a summary that goes to ``processed/``; arrays stay apart."""

from typing import Literal

from pydantic import Field

from pipeline.errors import Problem
from pipeline.records.base import Record
from pipeline.records.run_notes import RunNotes


class ClockRead(Record):
    """Which time of a channel was taken, and how it stands to the time of the log.

    `offset_s` is what was added to the stamps (0 where they were taken as they are), `drift_ppm`
    how much faster the clock of the log runs, `latency_s` the median time from stamp to log,
    `jitter_s` its spread (1.4826 times the median deviation).
    """

    used: Literal["header", "log", "field"]
    why: str
    offset_s: float = 0.0
    drift_ppm: float = 0.0
    latency_s: float | None = None
    jitter_s: float | None = None
    segments: int = 1
    """Parts between jumps and resets of the clock, each aligned by itself."""


UnitFrom = Literal[
    "vehicle file",
    "notes of the run",
    "head of the column",
    "usual map",
    "message",
    "values",
    "assumed",
]


class ChannelRead(Record):
    """How one quantity was found in the log."""

    quantity: str
    topic: str
    message_type: str
    encoding: str
    fields: tuple[str, ...]
    unit: str
    unit_from: UnitFrom
    sign: tuple[int, ...] = (1,)
    axes: str = ""
    mapped_by: str
    """"vehicle file", or the rule that chose it."""
    notes: tuple[str, ...] = ()


class TopicRead(Record):
    """A topic of the log, mapped or not."""

    topic: str
    message_type: str
    encoding: str
    messages: int
    used_for: tuple[str, ...] = ()
    why_not: str = ""


class ChannelSummary(Record):
    """A channel with its counts."""

    name: str
    read: ChannelRead
    clock: ClockRead
    columns: tuple[str, ...]
    readings: int
    rate_hz: float | None
    is_regular: bool
    delay_s: float
    first_s: float
    """From the start of the run."""
    last_s: float
    longest_gap_s: float
    marks: dict[str, int]
    lowest: tuple[float | None, ...]
    highest: tuple[float | None, ...]


class PoolRunRecord(Record):
    """One log of one vehicle."""

    schema_version: Literal[1] = 1
    vehicle: str
    file: str
    start_time_ns: int
    duration_s: float
    complete: bool
    """The recorder closed the log."""
    read_bytes: int
    size_bytes: int
    writer: str = ""
    channels: tuple[ChannelSummary, ...]
    topics: tuple[TopicRead, ...]
    metadata: dict[str, dict[str, str]] = Field(default_factory=dict)
    notes: RunNotes | None = None
    problems: tuple[Problem, ...]
