"""Compiled kernel: rotation between body and NED from a unit quaternion."""

from typing import Any

from pipeline.simulate.compiled import inlined

Array = Any  # compiled code sees plain arrays


@inlined
def rotation_matrix(w: float, x: float, y: float, z: float, rotation: Array) -> None:
    """Fill R (3, 3) with v_ned = R v_body for the unit quaternion (w, x, y, z).

    Fossen 2021, Handbook of Marine Craft Hydrodynamics and Motion Control, eq. (2.67).
    """
    rotation[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    rotation[0, 1] = 2.0 * (x * y - w * z)
    rotation[0, 2] = 2.0 * (x * z + w * y)
    rotation[1, 0] = 2.0 * (x * y + w * z)
    rotation[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    rotation[1, 2] = 2.0 * (y * z - w * x)
    rotation[2, 0] = 2.0 * (x * z - w * y)
    rotation[2, 1] = 2.0 * (y * z + w * x)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@inlined
def quaternion_rate(state: Array, nu: Array, rate: Array) -> None:
    """Rate of the quaternion from the body rates, into rate[3:7]. Fossen 2021, eq. (2.78)."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    p, q, r = nu[3], nu[4], nu[5]
    rate[3] = 0.5 * (-x * p - y * q - z * r)
    rate[4] = 0.5 * (w * p - z * q + y * r)
    rate[5] = 0.5 * (z * p + w * q - x * r)
    rate[6] = 0.5 * (-y * p + x * q + w * r)


@inlined
def position_rate(rotation: Array, nu: Array, rate: Array) -> None:
    """Rate of the position from the velocity, into rate[0:3]."""
    for k in range(3):
        rate[k] = rotation[k, 0] * nu[0] + rotation[k, 1] * nu[1] + rotation[k, 2] * nu[2]


@inlined
def normalise_quaternion(state: Array) -> None:
    """Bring the quaternion of a state back to unit length, in place."""
    norm = (state[3] ** 2 + state[4] ** 2 + state[5] ** 2 + state[6] ** 2) ** 0.5
    for k in range(3, 7):
        state[k] /= norm
