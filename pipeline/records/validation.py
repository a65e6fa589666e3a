"""The allocator in simulation: its error map, and how course, depth and speed are kept."""

from typing import Literal

from pipeline.records.base import Record
from pipeline.records.fits import Vector

Variant = Literal["ideal", "mooring", "compensated"]
#: Axes of a wrench that the flights use, in the order of every vector of four below.
AXES = ("surge", "heave", "pitch", "yaw")


class SpeedError(Record):
    """Wrench error at one speed: achieved less asked, as a fraction of the available range.

    The available range of a component at a speed is what the stern thrusters can make of it
    there: 4 T_max cos(delta) for surge, 2 T_max sin(delta) L_s for pitch and yaw, T_max the real
    thrust at the largest code; the error is divided by that one-sided value (`range_n_nm`), which
    is the stricter of the two readings (the range runs from minus to plus it). `worst` and `rms`
    are over surge, pitch and yaw of all demands that are within reach at this speed, need no
    thrust against the motion and leave no thruster inside the dead band of the inverse (0.5 N in
    the paper); `worst_with_dead_band` takes those in, `worst_opposed` is over the demands within
    reach that need thrust against the motion.
    """

    speed_mps: float
    worst: float
    rms: float
    worst_demand: Vector
    """(X_n, M_nm, N_nm) where the worst error occurs, SNAME."""
    reachable_share: float
    """Share of all demands that no limit or portion cuts at this speed."""
    opposed_share: float
    """Share of all demands that are within reach but need thrust against the motion."""
    worst_component: str = ""
    """"surge", "pitch" or "yaw"."""
    worst_asked: Vector = ()
    worst_achieved: Vector = ()
    """(X_n, M_nm, N_nm) at the worst demand."""
    worst_with_dead_band: float = 0.0
    worst_opposed: float = 0.0
    range_n_nm: Vector = ()
    """Available (X_n, M_nm, N_nm), one-sided."""


class AllocationMap(Record):
    """Errors with the mooring inverse and with the speed-compensated one, same demands.

    An error is the achieved value less what the variant asks for after its own
    portions and limits; the mooring variant's limit is that at rest at every speed.
    """

    form: str
    portions: Vector
    """Surge, heading, pitch."""
    mooring: tuple[SpeedError, ...]
    compensated: tuple[SpeedError, ...]
    speed_mps: Vector
    explanations: tuple[str, ...]
    mooring_inverse: str = ""
    compensated_inverse: str = ""
    thrust_dead_n: float = 0.5


class KeepingFlight(Record):
    """One flight that keeps speed, depth, heading and pitch against a given disturbance.

    Errors are root mean squares over the flight, reference less achieved. `wrench_error` is the
    wrench that the codes give when settled less the wanted one, root mean square as a share of the
    largest that the thrusters can make on that axis at that speed; `wrench_gain` is what they gave
    of what was wanted (least squares through zero), None where next to nothing was wanted.
    Both compare with what was wanted after portions and limits.
    """

    variant: Variant
    speed_mps: float
    """What was to be kept."""
    reached_mps: float
    """Mean over the last third."""
    speed_error_mps: float
    depth_error_m: float
    heading_error_deg: float
    pitch_error_deg: float
    wrench_error: Vector = ()
    wrench_gain: tuple[float | None, ...] = ()
    cut_share: float = 0.0
    """Share of the demands that a portion or limit cut."""
    cut_surge_share: float = 0.0
    """Share of the demands whose surge force was cut."""
    code_end_share: float = 0.0
    """Share of the time with a code at the end of its range."""
    largest_code: float = 0.0
    opposed_share: float = 0.0
    """Share of the time with a thruster that pushes against a flow of more than 0.1 m/s."""
    thrust_power_w: float = 0.0
    """Mean of the thrust times the inflow speed, summed over the thrusters."""
    shaft_power_w: float | None = None
    electrical_power_w: float | None = None


class StepFlight(Record):
    """A step of heading or depth while the rest is kept.

    `speed_mps`, `depth_m`, `heading_deg`, `pitch_deg` are the largest deviations from the same
    flight without the step, of the channels that were not stepped; that of the stepped one is the
    largest deviation from the same step with ideal thrusters. `wrench` holds, for each axis, the
    largest error of the settled wrench less that of the flight without the step, as a share of the
    range.
    """

    variant: Variant
    speed_at_mps: float
    step: Literal["heading", "depth"]
    speed_mps: float
    depth_m: float
    heading_deg: float
    pitch_deg: float
    wrench: Vector = ()
    cut_share: float = 0.0


class SettingFlight(Record):
    """A keeping flight with one thing changed."""

    setting: str
    flight: KeepingFlight


class PortionFlight(Record):
    """A keeping flight and a heading step with other portions."""

    surge: float
    heading: float
    pitch: float
    flight: KeepingFlight
    heading_step_cut_share: float
    heading_step_reached_deg: float
    """Largest heading within the flight, of a step of `AllocatorValidation.large_step_deg`."""


class CodeComparison(Record):
    """Codes of the firmware's fixed-point grid beside those of the same grid in floating point."""

    commands: int
    differing_share: float
    largest_difference: int


class FlightTrace(Record):
    """Part of a flight for the picture."""

    variant: Variant
    time_s: Vector
    speed_mps: Vector
    heading_deg: Vector
    depth_m: Vector


class ElectricalModel(Record):
    """Input power of a drive: 2 pi n M + constant + speed n + torque M^2, n in rev/s."""

    constant_w: float
    speed_ws: float
    torque_w_per_nm2: float
    points: int
    residual_rms_w: float


class AllocatorValidation(Record):
    """The vehicle flown with its regenerated tables, at several speeds and with both inverses."""

    allocator: Literal["paper", "general"]
    mooring_inverse: str
    compensated_inverse: str
    speed_mps: Vector
    portions: Vector
    """Surge, heading, pitch; empty for the general allocator."""
    form: str
    flight_s: float
    control_period_s: float
    disturbance: Vector
    """Amplitudes of the disturbance on surge, heave, pitch, yaw. [N], [N m]"""
    disturbance_period_s: Vector
    range_n_nm: tuple[Vector, ...]
    """For each speed the largest surge, heave, pitch, yaw that the thrusters can make alone.

    Surge ahead; the others either way, so the smaller of both.
    """
    heading_step_deg: float
    depth_step_m: float
    large_step_deg: float
    keeping: tuple[KeepingFlight, ...]
    steps: tuple[StepFlight, ...]
    settings: tuple[SettingFlight, ...]
    settings_at_mps: float
    portions_flown: tuple[PortionFlight, ...]
    fixed_point: CodeComparison | None
    traces: tuple[FlightTrace, ...]
    traces_at_mps: float
    electrical: ElectricalModel | None
    power_text: str
    explanations: tuple[str, ...]
