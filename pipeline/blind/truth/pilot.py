"""What the truth's autopilot believes: the vehicle file, whatever the vehicle really is."""

import numpy as np

from pipeline.blind.truth.craft import Craft, rigid_of
from pipeline.blind.truth.kernel_flight import Belief
from pipeline.types import FloatArray

#: Weight of an axis that cannot be pushed alone, in the allocation.
LEFT_ALONE = 0.03
#: Bandwidths [rad/s] of surge, place, depth, heading, pitch, roll.
BANDWIDTH = (0.5, 1.0, 0.4, 0.7, 0.9, 1.2)


def configuration(craft: Craft) -> FloatArray:
    """Wrench of a unit thrust of each thruster (6, n)."""
    return np.concatenate([craft.push, np.cross(craft.place, craft.push)], axis=1).T


def free_axes(craft: Craft) -> FloatArray:
    """Which of the six axes can be pushed without pushing another one (6,)."""
    matrix = configuration(craft)
    wrong = np.abs(matrix @ np.linalg.pinv(matrix, rcond=1e-6) - np.eye(6))
    return np.asarray(wrong.max(axis=0) < 1e-6)


def pilot_axes(craft: Craft) -> FloatArray:
    """Axes that are steered (6,): those that are free, and yaw where the rudder drags sway along.

    A slender hull turns by side thrusters at one end: sway comes with yaw and is left to drift.
    """
    free = free_axes(craft)
    if not free[5] and np.linalg.norm(configuration(craft)[5]) > 0.0:
        free[5], free[1] = True, False
    return free


def belief_of(craft: Craft) -> Belief:
    """Make the autopilot of a vehicle that is exactly as its file says."""
    axes = pilot_axes(craft)
    matrix = configuration(craft)
    # moments by an arm, so that newtons and newton metres weigh alike
    arm = max(float(np.linalg.norm(matrix[3:]) / np.linalg.norm(matrix[:3])), 1e-3)
    weight = np.where(axes, 1.0, LEFT_ALONE) * np.array([1, 1, 1, 1 / arm, 1 / arm, 1 / arm])
    inverse = np.linalg.pinv(weight[:, None] * matrix, rcond=1e-4) * weight
    inverse = inverse * np.where(axes, 1.0, 0.0)
    laws = [craft.laws[k] for k in craft.kind]
    total = np.diag(rigid_of(craft) + craft.added).copy()
    weight_n = craft.mass_kg * craft.gravity
    arm_z = weight_n * craft.centre_g[2] - craft.buoyancy_n * craft.centre_b[2]
    a = craft.added
    # Munk's moments net of lift, of an angle of attack and of drift
    pitch = craft.coriolis * (a[2, 2] - a[0, 0]) + craft.lift[1] + craft.turning[0]
    yaw = craft.coriolis * (a[1, 1] - a[0, 0]) - craft.lift[3] - craft.turning[1]
    return Belief(
        inertia=total,
        drag=np.array([craft.linear[0, 0], craft.quadratic[0]]),
        bandwidth=np.array(BANDWIDTH),
        inverse=np.ascontiguousarray(inverse),
        most=np.array([law.most_n for law in laws], float).reshape(-1, 2),
        codes=np.stack([law.inverse for law in laws]),
        gravity_stiffness=np.array([arm_z, arm_z]),
        upset=np.array([max(pitch, 0.0), max(yaw, 0.0)]),
    )


def reach_of(craft: Craft) -> FloatArray:
    """Largest force and moment along each steered axis alone (6,); 0 along the others."""
    belief = belief_of(craft)
    reach = np.zeros(6)
    for axis in np.flatnonzero(pilot_axes(craft)):
        ask = belief.inverse[:, axis]
        least = belief.most.min(axis=1)
        reach[axis] = float(np.min(least / np.maximum(np.abs(ask), 1e-9)))
    return reach
