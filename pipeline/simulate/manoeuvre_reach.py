"""How far the thrusters reach along each axis, and which manoeuvres that leaves unflown."""

from collections.abc import Sequence

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.physics.parameters import read
from pipeline.simulate.fly import autopilot_for, general_allocator
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray

#: Largest roll or pitch that an excitation may hold against the righting moment and the hold. [rad]
LARGEST_TILT_RAD = 0.15
#: The same for heading. [rad]
LARGEST_TURN_RAD = 1.0
#: What an excitation needs: one axis at least that can be pushed alone.
ANY_AXIS = ("any",)
#: Share of its reach that a manoeuvre usually asks for along an axis.
USUAL_SHARE = 0.4
_TILTING = (3, 4)


def reach_alone(packed: PackedVehicle) -> FloatArray:
    """Largest force and moment along each axis alone at rest, (6,); 0 where there is none.

    Roll and pitch that no thruster can hold are left to the righting moment: a push may tilt the
    vehicle there as far as a trial would allow.
    """
    allocator = general_allocator(packed)
    matrix = allocator.configuration()
    if not matrix.size:
        return np.zeros(6)
    size = np.minimum(allocator.largest_n, -allocator.smallest_n)
    alone = _shares(matrix, np.arange(6))
    reach = np.where(np.isnan(alone).any(axis=0), 0.0, _sizes(alone, size))
    righting = righting_moment(packed)
    passive = [axis for axis in _TILTING if reach[axis] == 0.0 and righting > 0.0]
    if passive:
        pushes = _shares(matrix, np.setdiff1d(np.arange(6), passive))
        spill = np.abs(matrix[passive] @ np.nan_to_num(pushes)).max(axis=0)
        tilt = LARGEST_TILT_RAD * righting / USUAL_SHARE / np.maximum(spill, 1e-12)
        tilted = np.minimum(_sizes(pushes, size), tilt)
        possible = (reach == 0.0) & ~np.isnan(pushes).any(axis=0)
        reach = np.where(possible, tilted, reach)
    return reach


def _shares(matrix: FloatArray, axes: IntArray) -> FloatArray:
    """Thrusts for a unit along each axis and nothing along the others of `axes`, (n, 6).

    NaN where there are none.
    """
    shares = np.full((matrix.shape[1], 6), np.nan)
    inverse = np.linalg.pinv(matrix[axes], rcond=1e-6)
    exact = np.abs(matrix[axes] @ inverse - np.eye(len(axes))).max(axis=0, initial=0.0) < 1e-6
    shares[:, axes[exact]] = inverse[:, exact]
    return shares


def _sizes(shares: FloatArray, size_n: FloatArray) -> FloatArray:
    """How often the unit of each axis can be had from thrusters of these sizes, (6,)."""
    reach: FloatArray = np.min(
        size_n[:, None] / np.maximum(np.abs(np.nan_to_num(shares)), 1e-12), axis=0
    )
    return reach


def righting_moment(packed: PackedVehicle) -> float:
    """Metacentric stiffness of roll and pitch [N m/rad]."""
    vector = packed.vector
    return float(
        read(vector, "weight") * read(vector, "centre_of_mass")[2]
        - read(vector, "buoyancy") * read(vector, "centre_of_buoyancy")[2]
    )


def gentle_reach(packed: PackedVehicle) -> FloatArray:
    """`reach_alone` with roll, pitch and yaw held to angles that a trial would allow, (6,).

    What resists is the righting moment and the autopilot that holds level and heading.
    """
    righting = righting_moment(packed)
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


def why_not_flown(packed: PackedVehicle, name: str, axes: Sequence[str]) -> str:
    """Say why a manoeuvre is impossible for a vehicle; "" where it can be flown."""
    missing = out_of_reach(packed, axes)
    if not missing:
        return ""
    matrix = general_allocator(packed).configuration()
    if missing == ANY_AXIS:
        reasons = ["it needs one axis at least along which the thrusters can push alone"]
    else:
        reasons = [_why_no_reach(matrix, axis) for axis in missing]
    return f"{name} cannot be flown: {'; '.join(reasons)}."


def _why_no_reach(matrix: FloatArray, axis: str) -> str:
    """Say why there is no push along an axis: nothing pushes there, or always elsewhere as well."""
    row = AXES.index(axis)
    if np.abs(matrix[row]).max(initial=0.0) < 1e-6:
        return f"no thruster pushes along {axis}"
    # what cannot be had apart from this axis
    wanted = np.eye(6)[row]
    got = matrix @ np.linalg.pinv(matrix, rcond=1e-6) @ wanted
    others = [AXES[k] for k in range(6) if k != row and abs(got[k]) > 1e-6]
    with_it = f" along {' and '.join(others)}" if others else " elsewhere"
    return f"its thrusters cannot push along {axis} without a push{with_it} that none can balance"
