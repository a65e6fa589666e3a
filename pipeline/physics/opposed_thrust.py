"""The drag of a propeller that turns freely: what stands for thrust against the motion at least.

The papers cover thrust and motion along the same direction only; how good the mooring branch is
against the motion is measured in docs/methods/allocator.md.
"""

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.physics.torque_balance import OpenWaterPropeller, first_zero
from pipeline.types import ArrayLike, FloatArray


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
