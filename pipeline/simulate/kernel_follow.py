"""Lead the model along a measured motion, compiled: the force that this takes, window by window."""

from typing import Any

import numpy as np

from pipeline.simulate.compiled import compiled, inlined
from pipeline.simulate.kernel import copied, fixed_parts, lag_codes, run_on, work_space

Array = Any


@inlined
def turned_back(state: Array, vector: Array, out: Array) -> None:
    """Turn a vector (3,) from the world into the body of a state, R(q)^T v, into out (3,)."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    # v + 2 u x (u x v - w v), the rotation by the conjugate
    a = y * vector[2] - z * vector[1] - w * vector[0]
    b = z * vector[0] - x * vector[2] - w * vector[1]
    c = x * vector[1] - y * vector[0] - w * vector[2]
    out[0] = vector[0] + 2.0 * (y * c - z * b)
    out[1] = vector[1] + 2.0 * (z * a - x * c)
    out[2] = vector[2] + 2.0 * (x * b - y * a)


@inlined
def turn_towards(state: Array, wanted: Array, out: Array) -> None:
    """Fill out (3,) with the rotation vector, in the body, from a state's attitude to `wanted`."""
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
    out[0], out[1], out[2] = x * factor, y * factor, z * factor


@compiled
def follow_window(  # noqa: PLR0912 - what was measured and what was not
    p: Array,
    begin: Array,
    commands: Array,
    dt: float,
    held: int,
    method: int,
    mass: Array,
    gains: Array,
    place: Array,
    rate: Array,
    rate_known: Array,
    velocity: Array,
    velocity_known: Array,
    attitude: Array,
    attitude_known: Array,
    position: Array,
    position_known: Array,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
    states: Array,
    pull: Array,
) -> bool:
    """Simulate commands (m, 12) from a state, pulled towards what was measured at each step.

    `gains` holds the bandwidth of turning and of going, the pull towards the place, and the most by
    which an angle, a way or a place may be off. `pull` (m, 6) is known in advance and grows by what
    is needed beyond it; it is held for `held` steps. Of `states` (m + 1, STATE) the last row is
    where the window ends. False where the motion leaves the finite numbers.
    """
    count = commands.shape[0]
    turning, going, placing, most = gains[0], gains[1], gains[2], gains[3]
    accelerations, thrusts = np.empty((held + 1, 6)), np.empty((held + 1, 12))
    lag, wanted, off, about = np.zeros(3), np.zeros(6), np.zeros(3), np.zeros(3)
    tilt, away = np.zeros(3), np.zeros(3)
    copied(begin, states[0])
    fixed = fixed_parts(p, strips, thrust_tables, screws, torque_tables, steps)
    work = work_space(p, begin, dt)
    late = np.empty((count, 3, commands.shape[1]))
    lag_codes(p, begin, commands, work, late)
    for k in range(0, count, held):
        end = min(k + held, count)
        state = states[k]
        for i in range(3):
            wanted[i], wanted[3 + i], about[i] = 0.0, 0.0, state[10 + i]
            if rate_known[k]:
                wanted[3 + i] += 2.0 * turning * (rate[k, i] - about[i])
                about[i] = rate[k, i]
        if attitude_known[k]:
            turn_towards(state, attitude[k], tilt)
            for i in range(3):
                wanted[3 + i] += turning**2 * min(max(tilt[i], -most), most)
        if velocity_known[k]:
            off[0] = velocity[k, 0] - about[1] * place[2] + about[2] * place[1] - state[7]
            off[1] = velocity[k, 1] - about[2] * place[0] + about[0] * place[2] - state[8]
            off[2] = velocity[k, 2] - about[0] * place[1] + about[1] * place[0] - state[9]
            for i in range(3):
                lag[i] += off[i] * dt * (end - k)
                wanted[i] += 2.0 * going * off[i] + going**2 * min(max(lag[i], -most), most)
        if placing > 0.0 and position_known[k]:
            for i in range(3):
                off[i] = position[k, i] - state[i]
            turned_back(state, off, away)
            for i in range(3):
                wanted[i] += min(max(placing * away[i], -most), most)
        for i in range(6):
            push = 0.0
            for j in range(6):
                push += mass[i, j] * wanted[j]
            for j in range(k, end):
                pull[j, i] += push
        run_on(
            p,
            state,
            late[k:end],
            pull[k:end],
            dt,
            method,
            fixed,
            work,
            states[k : end + 1],
            accelerations[: end - k + 1],
            thrusts[: end - k + 1],
        )
        size = 0.0
        for i in range(states.shape[1]):
            size += abs(states[end, i])
        if not np.isfinite(size):
            return False
    return True
