"""Schema of the gains of thrusters: what each gives on each axis, relative to the vehicle file."""

from typing import Literal

from pydantic import Field

from pipeline.records.base import Record

Interval = tuple[float, float]
FindingKind = Literal[
    "dead",
    "reversed",
    "weak",
    "strong",
    "swapped",
    "coupled",
    "axis_reversed",
    "heading_reversed",
    "common_scale",
]


class GainReference(Record):
    """The same gain in runs that are known to be sound.

    `mean` with its `ci95`, `between_runs` the standard deviation of single runs about it; `ratio`
    is value over mean with the interval that counts both and the scatter between runs.
    """

    name: str
    runs: tuple[str, ...]
    mean: float
    ci95: Interval
    between_runs: float
    ratio: float | None = None
    ratio_ci95: Interval | None = None


class ThrusterGain(Record):
    """Gain of one thruster on one axis in one run.

    `value` 1: as the vehicle file says, 0: nothing, below 0: the other way. `moves` is whether the
    file gives the thruster a lever on the axis; where it gives none, 1 is the effect of a typical
    thruster of that axis. `axis` "all" is the one gain that fits all axes together. `judged` is
    false where the interval tells nothing, and `why_not` says why; without a value nothing at all
    is known.
    """

    run: str
    thruster: str
    axis: str
    moves: bool
    value: float | None
    ci95: Interval | None
    judged: bool
    why_not: str = ""
    reference: GainReference | None = None


class PooledGain(Record):
    """Random-effects mean of a gain over the runs that tell it."""

    thruster: str
    axis: str
    moves: bool
    value: float
    ci95: Interval
    between_runs: float
    runs: tuple[str, ...]
    reference: GainReference | None = None


class GainRun(Record):
    """What of a run took part, and why an axis says nothing."""

    run: str
    delay_s: float
    """How late the commands act beyond the model's lag."""
    thrust_std_n: dict[str, float]
    why_not_axes: dict[str, str] = Field(default_factory=dict)
    heading_correlation: float | None = None
    """Of the yaw moment of the commands, through the model's inertia and drag, with the rate of the
    heading."""


class GainFinding(Record):
    """Something that the gains show, by a test."""

    kind: FindingKind
    thrusters: tuple[str, ...] = ()
    axis: str | None = None
    runs: tuple[str, ...]
    """The runs that it rests on."""
    value: float | None = None
    ci95: Interval | None = None
    p_value: float
    """Chance of so clear a sign in sound runs, all comparisons counted."""
    text: str


class ThrusterGains(Record):
    """Gains of all thrusters in all runs, pooled, and what they show.

    `false_alarms` is the chance of any finding at all where every run is sound.
    """

    vehicle: str
    vehicle_file_sha256: str = ""
    false_alarms: float
    reference: str | None = None
    runs: tuple[GainRun, ...]
    gains: tuple[ThrusterGain, ...]
    pooled: tuple[PooledGain, ...]
    findings: tuple[GainFinding, ...]
    not_judged: dict[str, str]
    """Thruster -> why none of the runs tells it."""
    why_no_run: dict[str, str] = Field(default_factory=dict)
    """Run -> why it took no part."""
