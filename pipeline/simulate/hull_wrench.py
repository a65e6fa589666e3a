"""Force and moment of water and weight on the hull along a measured run, and the mass matrix."""

import numpy as np

from pipeline.simulate.kernel_hull_along import hull_along
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def hull_wrench(
    packed: PackedVehicle, attitude: FloatArray, nu_relative: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Wrench of Coriolis terms, damping and restoring, and the mass matrix with added mass.

    With the thrusters' wrench tau the model is M nu_r' = wrench + tau, away from walls and without
    a tether.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle.
    attitude : ndarray, shape (m, 4)
        Unit quaternions w x y z, body to NED.
    nu_relative : ndarray, shape (m, 6)
        Velocity relative to the water, body axes. [m/s, rad/s]

    Returns
    -------
    wrench : ndarray, shape (m, 6)
        About the body origin. [N, N m]
    matrix : ndarray, shape (6, 6)
        M = M_RB + M_A.
    """
    matrix, wrenches = np.zeros((6, 6)), np.zeros((len(nu_relative), 6))
    hull_along(
        packed.vector,
        np.ascontiguousarray(attitude, float),
        np.ascontiguousarray(nu_relative, float),
        np.ascontiguousarray(packed.strips, float),
        matrix,
        wrenches,
    )
    return wrenches, matrix
