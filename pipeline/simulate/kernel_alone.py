"""Compiled kernel: parts that are called by themselves; those compiled into others cannot be."""

from typing import Any

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, offset
from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel import fixed_parts, lag_codes, run_on, work_space
from pipeline.simulate.kernel_frames import rotation_matrix
from pipeline.simulate.kernel_hull import (
    add_damping,
    add_restoring,
    add_towed_tether,
    mass_matrix,
    subtract_coriolis,
    wall_factor,
)
from pipeline.simulate.kernel_lag import set_step
from pipeline.simulate.kernel_thrusters import (
    add_thrust,
    effective_codes,
    static_thrust,
    thruster_directions,
    thruster_levers,
)

CURRENT = offset("current")
INFLOW_FRACTION = offset("inflow_fraction")
THRUSTER_COUNT = offset("thruster_count")

Array = Any


@compiled
def simulate_pieces(
    p: Array,
    starts: Array,
    late: Array,
    external: Array,
    bounds: Array,
    steps_s: Array,
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
    """Simulate stretch k over the codes and external forces [bounds[k], bounds[k + 1]).

    `starts` (k, STATE), `late` (m, 3, 12) of `lag_pieces`, `external` (m, 6) or (1, 6), `steps_s`
    (k,). Of `states` (m + k, STATE) and the others a stretch fills one row more than it has steps,
    so its first row is bounds[k] + k.
    """
    count = starts.shape[0]
    if count == 0:
        return
    fixed = fixed_parts(p, strips, thrust_tables, screws, torque_tables, steps)
    work = work_space(p, starts[0], steps_s[0])
    alike = external.shape[0] == 1
    for k in range(count):
        first, end = bounds[k], bounds[k + 1]
        run_on(
            p,
            starts[k],
            late[first:end],
            external if alike else external[first:end],
            steps_s[k],
            method,
            fixed,
            work,
            states[first + k : end + k + 1],
            accelerations[first + k : end + k + 1],
            thrusts[first + k : end + k + 1],
        )


@compiled
def lag_pieces(
    p: Array, starts: Array, commands: Array, bounds: Array, steps_s: Array, late: Array
) -> None:
    """Fill late (m, 3, 12), the codes of all stretches over the steps of commands (m, 12)."""
    if starts.shape[0] == 0:
        return
    work = work_space(p, starts[0], steps_s[0])
    for k in range(starts.shape[0]):
        first, end = bounds[k], bounds[k + 1]
        set_step(p, steps_s[k], work.lags)
        lag_codes(p, starts[k], commands[first:end], work, late[first:end])


@compiled
def codes_that_act(p: Array, commands: Array, codes: Array) -> None:
    """Fill codes (k, 12) with the effective codes of commands (k, 12) at parameters `p`."""
    for k in range(commands.shape[0]):
        effective_codes(p, commands[k], codes[k])


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


@compiled
def wrench_along(
    p: Array,
    actuators: Array,
    velocities: Array,
    thrust_tables: Array,
    screws: Array,
    steps: Array,
    thrusts: Array,
    wrenches: Array,
) -> None:
    """Fill thrusts (m, 12) and wrenches (m, 6) for actuator states (m, 12), velocities (m, 6).

    Velocities are relative to the water.
    """
    levers = np.zeros((MOST_THRUSTERS, 6))
    thruster_levers(p, levers)
    inflow, per_step = np.zeros(MOST_THRUSTERS), 1.0 / steps
    for k in range(actuators.shape[0]):
        for i in range(6):
            wrenches[k, i] = 0.0
        add_thrust(
            p,
            levers,
            actuators[k],
            velocities[k],
            thrust_tables,
            screws,
            per_step,
            thrusts[k],
            inflow,
            wrenches[k],
        )


@compiled
def settled_along(
    p: Array, commands: Array, speeds: Array, thrust_tables: Array, steps: Array, thrusts: Array
) -> None:
    """Fill thrusts (m, 12) of commands (m, 12) without lag at speeds past the hull (m, 12)."""
    codes, per_step = np.zeros(MOST_THRUSTERS), 1.0 / steps
    for k in range(commands.shape[0]):
        effective_codes(p, commands[k], codes)
        for i in range(int(p[THRUSTER_COUNT])):
            own = p[INFLOW_FRACTION + i] * speeds[k, i]
            thrusts[k, i] = static_thrust(p, i, codes[i], own, thrust_tables, per_step)


@compiled
def fill_mass(p: Array, near_wall: float, matrix: Array) -> None:
    """Fill a mass matrix (6, 6)."""
    mass_matrix(p, near_wall, matrix)


@compiled
def fill_directions(p: Array, directions: Array) -> None:
    """Fill directions (12, 3) of thrusters."""
    thruster_directions(p, directions)


@compiled
def fill_rotation(state: Array, rotation: Array) -> None:
    """Fill the rotation (3, 3) from the body of a state to the world."""
    rotation_matrix(state[3], state[4], state[5], state[6], rotation)


@compiled
def fill_turn(state: Array, wanted: Array, turn: Array) -> None:
    """Fill the rotation vector (3,) from the attitude of a state to a quaternion (4,)."""
    w0, x0, y0, z0 = state[3], state[4], state[5], state[6]
    w1, x1, y1, z1 = wanted[0], wanted[1], wanted[2], wanted[3]
    w = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    x = w0 * x1 - x0 * w1 - y0 * z1 + z0 * y1
    y = w0 * y1 - y0 * w1 - z0 * x1 + x0 * z1
    z = w0 * z1 - z0 * w1 - x0 * y1 + y0 * x1
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    size = np.sqrt(x * x + y * y + z * z)
    # the angle over the sine of its half; 2 where both vanish
    factor = 2.0 * np.arctan2(size, w) / size if size > 1e-9 else 2.0
    turn[0], turn[1], turn[2] = x * factor, y * factor, z * factor
