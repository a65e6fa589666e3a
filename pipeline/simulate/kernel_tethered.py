"""Compiled kernel: vehicle, tether and winch as one system of equations.

The lower node of the tether is the vehicle's attachment. Its half segment, with mass, added mass
and load, belongs to the node: with A the acceleration of the attachment per newton that acts there
(3 x 3, body axes), a_0 its acceleration without the tether, F and m the force and inertia of the
half node, the force f on the vehicle follows from f = F - m (a_0 + A f). So action and reaction are
one number at every instant, and no force is a step late.

RK4 with the sub-steps of the tether, of which the vehicle takes part in each; the drum is advanced
once a sub-step, by the tension at its end (semi-implicit).
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.physics.parameters import offset
from pipeline.simulate.compiled import compiled, inlined, within
from pipeline.simulate.kernel import (
    BODY,
    STATE,
    Fixed,
    StepWork,
    copied,
    fixed_parts,
    rates,
    work_space,
)
from pipeline.simulate.kernel_frames import normalise_quaternion, rotation_matrix
from pipeline.simulate.kernel_hull import mass_matrix, solve_symmetric, wall_factor
from pipeline.simulate.kernel_lag import aim_lags, end_lags, lagged, set_step
from pipeline.simulate.kernel_swing import (
    COUNT,
    DONE,
    DRUM,
    GIVE_BACK_S,
    LONGEST_TOP,
    NO_ROOM,
    NOT_FINITE,
    OWED,
    TOO_STIFF,
    all_finite,
    drum_speed_after,
    paid_out_length,
    record,
    renew_top,
)
from pipeline.simulate.kernel_tether import (
    RADIUS,
    SEGMENT,
    Nodes,
    begin,
    cable_forces,
    finish,
    next_stage,
    substeps,
    work_on,
)
from pipeline.simulate.kernel_thrusters import effective_codes

Array = Any

POINT = offset("tether_point")
WALL_STRENGTH = offset("wall_strength")


class Joint(NamedTuple):
    """The vehicle at its attachment, body axes.

    `columns` (6, 3): rates of nu by a force there; `mobility` (3, 3): acceleration of the
    attachment by a force there, A. `wrench` (6,) is the tether's. The rest is work space of
    `pull_vehicle`.
    """

    columns: Array
    mobility: Array
    rotation: Array
    bare: Array
    heavy: Array
    system: Array
    right: Array
    wrench: Array


@within
def joint_space() -> Joint:
    """Arrays of a joint."""
    return Joint(
        columns=np.zeros((6, 3)),
        mobility=np.zeros((3, 3)),
        rotation=np.zeros((3, 3)),
        bare=np.zeros(3),
        heavy=np.zeros((3, 3)),
        system=np.zeros((3, 3)),
        right=np.zeros(3),
        wrench=np.zeros(6),
    )


@inlined
def attach(p: Array, state: Array, rotation: Array, count: int, place: Array, speed: Array) -> None:
    """Put the last node where the vehicle's attachment is, with its velocity (NED)."""
    x, y, z = p[POINT], p[POINT + 1], p[POINT + 2]
    u = state[7] + state[11] * z - state[12] * y
    v = state[8] + state[12] * x - state[10] * z
    w = state[9] + state[10] * y - state[11] * x
    rotation_matrix(state[3], state[4], state[5], state[6], rotation)
    for j in range(3):
        place[count, j] = state[j] + rotation[j, 0] * x + rotation[j, 1] * y + rotation[j, 2] * z
        speed[count, j] = rotation[j, 0] * u + rotation[j, 1] * v + rotation[j, 2] * w


@inlined
def set_mobility(p: Array, matrix: Array, work: StepWork, joint: Joint) -> None:
    """Set what a force at the attachment does to a body of a mass matrix (6, 6)."""
    x, y, z = p[POINT], p[POINT + 1], p[POINT + 2]
    columns, mobility, force = joint.columns, joint.mobility, work.force
    for j in range(3):
        # the unit force along axis j, with its moment r x e_j
        for i in range(6):
            force[i] = 0.0
        force[j] = 1.0
        force[3] = y if j == 2 else (-z if j == 1 else 0.0)
        force[4] = z if j == 0 else (-x if j == 2 else 0.0)
        force[5] = x if j == 1 else (-y if j == 0 else 0.0)
        solve_symmetric(matrix, force, work.factor, work.solution)
        for i in range(6):
            columns[i, j] = work.solution[i]
    for j in range(3):
        mobility[0, j] = columns[0, j] + columns[4, j] * z - columns[5, j] * y
        mobility[1, j] = columns[1, j] + columns[5, j] * x - columns[3, j] * z
        mobility[2, j] = columns[2, j] + columns[3, j] * y - columns[4, j] * x


@inlined
def pull_vehicle(
    p: Array, state: Array, count: int, nodes: Nodes, joint: Joint, rate: Array
) -> None:
    """Add the tether to the vehicle's rates, and set its wrench (6,), body axes."""
    wrench = joint.wrench
    rotation, a, heavy, b, right = (
        joint.rotation,
        joint.bare,
        joint.heavy,
        joint.system,
        joint.right,
    )
    x, y, z = p[POINT], p[POINT + 1], p[POINT + 2]
    w0, w1, w2 = state[10], state[11], state[12]
    # acceleration of the attachment without the tether: v' + w x v + w' x r + w x (w x r)
    v0 = state[7] + w1 * z - w2 * y
    v1 = state[8] + w2 * x - w0 * z
    v2 = state[9] + w0 * y - w1 * x
    a[0] = rate[7] + w1 * v2 - w2 * v1 + rate[11] * z - rate[12] * y
    a[1] = rate[8] + w2 * v0 - w0 * v2 + rate[12] * x - rate[10] * z
    a[2] = rate[9] + w0 * v1 - w1 * v0 + rate[10] * y - rate[11] * x
    # half node in body axes, R^T m R and R^T F
    xx, yy, zz = nodes.inertia[count, 0], nodes.inertia[count, 1], nodes.inertia[count, 2]
    xy, xz, yz = nodes.inertia[count, 3], nodes.inertia[count, 4], nodes.inertia[count, 5]
    for j in range(3):
        r0, r1, r2 = rotation[0, j], rotation[1, j], rotation[2, j]
        right[j] = (
            r0 * nodes.force[count, 0] + r1 * nodes.force[count, 1] + r2 * nodes.force[count, 2]
        )
        m0, m1, m2 = (
            xx * r0 + xy * r1 + xz * r2,
            xy * r0 + yy * r1 + yz * r2,
            xz * r0 + yz * r1 + zz * r2,
        )
        for i in range(3):
            heavy[i, j] = rotation[0, i] * m0 + rotation[1, i] * m1 + rotation[2, i] * m2
    # (1 + m A) f = F - m a_0
    for i in range(3):
        for j in range(3):
            right[i] -= heavy[i, j] * a[j]
            total = 1.0 if i == j else 0.0
            for k in range(3):
                total += heavy[i, k] * joint.mobility[k, j]
            b[i, j] = total
    m00 = b[1, 1] * b[2, 2] - b[1, 2] * b[2, 1]
    m01 = b[0, 2] * b[2, 1] - b[0, 1] * b[2, 2]
    m02 = b[0, 1] * b[1, 2] - b[0, 2] * b[1, 1]
    m10 = b[1, 2] * b[2, 0] - b[1, 0] * b[2, 2]
    m11 = b[0, 0] * b[2, 2] - b[0, 2] * b[2, 0]
    m12 = b[0, 2] * b[1, 0] - b[0, 0] * b[1, 2]
    m20 = b[1, 0] * b[2, 1] - b[1, 1] * b[2, 0]
    m21 = b[0, 1] * b[2, 0] - b[0, 0] * b[2, 1]
    m22 = b[0, 0] * b[1, 1] - b[0, 1] * b[1, 0]
    scale = 1.0 / (b[0, 0] * m00 + b[0, 1] * m10 + b[0, 2] * m20)
    f0 = scale * (m00 * right[0] + m01 * right[1] + m02 * right[2])
    f1 = scale * (m10 * right[0] + m11 * right[1] + m12 * right[2])
    f2 = scale * (m20 * right[0] + m21 * right[1] + m22 * right[2])
    wrench[0], wrench[1], wrench[2] = f0, f1, f2
    wrench[3], wrench[4], wrench[5] = y * f2 - z * f1, z * f0 - x * f2, x * f1 - y * f0
    for i in range(6):
        rate[7 + i] += (
            joint.columns[i, 0] * f0 + joint.columns[i, 1] * f1 + joint.columns[i, 2] * f2
        )


@inlined
def integrate_tethered(  # noqa: PLR0912, PLR0915 - one loop over steps, sub-steps and stages
    p: Array,
    commands: Array,
    external: Array,
    dt: float,
    fixed: Fixed,
    work: StepWork,
    c: Array,
    winch: Array,
    winch_commands: Array,
    nodes: Nodes,
    joint: Joint,
    carried: Array,
    states: Array,
    accelerations: Array,
    thrusts: Array,
    wrenches: Array,
    places: Array,
    tensions: Array,
    ends: Array,
    logs: Array,
) -> int:
    """Do the work of `simulate_tethered`, on arrays that it has made."""
    set_mobility(p, fixed.matrix, work, joint)
    end_mass = 1.0 / (joint.mobility[0, 0] + joint.mobility[1, 1] + joint.mobility[2, 2])
    place, speed, rest, wrench = nodes.place, nodes.speed, nodes.rest, joint.wrench
    # x is the state of a stage, begun that of the sub-step
    x, begun, rate, total = work.state, work.start, work.rate, work.total
    lags = work.lags
    total_steps = commands.shape[0]
    count = int(carried[COUNT])
    drum_speed, owed = carried[DRUM], carried[OWED]
    for k in range(total_steps + 1):
        now = min(k, total_steps - 1)
        row = min(now, external.shape[0] - 1)
        command = winch_commands[min(now, winch_commands.shape[0] - 1)]
        effective_codes(p, commands[now], work.codes)
        aim_lags(p, work.codes, lags)
        for j in range(3):
            speed[0, j] = 0.0
        attach(p, x, joint.rotation, count, place, speed)
        size = 0.0
        for i in range(STATE):
            size += abs(x[i])
        if not (np.isfinite(size) and all_finite(count, nodes)):
            return NOT_FINITE
        n = substeps(c, winch, count, nodes, end_mass, dt)
        if n == 0:
            return TOO_STIFF
        paid_out = paid_out_length(count, nodes, owed)
        logs[k, 0], logs[k, 1], logs[k, 2], logs[k, 3] = count, paid_out, drum_speed, n
        h = dt / n
        set_step(p, h, lags)
        for step in range(n):
            lagged(p, x, work.codes, 0, lags, BODY, x)
            payout = drum_speed * winch[RADIUS]
            growth = payout + owed / GIVE_BACK_S
            top = rest[0]
            begin(count, nodes)
            for i in range(STATE):
                begun[i] = x[i]
                total[i] = 0.0
            for stage in range(4):
                elapsed = 0.5 * h if stage < 2 else h
                weight = 1.0 + (stage % 3 > 0)
                rates(p, x, work.codes, external, row, fixed, work, rate, work.thrust)
                attach(p, x, joint.rotation, count, nodes.at, nodes.moving)
                cable_forces(c, count, growth, nodes)
                if p[WALL_STRENGTH] != 0.0:
                    mass_matrix(p, wall_factor(p, x[0], x[1], x[2]), work.heavier)
                    set_mobility(p, work.heavier, work, joint)
                pull_vehicle(p, x, count, nodes, joint, rate)
                if step == 0 and stage == 0:
                    copied(x, states[k])
                    copied(rate[7:13], accelerations[k])
                    copied(work.thrust, thrusts[k])
                    copied(wrench, wrenches[k])
                    record(k, count, nodes, places, tensions, ends)
                    if k == total_steps:
                        break
                for i in range(STATE):
                    total[i] += weight * rate[i]
                    x[i] = begun[i] + elapsed * rate[i]
                lagged(p, begun, work.codes, 1 if stage < 2 else 2, lags, BODY, x)
                next_stage(count, count - 1, weight, elapsed, nodes)
                rest[0] = top + elapsed * growth
            if k == total_steps:
                break
            for i in range(STATE):
                x[i] = begun[i] + h / 6.0 * total[i]
            lagged(p, begun, work.codes, 2, lags, BODY, x)
            end_lags(p, lags)
            normalise_quaternion(x)
            finish(count, h, nodes)
            attach(p, x, joint.rotation, count, place, speed)
            paid_out += h * payout
            owed -= h * owed / GIVE_BACK_S
            drum_speed = drum_speed_after(winch, command, drum_speed, nodes.tension[0], paid_out, h)
            count, owed = renew_top(c, count, nodes, growth, owed)
            if rest[0] > LONGEST_TOP * c[SEGMENT]:
                return NO_ROOM
    carried[COUNT], carried[DRUM], carried[OWED] = count, drum_speed, owed
    return DONE


@compiled
def simulate_tethered(
    p: Array,
    initial: Array,
    commands: Array,
    external: Array,
    dt: float,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
    c: Array,
    winch: Array,
    winch_commands: Array,
    place: Array,
    speed: Array,
    rest: Array,
    carried: Array,
    states: Array,
    accelerations: Array,
    thrusts: Array,
    wrenches: Array,
    places: Array,
    tensions: Array,
    ends: Array,
    logs: Array,
) -> int:
    """Integrate vehicle, tether and winch over commands held for dt each.

    Vehicle arrays as in `kernel.run_on`, tether arrays as in `kernel_tether.swing`; `wrenches`
    (m + 1, 6) is the tether's on the vehicle, body axes. `place`, `speed`, `rest` and `carried` are
    the tether's state, before and after.
    """
    fixed = fixed_parts(p, strips, thrust_tables, screws, torque_tables, steps)
    work = work_space(p, initial, dt)
    joint, nodes = joint_space(), work_on(place, speed, rest)
    return integrate_tethered(
        p,
        commands,
        external,
        dt,
        fixed,
        work,
        c,
        winch,
        winch_commands,
        nodes,
        joint,
        carried,
        states,
        accelerations,
        thrusts,
        wrenches,
        places,
        tensions,
        ends,
        logs,
    )
