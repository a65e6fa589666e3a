"""Compiled kernel: inertia and the forces of the water on the hull.

Equations of Fossen 2021 in SNAME axes with the velocity relative to the water, nu_r:
M nu_r' + C(nu_r) nu_r + D nu_r + d |nu_r| nu_r + g = tau.
"""

from typing import Any

import numpy as np

from pipeline.physics.parameters import MOST_WALLS, offset
from pipeline.simulate.compiled import inlined

Array = Any

MASS = offset("mass")
CENTRE_OF_MASS = offset("centre_of_mass")
INERTIA = offset("inertia")
WEIGHT = offset("weight")
BUOYANCY = offset("buoyancy")
CENTRE_OF_BUOYANCY = offset("centre_of_buoyancy")
ADDED_MASS = offset("added_mass")
CORIOLIS_FRACTION = offset("coriolis_fraction")
LINEAR_DAMPING = offset("linear_damping")
QUADRATIC_DAMPING = offset("quadratic_damping")
CROSSFLOW_FRACTION = offset("crossflow_fraction")
HEAVE_LIFT = offset("heave_lift_slope")
SWAY_LIFT = offset("sway_lift_slope")
PITCH_LIFT = offset("pitch_lift_slope")
YAW_LIFT = offset("yaw_lift_slope")
TURNOVER = offset("turnover_slope")
DENSITY = offset("density")
WALL_STRENGTH = offset("wall_strength")
WALL_RADIUS = offset("wall_radius")
WALL_COUNT = offset("wall_count")
WALL_POINT = offset("wall_point")
WALL_NORMAL = offset("wall_normal")
TETHER_POINT = offset("tether_point")
TETHER_DRAG_AREA = offset("tether_drag_area")
TETHER_PULL = offset("tether_pull")
TETHER_ANCHOR = offset("tether_anchor")


@inlined
def mass_matrix(p: Array, near_wall: float, matrix: Array) -> None:
    """Fill M = M_RB + near_wall M_A (6, 6). Fossen 2021, eq. (3.49)."""
    m = p[MASS]
    x, y, z = p[CENTRE_OF_MASS], p[CENTRE_OF_MASS + 1], p[CENTRE_OF_MASS + 2]
    for i in range(6):
        for j in range(6):
            matrix[i, j] = near_wall * p[ADDED_MASS + 6 * i + j]
    for i in range(3):
        matrix[i, i] += m
        for j in range(3):
            matrix[3 + i, 3 + j] += p[INERTIA + 3 * i + j]
    # -m S(r_g) above the diagonal, its transpose below
    matrix[0, 4] += m * z
    matrix[0, 5] -= m * y
    matrix[1, 3] -= m * z
    matrix[1, 5] += m * x
    matrix[2, 3] += m * y
    matrix[2, 4] -= m * x
    matrix[4, 0] += m * z
    matrix[5, 0] -= m * y
    matrix[3, 1] -= m * z
    matrix[5, 1] += m * x
    matrix[3, 2] += m * y
    matrix[4, 2] -= m * x


@inlined
def solve_symmetric(matrix: Array, right: Array, factor: Array, solution: Array) -> None:
    """Solve a symmetric positive definite 6x6 system by Cholesky; `factor` is work space."""
    for i in range(6):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i == j:
                factor[i, i] = np.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
    for i in range(6):
        total = right[i]
        for k in range(i):
            total -= factor[i, k] * solution[k]
        solution[i] = total / factor[i, i]
    for i in range(5, -1, -1):
        total = solution[i]
        for k in range(i + 1, 6):
            total -= factor[k, i] * solution[k]
        solution[i] = total / factor[i, i]


@inlined
def wall_factor(p: Array, north: float, east: float, down: float) -> float:
    """1 + c sum (R / distance)^3 over the walls: the images' first term for a body near a plane.

    The distance is not taken below R: the body would touch. Lamb 1932, art. 137: a sphere of
    radius a moving at distance h from a plane wall gains 3/16 (a/h)^3 of the displaced mass normal
    to it.
    """
    factor = 1.0
    if p[WALL_STRENGTH] == 0.0:
        return factor
    count = min(int(p[WALL_COUNT]), MOST_WALLS)
    for k in range(count):
        point, normal = WALL_POINT + 3 * k, WALL_NORMAL + 3 * k
        distance = (
            (north - p[point]) * p[normal]
            + (east - p[point + 1]) * p[normal + 1]
            + (down - p[point + 2]) * p[normal + 2]
        )
        ratio = p[WALL_RADIUS] / max(distance, p[WALL_RADIUS])
        factor += p[WALL_STRENGTH] * ratio**3
    return factor


@inlined
def subtract_coriolis(p: Array, matrix: Array, v: Array, force: Array) -> None:
    """Subtract C(v) v from a force, C from the full symmetric matrix (Kirchhoff; Sagatun 1992).

    With the momenta (a, b) = M v: C v = (omega x a, omega x b + v x a), which is K I V of
    Voitasyk 2018 and does no work.
    """
    a0 = a1 = a2 = b0 = b1 = b2 = 0.0
    for j in range(6):
        a0 += matrix[0, j] * v[j]
        a1 += matrix[1, j] * v[j]
        a2 += matrix[2, j] * v[j]
        b0 += matrix[3, j] * v[j]
        b1 += matrix[4, j] * v[j]
        b2 += matrix[5, j] * v[j]
    share = p[CORIOLIS_FRACTION]
    force[0] -= share * (v[4] * a2 - v[5] * a1)
    force[1] -= share * (v[5] * a0 - v[3] * a2)
    force[2] -= share * (v[3] * a1 - v[4] * a0)
    force[3] -= share * (v[4] * b2 - v[5] * b1 + v[1] * a2 - v[2] * a1)
    force[4] -= share * (v[5] * b0 - v[3] * b2 + v[2] * a0 - v[0] * a2)
    force[5] -= share * (v[3] * b1 - v[4] * b0 + v[0] * a1 - v[1] * a0)


@inlined
def add_damping(p: Array, v: Array, near_wall: float, strips: Array, force: Array) -> None:
    """Add damping, cross-flow coupling and lift; `strips` rows are (x, C_d H dx, C_d B dx).

    Lift opposes the drift ahead and astern, so that it takes energy out both ways; its moment has
    the sign of its arm, but for the part that turns over with u as the Munk moment does.
    """
    for i in range(6):
        total = p[QUADRATIC_DAMPING + i] * abs(v[i]) * v[i]
        row = LINEAR_DAMPING + 6 * i
        for j in range(6):
            total += p[row + j] * v[j]
        force[i] -= near_wall * total
    share = p[CROSSFLOW_FRACTION]
    if share != 0.0:
        half = 0.5 * p[DENSITY] * share
        sway, heave, pitch, yaw = v[1], v[2], v[4], v[5]
        for k in range(strips.shape[0]):
            x = strips[k, 0]
            # what sway and yaw (heave and pitch) do together, beyond what each does alone
            both, turn = sway + x * yaw, x * yaw
            side = half * strips[k, 1] * (abs(both) * both - abs(sway) * sway - abs(turn) * turn)
            force[1] -= side
            force[5] -= x * side
            both, turn = heave - x * pitch, -x * pitch
            up = half * strips[k, 2] * (abs(both) * both - abs(heave) * heave - abs(turn) * turn)
            force[2] -= up
            force[4] += x * up
    speed = abs(v[0])
    force[2] -= p[HEAVE_LIFT] * speed * v[2]
    force[1] -= p[SWAY_LIFT] * speed * v[1]
    force[4] += p[PITCH_LIFT] * speed * v[2]
    force[5] += p[YAW_LIFT] * speed * v[1]
    if v[0] < 0.0:
        force[4] += 2.0 * p[TURNOVER] * v[0] * v[2]
        force[5] += 2.0 * p[TURNOVER + 1] * v[0] * v[1]


@inlined
def add_restoring(p: Array, rotation: Array, force: Array) -> None:
    """Add weight and buoyancy at their centres. Fossen 2021, eq. (4.5)."""
    weight, buoyancy = p[WEIGHT], p[BUOYANCY]
    # the down axis in body coordinates is the last row of R
    kx, ky, kz = rotation[2, 0], rotation[2, 1], rotation[2, 2]
    net = weight - buoyancy
    force[0] += net * kx
    force[1] += net * ky
    force[2] += net * kz
    ax = weight * p[CENTRE_OF_MASS] - buoyancy * p[CENTRE_OF_BUOYANCY]
    ay = weight * p[CENTRE_OF_MASS + 1] - buoyancy * p[CENTRE_OF_BUOYANCY + 1]
    az = weight * p[CENTRE_OF_MASS + 2] - buoyancy * p[CENTRE_OF_BUOYANCY + 2]
    force[3] += ay * kz - az * ky
    force[4] += az * kx - ax * kz
    force[5] += ax * ky - ay * kx


@inlined
def add_towed_tether(p: Array, state: Array, rotation: Array, v: Array, force: Array) -> None:
    """Add the lumped pull and drag of a tether at its point of attachment."""
    area, pull = p[TETHER_DRAG_AREA], p[TETHER_PULL]
    if area == 0.0 and pull == 0.0:
        return
    x, y, z = p[TETHER_POINT], p[TETHER_POINT + 1], p[TETHER_POINT + 2]
    u0 = v[0] + v[4] * z - v[5] * y
    u1 = v[1] + v[5] * x - v[3] * z
    u2 = v[2] + v[3] * y - v[4] * x
    drag = 0.5 * p[DENSITY] * area * (u0 * u0 + u1 * u1 + u2 * u2) ** 0.5
    f0, f1, f2 = -drag * u0, -drag * u1, -drag * u2
    if pull != 0.0:
        # from the point to the anchor, NED, then into body axes
        n0 = p[TETHER_ANCHOR] - state[0]
        n1 = p[TETHER_ANCHOR + 1] - state[1]
        n2 = p[TETHER_ANCHOR + 2] - state[2]
        b0 = rotation[0, 0] * n0 + rotation[1, 0] * n1 + rotation[2, 0] * n2 - x
        b1 = rotation[0, 1] * n0 + rotation[1, 1] * n1 + rotation[2, 1] * n2 - y
        b2 = rotation[0, 2] * n0 + rotation[1, 2] * n1 + rotation[2, 2] * n2 - z
        # within a metre of the anchor the pull fades instead of turning over
        reach = max((b0 * b0 + b1 * b1 + b2 * b2) ** 0.5, 1.0)
        f0 += pull * b0 / reach
        f1 += pull * b1 / reach
        f2 += pull * b2 / reach
    force[0] += f0
    force[1] += f1
    force[2] += f2
    force[3] += y * f2 - z * f1
    force[4] += z * f0 - x * f2
    force[5] += x * f1 - y * f0
