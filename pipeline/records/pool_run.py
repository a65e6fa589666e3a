"""A pool run: what a person wrote of it, and what was read from its log; arrays stay apart."""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from pipeline.errors import Problem
from pipeline.records.base import Record
from pipeline.records.pool_schema import PoolChannel

Text = Annotated[str, Field(max_length=2_000)]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Vector3 = tuple[float, float, float]


class BallastItem(Record):
    """Something put onto the vehicle, or taken off, that the vehicle file does not count.

    `mass_kg` in air, negative for what was taken off; `displaced_kg` is the mass of the water that
    it displaces, `volume_m3` its volume: one of them, of the sign of the mass. `position_m` in body
    axes: x forward, y starboard, z down.
    """

    what: Name
    mass_kg: Annotated[float, Field(ge=-10_000.0, le=10_000.0)]
    displaced_kg: Annotated[float, Field(ge=-10_000.0, le=10_000.0)] | None = None
    volume_m3: Annotated[float, Field(ge=-10.0, le=10.0)] | None = None
    position_m: Vector3 | None = None

    @model_validator(mode="after")
    def _water_once(self) -> Self:
        if self.displaced_kg is not None and self.volume_m3 is not None:
            raise ValueError("give displaced_kg or volume_m3, not both")
        return self


class RunEvent(Record):
    """Something that happened to the vehicle in the run, at seconds from the start of its log.

    One of: a module of the vehicle file let go or taken up, ballast, or the speed that the winch
    was set to, positive pays out, 0 sets its brake [m/s].
    """

    at_s: Annotated[float, Field(ge=0.0, le=1e6)]
    release: Name | None = None
    attach: Name | None = None
    ballast: BallastItem | None = None
    winch_mps: Annotated[float, Field(ge=-10.0, le=10.0)] | None = None

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        given = (self.release, self.attach, self.ballast, self.winch_mps)
        if sum(one is not None for one in given) != 1:
            raise ValueError("give one of release, attach, ballast, winch_mps; one event each")
        return self


class WaterNotes(Record):
    """The water on the day."""

    kind: Literal["fresh", "salt", "brackish", "pool"] | None = None
    density_kgpm3: Annotated[float, Field(gt=900.0, lt=1200.0)] | None = None
    temperature_c: Annotated[float, Field(gt=-5.0, lt=60.0)] | None = None
    salinity_psu: Annotated[float, Field(ge=0.0, lt=100.0)] | None = None
    depth_m: Annotated[float, Field(gt=0.0, le=12_000.0)] | None = None
    """From surface to bottom."""
    current_mps: Annotated[float, Field(ge=0.0, le=10.0)] | None = None
    waves: Text = ""


class TetherNotes(Record):
    """The tether on the day."""

    attached: bool
    paid_out_m: Annotated[float, Field(ge=0.0, le=20_000.0)] | None = None
    """At the start, in place of the length in the vehicle file."""
    diameter_mm: Annotated[float, Field(gt=0.0, le=500.0)] | None = None
    note: Text = ""


class RunNotes(Record):
    """Notes of one run.

    Ballast, payloads, the density of the water, the tether and the events are what the run is
    simulated with; the rest is shown, and compared.
    """

    what: Text = ""
    """The purpose, in one line."""
    who: tuple[Name, ...] = Field(default=(), max_length=50)
    when: Name | None = None
    """Date, as written."""
    where: Text = ""
    battery_v: Annotated[float, Field(gt=0.0, le=2_000.0)] | None = None
    """Supply at the start."""
    healthy: bool | None = None
    """The vehicle was as the vehicle file says, to the best knowledge of who wrote it."""
    ballast: tuple[BallastItem, ...] = Field(default=(), max_length=100)
    payloads: tuple[Name, ...] | None = Field(default=None, max_length=4)
    """Modules of the vehicle file on board at the start; as the file has them without it."""
    water: WaterNotes | None = None
    tether: TetherNotes | None = None
    events: tuple[RunEvent, ...] = Field(default=(), max_length=100)
    """What happened to the vehicle in the run."""
    channels: tuple[PoolChannel, ...] = Field(default=(), max_length=200)
    """Where quantities stand in this log, instead of what the vehicle file says of them."""
    changed: tuple[Name, ...] = Field(default=(), max_length=100)
    """What differs from the vehicle file or the run before."""
    text: Annotated[str, Field(max_length=20_000)] = ""
    """Anything else."""
    file: str = ""
    """Where they stand; not to be written."""

    @field_validator("who", "changed", "payloads", "channels", mode="before")
    @classmethod
    def _one_is_a_list_of_one(cls, value: object) -> object:
        # a tuple, because the file is checked strictly and a list is none
        if isinstance(value, str):
            return (value,)
        return tuple(value) if isinstance(value, list) else value


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
