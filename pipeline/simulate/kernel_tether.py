"""Compiled kernel: a tether of lumped masses between a winch and the vehicle.

Nodes 0 (at the top) to n are joined by n straight segments; each segment gives half of its mass,
weight, drag and added mass to either of its nodes (Walton and Polachek 1960; Buckham 2003; Hall and
Goupee 2015, MoorDyn). What is not as there: drag and added mass act with the directions of the
segments, not of the nodes; and the added mass brings the terms of its turning, which Morison's form
leaves out. With T_a = 1/2 c |u_n|^2 the kinetic energy of the water at one end of a segment, u_n
the velocity across it, they follow from Lagrange's equations, and without drag no energy is lost.

Arrays have room for more nodes than are in use; `count` is the number of segments in use.
"""

from typing import Any, NamedTuple

import numpy as np

from pipeline.simulate.compiled import inlined, within

Array = Any

#: Entries of the cable's vector.
MASS, WEIGHT, NORMAL, TANGENT, STIFFNESS, DASHPOT, ADDED, SEGMENT, CURRENT = range(9)
#: Entries of the winch's vector, as `Winch.numbers` gives them; a radius of 0 is no winch.
RADIUS, INERTIA, STALL, NO_LOAD, VISCOUS, FRICTION, BRAKE, SHORTEST, LONGEST = range(9)
WINCH_SIZE = 9
#: Sub-steps in a step at most: more means a mistake in stiffness, length or step.
MOST_SUBSTEPS = 20000
#: Largest (frequency of the fastest motion) x (sub-step); RK4 is stable to 2.6.
FASTEST_PHASE = 1.0


class Nodes(NamedTuple):
    """Arrays of a cable with room for r nodes.

    Its state: `place`, `speed` (r, 3), `rest` (r - 1,), the unstretched lengths. Work of a stage of
    the integrator: `at`, `moving`, `flow` (velocity relative to the water), `force`, `acceleration`
    (r, 3), `inertia` (r, 6: xx yy zz xy xz yz), `tension` (r - 1,), and the weighted sums
    `velocities`, `accelerations` (r, 3).
    """

    place: Array
    speed: Array
    rest: Array
    at: Array
    moving: Array
    flow: Array
    force: Array
    acceleration: Array
    inertia: Array
    tension: Array
    velocities: Array
    accelerations: Array


@within
def work_on(place: Array, speed: Array, rest: Array) -> Nodes:
    """Arrays to advance a state, which is changed in place."""
    room = place.shape[0]
    return Nodes(
        place=place,
        speed=speed,
        rest=rest,
        at=np.zeros((room, 3)),
        moving=np.zeros((room, 3)),
        flow=np.zeros((room, 3)),
        force=np.zeros((room, 3)),
        acceleration=np.zeros((room, 3)),
        inertia=np.zeros((room, 6)),
        tension=np.zeros(room - 1),
        velocities=np.zeros((room, 3)),
        accelerations=np.zeros((room, 3)),
    )


@inlined
def relative_flow(c: Array, count: int, nodes: Nodes) -> None:
    """Fill the nodes' velocity relative to the water."""
    for i in range(count + 1):
        for j in range(3):
            nodes.flow[i, j] = nodes.moving[i, j] - c[CURRENT + j]


@inlined
def cable_forces(  # noqa: PLR0915 - vectors are written out, component by component
    c: Array, count: int, growth: float, nodes: Nodes
) -> None:
    """Fill forces, inertias and tensions of a stage.

    `growth` is the rate at which the top segment's rest length grows.
    """
    place, speed, rest = nodes.at, nodes.moving, nodes.rest
    force, inertia, tension, work = nodes.force, nodes.inertia, nodes.tension, nodes.flow
    relative_flow(c, count, nodes)
    for i in range(count + 1):
        for j in range(3):
            force[i, j] = 0.0
            inertia[i, j] = 0.0
            inertia[i, 3 + j] = 0.0
    for i in range(count):
        length0 = rest[i]
        dx = place[i + 1, 0] - place[i, 0]
        dy = place[i + 1, 1] - place[i, 1]
        dz = place[i + 1, 2] - place[i, 2]
        length = max((dx * dx + dy * dy + dz * dz) ** 0.5, 1e-9)
        tx, ty, tz = dx / length, dy / length, dz / length
        ax, ay, az = work[i, 0], work[i, 1], work[i, 2]
        bx, by, bz = work[i + 1, 0], work[i + 1, 1], work[i + 1, 2]
        ux = speed[i + 1, 0] - speed[i, 0]
        uy = speed[i + 1, 1] - speed[i, 1]
        uz = speed[i + 1, 2] - speed[i, 2]
        stretching = tx * ux + ty * uy + tz * uz
        # a cable pulls, or it does nothing
        pull = 0.0
        strain = length / length0 - 1.0
        if strain > 0.0:
            rate = stretching
            if i == 0:
                rate -= (1.0 + strain) * growth
            pull = max(c[STIFFNESS] * strain + c[DASHPOT] * rate, 0.0)
        tension[i] = pull
        # across and along, at the upper end (a) and the lower (b)
        pa = tx * ax + ty * ay + tz * az
        pb = tx * bx + ty * by + tz * bz
        nax, nay, naz = ax - pa * tx, ay - pa * ty, az - pa * tz
        nbx, nby, nbz = bx - pb * tx, by - pb * ty, bz - pb * tz
        half = 0.5 * length0
        across = half * c[NORMAL]
        along = half * c[TANGENT]
        da = across * (nax * nax + nay * nay + naz * naz) ** 0.5
        db = across * (nbx * nbx + nby * nby + nbz * nbz) ** 0.5
        ea = along * abs(pa) * pa
        eb = along * abs(pb) * pb
        # the added mass turns with the segment
        added = half * c[ADDED]
        lever = max(length, 0.5 * length0)
        sx, sy, sz = (
            (ux - stretching * tx) / lever,
            (uy - stretching * ty) / lever,
            (uz - stretching * tz) / lever,
        )
        ga = added * (sx * ax + sy * ay + sz * az)
        gb = added * (sx * bx + sy * by + sz * bz)
        fa, fb = added * pa, added * pb
        hx = (fa * nax + fb * nbx) / lever
        hy = (fa * nay + fb * nby) / lever
        hz = (fa * naz + fb * nbz) / lever
        la = pull - ea + ga
        lb = -pull - eb + gb
        force[i, 0] += la * tx - da * nax + fa * sx + hx
        force[i, 1] += la * ty - da * nay + fa * sy + hy
        force[i, 2] += la * tz - da * naz + fa * sz + hz + half * c[WEIGHT]
        force[i + 1, 0] += lb * tx - db * nbx + fb * sx - hx
        force[i + 1, 1] += lb * ty - db * nby + fb * sy - hy
        force[i + 1, 2] += lb * tz - db * nbz + fb * sz - hz + half * c[WEIGHT]
        mass = half * c[MASS]
        xx, yy, zz = (
            mass + added * (1.0 - tx * tx),
            mass + added * (1.0 - ty * ty),
            mass + added * (1.0 - tz * tz),
        )
        xy, xz, yz = -added * tx * ty, -added * tx * tz, -added * ty * tz
        for k in range(i, i + 2):
            inertia[k, 0] += xx
            inertia[k, 1] += yy
            inertia[k, 2] += zz
            inertia[k, 3] += xy
            inertia[k, 4] += xz
            inertia[k, 5] += yz
        if i == 0 and growth != 0.0:
            # cable that comes to node 1 has the velocity of the segment's middle
            flux = 0.25 * c[MASS] * growth
            coming = growth * length / length0
            force[1, 0] += flux * (coming * tx - ux)
            force[1, 1] += flux * (coming * ty - uy)
            force[1, 2] += flux * (coming * tz - uz)


@inlined
def node_accelerations(last: int, nodes: Nodes) -> None:
    """Solve the symmetric 3 x 3 systems of the nodes 1 to `last`."""
    for i in range(1, last + 1):
        a, b, c = nodes.inertia[i, 0], nodes.inertia[i, 1], nodes.inertia[i, 2]
        d, e, f = nodes.inertia[i, 3], nodes.inertia[i, 4], nodes.inertia[i, 5]
        m00, m01, m02 = b * c - f * f, e * f - d * c, d * f - e * b
        m11, m12, m22 = a * c - e * e, d * e - a * f, a * b - d * d
        scale = 1.0 / (a * m00 + d * m01 + e * m02)
        x, y, z = nodes.force[i, 0], nodes.force[i, 1], nodes.force[i, 2]
        nodes.acceleration[i, 0] = scale * (m00 * x + m01 * y + m02 * z)
        nodes.acceleration[i, 1] = scale * (m01 * x + m11 * y + m12 * z)
        nodes.acceleration[i, 2] = scale * (m02 * x + m12 * y + m22 * z)


@inlined
def begin(count: int, nodes: Nodes) -> None:
    """Set the first stage of a sub-step, at the state itself."""
    for i in range(count + 1):
        for j in range(3):
            nodes.at[i, j], nodes.moving[i, j] = nodes.place[i, j], nodes.speed[i, j]
            nodes.velocities[i, j] = nodes.accelerations[i, j] = 0.0


@inlined
def next_stage(count: int, last: int, weight: float, elapsed: float, nodes: Nodes) -> None:
    """Add a stage to the sums, and set the one after it; nodes 1 to `last` are free."""
    node_accelerations(last, nodes)
    for i in range(count + 1):
        free = 1.0 if 0 < i <= last else 0.0
        for j in range(3):
            acceleration = free * nodes.acceleration[i, j]
            nodes.velocities[i, j] += weight * nodes.moving[i, j]
            nodes.accelerations[i, j] += weight * acceleration
            nodes.at[i, j] = nodes.place[i, j] + elapsed * nodes.moving[i, j]
            nodes.moving[i, j] = nodes.speed[i, j] + elapsed * acceleration


@inlined
def finish(count: int, h: float, nodes: Nodes) -> None:
    """Set the state at the end of a sub-step."""
    for i in range(count + 1):
        for j in range(3):
            nodes.place[i, j] += h / 6.0 * nodes.velocities[i, j]
            nodes.speed[i, j] += h / 6.0 * nodes.accelerations[i, j]


@inlined
def substeps(
    c: Array,
    winch: Array,
    count: int,
    nodes: Nodes,
    end_mass: float,
    dt: float,
) -> int:
    """Count the sub-steps that a step needs; 0 if that cannot be told.

    The fastest motion of a node is bounded by Gershgorin's theorem on the stiffnesses k = EA / l
    of its segments, omega^2 <= 2 (k_above + k_below) / m: for equal segments omega = 2 c / l with
    c = (EA / m)^(1/2), the speed of the axial wave. The dashpot makes it faster where it is above
    critical, and the drag adds its own rate. A sub-step is FASTEST_PHASE over the sum: a Courant
    number c h / l of 0.5. `end_mass` is the mass that the lower end finds; 0 is none.
    """
    speed, rest = nodes.speed, nodes.rest
    quickest = 0.0
    drag_rate = 0.0
    water = (c[CURRENT] ** 2 + c[CURRENT + 1] ** 2 + c[CURRENT + 2] ** 2) ** 0.5
    drag = 2.0 * max(c[NORMAL] / (c[MASS] + c[ADDED]), c[TANGENT] / c[MASS])
    for i in range(count + 1):
        stiffness = 0.0
        mass = 0.0
        dashpots = 0.0
        if i > 0:
            stiffness += c[STIFFNESS] / rest[i - 1]
            mass += 0.5 * c[MASS] * rest[i - 1]
            dashpots += c[DASHPOT]
        if i < count:
            stiffness += c[STIFFNESS] / rest[i]
            mass += 0.5 * c[MASS] * rest[i]
            dashpots += c[DASHPOT]
        if i == 0:
            if winch[RADIUS] == 0.0:
                continue
            mass = winch[INERTIA] / winch[RADIUS] ** 2
        if i == count:
            mass += end_mass
        square = 2.0 * stiffness / mass
        damping = dashpots / mass  # half of the bound 2 (sum of dashpots) / m
        rate = damping + (max(damping * damping - square, 0.0)) ** 0.5
        quickest = max(quickest, square**0.5, rate)
        size = (speed[i, 0] ** 2 + speed[i, 1] ** 2 + speed[i, 2] ** 2) ** 0.5 + water
        drag_rate = max(drag_rate, drag * size)
    need = dt * (quickest + drag_rate) / FASTEST_PHASE
    if not need < MOST_SUBSTEPS:
        return 0
    return max(int(np.ceil(need)), 1)
