"""Schema of ``diagnosis.json``: where simulation and vehicle differ, because of what, how sure."""

from pydantic import Field

from pipeline.records.base import FileChange, Glance, Record

Interval = tuple[float, float]


class GapFigures(Record):
    """Root mean square prediction error of a channel in its unit, and the floors beneath it."""

    rmse: float
    sensor_floor: float
    healthy_floor: float
    ratio: float
    """Error over the healthy floor: 1 leaves nothing to explain."""


class ChannelGap(GapFigures):
    """A channel over the windows of the diagnosis, and by how far ahead it is predicted."""

    unit: str
    horizons: dict[str, GapFigures]
    """Seconds ahead ("0.5", "2", "10") or "run": from the start of the run to its end."""


class RegimeShare(Record):
    """Share of the explainable gap that lies where a regressor is in a range."""

    regressor: str
    unit: str
    range: Interval
    share: float
    share_of_time: float
    correlation: float | None = None
    """Rank correlation of the gap in a window with the regressor.

    Of a cause that is unknown: of the force that is left, for the regressor it depends on.
    """


class TimeShare(Record):
    """Share of the explainable gap in a stretch of a run."""

    run: str
    from_s: float
    to_s: float
    share: float


class Where(Record):
    """Which channels, regimes and times carry the gap."""

    channels: tuple[str, ...]
    regimes: tuple[RegimeShare, ...]
    times: tuple[TimeShare, ...]


class RegimeGap(Record):
    """Error over the healthy floor, by channel, while a regressor is in a range."""

    regressor: str
    unit: str
    range: Interval
    share_of_time: float
    ratios: dict[str, float]


class Gap(Record):
    """Part one: where."""

    channels: dict[str, ChannelGap]
    where: Where
    by_regime: tuple[RegimeGap, ...] = ()


class ParameterEstimate(Record):
    """A parameter of an effect with its interval."""

    value: float
    unit: str
    ci95: Interval


#: Answers that are no effect: nothing is the matter, and what no effect explains.
NONE, UNKNOWN = "none", "unknown"
#: Axis -> the channel of its velocity (SNAME).
VELOCITIES = {"surge": "u", "sway": "v", "heave": "w", "roll": "p", "pitch": "q", "yaw": "r"}


class Detail(Record):
    """Which thruster, which axes by their velocities; None and empty where the effect has none."""

    thruster: str | None = None
    axes: tuple[str, ...] = ()


class FoundEvent(Record):
    """What happened during a run and its notes do not tell.

    `note` is the line of the notes that would tell it; empty where they have no word for it.
    `force` is what the vehicle file lacks along `axis` at `time_s` of the run, `step` what it is
    before and from `at_s` on, in `unit`.
    """

    run: str
    at_s: float
    between_s: Interval
    what: str
    axis: str
    unit: str
    time_s: tuple[float, ...]
    force: tuple[float, ...]
    step: tuple[float, float]
    note: str = ""


class Verdict(Record):
    """Part two: which effect; `sentence` is the answer in words."""

    effects: tuple[str, ...]
    probability: float
    ambiguous_with: tuple[str, ...]
    detail: Detail
    sentence: str
    since: str | None = None
    """Names of the sound runs that it is told against; None: against the vehicle file."""
    runs: tuple[str, ...] = ()
    """Runs that carry it."""
    from_s: float | None = None
    """Seconds into the run from which on it is so; None: all the time."""
    events: tuple[FoundEvent, ...] = ()
    """What happened during the runs; with `from_s` the first of them is the answer."""
    text: str = ""
    """What it says, in words."""


class RankedEffect(Record):
    """One answer and how probable it is; pairs are written ``a+b``."""

    effect: str
    probability: float
    parameters: dict[str, ParameterEstimate]
    gap_closed: float | None
    thruster: str | None = None
    thrusters: dict[str, str] = Field(default_factory=dict)
    """Of each effect that is one thruster's: which; `thruster` is that of the first."""
    axes: tuple[str, ...] = ()
    log_evidence: float
    """Natural logarithm, against the stated vehicle with its ordinary uncertainty."""
    held_out_log_evidence: float | None = None
    """Of the runs that took no part, with the size that the others show, against no change."""


class ShrinkFigures(Record):
    """Held-out gap before and after, over the healthy floor; a channel's in its unit."""

    before: float
    after: float
    noise_floor: float
    gap_closed: float | None
    ci95: Interval | None
    noise_floor_after: float | None = None
    """What healthy vehicles with the answer leave, where that is more: `after` counts over it."""


class Shrink(ShrinkFigures):
    """Part three: how far it shrinks on what took no part."""

    channels: dict[str, ShrinkFigures]
    held_out: str
    """What was held out, in words."""


class NextRun(Record):
    """Part four: the manoeuvre that would separate two answers best."""

    manoeuvre: str
    separates: tuple[str, str]
    expected_separation_sigma: float


class Leftover(Record):
    """Outside force that the answer leaves: rms over that of a healthy vehicle, by axis.

    `begins_s` is set where the force sets in during the runs; `depends_on` names the regressor
    that goes with it most, if one does.
    """

    axes: dict[str, float]
    worst_axis: str
    time_course: str
    depends_on: str | None
    correlation: float | None


class ChannelNoiseCheck(Record):
    """Whitened residual of the best model: variance (0.8 to 1.2 is right), lag-1, what was done."""

    variance: float
    lag1: float
    widened_by: float


class Evidence(Record):
    """How it was decided."""

    windows: int
    window_s: float
    readings: int
    linearisations: int
    force_scale: float
    """Most probable outside force over that of a healthy vehicle."""
    noise: dict[str, ChannelNoiseCheck]
    stages: dict[str, str]
    """What kinematics, actuators and dynamics said, or why they were skipped."""
    calibrated: str
    healthy_runs: tuple[str, ...]
    posterior: dict[str, float] = Field(default_factory=dict)
    """Probability of every answer as it was computed, where one posterior decides."""


class Gain(Record):
    """What a thruster gives on an axis in a run, over what the vehicle file says of it.

    `axis` "all" fits all axes together; `reference` is what the sound runs gave, where any did.
    """

    run: str
    thruster: str
    axis: str
    value: float
    ci95: Interval
    reference: float | None


class Series(Record):
    """Measured, model before, model after in a held-out window; None where nothing was read."""

    run: str
    channel: str
    unit: str
    time_s: tuple[float, ...]
    measured: tuple[float, ...]
    before: tuple[float, ...]
    after: tuple[float, ...]


class DiagnosisRecord(Record):
    """The whole answer."""

    vehicle: str
    runs: tuple[str, ...]
    holdout: tuple[str, ...]
    gap: Gap
    verdict: Verdict
    ranking: tuple[RankedEffect, ...]
    shrink: Shrink
    confusable: tuple[tuple[str, str, float], ...]
    next_run: NextRun | None
    leftover: Leftover
    evidence: Evidence
    series: tuple[Series, ...]
    notes: tuple[str, ...]
    elapsed_s: float
    glance: Glance | None = None
    """What its page begins with."""
    gains: tuple[Gain, ...] = ()
    vehicle_file_sha256: str = ""
    changes: tuple[FileChange, ...] = ()
    """What the verdict changes in that vehicle file; `rig2sea apply` writes it."""


class CodeSeries(Record):
    """One channel by control code: measured, the model before, the model with the answer."""

    channel: str
    unit: str
    code: tuple[float, ...]
    measured: tuple[float, ...]
    before: tuple[float, ...]
    after: tuple[float, ...]
    held_out: tuple[bool, ...]


class BenchDiagnosisRecord(DiagnosisRecord):
    """The answer for a mooring table; what only a pool run has is empty."""

    by_code: tuple[CodeSeries, ...]
    """Takes the place of `series`, which is over time."""
