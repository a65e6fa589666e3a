"""Fitted characteristics with covariance, intervals, quality and validity range."""

from typing import Literal

from pydantic import Field

from pipeline.records.base import Record, Source

Interval = tuple[float, float]
Vector = tuple[float, ...]
Matrix = tuple[tuple[float, ...], ...]


class Outlier(Record):
    """A point whose residual the robust fit found too large to belong; it was not fitted."""

    source: Source | None
    label: str
    residual: float
    robust_sigmas: float


class OrderScore(Record):
    """How well one candidate order did: the evidence for the choice."""

    order: str
    parameters: int
    aicc: float
    leave_one_out_rmse: float
    chosen: bool = False


class FitQuality(Record):
    """How good a fit is and where it holds."""

    points: int
    outliers: tuple[Outlier, ...] = ()
    r_squared: float
    residual_std: float
    unit: str
    valid_range: Interval
    orders: tuple[OrderScore, ...] = ()
    order_reason: str = ""


class ResidualPoint(Record):
    """One fitted point for the residual plot."""

    x: float
    measured: float
    fitted: float
    outlier: bool = False
    source: Source | None = None


class PolynomialFit(Record):
    """y = sum c_i x^i with the covariance of c and 95 % intervals."""

    quantity: str
    variable: str
    coefficients: Vector
    covariance: Matrix
    ci95: tuple[Interval, ...]
    quality: FitQuality
    points: tuple[ResidualPoint, ...] = ()


class Check(Record):
    """A physical or numerical check and its outcome."""

    name: str
    passed: bool
    text: str
    gate: str = ""
    """Name by which `accept` in vehicle.yaml lets the firmware pass; empty: it stops nothing."""


class PropellerFit(Record):
    """Table 1: K_T(J) and K_M(J) of one propeller."""

    diameter_m: float
    thrust: PolynomialFit
    torque: PolynomialFit
    checks: tuple[Check, ...]


class CodeSpread(Record):
    """The bench's points at one code: their range and how they scatter about the surface."""

    code: float
    points: int
    shaft_speed_rpm: Interval
    torque_nm: Interval
    residual_std_nm: float
    loading_minus_unloading_nm: float | None


class DriveFit(Record):
    """The mechanical characteristic M(n, N) as one polynomial surface.

    M = sum_k c_k x^i_k y^j_k with x = (n - n_c) / shaft_speed_scale, y = |N| / code_scale and
    n_c = sum_l centre_l y^l; n in rev/s, M in N m. Outside the measured band of speeds (given at
    `band_code`, linear between) M continues along its tangent. The covariance is clustered by
    sweep, because the errors of one sweep go together, and carries the scatter of torque scale
    between drives.
    """

    exponents: tuple[tuple[int, int], ...]
    coefficients: Vector
    covariance: Matrix
    centre_rps: Vector
    shaft_speed_scale_rps: float
    code_scale: float
    band_code: Vector
    slowest_rps: Vector
    fastest_rps: Vector
    code_range: Interval
    clusters: int
    clustered: bool = True
    """False where sweeps cannot carry the terms: points then count as independent."""
    torque_scale_by_file: dict[str, float] = Field(default_factory=dict)
    """Torque of each drive (file) over that of the family: the spread between exemplars."""
    torque_scale_std: float = 0.0
    quality: FitQuality
    codes: tuple[CodeSpread, ...]
    checks: tuple[Check, ...]


PointStatus = Literal["live", "dead", "extrapolated", "no_working_point"]


class StaticRow(Record):
    """Table 2, one speed: T = K_F0 sign N + K_F1 N + K_F2 N|N|."""

    speed_mps: float
    fit: PolynomialFit
    dead_zone_code: float
    thrust_max_n: float
    thrust_max_ci95: Interval
    mode_code: Vector
    thrust_modes_n: Matrix
    """Modes m of the thrust's covariance along `mode_code`: Cov(T) = sum m m^T. [N]"""


class FasterRows(Record):
    """The family beyond the tables, up to the speed at which the largest code gives no thrust.

    `ends` says why there are no more rows; `tested_mps` is the highest speed of all at which the
    working point of the largest code lies within what was measured.
    """

    speed_mps: Vector
    thrust_n: Matrix
    thrust_std_n: Matrix
    tested_mps: float
    ends: Literal["no thrust", "no working point", "search ends"]


class StaticCharacteristic(Record):
    """The static family T(N, V): working points of drive and propeller on a grid.

    Matrices are indexed [speed][code]; codes are positive, thrust and speed along the same
    direction; negative codes mirror them (Kostenko 2023, eq. 4). "dead": the thrust is not
    positive and the paper's convention T = 0 holds. "extrapolated": the working point lies outside
    what the bench measured. `thrust_std_n` is the standard error from the fits' covariance.
    """

    speed_mps: Vector
    code: Vector
    thrust_n: Matrix
    thrust_std_n: Matrix
    shaft_speed_rpm: Matrix
    torque_nm: Matrix
    advance_ratio: Matrix
    status: tuple[tuple[PointStatus, ...], ...]
    table2: tuple[StaticRow, ...]
    checks: tuple[Check, ...]
    explanations: tuple[str, ...]
    faster: FasterRows | None = None
    """The balance beyond the tabulated speeds; Table 2 and the simulation end before."""
    free_drag_ns2pm2: float = 0.0
    """Drag of the freely turning propeller over V^2; 0 where K_M(J) never falls to zero."""
    sources: tuple[str, ...] = ()
    """Files that the two fits are from."""


Basis = Literal["measured", "calculated", "mirrored"]


class SignedFamily(Record):
    """One sign of thrust T(N, V), magnitudes, matrices indexed [speed][code].

    `half95_n` is the half-width of the 95 % interval: the noise of the bench, and where the mooring
    test and the calculation differ at rest, that difference.
    """

    sign: Literal[1, -1]
    basis: Basis
    speed_mps: Vector
    code: Vector
    thrust_n: Matrix
    half95_n: Matrix


class ThrustFamily(Record):
    """The best knowledge of T(N, V): measured at rest where it was, calculated under way."""

    positive: SignedFamily
    negative: SignedFamily
    free_drag_ns2pm2: float = 0.0
    """Drag of the freely turning propeller over V^2. [N s^2/m^2]"""


class SpeedInverse(Record):
    """Table 4, one speed: N = K_N0 sign T + K_N1 T + K_N2 T|T| + K_N3 T^3."""

    speed_mps: float
    thrust_max_n: float
    coefficients: Vector
    ci95: tuple[Interval, ...]


class FirmwareBranch(Record):
    """One sign of thrust for the firmware: |N| on a grid of speed and T / T_max(V).

    Interpolated linearly in speed (rows and `thrust_max_n`) and in the fraction; `code[v][0]` is
    the edge of the dead zone; every row rises strictly. Speed is counted along the thrust.
    """

    sign: Literal[1, -1]
    speed_mps: Vector
    thrust_max_n: Vector
    fraction: Vector
    code: Matrix
    against_motion: str
    """How thrust against the motion is modelled, for the report."""
    drag_n: Vector = ()
    """Drag at code 0 at each speed, falling to zero at the edge of the dead zone; empty: none."""
    basis: Basis | None = None


class FirmwareCharacteristic(Record):
    """The monotone form of N(T, V) and its exact inverse T(N, V).

    Codes are held within `code_min` to `code_max`, the range of the drive: a branch that mirrors
    the other sign may reach beyond it.
    """

    thrust_dead_n: float
    code_max: int
    code_min: int = Field(default_factory=lambda known: -int(known["code_max"]), le=0)
    positive: FirmwareBranch
    negative: FirmwareBranch
    tested_mps: float | None = None
    """Speed up to which the bench supports the tables; 0: at rest only; None: all of them."""
    supply_voltage_v: float | None = None
    """What the mooring test had, or the vehicle file states."""
    sources: tuple[str, ...] = ()
    """Raw files that the tables are from."""

    @property
    def fastest_tested_mps(self) -> float:
        """The same as a number."""
        tested, last = self.tested_mps, self.positive.speed_mps[-1]
        return last if tested is None else tested

    @property
    def at_rest_only(self) -> bool:
        """Whether the tables say nothing of what speed does to the thrust."""
        return len(self.positive.speed_mps) == 1


class AtVoltage(Record):
    """T(N, V) at one supply voltage that was moored, and its firmware form.

    Between two voltages T_max and the codes of equal shares of it run straight. `between95_n`
    (ahead, in reverse; at the codes of the family) is the half-width of the 95 % interval that this
    adds at rest, midway to the next voltage.
    """

    voltage_v: float
    family: ThrustFamily
    firmware: FirmwareCharacteristic
    between95_n: Matrix


class RoundTrip(Record):
    """Largest |T(N(T, V), V) - T| over 0.5 N < T <= T_max at one speed."""

    speed_mps: float
    cubic_n: float | None
    firmware_n: float
    firmware_rounded_codes: float
    published_n: float | None = None


class InverseCharacteristic(Record):
    """Tables 3 and 4 and the firmware form.

    `table3_*` are None without mooring data, `table4` is empty without a static family.
    """

    table3_positive: PolynomialFit | None
    table3_negative: PolynomialFit | None
    table4: tuple[SpeedInverse, ...]
    firmware: FirmwareCharacteristic | None
    round_trip: tuple[RoundTrip, ...]
    checks: tuple[Check, ...]
    explanations: tuple[str, ...]
    """What could not be computed and why, and what was assumed."""
    family: ThrustFamily | None = None
    """What the firmware's grid was made from; None where there is none."""
    voltages: tuple[AtVoltage, ...] = ()
    """T(N, V, U): the same at each voltage that was moored, rising; empty where it was one."""
