"""The ``model:`` section of the vehicle file: what the simulation believes about the vehicle.

Axes SNAME unless the file names another frame, origin where the thrusters' positions are counted
from. Damping and added-mass entries are positive numbers; the forces they make carry the minus
sign.
"""

import math
from typing import Annotated, Literal, Self

from pydantic import (
    Field,
    field_validator,
    model_validator,
)

from pipeline.vehicle.attachment_schema import (
    Ballast,
    ModelSection,
    NotNegative,
    Payload,
    Positive,
    Tether,
    Vector3,
)
from pipeline.vehicle.model_checks import added_mass_fault, inertia_fault

Vector6 = tuple[float, float, float, float, float, float]
NotNegative6 = tuple[NotNegative, NotNegative, NotNegative, NotNegative, NotNegative, NotNegative]
Matrix6 = tuple[Vector6, Vector6, Vector6, Vector6, Vector6, Vector6]


class Terms(ModelSection):
    """Which terms the nominal model contains; an effect can name a missing one."""

    thrust_falls_with_speed: bool = True
    coriolis: bool = True
    """C(nu) nu, of rigid body and added mass together."""


class RigidBody(ModelSection):
    """Dry body without payloads; `inertia_kgm2` is I_xx, I_yy, I_zz, I_xy, I_xz, I_yz.

    The inertia is about the centre of mass; the products are the integrals of xy, xz, yz over the
    mass (the off-diagonal entries of the tensor carry the minus sign).
    """

    mass_kg: Positive
    centre_of_mass_m: Vector3 = (0.0, 0.0, 0.0)
    inertia_kgm2: Vector6
    displaced_volume_m3: Positive
    centre_of_buoyancy_m: Vector3 = (0.0, 0.0, 0.0)
    source: str = ""

    @field_validator("inertia_kgm2")
    @classmethod
    def _a_body_can_have_it(cls, inertia_kgm2: Vector6) -> Vector6:
        fault = inertia_fault(inertia_kgm2)
        if fault:
            raise ValueError(fault)
        return inertia_kgm2


class AddedMass(ModelSection):
    """Added masses and inertias, either the diagonal (A_11 ... A_66) or the full matrix."""

    diagonal: NotNegative6 | None = None
    matrix: Matrix6 | None = None
    source: str = ""

    @field_validator("matrix")
    @classmethod
    def _symmetric_and_positive(cls, matrix: Matrix6 | None) -> Matrix6 | None:
        fault = None if matrix is None else added_mass_fault(matrix)
        if fault:
            raise ValueError(fault)
        return matrix

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.diagonal is None) == (self.matrix is None):
            raise ValueError("give either diagonal or matrix")
        return self


class Damping(ModelSection):
    """Damping by axis, surge to yaw: N/(m/s)^k, N m/(rad/s)^k, k 1 (linear) and 2 (quadratic)."""

    linear: NotNegative6
    quadratic: NotNegative6
    source: str = ""


class HullSection(ModelSection):
    """Size of the hull at one station, for cross-flow strips."""

    x_m: float
    breadth_m: NotNegative
    height_m: NotNegative


class Crossflow(ModelSection):
    """Strips for the coupling of sway with yaw and heave with pitch."""

    drag_coefficient: Positive
    sections: tuple[HullSection, ...] = Field(min_length=2, max_length=100)
    in_nominal: bool = False
    source: str = ""


class Lift(ModelSection):
    """Force and moment slopes of the hull against angle of attack and drift at `speed_mps`.

    Kostenko 2017, eq. (4): R_y = K_y alpha, M_z = -K_z alpha, measured at one speed and scaled
    with speed squared. `heave_n_per_rad` is K_y (force up at positive angle of attack, so Z = -K_y
    alpha), `pitch_nm_per_rad` is K_z (moment M = -K_z alpha, righting when positive); for the drift
    angle beta likewise Y = -K beta and N = +K beta, righting when positive. A towed or computed
    moment holds the Munk moment already; `includes_munk` says so, and the model then counts it
    once.
    """

    speed_mps: Positive
    heave_n_per_rad: float = 0.0
    pitch_nm_per_rad: float = 0.0
    sway_n_per_rad: float = 0.0
    yaw_nm_per_rad: float = 0.0
    includes_munk: bool = True
    source: str = ""


class FromTables(ModelSection):
    """The static family that the bench data of this vehicle gave."""

    kind: Literal["tables"]


class FromMooring(ModelSection):
    """What the mooring test of this vehicle measured, each sign apart, at the tables' voltage.

    Under way it is what the torque balance makes of it where there is one. Where there is none the
    thrust falls as T = T_rest - sqrt(T_rest T_max) V / V_0, not below 0, with V_0 the speed at
    which the thrust at full code vanishes (the form of `bollard`); without V_0 it is that of rest
    at every speed.
    """

    kind: Literal["mooring"]
    zero_thrust_speed_mps: Positive | None = None
    source: str = ""


class FromBollard(ModelSection):
    """T = T_max q (q - V / V_0), q = s^(e/2), s = (|N| - N_dead) / (N_max - N_dead), not below 0.

    At rest T = T_max s^e. q is the shaft speed over its largest, n / n_max = sqrt(T / T_max) at
    rest, and K_T is linear in J: so V_0 is the speed at which the thrust at full code vanishes.
    With the exponent e = 2 the shaft speed is proportional to the code. N_max is `code_max` of the
    drive for both signs: `thrust_min_n` is the thrust at -code_max, and codes end at `code_min`.
    """

    kind: Literal["bollard"]
    thrust_max_n: Positive
    thrust_min_n: Annotated[float, Field(lt=0)]
    dead_zone_code: NotNegative = 0.0
    exponent: Annotated[float, Field(ge=0.5, le=4)] = 2.0
    zero_thrust_speed_mps: Positive
    free_drag_ns2pm2: NotNegative = 0.0
    """Drag of the propeller that is not driven, over V|V|; for the tables the bench says it."""
    source: str = ""


class ThrusterModel(ModelSection):
    """How a drive with its propeller behaves in the simulation."""

    characteristic: Annotated[FromTables | FromMooring | FromBollard, Field(discriminator="kind")]
    lag_s: NotNegative = 0.0
    """Of the code, before the dead zone of the characteristic takes its share."""
    rotor_inertia_kgm2: Positive | None = None
    """Rotor, shaft and propeller with entrained water."""
    balance_in_time: bool = False
    """Solve the torque balance in time (needs the rotor inertia and bench fits), not the lag."""
    source: str = ""


class HullShare(ModelSection):
    """A share that the hull takes of what a thruster has alone: of its inflow, or of its thrust.

    `value` holds for every thruster that `thrusters` does not name; `sigma` is the standard
    uncertainty common to all of them (0: known; not stated: 0.1 of an inflow, that of
    `uncertainty: thrust` of a thrust).
    """

    value: Annotated[float, Field(gt=-1, lt=1)] = 0.0
    sigma: NotNegative | None = None
    thrusters: dict[str, Annotated[float, Field(gt=-1, lt=1)]] = Field(default_factory=dict)
    source: str = ""

    def of(self, thruster: str) -> float:
        """Return the share that is taken of one thruster's. [1]."""
        return self.thrusters.get(thruster, self.value)


class WakeFraction(HullShare):
    """w: the inflow of a thruster's blades is (1 - w) of the speed along its axis."""


class ThrustDeduction(HullShare):
    """t: (1 - t) of a thruster's bench thrust drives the hull.

    Negative where a thruster gives more than the characteristic says.
    """


class Wall(ModelSection):
    """A plane wall: a point on it and the unit normal into the water, NED."""

    point_ned_m: Vector3
    normal_ned: Vector3

    @field_validator("normal_ned")
    @classmethod
    def _a_unit_vector(cls, normal_ned: Vector3) -> Vector3:
        length = math.hypot(*normal_ned)
        if abs(length - 1.0) > 1e-3:
            raise ValueError(
                f"the vector has length {length:.4f}, a unit vector into the water is expected"
            )
        return normal_ned


class Pool(ModelSection):
    """Walls and bottom near by; the bottom is a wall with normal (0, 0, -1).

    `strength` is c in the factor 1 + c (R / h)^3 on added mass and damping at distance h.
    """

    walls: tuple[Wall, ...] = Field(min_length=1, max_length=5)
    vehicle_radius_m: Positive
    """R: half the width of the hull; h, from the body's origin, never counts as less."""
    strength: Annotated[float, Field(ge=0, le=20)] = 0.0
    source: str = ""


class Supply(ModelSection):
    """Share of the bench's supply voltage that the drives lack on board.

    `drop` at no load (negative: more than on the bench), `load_drop` on top of it with every
    thruster at full code.
    """

    drop: Annotated[float, Field(ge=-1, le=0.95)] = 0.0
    load_drop: Annotated[float, Field(ge=0, le=0.95)] = 0.0
    source: str = ""

    @model_validator(mode="after")
    def _some_voltage_is_left(self) -> Self:
        if self.drop + self.load_drop >= 1.0:
            raise ValueError("drop and load_drop together must stay below 1")
        return self


class LumpedTether(ModelSection):
    """A cable that was found and not laid out: its pull and drag at the tether's attachment.

    The attachment and the upper end are those of `tether`; without one, the body's origin and the
    NED origin.
    """

    drag_area_m2: NotNegative = 0.0
    pull_n: NotNegative = 0.0
    source: str = ""


class Uncertainty(ModelSection):
    """Standard uncertainty of the model, as a share: a departure inside it is no effect."""

    thrust: NotNegative = 0.02
    """Of each thruster, and of all alike."""
    added_mass: NotNegative = 0.05
    damping: NotNegative = 0.05
    buoyancy_n: NotNegative = 0.5
    centre_of_mass_m: NotNegative = 0.001


class Model(ModelSection):
    """Everything that the simulation needs beside thrusters and water."""

    terms: Terms = Terms()
    rigid_body: RigidBody
    added_mass: AddedMass
    damping: Damping
    crossflow: Crossflow | None = None
    lift: Lift | None = None
    ballast: tuple[Ballast, ...] = Field(default=(), max_length=100)
    payloads: tuple[Payload, ...] = Field(default=(), max_length=4)
    thrusters: dict[str, ThrusterModel]
    """By drive."""
    wake_fraction: WakeFraction = WakeFraction()
    thrust_deduction: ThrustDeduction = ThrustDeduction()
    supply: Supply = Supply()
    tether: Tether | None = None
    lumped_tether: LumpedTether = LumpedTether()
    current_ned_mps: Vector3 = (0.0, 0.0, 0.0)
    """Velocity of the water where the vehicle is flown."""
    pool: Pool | None = None
    uncertainty: Uncertainty = Uncertainty()

    @field_validator("payloads")
    @classmethod
    def _payload_names_differ(cls, payloads: tuple[Payload, ...]) -> tuple[Payload, ...]:
        names = [payload.name for payload in payloads]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise ValueError(f'"{name}" is there twice')
        return payloads

    @model_validator(mode="after")
    def _something_is_left(self) -> Self:
        body = self.rigid_body
        mass = body.mass_kg + sum(one.mass_kg for one in self.on_board)
        volume = body.displaced_volume_m3 + sum(one.volume_m3 for one in self.on_board)
        if mass <= 0.0 or volume <= 0.0:
            raise ValueError(f"with its ballast the vehicle has {mass:g} kg and {volume:g} m^3")
        return self

    @property
    def on_board(self) -> tuple[Ballast | Payload, ...]:
        """What the dry body carries: ballast, and the modules that are attached."""
        return (*self.ballast, *(payload for payload in self.payloads if payload.attached))
