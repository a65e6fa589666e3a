"""Compiled kernel: the equations of motion and their integration.

State: position NED (3), quaternion w x y z (4), nu = u v w p q r (6), then one entry a thruster:
its effective code after the lag, or its shaft speed in rev/s where it has a rotor inertia.
"""

from typing import Any

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, offset
from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_frames import (
    normalise_quaternion,
    quaternion_rate,
    rotation_matrix,
)
from pipeline.simulate.kernel_hull import (
    add_damping,
    add_restoring,
    add_towed_tether,
    mass_matrix,
    solve_symmetric,
    subtract_coriolis,
    wall_factor,
)
from pipeline.simulate.kernel_thrusters import (
    add_thrust,
    effective_codes,
    shaft_rate,
    thruster_directions,
)

Array = Any

CURRENT = offset("current")
WALL_STRENGTH = offset("wall_strength")
THRUSTER_COUNT = offset("thruster_count")
LAG = offset("lag")
ROTOR_INERTIA = offset("rotor_inertia")
#: Entries of the state.
BODY = 13
STATE = BODY + MOST_THRUSTERS
RK4, SEMI_IMPLICIT = 0, 1


@compiled
def rates(
    p: Array,
    state: Array,
    codes: Array,
    external: Array,
    directions: Array,
    matrix: Array,
    inverse: Array,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
    rate: Array,
    thrust: Array,
    work: Array,
) -> None:
    """Fill the rate of change of a state, and the thrusts.

    `codes` are the effective codes, `external` (6,) a force and moment on the body from outside
    the model. `work` (5, 6) and the first rows of it hold vectors; `matrix`, `inverse` (6, 6) are
    the mass matrix and its inverse away from walls.
    """
    nu_r, force, water, scratch = work[0], work[1], work[2], work[3]
    rotation = np.empty((3, 3))
    rotation_matrix(state[3], state[4], state[5], state[6], rotation)
    for k in range(3):
        water[k] = (
            rotation[0, k] * p[CURRENT]
            + rotation[1, k] * p[CURRENT + 1]
            + rotation[2, k] * p[CURRENT + 2]
        )
        nu_r[k] = state[7 + k] - water[k]
        nu_r[3 + k] = state[10 + k]
    for k in range(6):
        force[k] = external[k]
    inflow = np.empty(MOST_THRUSTERS)
    add_thrust(
        p, directions, state[BODY:], nu_r, thrust_tables, screws, steps, thrust, inflow, force
    )
    add_restoring(p, rotation, force)
    add_towed_tether(p, state, rotation, nu_r, force)
    near_wall = wall_factor(p, state[0], state[1], state[2])
    add_damping(p, nu_r, near_wall, strips, force)
    if near_wall != 1.0:
        heavier = np.empty((6, 6))
        factor = np.empty((6, 6))
        mass_matrix(p, near_wall, heavier)
        subtract_coriolis(p, heavier, nu_r, force)
        solve_symmetric(heavier, force, factor, scratch)
        for k in range(6):
            rate[7 + k] = scratch[k]
    else:
        subtract_coriolis(p, matrix, nu_r, force)
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += inverse[i, j] * force[j]
            rate[7 + i] = total
    # nu = nu_r + water, and the water's velocity turns against the body: -omega x water
    rate[7] -= state[11] * water[2] - state[12] * water[1]
    rate[8] -= state[12] * water[0] - state[10] * water[2]
    rate[9] -= state[10] * water[1] - state[11] * water[0]
    for k in range(3):
        rate[k] = rotation[k, 0] * state[7] + rotation[k, 1] * state[8] + rotation[k, 2] * state[9]
    quaternion_rate(state, state[7:13], rate)
    for i in range(MOST_THRUSTERS):
        rate[BODY + i] = 0.0
    for i in range(int(p[THRUSTER_COUNT])):
        if p[ROTOR_INERTIA + i] > 0.0:
            rate[BODY + i] = shaft_rate(
                p, i, state[BODY + i], codes[i], inflow[i], screws, torque_tables, steps
            )


@compiled
def lagged(p: Array, start: Array, codes: Array, elapsed: float, state: Array) -> None:
    """Set the lagged codes of a state a time after the start of a step, exactly.

    The command is constant over a step, so the first-order lag has a closed form; integrating it
    would tie the step to the shortest lag.
    """
    for i in range(int(p[THRUSTER_COUNT])):
        if p[ROTOR_INERTIA + i] > 0.0:
            continue
        tau = p[LAG + i]
        if tau > 0.0:
            state[BODY + i] = codes[i] + (start[BODY + i] - codes[i]) * np.exp(-elapsed / tau)
        else:
            state[BODY + i] = codes[i]


@compiled
def simulate(
    p: Array,
    initial: Array,
    commands: Array,
    external: Array,
    dt: float,
    method: int,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
    states: Array,
    accelerations: Array,
    thrusts: Array,
) -> None:
    """Integrate over commands (m, 12) held for dt each; external (m, 6) or (1, 6) likewise.

    Fills states (m + 1, STATE), accelerations nu' (m + 1, 6) and thrusts (m + 1, 12); the last row
    of the last two repeats the last command.
    """
    count = commands.shape[0]
    matrix = np.empty((6, 6))
    mass_matrix(p, 1.0, matrix)
    inverse = np.linalg.inv(matrix)
    directions = np.zeros((MOST_THRUSTERS, 3))
    thruster_directions(p, directions)
    codes = np.zeros(MOST_THRUSTERS)
    thrust = np.zeros(MOST_THRUSTERS)
    spare = np.zeros(MOST_THRUSTERS)
    work = np.empty((5, 6))
    k1, k2, k3, k4 = np.empty(STATE), np.empty(STATE), np.empty(STATE), np.empty(STATE)
    x, stage = initial.copy(), np.empty(STATE)
    for k in range(count + 1):
        now = min(k, count - 1)
        outside = external[min(now, external.shape[0] - 1)]
        effective_codes(p, commands[now], codes)
        # a thruster without lag is at its code from the start of the step
        lagged(p, x, codes, 0.0, x)
        rates(
            p,
            x,
            codes,
            outside,
            directions,
            matrix,
            inverse,
            strips,
            thrust_tables,
            screws,
            torque_tables,
            steps,
            k1,
            thrust,
            work,
        )
        states[k] = x
        accelerations[k] = k1[7:13]
        thrusts[k] = thrust
        if k == count:
            break
        if method == SEMI_IMPLICIT:
            stage[:] = x
            for i in range(7, STATE):
                stage[i] = x[i] + dt * k1[i]
            rotation = np.empty((3, 3))
            rotation_matrix(x[3], x[4], x[5], x[6], rotation)
            for i in range(3):
                k1[i] = (
                    rotation[i, 0] * stage[7]
                    + rotation[i, 1] * stage[8]
                    + rotation[i, 2] * stage[9]
                )
            quaternion_rate(x, stage[7:13], k1)
            for i in range(7):
                stage[i] = x[i] + dt * k1[i]
            lagged(p, x, codes, dt, stage)
            x[:] = stage
        else:
            for i in range(STATE):
                stage[i] = x[i] + 0.5 * dt * k1[i]
            lagged(p, x, codes, 0.5 * dt, stage)
            rates(
                p,
                stage,
                codes,
                outside,
                directions,
                matrix,
                inverse,
                strips,
                thrust_tables,
                screws,
                torque_tables,
                steps,
                k2,
                spare,
                work,
            )
            for i in range(STATE):
                stage[i] = x[i] + 0.5 * dt * k2[i]
            lagged(p, x, codes, 0.5 * dt, stage)
            rates(
                p,
                stage,
                codes,
                outside,
                directions,
                matrix,
                inverse,
                strips,
                thrust_tables,
                screws,
                torque_tables,
                steps,
                k3,
                spare,
                work,
            )
            for i in range(STATE):
                stage[i] = x[i] + dt * k3[i]
            lagged(p, x, codes, dt, stage)
            rates(
                p,
                stage,
                codes,
                outside,
                directions,
                matrix,
                inverse,
                strips,
                thrust_tables,
                screws,
                torque_tables,
                steps,
                k4,
                spare,
                work,
            )
            for i in range(STATE):
                stage[i] = x[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            lagged(p, x, codes, dt, stage)
            x[:] = stage
        normalise_quaternion(x)
