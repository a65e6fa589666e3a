r"""Wrench of the thrusters: Kostenko 2023, eq. (5), and the general configuration matrix.

Inside, everything is SNAME (x forward, y starboard, z down). The paper's body frame is x forward,
y up, z starboard, so (X, Y, Z, K, M, N) = (F_x, F_z, -F_y, M_x, M_z, -M_y).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator, Thruster

#: Order of the components of a wrench in SNAME axes.
COMPONENTS = ("X", "Y", "Z", "K", "M", "N")


@dataclass(frozen=True)
class PaperWrench:
    """Forces and moments in the paper's frame, as eq. (5) prints them. [N], [N m]."""

    force_x: FloatArray
    force_y: FloatArray
    force_z: FloatArray
    moment_y: FloatArray
    moment_z: FloatArray

    def to_sname(self) -> FloatArray:
        """Return (X, Y, Z, K, M, N), shape (..., 6). [N], [N m]."""
        zero = np.zeros_like(self.force_x)
        parts = [self.force_x, self.force_z, -self.force_y, zero, self.moment_z, -self.moment_y]
        return np.stack(parts, axis=-1)

    @classmethod
    def from_sname(cls, wrench: FloatArray) -> Self:
        """Map (X, Y, Z, K, M, N), shape (..., 6), to the paper's frame; K is left out."""
        x, y, z, _, m, n = np.moveaxis(np.asarray(wrench, float), -1, 0)
        return cls(force_x=x, force_y=-z, force_z=y, moment_y=-n, moment_z=m)


def paper_wrench(
    stern_thrust_n: FloatArray, allocator: Allocator, bow_thrust_n: FloatArray | float = 0.0
) -> PaperWrench:
    r"""Wrench of four inclined stern thrusters and the bow one, as printed.

    .. math::
        F_x &= (T_u + T_d + T_l + T_r) \cos\delta, &
        F_y &= (T_u - T_d) \sin\delta + T_b, \\
        F_z &= (T_r - T_l) \sin\delta, &
        M_y &= (T_r - T_l) \sin\delta\, L_s, \\
        M_z &= T_b L_b - (T_u - T_d) \sin\delta\, L_s

    Parameters
    ----------
    stern_thrust_n : ndarray, shape (..., 4)
        Upper, lower, left, right. [N]
    allocator : Allocator
        delta, L_s and L_b.
    bow_thrust_n : array_like, shape (...)
        Bow thruster, positive up. [N]

    Returns
    -------
    PaperWrench
        In the paper's frame. [N], [N m]

    References
    ----------
    Kostenko 2023, eq. (5), fig. 8.
    """
    upper, lower, left, right = np.moveaxis(np.asarray(stern_thrust_n, float), -1, 0)
    bow = np.asarray(bow_thrust_n, float)
    delta = np.radians(allocator.delta_deg)
    stern_arm, bow_arm = allocator.stern_arm_m, allocator.bow_arm_m or 0.0
    lateral = (right - left) * np.sin(delta)
    vertical = (upper - lower) * np.sin(delta)
    return PaperWrench(
        force_x=(upper + lower + left + right) * np.cos(delta),
        force_y=vertical + bow,
        force_z=lateral,
        moment_y=lateral * stern_arm,
        moment_z=bow * bow_arm - vertical * stern_arm,
    )


def stern_matrix(allocator: Allocator) -> FloatArray:
    """Matrix of eq. (5) in SNAME axes, shape (6, 5): upper, lower, left, right, bow.

    `stern_matrix(a) @ thrusts` is (X, Y, Z, K, M, N). [N per N, N m per N]
    """
    unit = np.eye(5)
    return paper_wrench(unit[:, :4], allocator, unit[:, 4]).to_sname().T


def configuration_matrix(
    position_m: Sequence[Sequence[float]], direction: Sequence[Sequence[float]]
) -> FloatArray:
    r"""Wrench per newton of any set of thrusters: columns :math:`[d;\ r \times d]`.

    Parameters
    ----------
    position_m, direction : array_like, shape (k, 3)
        Where each thruster sits from the centre of mass [m] and where it pushes (unit), SNAME.

    Returns
    -------
    ndarray, shape (6, k)
        Rows X, Y, Z, K, M, N.

    References
    ----------
    Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. 2021, sec. 9.7
    and 11.2 (thrust configuration matrix).

    Examples
    --------
    A thruster one metre behind the centre of mass that pushes the stern to starboard turns the
    bow to port:

    >>> configuration_matrix([[-1, 0, 0]], [[0, 1, 0]])[:, 0].tolist()
    [0.0, 1.0, 0.0, 0.0, 0.0, -1.0]
    """
    r = np.asarray(position_m, float)
    d = np.asarray(direction, float)
    return np.hstack([d, np.cross(r, d)]).T + 0.0


def thruster_matrix(thrusters: Sequence[Thruster]) -> FloatArray:
    """Build the configuration matrix of thrusters of a vehicle file, shape (6, k)."""
    return configuration_matrix(
        [thruster.position_m for thruster in thrusters],
        [thruster.direction for thruster in thrusters],
    )
