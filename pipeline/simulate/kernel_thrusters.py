"""Compiled kernel: from commanded codes to the forces of the thrusters."""

from typing import Any

import numpy as np

from pipeline.physics.parameters import offset
from pipeline.simulate.compiled import inlined

Array = Any

THRUSTER_COUNT = offset("thruster_count")
THRUSTER_POSITION = offset("thruster_position")
THRUSTER_DIRECTION = offset("thruster_direction")
THRUSTER_TYPE = offset("thruster_type")
THRUST_GAIN = offset("thrust_gain")
REVERSE_GAIN = offset("reverse_gain")
INFLOW_FRACTION = offset("inflow_fraction")
OPPOSED_SHARE = offset("opposed_share")
DEAD_ZONE = offset("dead_zone")
DRIVE_DEAD = offset("drive_dead")
LAG_DEAD_SHARE = offset("lag_dead_share")
CODE_MAX = offset("code_max")
CODE_MIN = offset("code_min")
ROTOR_INERTIA = offset("rotor_inertia")
SUPPLY_DROP = offset("supply_drop")
LOAD_DROP = offset("load_drop")
AZIMUTH = offset("misalignment_azimuth")
ELEVATION = offset("misalignment_elevation")
DENSITY = offset("density")

#: Columns of `screws` (one row a thruster type): diameter, K_T0..2, K_M0..2, the steps of the
#: torque table in shaft speed and code, and K_T / J^2 of the freely turning propeller, 0 or less.
SCREW_COLUMNS = 10


@inlined
def thruster_directions(p: Array, directions: Array) -> None:
    """Fill directions (12, 3): the stated ones, tilted by azimuth and elevation.

    Two axes across the stated direction d: s = z x d, level and to starboard of a thruster that
    pushes ahead (body y where d is vertical), and n = d x s. Azimuth turns d towards s, elevation
    then lifts it away from n: d cos a cos e + s sin a cos e - n sin e, which tilts every thruster.
    """
    for i in range(int(p[THRUSTER_COUNT])):
        d = THRUSTER_DIRECTION + 3 * i
        x, y, z = p[d], p[d + 1], p[d + 2]
        azimuth, elevation = p[AZIMUTH + i], p[ELEVATION + i]
        if azimuth != 0.0 or elevation != 0.0:
            flat = (x * x + y * y) ** 0.5
            if flat > 1e-6:
                s0, s1 = -y / flat, x / flat
            else:
                s0, s1 = 0.0, 1.0
            # n = d x s with s level
            n0, n1, n2 = -z * s1, z * s0, x * s1 - y * s0
            along, side = np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation)
            up = np.sin(elevation)
            x = along * x + side * s0 - up * n0
            y = along * y + side * s1 - up * n1
            z = along * z - up * n2
        directions[i, 0], directions[i, 1], directions[i, 2] = x, y, z


@inlined
def thruster_levers(p: Array, levers: Array) -> None:
    """Fill levers (12, 6): force and moment about the body origin of one newton of each."""
    thruster_directions(p, levers)
    for i in range(int(p[THRUSTER_COUNT])):
        r = THRUSTER_POSITION + 3 * i
        x, y, z = p[r], p[r + 1], p[r + 2]
        d0, d1, d2 = levers[i, 0], levers[i, 1], levers[i, 2]
        levers[i, 3], levers[i, 4], levers[i, 5] = y * d2 - z * d1, z * d0 - x * d2, x * d1 - y * d0


@inlined
def effective_codes(p: Array, command: Array, codes: Array) -> None:
    """Fill codes (12,) with what reaches the drives: dead zone and supply voltage taken off.

    A command beyond the range of the drive is held at its end. What a controller ignores of a code
    it ignores at any voltage: of the characteristic's dead zone the share that comes before the
    drive is not scaled.
    """
    count = int(p[THRUSTER_COUNT])
    load = 0.0
    for i in range(count):
        largest = p[CODE_MAX + i]
        held = min(max(command[i], p[CODE_MIN + i], -largest), largest)
        load += (held / largest) ** 2
        codes[i] = held
    supply = 1.0 - p[SUPPLY_DROP]
    if count > 0:
        supply -= p[LOAD_DROP] * load / count
    for i in range(count):
        code, lost, largest = codes[i], p[DEAD_ZONE + i], p[CODE_MAX + i]
        if lost != 0.0:
            size = max(abs(code) - lost, 0.0) * largest / (largest - lost)
            code = np.copysign(size, code)
        before = p[LAG_DEAD_SHARE] * p[DRIVE_DEAD + i]
        if before == 0.0:
            codes[i] = supply * code
        elif abs(code) > before:
            codes[i] = np.copysign(before + supply * (abs(code) - before), code)
        else:
            codes[i] = code


@inlined
def tabulated(
    table: Array, rows_per: float, columns_per: float, row: float, column: float
) -> float:
    """Bilinear value on a regular grid from (0, 0), of so many rows and columns a unit.

    Beyond the end of the grid it goes on along the slope there.

    A supply voltage above that of the bench drives a thruster beyond its largest code.
    """
    rows, columns = table.shape
    c = max(column * columns_per, 0.0)
    j = min(int(c), columns - 2)
    c -= j
    if rows == 1:
        return table[0, j] * (1.0 - c) + table[0, j + 1] * c
    r = max(row * rows_per, 0.0)
    i = min(int(r), rows - 2)
    r -= i
    low = table[i, j] * (1.0 - c) + table[i, j + 1] * c
    high = table[i + 1, j] * (1.0 - c) + table[i + 1, j + 1] * c
    return low + r * (high - low)


@inlined
def static_thrust(
    p: Array, i: int, code: float, speed: float, thrust_tables: Array, per_step: Array
) -> float:
    """Thrust of thruster i from its table T(|N|, V along the thrust), signed.

    A propeller that turns slower than the water drags it: at code 0 the table holds the drag of a
    free one, from where the thrust rises to nothing at the edge of the dead zone. Beyond the last
    speed the thrust goes on falling to that drag and stays there. Against the motion the row at
    rest holds, or the drag where that is more, and a share of what the thrust would lose along the
    motion is added. What a thruster lacks of its thrust it does not lack of its drag.
    """
    kind = int(p[THRUSTER_TYPE + i])
    per = per_step[kind]
    side = 0 if code >= 0.0 else 1
    along = speed if code >= 0.0 else -speed
    share = p[OPPOSED_SHARE] if along < 0.0 else 0.0
    value = tabulated(thrust_tables[kind, side], per[0], per[1], max(along, 0.0), abs(code))
    drag = 0.0
    if value < 0.0 or along < 0.0:
        table = thrust_tables[kind, side]
        drag = -min(tabulated(table, per[0], per[1], abs(along), 0.0), 0.0)
    if value < 0.0:
        value = max(value, -drag)
    else:
        if share != 0.0:
            lost = tabulated(thrust_tables[kind, side], per[0], per[1], -along, abs(code))
            value += share * (value - max(lost, 0.0))
        value *= p[THRUST_GAIN + i]
        if code < 0.0:
            value *= p[REVERSE_GAIN + i]
        value = max(value, drag)
    return value if code >= 0.0 else -value


@inlined
def screw_thrust(p: Array, i: int, shaft: float, speed: float, screws: Array) -> float:
    """Thrust of thruster i at a shaft speed (signed), rho D^4 (K_T0 n^2 + K_T1 n V/D + ...).

    Below zero where the water turns the propeller, down to what it drags freely (`screws`).
    """
    screw = screws[int(p[THRUSTER_TYPE + i])]
    diameter = screw[0]
    n = abs(shaft)
    along = max(speed if shaft >= 0.0 else -speed, 0.0) / diameter
    value = screw[1] * n * n + screw[2] * n * along + screw[3] * along * along
    value = max(value, screw[9] * along * along) * p[DENSITY] * diameter**4
    if value > 0.0:
        value *= p[THRUST_GAIN + i]
    elif shaft < 0.0:
        return -value
    if shaft < 0.0:
        return -value * p[REVERSE_GAIN + i]
    return value


@inlined
def shaft_rate(
    p: Array,
    i: int,
    shaft: float,
    code: float,
    speed: float,
    screws: Array,
    torque_tables: Array,
) -> float:
    """Rate of the shaft speed: 2 pi J n' = M_drive(n, N) - M_propeller(n, V) [rev/s^2]."""
    kind = int(p[THRUSTER_TYPE + i])
    screw = screws[kind]
    diameter = screw[0]
    # seen from the side to which the code drives
    sense = 1.0 if code > 0.0 or (code == 0.0 and speed >= 0.0) else -1.0
    n = sense * shaft
    along = max(sense * speed, 0.0) / diameter
    drive = tabulated(torque_tables[kind], 1.0 / screw[8], 1.0 / screw[7], abs(code), max(n, 0.0))
    load = screw[4] * n * abs(n) + screw[5] * max(n, 0.0) * along
    if n >= 0.0:
        load += screw[6] * along * along
    load *= p[DENSITY] * diameter**5
    if code == 0.0:
        drive = 0.0
    return sense * (drive - load) / (2.0 * np.pi * p[ROTOR_INERTIA + i])


@inlined
def add_thrust(
    p: Array,
    levers: Array,
    actuator: Array,
    v: Array,
    thrust_tables: Array,
    screws: Array,
    per_step: Array,
    thrust: Array,
    inflow: Array,
    force: Array,
) -> None:
    """Add the thrusters' forces and moments; fills thrust and inflow speed of each (12,).

    The sums are kept in scalars: the compiler cannot know that the arrays do not overlap.
    """
    f0, f1, f2, f3, f4, f5 = force[0], force[1], force[2], force[3], force[4], force[5]
    for i in range(int(p[THRUSTER_COUNT])):
        l0, l1, l2 = levers[i, 0], levers[i, 1], levers[i, 2]
        l3, l4, l5 = levers[i, 3], levers[i, 4], levers[i, 5]
        # the place moves along by d (v + w x r) = d v + (r x d) w
        along = l0 * v[0] + l1 * v[1] + l2 * v[2] + l3 * v[3] + l4 * v[4] + l5 * v[5]
        inflow[i] = p[INFLOW_FRACTION + i] * along
        if p[ROTOR_INERTIA + i] > 0.0:
            t = screw_thrust(p, i, actuator[i], inflow[i], screws)
        else:
            t = static_thrust(p, i, actuator[i], inflow[i], thrust_tables, per_step)
            if p[INFLOW_FRACTION + i] < 0.0:
                # no vehicle has this; a fit that crosses zero meets the mirror image of the other
                # side there, where the thrust at rest against the motion would be a kink
                mirrored = static_thrust(p, i, actuator[i], -inflow[i], thrust_tables, per_step)
                t = 2.0 * static_thrust(p, i, actuator[i], 0.0, thrust_tables, per_step) - mirrored
        thrust[i] = t
        f0 += t * l0
        f1 += t * l1
        f2 += t * l2
        f3 += t * l3
        f4 += t * l4
        f5 += t * l5
    force[0], force[1], force[2], force[3], force[4], force[5] = f0, f1, f2, f3, f4, f5
