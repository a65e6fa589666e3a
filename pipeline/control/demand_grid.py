"""The demands (X, M, N) over which the allocator's error map is taken."""

from dataclasses import dataclass

import numpy as np

from pipeline.control.allocation import Demand, ThrustLimits
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator

#: Demands on each axis of the grid.
SURGE_DEMANDS, MOMENT_DEMANDS = 41, 21


@dataclass(frozen=True)
class DemandGrid:
    """Demands on the three axes, SNAME: shapes (s,), (p,), (y,). [N], [N m]."""

    surge_n: FloatArray
    pitch_nm: FloatArray
    yaw_nm: FloatArray

    def open(self) -> Demand:
        """Return the axes shaped to broadcast to (s, p, y)."""
        return Demand(
            self.surge_n[:, None, None], self.pitch_nm[None, :, None], self.yaw_nm[None, None, :]
        )


def demand_grid(allocator: Allocator, rest: ThrustLimits) -> DemandGrid:
    """Demands up to what the form can ask at rest: Pi T_max in "limit", T_max in "scaled".

    Surge has a reach of its own for each sign, as it has a limit; a moment needs both signs of
    thrust at once. An axis without any reach has the one demand zero.

    Parameters
    ----------
    allocator : Allocator
        Geometry, form and portions.
    rest : ThrustLimits
        T_max at rest. [N]
    """
    delta = np.radians(allocator.delta_deg)
    full = allocator.form == "scaled"
    portions = allocator.portions
    moment = 2.0 * np.sin(delta) * allocator.stern_arm_m * rest.both_n
    surge = 4.0 * np.cos(delta) * (1.0 if full else portions.surge)
    pitch = moment * (1.0 if full else portions.pitch)
    yaw = moment * (1.0 if full else portions.heading)
    return DemandGrid(
        _axis(-surge * rest.reverse_n, surge * rest.forward_n, SURGE_DEMANDS),
        _axis(-pitch, pitch, MOMENT_DEMANDS),
        _axis(-yaw, yaw, MOMENT_DEMANDS),
    )


def _axis(least: float, largest: float, count: int) -> FloatArray:
    """Return `count` demands from end to end, zero among them, as even as that allows."""
    if largest <= least:
        return np.zeros(1)
    below = round((count - 1) * -least / (largest - least))
    below = min(max(below, int(least < 0.0)), count - 1 - int(largest > 0.0))
    negative = np.linspace(least, 0.0, below + 1)[:-1]
    return np.concatenate([negative, np.linspace(0.0, largest, count - below)])
