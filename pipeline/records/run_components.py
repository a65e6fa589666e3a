"""The components of a run that are compared, measured with simulated.

Attitude is compared as roll, pitch and yaw, which a person can read; everything else as it is.
"""

import numpy as np

from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Quantity -> name and unit of each component that is compared; shaft speeds are named by thruster.
COMPONENTS: dict[str, tuple[tuple[str, str], ...]] = {
    "velocity": (("u", "m/s"), ("v", "m/s"), ("w", "m/s")),
    "angular_velocity": (("p", "rad/s"), ("q", "rad/s"), ("r", "rad/s")),
    "attitude": (("phi", "rad"), ("theta", "rad"), ("psi", "rad")),
    "depth": (("depth", "m"),),
    "position": (("north", "m"), ("east", "m"), ("down", "m")),
    "specific_force": (("fx", "m/s^2"), ("fy", "m/s^2"), ("fz", "m/s^2")),
    "shaft_speed": (),
    "voltage": (("supply", "V"),),
}


def angles(quaternion: FloatArray) -> FloatArray:
    """Roll, pitch, yaw (m, 3) of quaternions (m, 4), not a number where they are not. [rad]."""
    found = np.full((len(quaternion), 3), np.nan)
    there = np.isfinite(quaternion).all(axis=1) & (np.abs(quaternion).sum(axis=1) > 0)
    if there.any():
        # a second of processor, which whoever reads a record has no use for
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_quat(quaternion[there][:, [1, 2, 3, 0]])
        found[there] = turn.as_euler("ZYX")[:, ::-1]
    return found


def down_axis(quaternion: FloatArray) -> FloatArray:
    """Down in body axes (m, 3), the last row of the rotation matrix, of quaternions (m, 4)."""
    w, x, y, z = quaternion.T
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)


def quaternion_product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Product p q (m, 4) of quaternions w, x, y, z (m, 4); one of them may be a single one (4,)."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def components(table: RunTable, quantity: str) -> FloatArray:
    """Values (m, k) of what is compared; attitude as angles."""
    values = table.values[quantity]
    return angles(values) if quantity == "attitude" else values


def difference(quantity: str, measured: FloatArray, simulated: FloatArray) -> FloatArray:
    """Measured less simulated; angles by the shorter way."""
    gap = measured - simulated
    return np.asarray((gap + np.pi) % (2 * np.pi) - np.pi) if quantity == "attitude" else gap
