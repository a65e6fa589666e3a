"""Compiled kernel: parts that are called by themselves; those compiled into others cannot be."""

from typing import Any

from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_follow import turn_towards
from pipeline.simulate.kernel_frames import rotation_matrix
from pipeline.simulate.kernel_hull import mass_matrix
from pipeline.simulate.kernel_thrusters import thruster_directions

Array = Any


@compiled
def fill_mass(p: Array, near_wall: float, matrix: Array) -> None:
    """Fill a mass matrix (6, 6)."""
    mass_matrix(p, near_wall, matrix)


@compiled
def fill_directions(p: Array, directions: Array) -> None:
    """Fill directions (12, 3) of thrusters."""
    thruster_directions(p, directions)


@compiled
def fill_rotation(state: Array, rotation: Array) -> None:
    """Fill the rotation (3, 3) from the body of a state to the world."""
    rotation_matrix(state[3], state[4], state[5], state[6], rotation)


@compiled
def fill_turn(state: Array, wanted: Array, turn: Array) -> None:
    """Fill the rotation vector (3,) from the attitude of a state to a quaternion (4,)."""
    turn_towards(state, wanted, turn)
