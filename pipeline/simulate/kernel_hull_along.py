"""Compiled kernel: the wrench of water and weight on the hull along a run whose motion is known."""

from typing import Any

import numpy as np

from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_frames import rotation_matrix
from pipeline.simulate.kernel_hull import (
    add_damping,
    add_restoring,
    mass_matrix,
    subtract_coriolis,
)

Array = Any


@compiled
def hull_along(
    p: Array, attitudes: Array, velocities: Array, strips: Array, matrix: Array, wrenches: Array
) -> None:
    """Fill the mass matrix (6, 6), and wrenches (m, 6) for attitudes (m, 4), velocities (m, 6).

    A wrench is -(C(nu_r) nu_r + D nu_r + d |nu_r| nu_r + g), away from walls.
    """
    mass_matrix(p, 1.0, matrix)
    rotation = np.zeros((3, 3))
    for k in range(velocities.shape[0]):
        q = attitudes[k]
        rotation_matrix(q[0], q[1], q[2], q[3], rotation)
        for i in range(6):
            wrenches[k, i] = 0.0
        add_restoring(p, rotation, wrenches[k])
        add_damping(p, velocities[k], 1.0, strips, wrenches[k])
        subtract_coriolis(p, matrix, velocities[k], wrenches[k])
