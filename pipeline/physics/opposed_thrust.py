"""Thrust against the motion, and the drag of a propeller that does not drive.

The papers cover thrust and motion along the same direction only. Here the mooring branch is the
model for thrust against the motion, and this module says how far off it can be: it evaluates what
the open-water curves give when they are extrapolated to a negative advance ratio. Measured
four-quadrant curves (Wageningen B4-70; van Lammeren, van Manen and Oosterveld 1969) stay closer to
the mooring branch than the extrapolation does; see docs/methods/allocator.md.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.physics.propeller import advance_ratio, polynomial
from pipeline.physics.torque_balance import OpenWaterPropeller, first_zero
from pipeline.types import ArrayLike, FloatArray

#: Drag coefficient of a locked propeller on its expanded blade area: -C_T* = 0.77 of the disc for
#: the Wageningen B4-70 with the shaft stopped (beta = 90 deg), over its area ratio 0.70.
LOCKED_DRAG_COEFFICIENT = 1.1


@dataclass(frozen=True)
class OpposedThrust:
    """Thrust against the motion for one or many states; all arrays of one shape. [N].

    `rest_n` is the model (the mooring branch). `same_speed_n` keeps the shaft speed of rest,
    `same_torque_n` the torque of rest; both extrapolate K_T and K_M to J < 0. A drive whose torque
    falls with speed lies between; `drive_n` solves its balance if the drive is given. `low_n` and
    `high_n` span all of them. `advance_ratio` (negative) is at the shaft speed of rest.
    """

    advance_ratio: FloatArray
    rest_n: FloatArray
    same_speed_n: FloatArray
    same_torque_n: FloatArray
    drive_n: FloatArray | None
    low_n: FloatArray
    high_n: FloatArray


def opposed_thrust_band(
    rest_shaft_speed_rps: ArrayLike,
    speed_mps: ArrayLike,
    propeller: OpenWaterPropeller,
    *,
    drive: Callable[[FloatArray], FloatArray] | None = None,
) -> OpposedThrust:
    r"""Span the thrust against the motion between the rest value and extrapolated curves.

    With :math:`n_0` the shaft speed at rest and :math:`J = -V/(n D) < 0`:

    .. math:: T = K_T(0) \rho n_0^2 D^4, \quad T = K_T(J_0) \rho n_0^2 D^4, \quad
              T = K_T(J_1) \rho n_1^2 D^4 \text{ with } K_M(J_1) n_1^2 = K_M(0) n_0^2

    Parameters
    ----------
    rest_shaft_speed_rps : array_like
        Shaft speed of the same code at rest, positive. [rev/s]
    speed_mps : array_like
        Speed against the thrust, as a positive number. [m/s]
    propeller : OpenWaterPropeller
        Open-water curves; those of normal running are used for both signs of the code.
    drive : callable, optional
        Torque of the drive at that code against shaft speed, for arrays of the broadcast shape.
        [rev/s] -> [N m]

    Returns
    -------
    OpposedThrust
        Magnitudes, positive in the direction of the thrust.

    Raises
    ------
    ValueError
        If a shaft speed is not positive or a speed is negative.

    Notes
    -----
    A band between models, not a confidence interval. Beyond \|J\| of about 0.5 the polynomials are
    far from any point that they were fitted to.

    Examples
    --------
    >>> p = OpenWaterPropeller(np.array([0.139, -0.155, -0.061]),
    ...                        np.array([0.0171, -0.0164, -0.0055]), 0.14, 1000.62)
    >>> band = opposed_thrust_band(28.2, 2.0, p)
    >>> [round(float(t), 1) for t in (band.rest_n, band.same_speed_n, band.same_torque_n)]
    [42.5, 61.7, 44.0]
    """
    n0, speed = np.broadcast_arrays(
        np.asarray(rest_shaft_speed_rps, float), np.asarray(speed_mps, float)
    )
    if (n0 <= 0.0).any() or (speed < 0.0).any():
        raise ValueError("shaft speeds must be positive and speeds not negative")
    rest = propeller.thrust_n(n0, 0.0)
    same_speed = propeller.thrust_n(n0, -speed)
    rest_torque = propeller.torque_nm(n0, 0.0)
    same_torque = propeller.thrust_n(
        _shaft_speed(propeller, n0, speed, lambda _: rest_torque), -speed
    )
    of_drive = None
    if drive is not None:
        of_drive = propeller.thrust_n(_shaft_speed(propeller, n0, speed, drive), -speed)
    span = [rest, same_speed, same_torque] + ([] if of_drive is None else [of_drive])
    return OpposedThrust(
        advance_ratio=advance_ratio(-speed, n0, propeller.diameter_m),
        rest_n=rest,
        same_speed_n=same_speed,
        same_torque_n=same_torque,
        drive_n=of_drive,
        low_n=np.minimum.reduce(span),
        high_n=np.maximum.reduce(span),
    )


def _shaft_speed(
    propeller: OpenWaterPropeller,
    rest_shaft_speed_rps: FloatArray,
    speed_mps: FloatArray,
    available: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """Balance the propeller's torque against the drive's by bisection, on [0, 4 n_0].

    Bisection, because the extrapolated curves guarantee one crossing but no smoothness of it.
    """
    low = np.full(rest_shaft_speed_rps.shape, 1e-9) * rest_shaft_speed_rps
    high = 4.0 * rest_shaft_speed_rps
    for _ in range(60):
        middle = 0.5 * (low + high)
        too_fast = propeller.torque_nm(middle, -speed_mps) > available(middle)
        high = np.where(too_fast, middle, high)
        low = np.where(too_fast, low, middle)
    return np.asarray(0.5 * (low + high))


def locked_propeller_drag(
    speed_mps: ArrayLike,
    *,
    diameter_m: float,
    area_ratio: float,
    density_kgpm3: float,
    drag_coefficient: float = LOCKED_DRAG_COEFFICIENT,
) -> FloatArray:
    r"""Drag of a propeller that does not turn, :math:`C_D \rho V |V| A_E / 2`.

    Parameters
    ----------
    speed_mps : array_like
        Speed of the inflow. [m/s]
    diameter_m, area_ratio : float
        Diameter [m] and expanded blade area over disc area [-].
    density_kgpm3 : float
        Water density. [kg/m^3]
    drag_coefficient : float
        On the expanded blade area; the default is from a propeller of pitch ratio 1.0. [-]

    Returns
    -------
    ndarray
        Drag with the sign of the speed. [N]

    References
    ----------
    Default coefficient: Wageningen B4-70 with the shaft stopped (van Lammeren et al. 1969). Towing
    tests of locked sailboat propellers, not used here: MacKenzie and Forrester, Sailboat propeller
    drag, Ocean Engineering 2008, doi 10.1016/j.oceaneng.2007.07.004.

    Examples
    --------
    >>> drag = locked_propeller_drag(2.0, diameter_m=0.14, area_ratio=0.26, density_kgpm3=1000.62)
    >>> round(float(drag), 1)
    8.8
    """
    speed = np.asarray(speed_mps, float)
    area = area_ratio * np.pi / 4.0 * diameter_m**2
    return np.asarray(0.5 * drag_coefficient * density_kgpm3 * area * speed * np.abs(speed))


def free_propeller_drag(speed_mps: ArrayLike, propeller: OpenWaterPropeller) -> FloatArray:
    r"""Drag of a propeller that turns freely: the thrust where K_M = 0, with the sign turned.

    .. math:: D = -\frac{K_T(J_0)}{J_0^2} \rho D^2 V |V|, \qquad K_M(J_0) = 0

    Parameters
    ----------
    speed_mps : array_like
        Speed of the inflow. [m/s]
    propeller : OpenWaterPropeller
        Open-water curves, here used beyond their fitted range.

    Returns
    -------
    ndarray
        Drag with the sign of the speed; a drive's friction adds to it. [N]

    Raises
    ------
    ValueError
        If K_M(J) never falls to zero.

    Examples
    --------
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
