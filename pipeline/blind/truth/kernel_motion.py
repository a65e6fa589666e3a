"""Compiled: Kirchhoff's equations in momenta, integrated by Dormand and Prince with error control.

State: place in NED (3,), attitude as a rotation matrix (9,), linear and angular momentum of body
and water in body axes relative to the water (6,), ramped codes (12,) and shafts (12,). With T the
kinetic energy, v and w the velocities and X the place,

    a' = a x w + F + dT/dX        b' = b x w + a x v + G

so walls, which make T depend on the place, bring their suction with them. Hairer, Norsett, Wanner
1993, Solving Ordinary Differential Equations I, table 5.2 (the method); Lamb 1932, art. 124.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.blind.truth.compiled import inlined
from pipeline.blind.truth.kernel_forces import (
    CORIOLIS,
    Truth,
    add_hull,
    add_tow,
    add_trouble,
    add_weights,
    walls_near,
)
from pipeline.blind.truth.kernel_shafts import MOMENTA, add_thrusters

Array = Any

STAGES = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
#: Fifth-order weights less the fourth-order ones.
ERROR = np.array(
    [71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40],
)
TOLERANCE = 1e-6
#: Below this step an error is accepted: a kink of a table is no smooth function. [s]
SMALLEST_STEP = 5e-4


class Work(NamedTuple):
    """Arrays that are written to, made once a flight.

    `inverse` (6, 6) of the inertia away from walls; `turn` (3, 3); `slope` (3,) of the walls;
    `force`, `v` (6,); `thrust`, `working` (n,); `push` (9,); `slopes` (7, 42); `trial`, `scale`
    (42,); `table` (6, 7).
    """

    inverse: Array
    turn: Array
    slope: Array
    force: Array
    v: Array
    thrust: Array
    working: Array
    push: Array
    slopes: Array
    trial: Array
    scale: Array
    table: Array


@inlined
def solved(t: Truth, near: float, right: Array, first: int, table: Array, v: Array) -> None:
    """Solve (rigid + near added) v = right[first : first + 6] by Gauss; `table` (6, 7) is work."""
    for i in range(6):
        for j in range(6):
            table[i, j] = t.rigid[i, j] + near * t.added[i, j]
        table[i, 6] = right[first + i]
    # symmetric and positive definite: no pivot is needed
    for k in range(6):
        for i in range(k + 1, 6):
            part = table[i, k] / table[k, k]
            for j in range(k, 7):
                table[i, j] -= part * table[k, j]
    for k in range(5, -1, -1):
        total = table[k, 6]
        for j in range(k + 1, 6):
            total -= table[k, j] * v[j]
        v[k] = total / table[k, k]


@inlined
def velocity_of(t: Truth, near: float, state: Array, w: Work) -> None:
    """Velocity relative to the water from the momenta."""
    if near == 1.0:
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += w.inverse[i, j] * state[MOMENTA + j]
            w.v[i] = total
    else:
        solved(t, near, state, MOMENTA, w.table, w.v)


@inlined
def rates(t: Truth, time: float, state: Array, gains: Array, w: Work, rate: Array) -> None:
    """Fill the rate of a state (42,), the velocity (6,) and thrusts (n,).

    `w.push` (9,) is a force in NED and a force and moment in body axes from outside.
    """
    turn, v, force = w.turn, w.v, w.force
    for i in range(3):
        for k in range(3):
            turn[i, k] = state[3 + 3 * i + k]
    near = walls_near(t, state, w.slope)
    velocity_of(t, near, state, w)
    for i in range(3):
        force[i] = w.push[3 + i]
        force[3 + i] = w.push[6 + i]
        for k in range(3):
            force[i] += turn[k, i] * w.push[k]
    add_thrusters(t, state, v, w.working, gains, force, rate, w.thrust)
    add_weights(t, turn, force)
    add_tow(t, state, turn, v, force)
    add_trouble(t, time, state, turn, force)
    add_hull(t, v, near, force)
    if near != 1.0:
        energy = 0.0
        for i in range(6):
            for j in range(6):
                energy += 0.5 * v[i] * t.added[i, j] * v[j]
        for i in range(3):
            for k in range(3):
                force[i] += energy * turn[k, i] * w.slope[k]
    share = t.scalars[CORIOLIS]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        aj, ak = state[MOMENTA + j], state[MOMENTA + k]
        bj, bk = state[MOMENTA + 3 + j], state[MOMENTA + 3 + k]
        wj, wk = v[3 + j], v[3 + k]
        rate[i] = t.current[i] + turn[i, 0] * v[0] + turn[i, 1] * v[1] + turn[i, 2] * v[2]
        rate[MOMENTA + i] = force[i] + share * (aj * wk - ak * wj)
        rate[MOMENTA + 3 + i] = force[3 + i] + share * (bj * wk - bk * wj + aj * v[k] - ak * v[j])
        # R' = R S(w), column by column of S
        for m in range(3):
            n, o = (m + 1) % 3, (m + 2) % 3
            rate[3 + 3 * i + m] = turn[i, n] * v[3 + o] - turn[i, o] * v[3 + n]


@inlined
def straighten(state: Array) -> None:
    """Make the rotation matrix orthonormal again (Gram and Schmidt on its rows)."""
    size = np.sqrt(state[3] ** 2 + state[4] ** 2 + state[5] ** 2)
    part = 0.0
    for i in range(3, 6):
        state[i] /= size
        part += state[i] * state[3 + i]
    for i in range(3, 6):
        state[3 + i] -= part * state[i]
    size = np.sqrt(state[6] ** 2 + state[7] ** 2 + state[8] ** 2)
    for i in range(6, 9):
        state[i] /= size
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        state[9 + i] = state[3 + j] * state[6 + k] - state[3 + k] * state[6 + j]


@inlined
def advance(
    t: Truth, begin: float, end: float, used: int, state: Array, gains: Array, w: Work
) -> None:
    """Bring a state from one time to another, in place; slopes[0] is its rate at the beginning.

    `used` is the number of entries of the state in use.
    """
    now, step = begin, end - begin
    slopes, trial = w.slopes, w.trial
    fresh = True
    while now < end - 1e-9:
        step = min(step, end - now)
        if not fresh:
            rates(t, now, state, gains, w, slopes[0])
        for s in range(1, 7):
            for i in range(used):
                total = 0.0
                for k in range(s):
                    total += STAGES[s, k] * slopes[k, i]
                trial[i] = state[i] + step * total
            rates(t, now + NODES[s] * step, trial, gains, w, slopes[s])
        worst = 0.0
        for i in range(used):
            wrong = 0.0
            for s in range(7):
                wrong += ERROR[s] * slopes[s, i]
            worst = max(worst, abs(step * wrong) / (TOLERANCE * (w.scale[i] + abs(state[i]))))
        fresh = True
        if worst <= 1.0 or step <= SMALLEST_STEP:
            # the seventh stage stands at the fifth-order solution
            now += step
            for i in range(used):
                state[i] = trial[i]
            straighten(state)
            fresh = False
        step = max(step * min(max(0.9 * max(worst, 1e-9) ** -0.2, 0.2), 5.0), SMALLEST_STEP)
