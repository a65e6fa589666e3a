"""Compiled kernel: the equations of motion and their integration.

State: position NED (3), quaternion w x y z (4), nu = u v w p q r (6), then one entry a thruster:
its effective code after the lag, or its shaft speed in rev/s where it has a rotor inertia.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, offset
from pipeline.simulate.compiled import inlined, within
from pipeline.simulate.kernel_frames import (
    normalise_quaternion,
    position_rate,
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
from pipeline.simulate.kernel_lag import Lags, aim_lags, begin_lags, end_lags, lagged, lags_at
from pipeline.simulate.kernel_thrusters import (
    add_thrust,
    effective_codes,
    shaft_rate,
    thruster_levers,
)

Array = Any

CURRENT = offset("current")
THRUSTER_COUNT = offset("thruster_count")
ROTOR_INERTIA = offset("rotor_inertia")
#: Entries of the state.
BODY = 13
STATE = BODY + MOST_THRUSTERS
RK4, SEMI_IMPLICIT = 0, 1


class Fixed(NamedTuple):
    """What stays the same over a run, beside the parameter vector.

    `levers` (12, 6) of the thrusters; `matrix`, `inverse` (6, 6): the mass matrix and its inverse
    away from walls; `strips` (k, 3); `thrust_tables` (types, 2, speeds, codes); `screws` (types,
    9); `torque_tables` (types, codes, shaft speeds); `per_step` (types, 2): rows and columns of the
    thrust tables a unit.
    """

    levers: Array
    matrix: Array
    inverse: Array
    strips: Array
    thrust_tables: Array
    screws: Array
    torque_tables: Array
    per_step: Array


class StepWork(NamedTuple):
    """Arrays that the integration writes to, made once a run.

    Of `rates`: `nu_r`, `force`, `solution` (6,), `water` (3,), `rotation` (3, 3), `inflow` (12,),
    `heavier`, `factor` (6, 6). Of the integrator: `state`, `start` of a step, `rate`, `total` of
    the weighted rates (STATE,), `codes`, `thrust` (12,), and the thrusters' `lags`.
    """

    nu_r: Array
    force: Array
    water: Array
    solution: Array
    rotation: Array
    inflow: Array
    heavier: Array
    factor: Array
    state: Array
    start: Array
    rate: Array
    total: Array
    codes: Array
    thrust: Array
    lags: Lags


@within
def work_space(p: Array, initial: Array, dt: float) -> StepWork:
    """Make the work space of a run that starts from `initial` (STATE,)."""
    return StepWork(
        nu_r=np.zeros(6),
        force=np.zeros(6),
        water=np.zeros(3),
        solution=np.zeros(6),
        rotation=np.zeros((3, 3)),
        inflow=np.zeros(MOST_THRUSTERS),
        heavier=np.zeros((6, 6)),
        factor=np.zeros((6, 6)),
        state=initial.copy(),
        start=np.zeros(STATE),
        rate=np.zeros(STATE),
        total=np.zeros(STATE),
        codes=np.zeros(MOST_THRUSTERS),
        thrust=np.zeros(MOST_THRUSTERS),
        lags=lags_at(p, initial[BODY:], dt),
    )


@within
def fixed_parts(
    p: Array,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
) -> Fixed:
    """Work out what stays the same over a run."""
    matrix, levers = np.empty((6, 6)), np.zeros((MOST_THRUSTERS, 6))
    mass_matrix(p, 1.0, matrix)
    thruster_levers(p, levers)
    inverse = np.linalg.inv(matrix)
    per_step = 1.0 / steps
    return Fixed(levers, matrix, inverse, strips, thrust_tables, screws, torque_tables, per_step)


@inlined
def rates(
    p: Array,
    state: Array,
    codes: Array,
    external: Array,
    row: int,
    fixed: Fixed,
    work: StepWork,
    rate: Array,
    thrust: Array,
) -> None:
    """Fill the rate of change of a state (STATE,), and the thrusts (12,).

    `codes` (12,) are the effective codes; row `row` of `external` (k, 6) is a force and moment on
    the body from outside the model. `work.rotation` is that of the state afterwards.
    """
    nu_r, force, water, rotation = work.nu_r, work.force, work.water, work.rotation
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
        force[k] = external[row, k]
    add_thrust(
        p,
        fixed.levers,
        state[BODY:],
        nu_r,
        fixed.thrust_tables,
        fixed.screws,
        fixed.per_step,
        thrust,
        work.inflow,
        force,
    )
    add_restoring(p, rotation, force)
    add_towed_tether(p, state, rotation, nu_r, force)
    near_wall = wall_factor(p, state[0], state[1], state[2])
    add_damping(p, nu_r, near_wall, fixed.strips, force)
    if near_wall != 1.0:
        mass_matrix(p, near_wall, work.heavier)
        subtract_coriolis(p, work.heavier, nu_r, force)
        solve_symmetric(work.heavier, force, work.factor, work.solution)
        for k in range(6):
            rate[7 + k] = work.solution[k]
    else:
        subtract_coriolis(p, fixed.matrix, nu_r, force)
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += fixed.inverse[i, j] * force[j]
            rate[7 + i] = total
    # nu = nu_r + water, and the water's velocity turns against the body: -omega x water
    rate[7] -= state[11] * water[2] - state[12] * water[1]
    rate[8] -= state[12] * water[0] - state[10] * water[2]
    rate[9] -= state[10] * water[1] - state[11] * water[0]
    position_rate(rotation, state[7:13], rate)
    quaternion_rate(state, state[7:13], rate)
    for i in range(MOST_THRUSTERS):
        rate[BODY + i] = 0.0
    for i in range(int(p[THRUSTER_COUNT])):
        if p[ROTOR_INERTIA + i] > 0.0:
            rate[BODY + i] = shaft_rate(
                p,
                i,
                state[BODY + i],
                codes[i],
                work.inflow[i],
                fixed.screws,
                fixed.torque_tables,
            )


@inlined
def copied(source: Array, target: Array) -> None:
    """Copy a vector of the target's length."""
    for i in range(target.shape[0]):
        target[i] = source[i]


@inlined
def moved(start: Array, rate: Array, share: float, first: int, end: int, target: Array) -> None:
    """Set target = start + share * rate in the entries from `first` to before `end`."""
    for i in range(first, end):
        target[i] = start[i] + share * rate[i]


@inlined
def lag_codes(p: Array, initial: Array, commands: Array, work: StepWork, late: Array) -> None:
    """Fill late (m, 3, 12): effective codes at the start, the middle and the end of each step.

    They follow from `initial` (STATE,) and the commands (m, 12) alone, however the vehicle moves.
    Where a shaft turns they are what its drive is told.
    """
    codes, lags, start = work.codes, work.lags, work.start
    copied(initial, start)
    begin_lags(p, start[BODY:], lags)
    for k in range(commands.shape[0]):
        effective_codes(p, commands[k], codes)
        aim_lags(p, codes, lags)
        for row in range(3):
            copied(codes, late[k, row])
            lagged(p, start[BODY:], codes, row, lags, 0, late[k, row])
        copied(late[k, 2], start[BODY:])
        end_lags(p, lags)


@inlined
def set_codes(p: Array, late: Array, state: Array) -> None:
    """Set the effective codes (12,) of a state; a shaft turns as it does."""
    for i in range(int(p[THRUSTER_COUNT])):
        if p[ROTOR_INERTIA + i] <= 0.0:
            state[BODY + i] = late[i]


@inlined
def integrate(
    p: Array,
    late: Array,
    external: Array,
    dt: float,
    method: int,
    fixed: Fixed,
    work: StepWork,
    states: Array,
    accelerations: Array,
    thrusts: Array,
) -> None:
    """Integrate from work.state; the arrays are those of `run_on`."""
    count = late.shape[0]
    x, start, rate, total, thrust = work.state, work.start, work.rate, work.total, work.thrust
    for k in range(count + 1):
        now = min(k, count - 1)
        row = min(now, external.shape[0] - 1)
        # a thruster without lag is at its code from the start of the step
        codes = late[now, 0 if k < count else 2]
        set_codes(p, codes, x)
        copied(x, start)
        copied(x, states[k])
        # the four slopes of Runge and Kutta, or the first alone
        last = 0 if k == count or method == SEMI_IMPLICIT else 3
        for stage in range(last + 1):
            rates(p, x, codes, external, row, fixed, work, rate, thrust)
            if stage == 0:
                copied(rate[7:13], accelerations[k])
                copied(thrust, thrusts[k])
                copied(rate, total)
            else:
                moved(total, rate, 2.0 if stage < 3 else 1.0, 0, STATE, total)
            if stage < last:
                moved(start, rate, dt if stage == 2 else 0.5 * dt, 0, STATE, x)
                set_codes(p, late[k, 2 if stage == 2 else 1], x)
        if k == count:
            break
        if method == SEMI_IMPLICIT:
            # velocities first; the pose moves with the new velocity
            moved(start, rate, dt, 7, STATE, x)
            position_rate(work.rotation, x[7:13], rate)
            quaternion_rate(start, x[7:13], rate)
            moved(start, rate, dt, 0, 7, x)
        else:
            moved(start, total, dt / 6.0, 0, STATE, x)
        set_codes(p, late[k, 2], x)
        normalise_quaternion(x)


@within
def run_on(
    p: Array,
    initial: Array,
    late: Array,
    external: Array,
    dt: float,
    method: int,
    fixed: Fixed,
    work: StepWork,
    states: Array,
    accelerations: Array,
    thrusts: Array,
) -> None:
    """Integrate from `initial` (STATE,) over the codes (m, 3, 12) of `lag_codes`, each for dt.

    `external` is (m, 6) or (1, 6). Fills states (m + 1, STATE), accelerations nu' (m + 1, 6) and
    thrusts (m + 1, 12); the last row of the last two repeats the last command.
    """
    copied(initial, work.state)
    integrate(p, late, external, dt, method, fixed, work, states, accelerations, thrusts)
