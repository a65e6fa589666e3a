"""Where the drive's torque meets the propeller's: Kostenko 2023, eq. (3) and figure 5."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.physics.drive import TorqueSurface, drive_torque, drive_torque_slope
from pipeline.physics.propeller import polynomial, thrust, torque
from pipeline.types import ArrayLike, BoolArray, FloatArray

#: A search below this shaft speed is a search for nothing. [rev/s]
SLOWEST_SHAFT_RPS = 1e-6


@dataclass(frozen=True)
class OpenWaterPropeller:
    """Open-water polynomials of a propeller of known size in water of known density."""

    thrust_coefficients: FloatArray
    torque_coefficients: FloatArray
    diameter_m: float
    density_kgpm3: float

    def thrust_n(self, shaft_speed_rps: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Thrust [N]."""
        return thrust(
            shaft_speed_rps,
            speed_mps,
            coefficients=self.thrust_coefficients,
            diameter_m=self.diameter_m,
            density_kgpm3=self.density_kgpm3,
        )

    def torque_nm(self, shaft_speed_rps: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Torque at the shaft [N m]."""
        return torque(
            shaft_speed_rps,
            speed_mps,
            coefficients=self.torque_coefficients,
            diameter_m=self.diameter_m,
            density_kgpm3=self.density_kgpm3,
        )


@dataclass(frozen=True)
class WorkingPoints:
    """Solutions of the torque balance, all arrays of one shape.

    `found` is False where the curves do not meet; there the numbers are zero. `dead` marks points
    where the drive cannot bring the propeller to positive thrust (T = 0 by the paper's convention).
    """

    shaft_speed_rps: FloatArray
    torque_nm: FloatArray
    thrust_n: FloatArray
    advance_ratio: FloatArray
    found: BoolArray
    dead: BoolArray


def first_zero(coefficients: ArrayLike) -> float:
    """Smallest positive zero of a polynomial with ascending coefficients; inf if there is none.

    >>> round(first_zero([0.139, -0.155, -0.061]), 4)
    0.7025
    """
    roots = np.polynomial.polynomial.polyroots(np.asarray(coefficients, float))
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(real.min()) if real.size else np.inf


def working_points(
    code: ArrayLike,
    speed_mps: ArrayLike,
    *,
    propeller: OpenWaterPropeller,
    surface: TorqueSurface,
    fastest_shaft_rps: float,
) -> WorkingPoints:
    r"""Solve :math:`K_M(J) \rho n^2 D^5 = M(n, N)` for n wherever the thrust is positive.

    Positive codes and speeds along the thrust, not negative, broadcast together. The search runs
    from the shaft speed at which K_T(V / nD) = 0 up to `fastest_shaft_rps`. If the propeller
    already needs more torque than the drive gives at the lower end, the balance lies where the
    thrust is negative, and the point is dead.

    References
    ----------
    Kostenko 2023, eq. (3), section 3; the printed "n / 60" squares as (n / 60)^2 with n in rpm.
    """
    codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
    zero_thrust_ratio = first_zero(propeller.thrust_coefficients)
    slowest = np.maximum(speed / (propeller.diameter_m * zero_thrust_ratio), SLOWEST_SHAFT_RPS)

    def excess(n: FloatArray, at_speed: FloatArray, at_code: FloatArray) -> FloatArray:
        return propeller.torque_nm(n, at_speed) - drive_torque(n, at_code, surface)

    shaft, found, dead = balanced(excess, slowest, fastest_shaft_rps, speed, codes)
    safe = np.where(found, shaft, 1.0)
    return WorkingPoints(
        shaft_speed_rps=shaft,
        torque_nm=np.where(found, propeller.torque_nm(safe, speed), 0.0),
        thrust_n=np.where(found, propeller.thrust_n(safe, speed), 0.0),
        advance_ratio=np.where(found, speed / (safe * propeller.diameter_m), 0.0),
        found=found,
        dead=dead,
    )


def balanced(
    excess: Callable[..., FloatArray],
    slowest_rps: FloatArray,
    fastest_rps: float,
    *arguments: FloatArray,
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Return the shaft speeds without torque to spare [rev/s], where found, and what is dead.

    `excess` is the torque of the propeller less that of the drive, of shaft speeds and `arguments`
    [N m]; the search goes from `slowest_rps`, where a point is dead if the drive lacks torque even
    there, to `fastest_rps`.
    """
    from scipy.optimize import elementwise

    fastest = np.full(slowest_rps.shape, fastest_rps)
    dead = excess(slowest_rps, *arguments) >= 0
    # beyond the range every drive is dead: nothing drives the shaft past the zero-thrust speed
    unmet = ~dead & ((excess(fastest, *arguments) < 0) | (slowest_rps >= fastest))
    found = ~dead & ~unmet
    shaft = np.zeros(slowest_rps.shape)
    if found.any():
        ends = (slowest_rps[found], fastest[found])
        result = elementwise.find_root(excess, ends, args=tuple(one[found] for one in arguments))
        shaft[found] = result.x
    return shaft, found, dead


def torque_excess_slope(
    points: WorkingPoints,
    code: ArrayLike,
    *,
    propeller: OpenWaterPropeller,
    surface: TorqueSurface,
) -> FloatArray:
    r"""Slope d(M_propeller - M_drive)/dn at the working points, positive if stable [N m s].

    From M = rho D^5 (K_M n^2) with K_M a polynomial in J = V/(nD):
    :math:`dM/dn = \rho D^5 n (2 K_M - J K_M')`.
    """
    n, j = points.shaft_speed_rps, points.advance_ratio
    k_m = polynomial(j, propeller.torque_coefficients)
    k_m_slope = polynomial(j, np.polynomial.polynomial.polyder(propeller.torque_coefficients))
    of_propeller = (
        propeller.density_kgpm3 * propeller.diameter_m**5 * n * (2.0 * k_m - j * k_m_slope)
    )
    return of_propeller - drive_torque_slope(n, code, surface)


def thrust_slope(points: WorkingPoints, propeller: OpenWaterPropeller) -> FloatArray:
    r"""Slope of thrust to shaft speed at fixed speed, dT/dn = rho D^4 n (2 K_T - J K_T') [N s]."""
    n, j = points.shaft_speed_rps, points.advance_ratio
    k_t = polynomial(j, propeller.thrust_coefficients)
    k_t_slope = polynomial(j, np.polynomial.polynomial.polyder(propeller.thrust_coefficients))
    return np.asarray(
        propeller.density_kgpm3 * propeller.diameter_m**4 * n * (2.0 * k_t - j * k_t_slope)
    )


def free_propeller_drag(speed_mps: ArrayLike, propeller: OpenWaterPropeller) -> FloatArray:
    r"""Drag of a propeller that turns freely, K_M = 0, with the sign of the speed. [N].

    .. math:: D = -\frac{K_T(J_0)}{J_0^2} \rho D^2 V |V|, \qquad K_M(J_0) = 0

    The curves are used beyond their fitted range; a drive's friction adds to it.

    Raises
    ------
    ValueError
        If K_M(J) never falls to zero.

    >>> p = OpenWaterPropeller(np.array([0.139, -0.155, -0.061]),
    ...                        np.array([0.0171, -0.0164, -0.0055]), 0.14, 1000.62)
    >>> round(float(free_propeller_drag(2.0, p)), 1)
    3.4
    """
    zero = first_zero(propeller.torque_coefficients)
    if not np.isfinite(zero):
        raise ValueError("K_M(J) has no zero: a freely turning propeller cannot be computed")
    speed = np.asarray(speed_mps, float)
    factor = -float(polynomial(zero, propeller.thrust_coefficients)) / zero**2
    return np.asarray(
        factor * propeller.density_kgpm3 * propeller.diameter_m**2 * speed * np.abs(speed)
    )
