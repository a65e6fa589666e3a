"""How far the thrusters reach along each axis, and which manoeuvres that leaves unflown."""

from collections.abc import Sequence

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.physics.parameters import read
from pipeline.simulate.fly import autopilot_for, general_allocator
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray

#: Largest roll or pitch that an excitation may hold against the righting moment and the hold. [rad]
LARGEST_TILT_RAD = 0.15
#: The same for heading. [rad]
LARGEST_TURN_RAD = 1.0
#: What an excitation needs: one axis at least that can be pushed alone.
ANY_AXIS = ("any",)


def reach_alone(packed: PackedVehicle) -> FloatArray:
    """Largest force and moment along each axis alone at rest, (6,); 0 where there is none."""
    allocator = general_allocator(packed)
    matrix = allocator.configuration()
    size = np.minimum(allocator.largest_n, -allocator.smallest_n)
    reach = np.zeros(6)
    inverse = np.linalg.pinv(matrix, rcond=1e-6)
    for axis in range(6):
        unit = inverse[:, axis]
        if np.abs(matrix @ unit - np.eye(6)[axis]).max() < 1e-6:
            reach[axis] = float(np.min(size / np.maximum(np.abs(unit), 1e-12)))
    return reach


def gentle_reach(packed: PackedVehicle) -> FloatArray:
    """`reach_alone` with roll, pitch and yaw held to angles that a trial would allow, (6,).

    What resists is the righting moment and the autopilot that holds level and heading.
    """
    vector = packed.vector
    righting = float(
        read(vector, "weight") * read(vector, "centre_of_mass")[2]
        - read(vector, "buoyancy") * read(vector, "centre_of_buoyancy")[2]
    )
    reach = reach_alone(packed)
    design = autopilot_for(packed).design
    hold = [
        design.roll_inertia_kgm2 * design.roll_bandwidth**2,
        design.pitch_inertia_kgm2 * design.pitch_bandwidth**2,
    ]
    tilt = (max(righting, 0.0) + np.array(hold)) * LARGEST_TILT_RAD / 0.35
    reach[3:5] = np.minimum(reach[3:5], tilt)
    turn = design.yaw_inertia_kgm2 * design.heading_bandwidth**2 * LARGEST_TURN_RAD / 0.35
    reach[5] = min(reach[5], turn)
    return reach


def out_of_reach(packed: PackedVehicle, axes: Sequence[str]) -> tuple[str, ...]:
    """Return those axes of a manoeuvre along which it gives no motion.

    Surge has to be pushed alone, as its size sets the speed; along the others the autopilot's
    demand is met as far as any thruster pushes that way. Of `ANY_AXIS` one axis has to be free.
    """
    if tuple(axes) == ANY_AXIS:
        return () if reach_alone(packed).any() else ANY_AXIS
    alone = reach_alone(packed)
    matrix = np.abs(general_allocator(packed).configuration()).max(axis=1, initial=0.0)
    reach = np.where(np.array(AXES) == "surge", alone, matrix)
    return tuple(axis for axis in axes if reach[AXES.index(axis)] < 1e-6)
