"""Compiled kernel: the wrench that a known motion demands of the thrusters."""

from typing import Any

import numpy as np

from pipeline.physics.parameters import offset
from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_frames import rotation_matrix
from pipeline.simulate.kernel_hull import (
    add_damping,
    add_restoring,
    add_towed_tether,
    mass_matrix,
    subtract_coriolis,
    wall_factor,
)

Array = Any

CURRENT = offset("current")


@compiled
def demand_along(p: Array, states: Array, accelerations: Array, strips: Array, out: Array) -> None:
    """Fill out (m, 6) with M nu_r' less every force but thrust, at states (m, 13).

    `accelerations` (m, 6) are those of nu, the velocity over ground.
    """
    rotation, matrix = np.zeros((3, 3)), np.zeros((6, 6))
    nu_r, rate, force, water = np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(3)
    for row in range(states.shape[0]):
        state = states[row]
        rotation_matrix(state[3], state[4], state[5], state[6], rotation)
        for k in range(3):
            water[k] = 0.0
            for j in range(3):
                water[k] += rotation[j, k] * p[CURRENT + j]
        for k in range(3):
            nu_r[k] = state[7 + k] - water[k]
            nu_r[3 + k] = state[10 + k]
        for k in range(6):
            rate[k], force[k] = accelerations[row, k], 0.0
        # nu = nu_r + water, and the water's velocity turns against the body: -omega x water
        rate[0] += state[11] * water[2] - state[12] * water[1]
        rate[1] += state[12] * water[0] - state[10] * water[2]
        rate[2] += state[10] * water[1] - state[11] * water[0]
        add_restoring(p, rotation, force)
        add_towed_tether(p, state, rotation, nu_r, force)
        near_wall = wall_factor(p, state[0], state[1], state[2])
        add_damping(p, nu_r, near_wall, strips, force)
        mass_matrix(p, near_wall, matrix)
        subtract_coriolis(p, matrix, nu_r, force)
        for i in range(6):
            total = -force[i]
            for j in range(6):
                total += matrix[i, j] * rate[j]
            out[row, i] = total
