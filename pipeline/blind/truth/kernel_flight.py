"""Compiled: a whole flight, under the truth's own autopilot or with the codes of another one.

The autopilot is a PID on each axis with the inertias that the vehicle file states; demands go
through a weighted pseudo-inverse and the stated curve at rest to whole codes, every 0.1 s.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.blind.truth.compiled import compiled, inlined
from pipeline.blind.truth.kernel_forces import (
    BALANCED,
    CODE_LAG,
    MODE,
    SHAFT_LAG,
    Truth,
    walls_near,
)
from pipeline.blind.truth.kernel_motion import Work, advance, rates, solved, velocity_of
from pipeline.blind.truth.kernel_shafts import (
    CODES,
    MOMENTA,
    SHAFTS,
    drive_code,
    steady_shaft,
    supply,
)

Array = Any

#: Seconds between commands, and samples of the motion in that time.
CONTROL_S = 0.1
SAMPLES = 5
#: Columns of the wishes: a switch and a value each, then a wrench (6,) that is added.
(SURGE, PLACE, DEPTH, HEADING, PITCH, ROLL) = (0, 2, 5, 7, 9, 11)
WRENCH = 13
WISHES = 19
#: Columns of a sample: place 3, turn 9, velocity over ground 6, its rate 6, then shafts, thrusts.
SAMPLE = 24


class Belief(NamedTuple):
    """What the autopilot holds true.

    `inertia` (6,) with added mass; `drag` (2,): linear and quadratic in surge; `bandwidth` (6,) of
    surge, place, depth, heading, pitch, roll; `inverse` (n, 6); `most` (n, 2): largest thrust both
    ways; `codes` (n, 2, k): code for even shares of it; `gravity_stiffness` (2,): roll, pitch;
    `upset` (2,): moment of pitch and yaw across the flow over speed squared.
    """

    inertia: Array
    drag: Array
    bandwidth: Array
    inverse: Array
    most: Array
    codes: Array
    gravity_stiffness: Array
    upset: Array


@inlined
def wrapped(angle: float) -> float:
    """Angle between -pi and pi."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@inlined
def axis_pid(
    error: float, rate: float, inertia: float, w: float, integral: Array, k: int, reach: float
) -> float:
    """Force of one axis: poles at w with damping 0.9, an integral of errors within reach."""
    integral[k] += CONTROL_S * min(max(error, -reach), reach)
    return inertia * (w * w * error - 1.8 * w * rate + 0.12 * w**3 * integral[k])


@inlined
def stiffened(bandwidth: float, upset: float, inertia: float, speed: float) -> float:
    """Bandwidth that outweighs the hull's turning across the flow twice over [rad/s]."""
    return np.sqrt(bandwidth**2 + 2.0 * upset * speed * speed / inertia)


@inlined
def demand_of(
    b: Belief, state: Array, ground: Array, wish: Array, integral: Array, wrench: Array
) -> None:
    """Fill the wanted force and moment (6,) in body axes; `ground` (6,) is the velocity."""
    for i in range(6):
        wrench[i] = wish[WRENCH + i]
    heading = np.arctan2(state[6], state[3])
    pitch = -np.arcsin(min(max(state[9], -1.0), 1.0))
    roll = np.arctan2(state[10], state[11])
    if wish[SURGE] > 0.0:
        want = wish[SURGE + 1]
        error = want - ground[0]
        integral[0] += CONTROL_S * min(max(error, -0.3), 0.3)
        w = b.bandwidth[0]
        wrench[0] += b.inertia[0] * (w * error + 0.1 * w * w * integral[0])
        wrench[0] += (b.drag[0] + b.drag[1] * abs(want)) * want
    if wish[PLACE] > 0.0:
        north, east = wish[PLACE + 1] - state[0], wish[PLACE + 2] - state[1]
        size = np.sqrt(north * north + east * east)
        shrink = min(1.0, 2.0 / max(size, 1e-9))
        c, s = np.cos(heading), np.sin(heading)
        ahead, side = shrink * (c * north + s * east), shrink * (c * east - s * north)
        w = b.bandwidth[1] * wish[PLACE]
        wrench[0] += axis_pid(ahead, ground[0], b.inertia[0], w, integral, 1, 0.3)
        wrench[1] += axis_pid(side, ground[1], b.inertia[1], w, integral, 2, 0.3)
    if wish[DEPTH] > 0.0:
        sink = state[9] * ground[0] + state[10] * ground[1] + state[11] * ground[2]
        error = min(max(wish[DEPTH + 1] - state[2], -1.5), 1.5)
        wrench[2] += axis_pid(error, sink, b.inertia[2], b.bandwidth[2], integral, 3, 0.4)
    if wish[HEADING] > 0.0:
        error = min(max(wrapped(wish[HEADING + 1] - heading), -0.6), 0.6)
        w = stiffened(b.bandwidth[3], b.upset[1], b.inertia[5], ground[0])
        wrench[5] += axis_pid(error, ground[5], b.inertia[5], w, integral, 4, 0.1)
    if wish[PITCH] > 0.0:
        error = wish[PITCH + 1] - pitch
        w = stiffened(b.bandwidth[4], b.upset[0], b.inertia[4], ground[0])
        wrench[4] += axis_pid(error, ground[4], b.inertia[4], w, integral, 5, 0.1)
        wrench[4] += b.gravity_stiffness[1] * wish[PITCH + 1]
    if wish[ROLL] > 0.0:
        error = wish[ROLL + 1] - roll
        wrench[3] += axis_pid(error, ground[3], b.inertia[3], b.bandwidth[5], integral, 6, 0.1)
        wrench[3] += b.gravity_stiffness[0] * wish[ROLL + 1]


@inlined
def codes_of(b: Belief, wrench: Array, command: Array) -> bool:
    """Fill whole codes (n,) for a wrench and tell whether it had to be scaled down."""
    n = command.shape[0]
    fullest = 1.0
    for i in range(n):
        thrust = 0.0
        for k in range(6):
            thrust += b.inverse[i, k] * wrench[k]
        command[i] = thrust
        fullest = max(fullest, abs(thrust) / b.most[i, 0 if thrust >= 0.0 else 1])
    for i in range(n):
        side = 0 if command[i] >= 0.0 else 1
        share = abs(command[i]) / fullest / b.most[i, side]
        if share < 0.003:
            command[i] = 0.0
            continue
        table = b.codes[i, side]
        place = share * (table.shape[0] - 1)
        j = min(int(place), table.shape[0] - 2)
        code = np.rint(table[j] + (place - j) * (table[j + 1] - table[j]))
        command[i] = code if side == 0 else -code
    return fullest > 1.0


@inlined
def begin_state(
    t: Truth, sample: Array, shafts: Array, codes: Array, w: Work, state: Array
) -> None:
    """Fill the state (42,) of a vehicle that moves as a sample (24 or more,) says."""
    for i in range(12):
        state[i] = sample[i]
    for i in range(3):
        w.v[i] = sample[12 + i]
        w.v[3 + i] = sample[15 + i]
        for k in range(3):
            w.v[i] -= sample[3 + 3 * k + i] * t.current[k]
    near = walls_near(t, sample, w.slope)
    for i in range(6):
        total = 0.0
        for j in range(6):
            total += (t.rigid[i, j] + near * t.added[i, j]) * w.v[j]
        state[MOMENTA + i] = total
    for i in range(codes.shape[0]):
        state[CODES + i] = codes[i]
        state[SHAFTS + i] = shafts[i]


@inlined
def blend(outside: Array, m: int, part: float, push: Array) -> None:
    """Blend the forces from outside at a part of the time between two commands."""
    after = min(m + 1, outside.shape[0] - 1)
    for i in range(9):
        push[i] = (1.0 - part) * outside[m, i] + part * outside[after, i]


@compiled
def fly(
    t: Truth,
    belief: Belief,
    closed: bool,
    wishes: Array,
    given: Array,
    outside: Array,
    gains: Array,
    first: float,
    sample: Array,
    shafts: Array,
    ramped: Array,
    w: Work,
    state: Array,
    commands: Array,
    samples: Array,
) -> None:
    """Fly from a sample on; fills the commands (m, n) and samples (m * 5 + 1, 24 + 3 n).

    `wishes` (m, 19) for the autopilot (`closed`) or `given` (m, n) codes; `outside` (m + 1, 9) the
    forces from outside at the commands' times, linear between; `gains` (m, n) what trouble leaves
    of each thrust; `first` is the time of the start; `state` (42,) is work. A sample holds place,
    turn, velocity over ground and its rate, then shafts, thrusts and ramped codes.
    """
    n, count = t.screws.shape[0], commands.shape[0]
    begin_state(t, sample, shafts, ramped, w, state)
    ground, wrench, integral, before = np.zeros(6), np.zeros(6), np.zeros(7), np.zeros(7)
    used = SHAFTS + n
    for m in range(count + 1):
        step = min(m, count - 1)
        if m < count:
            if closed:
                velocity_of(t, walls_near(t, state, w.slope), state, w)
                for i in range(3):
                    ground[i] = w.v[i]
                    ground[3 + i] = w.v[3 + i]
                    for k in range(3):
                        ground[i] += state[3 + 3 * k + i] * t.current[k]
                for i in range(7):
                    before[i] = integral[i]
                demand_of(belief, state, ground, wishes[m], integral, wrench)
                if codes_of(belief, wrench, commands[m]):
                    for i in range(7):
                        integral[i] = before[i]
            else:
                for i in range(n):
                    commands[m, i] = given[m, i]
            left = supply(t, commands[m])
            for i in range(n):
                w.working[i] = drive_code(t, i, commands[m, i], left)
        for s in range(SAMPLES if m < count else 1):
            now = first + m * CONTROL_S + s * CONTROL_S / SAMPLES
            blend(outside, m, s / SAMPLES, w.push)
            rates(t, now, state, gains[step], w, w.slopes[0])
            record(t, state, w, samples[m * SAMPLES + s])
            if m < count:
                blend(outside, m, (s + 0.5) / SAMPLES, w.push)
                advance(t, now, now + CONTROL_S / SAMPLES, used, state, gains[step], w)
                for i in range(n):
                    if t.screws[i, CODE_LAG] <= 0.0:
                        state[CODES + i] = w.working[i]
                    if t.screws[i, SHAFT_LAG] <= 0.0 and t.screws[i, MODE] != BALANCED:
                        state[SHAFTS + i] = steady_shaft(t, i, state[CODES + i], 0.0)


@inlined
def record(t: Truth, state: Array, w: Work, row: Array) -> None:
    """Write one sample: what happens at a state of which the rates (slopes[0]) are known."""
    n = w.thrust.shape[0]
    rate = w.slopes[0]
    for i in range(12):
        row[i] = state[i]
    near = walls_near(t, state, w.slope)
    drift = w.slope[0] * rate[0] + w.slope[1] * rate[1] + w.slope[2] * rate[2]
    # v' = M^-1 (momenta' - M' v), M' from the motion along the slope of the walls
    for i in range(6):
        total = rate[MOMENTA + i]
        if near != 1.0:
            for j in range(6):
                total -= drift * t.added[i, j] * w.v[j]
        w.force[i] = total
    solved(t, near, w.force, 0, w.table, w.trial)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        water = water_j = water_k = 0.0
        for m in range(3):
            water += state[3 + 3 * m + i] * t.current[m]
            water_j += state[3 + 3 * m + j] * t.current[m]
            water_k += state[3 + 3 * m + k] * t.current[m]
        row[12 + i] = w.v[i] + water
        row[15 + i] = w.v[3 + i]
        # the current turns against the body
        row[18 + i] = w.trial[i] - (w.v[3 + j] * water_k - w.v[3 + k] * water_j)
        row[21 + i] = w.trial[3 + i]
    for i in range(n):
        row[24 + i] = state[SHAFTS + i]
        row[24 + n + i] = w.thrust[i]
        row[24 + 2 * n + i] = state[CODES + i]
