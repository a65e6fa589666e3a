"""Schema of a planned pool day: what to fly, what it promises, and what was flown of it."""

from pipeline.records.base import Record


class PlannedRun(Record):
    """One manoeuvre of the list: how it is flown, its room, what it is for."""

    number: int
    manoeuvre: str
    amplitude: float
    duration_s: float
    room_m: tuple[float, float, float]
    """Extent of the track: north, east, down."""
    what_for: tuple[str, ...]
    log: str
    codes: str


class Promise(Record):
    """What is to be known of a parameter after the day; half-widths of 95 % intervals in `unit`."""

    name: str
    unit: str
    meaning: str
    value: float
    half_width_before: float
    half_width: float
    wanted: float
    reached: bool


class PoolDay(Record):
    """The plan. `bundled_*` is the usual set of the same length, for comparison."""

    vehicle: str
    vehicle_file_sha256: str
    minutes: float
    """At most: what was asked for, or what the battery lasts where that is less."""
    pool_m: tuple[float, float, float] | None
    runs: tuple[PlannedRun, ...]
    promises: tuple[Promise, ...]
    total_s: float
    usual_s: float
    usual_mean_share: float
    """Mean width over the prior's after the usual set of the same length."""
    mean_share: float
    left_out: tuple[str, ...] = ()
    """Manoeuvres that do not fit, with the reason."""
    notes: tuple[str, ...] = ()


class FlownOfPlan(Record):
    """A run of the last plan and the log that flew it, if any."""

    number: int
    manoeuvre: str
    log: str | None
    text: str
