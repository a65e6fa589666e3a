"""Values of the fitted curves, for those who hold only the records; no fit is made here."""

from collections.abc import Sequence

import numpy as np

from pipeline.physics.drive import TorqueSurface, surface_basis
from pipeline.physics.propeller import polynomial
from pipeline.records.fits import DriveFit, PolynomialFit, PropellerFit, StaticCharacteristic
from pipeline.records.intervals import interval_factor
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
