"""What follows from recorded fits: values, 95 % intervals, the gap to the bollard pull."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.physics.drive import TorqueSurface, surface_basis
from pipeline.physics.propeller import polynomial
from pipeline.records.fits import (
    DriveFit,
    Interval,
    InverseCharacteristic,
    PolynomialFit,
    PropellerFit,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.records.measurements import MooringPoint
from pipeline.types import ArrayLike, FloatArray


def polynomial_band(fit: PolynomialFit, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Value and 95 % half-width of a polynomial fit at x shape (n,)."""
    powers = np.vander(x, len(fit.coefficients), increasing=True)
    covariance = np.asarray(fit.covariance)
    variance = np.einsum("ni,ij,nj->n", powers, covariance, powers)
    half_width = interval_factor(fit) * np.sqrt(np.maximum(variance, 0.0))
    return polynomial(x, np.asarray(fit.coefficients)), half_width


def torque_surface(drive: DriveFit) -> TorqueSurface:
    """Turn the record into the surface that the physics evaluates."""
    return TorqueSurface(
        np.array(drive.exponents, dtype=np.int64),
        np.array(drive.coefficients),
        np.array(drive.centre_rps),
        drive.shaft_speed_scale_rps,
        drive.code_scale,
        np.array(drive.band_code),
        np.array(drive.slowest_rps),
        np.array(drive.fastest_rps),
    )


def drive_torque(
    fit: DriveFit, shaft_speed_rpm: ArrayLike, code: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Torque M(n, N) of the drive surface and its standard error. [N m].

    Magnitudes of shaft speed and code are broadcast together.
    """
    rps = np.abs(np.asarray(shaft_speed_rpm, float)) / 60.0
    terms = surface_basis(rps, code, torque_surface(fit))
    variance = np.einsum("...i,ij,...j->...", terms, np.asarray(fit.covariance), terms)
    return terms @ np.asarray(fit.coefficients), np.sqrt(np.maximum(variance, 0.0))


def efficiency_curve(fit: PropellerFit, advance_ratio: FloatArray) -> FloatArray:
    """Efficiency from the two fits; NaN where thrust or torque is not positive."""
    k_t = polynomial(advance_ratio, np.asarray(fit.thrust.coefficients))
    k_m = polynomial(advance_ratio, np.asarray(fit.torque.coefficients))
    usable = (k_t > 0) & (k_m > 0)
    return np.where(usable, advance_ratio * k_t / (2 * np.pi * np.where(usable, k_m, 1.0)), np.nan)


def static_thrust(static: StaticCharacteristic, speed_index: int, code: ArrayLike) -> FloatArray:
    """Thrust of the family at a tabulated speed, linear between the grid's codes; signed.

    NaN at codes where drive and propeller have no working point: that is not zero thrust.
    """
    codes = np.asarray(code, float)
    met = np.asarray(static.status[speed_index]) != "no_working_point"
    grid, thrust = np.asarray(static.code), np.where(met, static.thrust_n[speed_index], np.nan)
    if not (static.code and static.code[0] == 0.0):
        grid, thrust = np.append(0.0, grid), np.append(0.0, thrust)
    return np.asarray(np.sign(codes) * np.interp(np.abs(codes), grid, thrust))


def static_std(static: StaticCharacteristic, speed_index: int, code: ArrayLike) -> FloatArray:
    """Return the standard error of the family's thrust, linear between the grid's codes."""
    magnitude = np.abs(np.asarray(code, float))
    return np.asarray(np.interp(magnitude, static.code, static.thrust_std_n[speed_index]))


def family_code(
    static: StaticCharacteristic, speed_mps: float, thrust_n: FloatArray
) -> FloatArray | None:
    """Code of the family at a thrust, by inverting its own grid; None at a speed it has not."""
    index = speed_index(static.speed_mps, speed_mps)
    if index is None:
        return None
    thrust = np.asarray(static.thrust_n[index])
    live = np.isin(np.asarray(static.status[index]), ["live", "extrapolated"])
    if live.sum() < 2:
        return None
    codes = np.asarray(static.code)[live]
    return np.asarray(np.interp(thrust_n, thrust[live], codes, left=np.nan, right=np.nan))


def table2_thrust(coefficients: ArrayLike, code: ArrayLike) -> FloatArray:
    """Thrust by eq. (4) of Kostenko 2023, zero where the polynomial is not positive.

    The dead zone is taken where the polynomial itself says so: K_F0 is a thrust, so the printed
    condition |N| <= K_F0 cannot be meant.

    >>> table2_thrust([-4.0, 0.254, 8.82e-4], [-127.0, 10.0, 127.0]).round(2).tolist()
    [-42.48, 0.0, 42.48]
    """
    codes = np.asarray(code, float)
    return np.asarray(np.sign(codes) * np.maximum(polynomial(np.abs(codes), coefficients), 0.0))


def table4_code(coefficients: ArrayLike, thrust_n: ArrayLike) -> FloatArray:
    """Code by eq. (8) of Kostenko 2023 for thrust over the dead zone; odd in the thrust.

    >>> float(table4_code([11.7, 4.32, -0.073, 8.51e-4], 42.0).round(1))
    127.4
    """
    thrust = np.asarray(thrust_n, float)
    return np.asarray(np.sign(thrust) * polynomial(np.abs(thrust), coefficients))


def speed_index(speeds: tuple[float, ...], speed_mps: float) -> int | None:
    """Return where a speed stands among the tabulated ones, None if it does not.

    >>> speed_index((0.0, 0.5, 1.0), 0.5), speed_index((0.0, 0.5), 0.7)
    (1, None)
    """
    return next((k for k, own in enumerate(speeds) if abs(own - speed_mps) < 1e-6), None)


def shown_speeds(static: StaticCharacteristic, speeds: Sequence[float]) -> list[tuple[float, int]]:
    """Those of the given speeds that the family holds, each with its row."""
    pairs = [(v, speed_index(static.speed_mps, v)) for v in speeds]
    return [(v, index) for v, index in pairs if index is not None]


#: 0.975 quantile of the standard normal distribution.
NORMAL_95 = 1.959963984540054
#: Sweeps for each term of the drive's surface below which its intervals are still too narrow.
SWEEPS_PER_TERM = 2


def student_95(degrees_of_freedom: int) -> float:
    """0.975 quantile of Student's t.

    >>> round(student_95(11), 3)
    2.201
    """
    # `scipy.stats` takes a second to import
    from scipy.special import stdtrit

    return float(stdtrit(degrees_of_freedom, 0.975))


def drive_degrees(drive: DriveFit) -> int:
    """Degrees of freedom of the drive's covariance: sweeps less one, or points less terms."""
    if drive.clustered:
        return drive.clusters - 1
    return drive.quality.points - len(drive.coefficients)


def drive_factor(drive: DriveFit) -> float:
    """Half-width of a 95 % interval of the drive's surface in standard errors."""
    return student_95(drive_degrees(drive))


def interval_factor(fit: PolynomialFit) -> float:
    """Half-width of the recorded 95 % intervals in standard errors.

    What is derived from a fit then has the factor (normal or Student) that the fit itself used.
    """
    for index, (low, high) in enumerate(fit.ci95):
        std = float(np.sqrt(max(fit.covariance[index][index], 0.0)))
        if std > 0:
            return (high - low) / (2 * std)
    return NORMAL_95


def static_factor(static: StaticCharacteristic, drive: DriveFit | None = None) -> float:
    """Half-width of the 95 % interval of the family's thrust in standard errors.

    Where Table 2 has no row, that of the drive, whose scatter it is; normal where that is unknown.
    """
    if static.table2:
        return interval_factor(static.table2[0].fit)
    return NORMAL_95 if drive is None else drive_factor(drive)


def largest_thrust_interval(row: StaticRow, inverse: InverseCharacteristic | None) -> Interval:
    """95 % interval of T_max: the bench's, widened by what the mooring test differs by."""
    low, high = row.thrust_max_ci95
    own = half = (high - low) / 2.0
    if inverse is not None and inverse.family is not None:
        for side in (inverse.family.positive, inverse.family.negative):
            for speed_mps, widths in zip(side.speed_mps, side.half95_n, strict=True):
                if abs(speed_mps - row.speed_mps) < 1e-9:
                    half = max(half, widths[-1])
    if half == own:
        return low, high
    return row.thrust_max_n - half, row.thrust_max_n + half


@dataclass(frozen=True)
class CodeGap:
    """Mooring test and calculation at one signed code; thrusts are magnitudes."""

    code: float
    points: int
    measured_n: float
    calculated_n: float
    half_width_n: float
    """95 %, of the calculation and of the mean of the mooring points together."""

    @property
    def gap_n(self) -> float:
        """Measured less calculated, positive where the mooring test gives more."""
        return self.measured_n - self.calculated_n


def code_gaps(
    points: Sequence[MooringPoint], static: StaticCharacteristic, drive: DriveFit | None = None
) -> tuple[CodeGap, ...]:
    """Mean of the mooring points at each signed code, less the calculation at rest."""
    row = speed_index(static.speed_mps, 0.0)
    if row is None:
        return ()
    used = {p.code for p in points if p.code != 0}
    by_code = {own: np.array([p.thrust_n for p in points if p.code == own]) for own in sorted(used)}
    # of the points about their code's mean, pooled
    squares = sum(float(np.sum((own - np.mean(own)) ** 2)) for own in by_code.values())
    freedom = sum(len(own) - 1 for own in by_code.values())
    scatter = float(np.sqrt(squares / freedom)) if freedom > 0 else 0.0
    gaps = []
    for value, measured in by_code.items():
        calculated = float(static_thrust(static, row, abs(value)))
        if not calculated > 0 or abs(value) > static.code[-1]:
            continue
        thrust = float(np.sign(value)) * measured
        half = np.hypot(
            static_factor(static, drive) * float(static_std(static, row, value)),
            NORMAL_95 * scatter / np.sqrt(len(thrust)),
        )
        gaps.append(CodeGap(value, len(thrust), float(np.mean(thrust)), calculated, float(half)))
    return tuple(gaps)
