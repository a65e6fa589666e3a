"""Schema of ``identification.json``: what the runs of a vehicle say about its model."""

from typing import Literal

from pipeline.records.base import FileChange, Record
from pipeline.records.gains import ThrusterGains

Interval = tuple[float, float]


class IdentifiedParameter(Record):
    """One parameter of the whole-vehicle fit, in `unit`.

    `std` and `ci95` hold with the thrust as uncertain as the vehicle file states;
    `ci95_thrust_known` is what would be left if the thrust were what the fit made of it.
    `posterior_over_prior` near 1: the runs say nothing that the vehicle file did not. `identified`
    is false above the limit of the fit. What `stands` is identified, the fit came to rest in it,
    and two `halves` of the runs agree; `reason` says why not, or how well it is known.
    `file_value` is what the corrected vehicle file has: that of a fit in which all that does not
    stand is held at `prior_value`.
    """

    name: str
    unit: str
    meaning: str
    value: float
    std: float
    ci95: Interval
    ci95_thrust_known: Interval
    prior_value: float
    prior_std: float
    posterior_over_prior: float
    inflation: float
    """Factor on the Fisher standard deviation, for residuals that go together."""
    identified: bool
    reason: str
    stands: bool = True
    halves: Interval | None = None
    file_value: float | None = None


class ThrustFound(Record):
    """What the fit made of an unknown of the thrust: a factor (unit 1), or an error of a curve (N).

    `widths` is how many of its stated standard deviations `prior_std` it lies from the bench. The
    factor of a thruster is a result; `file_value` is the one behind the corrected vehicle file.
    """

    name: str
    unit: str
    value: float
    ci95: Interval
    prior_std: float
    widths: float = 0.0
    halves: Interval | None = None
    file_value: float | None = None


class ChannelQuality(Record):
    """How well a channel is predicted over windows that took no part in the fit.

    Root mean square errors over `horizon_s` from a start that is estimated from the readings before
    it, in `unit`; `sensor_noise` is that of one reading, with its offset where that was not
    estimated. `rmse_identified` is that of the fit with the thrust that it found beside the
    parameters; `rmse_corrected_file` that of the parameters alone, as the corrected vehicle file
    has them. The baselines: the vehicle file before the fit, the last value held, and a linear
    black box. None where a prediction ran away, or a baseline has nothing to start from.
    """

    channel: str
    unit: str
    horizon_s: float
    readings: int
    sensor_noise: float
    rmse_identified: float | None
    rmse_corrected_file: float | None = None
    rmse_vehicle_file: float | None
    rmse_last_value: float | None
    rmse_black_box: float | None


class ChannelNoiseFound(Record):
    """Scatter of a channel's residuals in the fit over the stated noise."""

    channel: str
    unit: str
    stated_noise: float
    scale: float
    """Factor that the fit put on the stated noise; 1 where the residuals bear it out."""
    residual_over_noise: float


class ManoeuvreGain(Record):
    """What one more run of a manoeuvre would leave of a parameter's standard deviation."""

    parameter: str
    manoeuvre: str
    duration_s: float
    posterior_over_prior: float


class VehicleIdentification(Record):
    """The whole-vehicle fit."""

    vehicle: str
    runs: tuple[str, ...]
    holdout: tuple[str, ...]
    windows: int
    holdout_windows: int
    window_s: float
    readings: int
    iterations: int
    converged: bool
    """Whether the fit came to rest in everything that it found."""
    thrust_uncertainty: float
    parameters: tuple[IdentifiedParameter, ...]
    thrust: tuple[ThrustFound, ...] = ()
    thrust_deduction: ThrustFound | None = None
    """Share of the thrust that the hull takes, mean over the thrusters; from their factors."""
    why_no_file: str = ""
    """Why no corrected vehicle file is written; empty where one is."""
    cannot_identify: tuple[str, ...]
    """One plain sentence a parameter."""
    next_manoeuvres: tuple[ManoeuvreGain, ...]
    """For each parameter that was not identified the best manoeuvre, if one helps."""
    noise: tuple[ChannelNoiseFound, ...]
    quality: tuple[ChannelQuality, ...]
    notes: tuple[str, ...]


class SlopeEstimate(Record):
    """Added mass from the slope of acceleration against thrust, by one estimator [kg]."""

    estimator: str
    slope_per_kg: float
    total_mass_kg: float
    added_mass_kg: float
    ci95_kg: Interval | None
    """Of the added mass; None where the slope's interval holds zero and so bounds no mass."""
    note: str
    refused: str = ""
    """Why this is no result: no body has such an added mass."""


class RegressionTerm(Record):
    """A regressor of the straight-line method and its coefficient."""

    name: str
    unit: str
    coefficient: float
    ci95: Interval


class StraightSegment(Record):
    """A straight stretch of a run."""

    run: str
    from_s: float
    to_s: float
    largest_turn_rate_radps: float
    largest_drift: float
    """Largest ratio of sideways to forward speed."""


class StraightLineIdentification(Record):
    """The paper's method on straight segments, without and with the terms that it omits."""

    vehicle: str
    axis: str
    segments: tuple[StraightSegment, ...]
    seconds: float
    smoother: str
    bandwidth_hz: float
    acceleration_noise_mps2: float
    thrust_noise_n: float
    reliability: float
    """1 less the share of the thrust's variance that is noise: what attenuates the plain slope."""
    dry_mass_kg: float
    plain: tuple[SlopeEstimate, ...]
    with_terms: SlopeEstimate | None
    terms: tuple[RegressionTerm, ...]
    warnings: tuple[str, ...]
    points: tuple[tuple[float, float], ...] = ()
    """Thrust [N] and acceleration [m/s^2] of straight stretches, thinned: figure 4 of the paper."""


class RunRead(Record):
    """A log that took part: seconds of it, what was measured, what the reader warned of."""

    name: str
    file: str
    sha256: str
    seconds: float
    quantities: tuple[str, ...]
    warnings: tuple[str, ...]


class Identification(Record):
    """Everything that `rig2sea identify` found."""

    schema_version: Literal[2] = 2
    vehicle: str
    vehicle_file_sha256: str
    rig2sea_version: str
    runs: tuple[RunRead, ...]
    holdout: tuple[RunRead, ...]
    whole_vehicle: VehicleIdentification | None
    why_no_whole_vehicle: str
    straight_line: tuple[StraightLineIdentification, ...]
    why_no_straight_line: dict[str, str]
    """Axis -> why the slope was not computed along it."""
    warnings: tuple[str, ...]
    elapsed_s: float
    gains: ThrusterGains | None = None
    """Of each thruster in each run, held-out ones too, against the vehicle file."""
    changes: tuple[FileChange, ...] = ()
    """What stands changes in the vehicle file; `rig2sea apply` writes it."""
