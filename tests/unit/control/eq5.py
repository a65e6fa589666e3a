"""Eq. (5) of Kostenko 2023 by itself, in SNAME axes, for what the allocators are held against."""

import numpy as np

from pipeline.control.allocation import ChannelThrusts
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator


def stern_matrix(allocator: Allocator) -> FloatArray:
    """(6, 5): X, Y, Z, K, M, N of one newton of upper, lower, left, right and bow.

    The paper's F_x, F_y, F_z, M_y, M_z are X, -Z, Y, -N and M here.
    """
    c, s = np.cos(np.radians(allocator.delta_deg)), np.sin(np.radians(allocator.delta_deg))
    arm, bow_arm = s * allocator.stern_arm_m, allocator.bow_arm_m or 0.0
    return np.array(
        [
            [c, c, c, c, 0.0],
            [0.0, 0.0, -s, s, 0.0],
            [-s, s, 0.0, 0.0, -1.0],
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [-arm, arm, 0.0, 0.0, bow_arm],
            [0.0, 0.0, arm, -arm, 0.0],
        ]
    )


def asked_wrench(channels: ChannelThrusts, allocator: Allocator) -> FloatArray:
    """Wrench (..., 6) that thrusts of the channels mean."""
    return np.asarray(channels.stern_thrust_n() @ stern_matrix(allocator)[:, :4].T)
