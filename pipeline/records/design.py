"""Results of the design calculations: balance, propeller, tether."""

from pipeline.records.base import Record
from pipeline.records.fits import Matrix, Vector


class Printed(Record):
    """A number that somebody printed beside ours.

    `rounding` is half a unit of the last printed digit; `reason` says why a difference is larger.
    """

    table: str
    quantity: str
    unit: str
    printed: float
    computed: float
    rounding: float
    reason: str = ""

    @property
    def difference(self) -> float:
        """Computed less printed."""
        return self.computed - self.printed

    @property
    def within_rounding(self) -> bool:
        """Whether rounding alone explains the difference."""
        return abs(self.difference) <= self.rounding * (1 + 1e-9)


class ThrusterLoad(Record):
    """One stern thruster in a steady state; `use` is the load over what it can give."""

    thruster: str
    thrust_n: float
    inflow_mps: float
    power_w: float | None = None
    """Shaft power."""
    shaft_speed_rpm: float | None = None
    torque_nm: float | None = None
    code: float | None = None
    limit_n: float | None = None
    use: float | None = None


class SteadyState(Record):
    """Angle of attack, control forces in body axes (forward; up) and the loads."""

    method: str
    angle_of_attack_deg: float
    surge_force_n: float
    vertical_force_n: float
    loads: tuple[ThrusterLoad, ...]


class SurgeReading(Record):
    """One way to read the surge force out of the paper, with the loads that follow from it."""

    reading: str
    surge_force_n: float
    loads_n: Vector
    """Left, right, upper, lower."""


class Saturation(Record):
    """Where the first thruster comes to its limit when one quantity is changed alone."""

    quantity: str
    unit: str
    value: float | None
    """None where none does within the envelope."""
    thruster: str = ""
    text: str


class BalanceEnvelope(Record):
    """Exact steady states over speed, buoyancy and angle of the thrusters.

    Entries are indexed [speed][buoyancy][angle]; NaN is not written: a state that does not exist
    has `most_loaded` "" and zero elsewhere. `use` is zero where no limit is stated.
    """

    speed_mps: Vector
    residual_buoyancy_n: Vector
    angle_deg: Vector
    angle_of_attack_deg: tuple[Matrix, ...]
    largest_load_n: tuple[Matrix, ...]
    use: tuple[Matrix, ...]
    most_loaded: tuple[tuple[tuple[str, ...], ...], ...]


class BalanceDesign(Record):
    """What `rig2sea design balance` found."""

    name: str
    title: str
    source: str
    vehicle: str
    speed_mps: float
    residual_buoyancy_n: float
    angle_deg: float
    exact: SteadyState
    small_angle: SteadyState | None
    """None where the small-angle form has no state; a warning says why."""
    readings: tuple[SurgeReading, ...]
    preliminary_power_w: float | None
    """From the small-angle form, where that has a state, else from the exact one."""
    preliminary_shaft_speed_rpm: float | None
    limit_kind: str
    saturation: tuple[Saturation, ...]
    envelope: BalanceEnvelope
    printed: tuple[Printed, ...] = ()
    published_source: str = ""
    warnings: tuple[str, ...] = ()


class PropellerPoint(Record):
    """A propeller of the series at its operating point."""

    label: str
    blades: int
    diameter_m: float
    pitch_ratio: float
    area_ratio: float
    shaft_speed_rpm: float
    advance_ratio: float
    thrust_coefficient: float
    torque_coefficient: float
    thrust_n: float
    torque_nm: float
    power_w: float
    efficiency: float
    reynolds: float
    keller_area_ratio: float
    """Least area ratio by Keller's formula."""
    burrill_loading: float
    burrill_limit: float
    cavitates: bool
    full_power_shaft_speed_rpm: float | None = None
    """Where the propeller takes all that the drive has at this speed of advance."""
    full_power_thrust_n: float | None = None
    full_power_torque_nm: float | None = None
    notes: tuple[str, ...] = ()


class PropellerCurves(Record):
    """Curves for the pictures: open water of the best, and torque over shaft speed."""

    advance_ratio: Vector
    thrust_coefficient: Vector
    torque_coefficient: Vector
    efficiency: Vector
    shaft_speed_rpm: Vector
    drive_torque_nm: tuple[float | None, ...]
    propeller_torque_nm: tuple[float | None, ...]
    propeller_thrust_n: tuple[float | None, ...]


class PropellerDesign(Record):
    """What `rig2sea design propeller` found; `ranked` best first."""

    name: str
    title: str
    source: str
    thrust_n: float
    advance_speed_mps: float
    density_kgpm3: float
    drive: str
    drive_torque_at_point_nm: float
    ranked: tuple[PropellerPoint, ...]
    candidate: PropellerPoint | None
    curves: PropellerCurves
    printed: tuple[Printed, ...] = ()
    published_source: str = ""
    warnings: tuple[str, ...] = ()


class FootprintRow(Record):
    """Cable forces and needed thrust at one place of the footprint's edge, paper's axes."""

    angle_deg: float
    on_vehicle_n: Vector
    on_garage_n: Vector
    required_n: Vector
    use: float | None = None
    """Needed thrust over what the vehicle's thrusters can give in that direction."""


class FootprintVariant(Record):
    """The footprint's edge with one assumption on the flow along the cable."""

    variant: str
    rows: tuple[FootprintRow, ...]
    largest_pull_n: Vector
    """|X|, |Y|, |Z| and the whole."""


class DriveNeed(Record):
    """Tables 5 and 6 from one set of largest pulls: forces [N] and powers [W] along X, Y, Z."""

    basis: str
    pull_n: Vector
    drag_n: Vector
    force_n: Vector
    towing_power_w: Vector
    consumed_power_w: Vector


class CableShape(Record):
    """Shape of the cable for one place, paper's axes; rows are points."""

    angle_deg: float
    x_m: Vector
    y_m: Vector
    z_m: Vector
    tension_n: Vector


class HeldFootprint(Record):
    """What a vehicle's thrusters can hold: `use` over angle and radius, radius where it is 1."""

    vehicle: str
    variant: str
    angle_deg: Vector
    radius_m: Vector
    use: Matrix
    """Indexed [angle][radius]."""
    held_radius_m: Vector
    limit: tuple[str, ...]
    """What ends it at each angle: the thrusters, the cable, or nothing up to the largest radius."""
    largest_force_n: Vector
    """Largest thrust forward, backward, up, down, starboard, port."""


class EquivalentEffect(Record):
    """The lumped tether effect that drags and pulls like the cable at one place."""

    angle_deg: float
    drag_area_m2: float
    pull_n: float
    text: str


class TetherDesign(Record):
    """What `rig2sea design tether` found; forces in the paper's axes (X ahead, Y up, Z right)."""

    name: str
    title: str
    source: str
    variant: str
    length_m: float
    radius_m: float
    height_m: float
    vehicle_velocity_mps: Vector
    current_mps: Vector
    density_kgpm3: float
    variants: tuple[FootprintVariant, ...]
    needs: tuple[DriveNeed, ...]
    shapes: tuple[CableShape, ...]
    held: HeldFootprint | None
    equivalent: EquivalentEffect | None
    printed: tuple[Printed, ...] = ()
    published_source: str = ""
    warnings: tuple[str, ...] = ()


Design = BalanceDesign | PropellerDesign | TetherDesign
