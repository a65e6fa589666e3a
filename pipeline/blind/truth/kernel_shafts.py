"""Compiled: from commanded codes to shafts and thrust.

A shaft has two numbers of state: the code that its controller has ramped to, and its speed. The
speed is in rev/s, or a share of the largest for a drive of which only the bollard pull is known.
"""

from typing import Any

import numpy as np

from pipeline.blind.truth.compiled import inlined
from pipeline.blind.truth.kernel_forces import (
    BALANCED,
    CODE_LAG,
    CODE_MAX,
    DEAD,
    DENSITY,
    GAIN,
    INFLOW,
    KIND,
    LOAD_DROP,
    MODE,
    REVERSE,
    ROTOR,
    SHAFT_LAG,
    SHARE,
    SUPPLY_DROP,
    VENT_ABOVE,
    VENT_DEPTH,
    VENT_LEFT,
    Truth,
    add_at,
)

Array = Any

#: Entries of the state: momenta from 12, ramped codes from 18, shafts from 30.
MOMENTA, CODES, SHAFTS, STATE = 12, 18, 30, 42


@inlined
def supply(t: Truth, command: Array) -> float:
    """Share of the nominal supply voltage that is left under these codes."""
    load, count = 0.0, t.screws.shape[0]
    for i in range(count):
        load += (command[i] / t.screws[i, CODE_MAX]) ** 2
    return 1.0 - t.scalars[SUPPLY_DROP] - t.scalars[LOAD_DROP] * load / max(count, 1)


@inlined
def drive_code(t: Truth, i: int, command: float, left: float) -> float:
    """Code that is at work: the dead zone taken off, times the share of the voltage."""
    top, dead = t.screws[i, CODE_MAX], t.screws[i, DEAD]
    size = min(abs(command), top)
    if dead > 0.0:
        size = 0.0 if size <= dead else (size - dead) * top / (top - dead)
    return left * size if command >= 0.0 else -left * size


@inlined
def between(table: Array, row: float, column: float) -> float:
    """Bilinear value of a table at fractional indices; codes (columns) go on beyond the last."""
    row = min(max(row, 0.0), table.shape[0] - 1.0)
    column = max(column, 0.0)
    i = min(int(row), max(table.shape[0] - 2, 0))
    j = min(int(column), table.shape[1] - 2)
    a, b = row - i, column - j
    k = min(i + 1, table.shape[0] - 1)
    low = table[i, j] + b * (table[i, j + 1] - table[i, j])
    high = table[k, j] + b * (table[k, j + 1] - table[k, j])
    return low + a * (high - low)


@inlined
def steady_shaft(t: Truth, i: int, code: float, inflow: float) -> float:
    """Steady shaft speed at a working code and an inflow along the thruster's axis."""
    law = t.laws[int(t.screws[i, KIND])]
    if t.screws[i, MODE] == SHARE:
        top = t.screws[i, CODE_MAX]
        s = max(abs(code) - law[3], 0.0) / (top - law[3])
        size = s ** (0.5 * law[4])
    else:
        along = max(inflow if code >= 0.0 else -inflow, 0.0)
        size = between(t.steady[int(t.screws[i, KIND])], along / law[8], abs(code) / law[7])
    return size if code >= 0.0 else -size


@inlined
def load_torque(t: Truth, law: Array, n: float, along: float) -> float:
    """Torque that the water takes at a shaft speed and an inflow not below zero [N m]."""
    d = law[0]
    load = law[4] * n * abs(n)
    if n > 0.0:
        load = max(load + law[5] * n * along / d + law[6] * along * along / (d * d), 0.0)
    return t.scalars[DENSITY] * d**5 * load


@inlined
def shaft_acceleration(t: Truth, i: int, code: float, shaft: float, inflow: float) -> float:
    """Rate of a shaft's speed by the balance of torques, 2 pi J n' = motor - water [rev/s^2].

    Off the steady point the motor's torque falls along its slope and the water's grows.
    """
    law = t.laws[int(t.screws[i, KIND])]
    sense = 1.0 if code >= 0.0 else -1.0
    n, along = sense * shaft, max(sense * inflow, 0.0)
    steady = sense * steady_shaft(t, i, code, inflow)
    slopes = t.motor[int(t.screws[i, KIND])]
    slope = slopes[min(int(abs(code) / law[7]), slopes.shape[0] - 1)]
    spare = slope * (n - steady) + load_torque(t, law, steady, along)
    spare -= load_torque(t, law, n, along)
    return sense * spare / (2.0 * np.pi * t.screws[i, ROTOR])


@inlined
def thrust_of(t: Truth, i: int, shaft: float, inflow: float) -> float:
    """Thrust of a turning propeller [N]; against the motion that at rest, or the drag.

    A propeller that the water turns drags, at most as a free one does.
    """
    law = t.laws[int(t.screws[i, KIND])]
    n = abs(shaft)
    flow = inflow if shaft >= 0.0 else -inflow
    along, drag = max(flow, 0.0), law[9] * flow * flow
    if t.screws[i, MODE] == SHARE:
        value = law[0 if shaft >= 0.0 else 1] * n * (n - along / law[2])
    else:
        d = law[0]
        value = law[1] * n * n + law[2] * n * along / d + law[3] * along * along / (d * d)
        value *= t.scalars[DENSITY] * d**4
    if value > 0.0:
        value *= t.screws[i, GAIN] * (1.0 if shaft >= 0.0 else t.screws[i, REVERSE])
    value = max(value, -drag if flow >= 0.0 else drag)
    return value if shaft >= 0.0 else -value


@inlined
def add_thrusters(
    t: Truth,
    state: Array,
    v: Array,
    working: Array,
    gains: Array,
    force: Array,
    rate: Array,
    thrust: Array,
) -> None:
    """Add all thrust; fills the rates of the ramped codes and shafts, and the thrusts (n,).

    `working` (n,) is what is asked of the drives, `gains` (n,) what trouble leaves of each thrust.
    """
    for i in range(t.screws.shape[0]):
        x, y, z = t.place[i, 0], t.place[i, 1], t.place[i, 2]
        dx, dy, dz = t.push[i, 0], t.push[i, 1], t.push[i, 2]
        inflow = t.screws[i, INFLOW] * (
            dx * (v[0] + v[4] * z - v[5] * y)
            + dy * (v[1] + v[5] * x - v[3] * z)
            + dz * (v[2] + v[3] * y - v[4] * x)
        )
        code = working[i]
        rate[CODES + i] = 0.0
        if t.screws[i, CODE_LAG] > 0.0:
            rate[CODES + i] = (working[i] - state[CODES + i]) / t.screws[i, CODE_LAG]
            code = state[CODES + i]
        shaft = state[SHAFTS + i]
        if t.screws[i, MODE] == BALANCED:
            rate[SHAFTS + i] = shaft_acceleration(t, i, code, shaft, inflow)
        else:
            steady = steady_shaft(t, i, code, inflow)
            if t.screws[i, SHAFT_LAG] > 0.0:
                rate[SHAFTS + i] = (steady - shaft) / t.screws[i, SHAFT_LAG]
            else:
                rate[SHAFTS + i] = 0.0
                shaft = steady
        value = thrust_of(t, i, shaft, inflow) * gains[i]
        if t.trouble[VENT_ABOVE] > 0.0:
            # a propeller that works hard near the surface draws air
            edge = t.trouble[VENT_ABOVE] * t.screws[i, CODE_MAX]
            if abs(code) > edge and state[2] < t.trouble[VENT_DEPTH]:
                share = min((abs(code) - edge) / (0.05 * t.screws[i, CODE_MAX]), 1.0)
                value *= 1.0 - share * (1.0 - t.trouble[VENT_LEFT])
        thrust[i] = value
        add_at(x, y, z, value * dx, value * dy, value * dz, force)
