"""Compiled: the forces on the body, each worked out on its own.

The velocity `v` (6,) is that of the body origin relative to the water, in body axes; `force` (6,)
collects force and moment about the origin.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.blind.truth.compiled import inlined

Array = Any

#: Columns of `scalars`.
(
    WEIGHT,
    BUOYANCY,
    DENSITY,
    CORIOLIS,
    CROSSFLOW,
    WALL_STRENGTH,
    WALL_RADIUS,
    TOW_AREA,
    TOW_PULL,
    SUPPLY_DROP,
    LOAD_DROP,
    GRAVITY,
) = range(12)
#: Columns of `screws`, one row a thruster: the mode and what it needs.
(MODE, CODE_LAG, SHAFT_LAG, GAIN, REVERSE, INFLOW, DEAD, CODE_MAX, KIND, ROTOR) = range(10)
#: Columns of `laws`, one row a kind. Of a propeller: D, K_T 0..2, K_M 0..2, steps in code and
#: speed; of a bollard curve: T_max, |T_min|, speed of no thrust, dead zone, exponent. Of both the
#: drag of the free propeller over V^2, in the last.
SCREW_LAW = 10
#: How the shaft follows: a share of its largest speed with a lag, a shaft speed with a lag, the
#: balance of torques in time.
SHARE, LAGGED, BALANCED = 0.0, 1.0, 2.0
#: Columns of `trouble`: what a vehicle of the library does not have.
(
    SNAG_FROM,
    SNAG_TO,
    SNAG_X,
    SNAG_Y,
    SNAG_Z,
    SNAG_SLACK,
    SNAG_STIFF,
    FLOOD_FROM,
    FLOOD_RATE,
    FLOOD_MOST,
    FLOOD_X,
    FLOOD_Y,
    FLOOD_Z,
    VENT_ABOVE,
    VENT_LEFT,
    VENT_DEPTH,
) = range(16)


class Truth(NamedTuple):
    """A vehicle and its surroundings as they are.

    `rigid`, `added`, `linear` (6, 6); `quadratic` (6,); `strips` (k, 3): station, C_d H dx,
    C_d B dx; `lift` (4,): heave, pitch, sway, yaw slopes; `turning` (2,): slopes of pitch and yaw
    moments that turn over with the course; `scalars`; `centre_g`, `centre_b`,
    `current` (3,); `walls` (k, 6): point, normal; `place`, `push` (n, 3); `screws` (n, 10); `laws`
    (kinds, 9); `steady` (kinds, speeds, codes): shaft speed; `motor` (kinds, codes): slope of the
    motor's torque against the shaft speed; `tow` (6,): attachment and anchor; `trouble` (16,).
    """

    rigid: Array
    added: Array
    linear: Array
    quadratic: Array
    strips: Array
    lift: Array
    turning: Array
    scalars: Array
    centre_g: Array
    centre_b: Array
    current: Array
    walls: Array
    place: Array
    push: Array
    screws: Array
    laws: Array
    steady: Array
    motor: Array
    tow: Array
    trouble: Array


@inlined
def add_at(x: float, y: float, z: float, fx: float, fy: float, fz: float, force: Array) -> None:
    """Add a force that acts at a point of the body."""
    force[0] += fx
    force[1] += fy
    force[2] += fz
    force[3] += y * fz - z * fy
    force[4] += z * fx - x * fz
    force[5] += x * fy - y * fx


@inlined
def add_hull(t: Truth, v: Array, near: float, force: Array) -> None:
    """Damping, cross-flow on strips, lift; `near` is the factor of the walls on damping."""
    for i in range(6):
        total = t.quadratic[i] * abs(v[i]) * v[i]
        for j in range(6):
            total += t.linear[i, j] * v[j]
        force[i] -= near * total
    share = 0.5 * t.scalars[DENSITY] * t.scalars[CROSSFLOW]
    if share != 0.0:
        for k in range(t.strips.shape[0]):
            x = t.strips[k, 0]
            side = v[1] + x * v[5]
            y = abs(side) * side - abs(v[1]) * v[1] - x * abs(x) * abs(v[5]) * v[5]
            y *= -share * t.strips[k, 1]
            down = v[2] - x * v[4]
            z = abs(down) * down - abs(v[2]) * v[2] + x * abs(x) * abs(v[4]) * v[4]
            z *= -share * t.strips[k, 2]
            force[1] += y
            force[5] += x * y
            force[2] += z
            force[4] -= x * z
    # a force against the drift at a fixed arm, whichever end is first
    ahead = abs(v[0])
    force[2] -= ahead * v[2] * t.lift[0]
    force[4] += ahead * v[2] * t.lift[1] + v[0] * v[2] * t.turning[0]
    force[1] -= ahead * v[1] * t.lift[2]
    force[5] += ahead * v[1] * t.lift[3] + v[0] * v[1] * t.turning[1]


@inlined
def add_weights(t: Truth, turn: Array, force: Array) -> None:
    """Weight and buoyancy at their centres; `turn` (3, 3) is body to NED."""
    w, b, g, c = t.scalars[WEIGHT], t.scalars[BUOYANCY], t.centre_g, t.centre_b
    add_at(g[0], g[1], g[2], w * turn[2, 0], w * turn[2, 1], w * turn[2, 2], force)
    add_at(c[0], c[1], c[2], -b * turn[2, 0], -b * turn[2, 1], -b * turn[2, 2], force)


@inlined
def add_tow(t: Truth, state: Array, turn: Array, v: Array, force: Array) -> None:
    """Drag of a towed cable and its pull towards its upper end."""
    area, pull = t.scalars[TOW_AREA], t.scalars[TOW_PULL]
    if area == 0.0 and pull == 0.0:
        return
    x, y, z = t.tow[0], t.tow[1], t.tow[2]
    ux = v[0] + v[4] * z - v[5] * y
    uy = v[1] + v[5] * x - v[3] * z
    uz = v[2] + v[3] * y - v[4] * x
    k = -0.5 * t.scalars[DENSITY] * area * np.sqrt(ux * ux + uy * uy + uz * uz)
    add_at(x, y, z, k * ux, k * uy, k * uz, force)
    if pull != 0.0:
        add_pull(t, state, turn, t.tow[3], t.tow[4], t.tow[5], pull, 0.0, force)


@inlined
def add_pull(
    t: Truth,
    state: Array,
    turn: Array,
    north: float,
    east: float,
    down: float,
    pull: float,
    slack: float,
    force: Array,
) -> None:
    """Pull of a line from the tether's point of attachment to a place in NED.

    With a slack length it is a spring of stiffness `pull` beyond it; else constant, fading within
    a metre of its end.
    """
    dx, dy, dz = north - state[0], east - state[1], down - state[2]
    x, y, z = t.tow[0], t.tow[1], t.tow[2]
    bx = turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz - x
    by = turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz - y
    bz = turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz - z
    length = np.sqrt(bx * bx + by * by + bz * bz)
    if slack > 0.0:
        size = pull * max(length - slack, 0.0) / max(length, 1e-9)
    else:
        size = pull / max(length, 1.0)
    add_at(x, y, z, size * bx, size * by, size * bz, force)


@inlined
def add_trouble(t: Truth, time: float, state: Array, turn: Array, force: Array) -> None:
    """Add a snagged line and water that comes in: neither is an effect of the library."""
    c = t.trouble
    if c[SNAG_STIFF] > 0.0 and c[SNAG_FROM] <= time <= c[SNAG_TO]:
        stiff, slack = c[SNAG_STIFF], c[SNAG_SLACK]
        add_pull(t, state, turn, c[SNAG_X], c[SNAG_Y], c[SNAG_Z], stiff, slack, force)
    if c[FLOOD_RATE] > 0.0 and time > c[FLOOD_FROM]:
        w = min(c[FLOOD_RATE] * (time - c[FLOOD_FROM]), c[FLOOD_MOST]) * t.scalars[GRAVITY]
        x, y, z = c[FLOOD_X], c[FLOOD_Y], c[FLOOD_Z]
        add_at(x, y, z, w * turn[2, 0], w * turn[2, 1], w * turn[2, 2], force)


@inlined
def walls_near(t: Truth, state: Array, slope: Array) -> float:
    """Return 1 + c sum (R / h)^3 over the walls and fill its gradient in NED (3,)."""
    slope[0] = slope[1] = slope[2] = 0.0
    factor, c, radius = 1.0, t.scalars[WALL_STRENGTH], t.scalars[WALL_RADIUS]
    if c == 0.0:
        return factor
    for k in range(t.walls.shape[0]):
        away = 0.0
        for i in range(3):
            away += (state[i] - t.walls[k, i]) * t.walls[k, 3 + i]
        if away <= radius:
            factor += c
            continue
        part = c * (radius / away) ** 3
        factor += part
        for i in range(3):
            slope[i] -= 3.0 * part / away * t.walls[k, 3 + i]
    return factor
