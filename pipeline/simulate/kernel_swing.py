"""Compiled kernel: paying a tether out and hauling it in, and a run of a tether alone.

The winch lets the top segment grow or shrink. Above 1.5 nominal lengths a node is brought in, below
0.4 one is taken out, so all other nodes stay the pieces of cable that they are. Momentum comes in
with the cable. The drum is advanced once a sub-step, by the tension at its end (semi-implicit).
"""

from typing import Any

import numpy as np

from pipeline.physics.winch import drum_step
from pipeline.simulate.compiled import compiled, inlined
from pipeline.simulate.kernel_tether import (
    BRAKE,
    FRICTION,
    INERTIA,
    LONGEST,
    NO_LOAD,
    RADIUS,
    SEGMENT,
    SHORTEST,
    STALL,
    VISCOUS,
    Nodes,
    begin,
    cable_forces,
    finish,
    next_stage,
    substeps,
    work_on,
)

Array = Any

#: Lower end of a cable without a vehicle.
FREE, HELD = 0, 1
#: Numbers that a run carries along beside the nodes: segments in use, drum speed, length owed.
COUNT, DRUM, OWED = range(3)
#: What a run came to.
DONE, NOT_FINITE, TOO_STIFF, NO_ROOM = range(4)
#: The top segment's length, in nominal ones, at which a node comes or goes.
LONGEST_TOP, SHORTEST_TOP = 1.5, 0.4
#: Time in which rest length that was put off when a node went is given back. [s]
GIVE_BACK_S = 1.0

drum = inlined(drum_step)


@inlined
def renew_top(c: Array, count: int, nodes: Nodes, growth: float, owed: float) -> tuple[int, float]:
    """Bring a node in at the top, or take one out; returns the count and the length owed.

    A new node lies on the old segment, at its strain, with the velocity of the cable there. When
    a node goes, the kink at it is cut off; so that the tension does not jump, the rest length is
    that of the same strain, and what it lacks is owed and given back slowly.
    """
    place, speed, rest = nodes.place, nodes.speed, nodes.rest
    nominal = c[SEGMENT]
    if rest[0] > LONGEST_TOP * nominal and count + 1 < place.shape[0]:
        share = (rest[0] - nominal) / rest[0]
        stretch = 1.0 / rest[0]
        for i in range(count + 1, 1, -1):
            for j in range(3):
                place[i, j] = place[i - 1, j]
                speed[i, j] = speed[i - 1, j]
        for i in range(count, 1, -1):
            rest[i] = rest[i - 1]
        for j in range(3):
            chord = place[2, j] - place[0, j]
            leaving = speed[0, j] + growth * chord * stretch
            place[1, j] = place[0, j] + share * chord
            speed[1, j] = (1.0 - share) * leaving + share * speed[2, j]
        rest[1] = nominal
        rest[0] -= nominal
        return count + 1, owed
    if rest[0] < SHORTEST_TOP * nominal and count > 2:
        upper = 0.0
        chord2 = 0.0
        for j in range(3):
            upper += (place[1, j] - place[0, j]) ** 2
            chord2 += (place[2, j] - place[0, j]) ** 2
        together = rest[0] + rest[1]
        strain = upper**0.5 / rest[0]
        length0 = together
        if strain > 1.0:
            length0 = min(chord2**0.5 / strain, together)
        owed += together - length0
        rest[0] = length0
        for i in range(1, count):
            for j in range(3):
                place[i, j] = place[i + 1, j]
                speed[i, j] = speed[i + 1, j]
        for i in range(1, count - 1):
            rest[i] = rest[i + 1]
        return count - 1, owed
    return count, owed


@inlined
def drum_speed_after(
    winch: Array, command: float, speed: float, tension: float, paid_out: float, h: float
) -> float:
    """Return the drum's speed after a sub-step; it stops at the ends of the cable."""
    if winch[RADIUS] == 0.0:
        return 0.0
    turned = drum(
        speed,
        command,
        tension,
        h,
        winch[RADIUS],
        winch[INERTIA],
        winch[STALL],
        winch[NO_LOAD],
        winch[VISCOUS],
        winch[FRICTION],
        winch[BRAKE],
    )
    if turned < 0.0 and paid_out <= winch[SHORTEST]:
        turned = 0.0
    if turned > 0.0 and paid_out >= winch[LONGEST]:
        turned = 0.0
    return turned


@inlined
def paid_out_length(count: int, nodes: Nodes, owed: float) -> float:
    """Unstretched length between the drum and the lower end."""
    total = owed
    for i in range(count):
        total += nodes.rest[i]
    return total


@inlined
def record(
    k: int,
    count: int,
    nodes: Nodes,
    places: Array,
    tensions: Array,
    ends: Array,
) -> None:
    """Write row k of what a run keeps of the cable; NaN where there are no nodes."""
    for j in range(3):
        ends[k, 0, j], ends[k, 1, j] = nodes.force[0, j], nodes.force[count, j]
    for i in range(places.shape[1]):
        for j in range(3):
            places[k, i, j] = nodes.at[i, j] if i <= count else np.nan
    for i in range(tensions.shape[1]):
        tensions[k, i] = nodes.tension[i] if i < count else np.nan


@inlined
def all_finite(count: int, nodes: Nodes) -> bool:
    """Whether the cable's state is made of numbers."""
    total = 0.0
    for i in range(count + 1):
        for j in range(3):
            total += abs(nodes.place[i, j]) + abs(nodes.speed[i, j])
    return bool(np.isfinite(total))


@inlined
def swing_on(  # noqa: PLR0912 - one loop over steps, sub-steps and stages
    c: Array,
    winch: Array,
    lower: int,
    lower_velocity: Array,
    commands: Array,
    dt: float,
    settle: bool,
    nodes: Nodes,
    carried: Array,
    places: Array,
    tensions: Array,
    ends: Array,
    logs: Array,
) -> int:
    """Do the work of `swing`, on arrays that it has made."""
    speed, rest = nodes.speed, nodes.rest
    steps = places.shape[0] - 1
    count = int(carried[COUNT])
    drum_speed, owed, energy = carried[DRUM], carried[OWED], 0.0
    end_mass = 0.0 if lower == FREE else 1e30
    for k in range(steps + 1):
        now = min(k, steps - 1)
        down = min(now, lower_velocity.shape[0] - 1)
        command = commands[min(now, commands.shape[0] - 1)]
        for j in range(3):
            speed[0, j] = 0.0
            if lower == HELD:
                speed[count, j] = lower_velocity[down, j]
        if not all_finite(count, nodes):
            return NOT_FINITE
        n = substeps(c, winch, count, nodes, end_mass, dt)
        if n == 0:
            return TOO_STIFF
        paid_out = paid_out_length(count, nodes, owed)
        logs[k, 0], logs[k, 1], logs[k, 2], logs[k, 3] = count, paid_out, drum_speed, n
        h = dt / n
        for step in range(n):
            payout = drum_speed * winch[RADIUS]
            growth = payout + owed / GIVE_BACK_S
            last = count if lower == FREE else count - 1
            top = rest[0]
            begin(count, nodes)
            for stage in range(4):
                elapsed = 0.5 * h if stage < 2 else h
                cable_forces(c, count, growth, nodes)
                if step == 0 and stage == 0:
                    record(k, count, nodes, places, tensions, ends)
                    if k == steps:
                        break
                next_stage(count, last, 1.0 + (stage % 3 > 0), elapsed, nodes)
                rest[0] = top + elapsed * growth
            if k == steps:
                break
            finish(count, h, nodes)
            paid_out += h * payout
            owed -= h * owed / GIVE_BACK_S
            drum_speed = drum_speed_after(winch, command, drum_speed, nodes.tension[0], paid_out, h)
            if settle:
                kinetic = 0.0
                for i in range(count + 1):
                    for j in range(3):
                        kinetic += speed[i, j] ** 2
                if kinetic < energy:
                    kinetic = 0.0
                    for i in range(count + 1):
                        for j in range(3):
                            speed[i, j] = 0.0
                energy = kinetic
            count, owed = renew_top(c, count, nodes, growth, owed)
            if rest[0] > LONGEST_TOP * c[SEGMENT]:
                return NO_ROOM
    carried[COUNT], carried[DRUM], carried[OWED] = count, drum_speed, owed
    return DONE


@compiled
def swing(
    lower: int,
    lower_velocity: Array,
    dt: float,
    settle: bool,
    c: Array,
    winch: Array,
    commands: Array,
    place: Array,
    speed: Array,
    rest: Array,
    carried: Array,
    places: Array,
    tensions: Array,
    ends: Array,
    logs: Array,
) -> int:
    """Integrate a cable alone, its lower end `FREE` or `HELD`; RK4 with sub-steps.

    `lower_velocity` (m or 1, 3) of a held end and the winch's `commands` (m or 1,) are held for a
    step each. Fills `places` (m + 1, room, 3), `tensions` (m + 1, room - 1), `ends` (m + 1, 2, 3),
    the force on the bodies at the top and below, and `logs` (m + 1, 4): segments in use, paid-out
    length, drum speed, sub-steps. With `settle` the nodes are stopped whenever their kinetic energy
    has passed a peak, which brings the cable to rest (dynamic relaxation with kinetic damping,
    Barnes 1999).
    """
    nodes = work_on(place, speed, rest)
    return swing_on(
        c,
        winch,
        lower,
        lower_velocity,
        commands,
        dt,
        settle,
        nodes,
        carried,
        places,
        tensions,
        ends,
        logs,
    )
