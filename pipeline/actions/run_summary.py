"""A simulated run in a few numbers, and what should make one doubt it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.control.allocation import at_limit
from pipeline.physics.parameters import read
from pipeline.simulate.events import LatchLoad
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.simulate.sensors import Log
from pipeline.simulate.tethered_mover import TetherLog
from pipeline.types import FloatArray

Range = tuple[float, float]


@dataclass(frozen=True)
class RunSummary:
    """Ranges over the run; `channels` counts the readings of each sensor."""

    duration_s: float
    surge_mps: Range
    depth_m: Range
    tilt_deg: float
    largest_code: float
    at_limit_share: float
    channels: dict[str, int]
    doubts: tuple[str, ...]


@dataclass(frozen=True)
class TetherSummary:
    """A tether's run: tension at both ends, cable paid out. [N], [m]."""

    tension_at_vehicle_n: Range
    tension_at_top_n: Range
    paid_out_m: Range


def summarise_tether(tether: TetherLog) -> TetherSummary:
    """Sum up what a tether did."""
    ends = (tether.lower_tension_n, tether.top_tension_n, tether.paid_out_m)
    return TetherSummary(*map(_range, ends))


def latch_doubts(loads: Sequence[LatchLoad]) -> list[str]:
    """Say which latches would have failed."""
    return [
        f"the latch of {load.module} carried {load.largest_share:.2f} of its strength; it would "
        "have let go, which is not simulated."
        for load in loads
        if load.largest_share > 1.0
    ]


def summarise(
    trajectory: Trajectory, log: Log, packed: PackedVehicle, vector: FloatArray
) -> RunSummary:
    """Sum up the true motion of a run, at its parameter `vector`, and what was measured of it."""
    x, y = trajectory.quaternion[:, 1], trajectory.quaternion[:, 2]
    # angle between body z and down: R_33 of the rotation
    tilt = np.degrees(np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0)))
    ends = at_limit(trajectory.command, *packed.code_limits.T)
    depth = trajectory.position_ned_m[:, 2]
    return RunSummary(
        duration_s=float(trajectory.time_s[-1] - trajectory.time_s[0]),
        surge_mps=_range(trajectory.nu[:, 0]),
        depth_m=_range(depth),
        tilt_deg=float(tilt.max()),
        largest_code=float(np.abs(trajectory.command).max(initial=0.0)),
        at_limit_share=float(ends.any(axis=1).mean()),
        channels={name: int(channel.valid_s.size) for name, channel in log.items()},
        doubts=tuple(_doubts(trajectory, tilt, packed, vector)),
    )


def _range(values: FloatArray) -> Range:
    return float(values.min()), float(values.max())


def _doubts(
    trajectory: Trajectory, tilt: FloatArray, packed: PackedVehicle, vector: FloatArray
) -> list[str]:
    """Say where the run left what the model holds for."""
    doubts = []
    above = float(-trajectory.position_ned_m[:, 2].min())
    if above > 0.0:
        doubts.append(f"the vehicle rose {above:.2f} m above the surface, which is not modelled.")
    count = int(read(vector, "wall_count"))
    points, normals = read(vector, "wall_point")[:count], read(vector, "wall_normal")[:count]
    away = np.einsum("kij,ij->ki", trajectory.position_ned_m[:, None, :] - points[None], normals)
    if count and away.min() < 0.0:
        doubts.append(
            f"the vehicle went {-away.min():.2f} m through a wall or the bottom, which do not stop "
            "it; choose a smaller --amplitude or a shorter --duration."
        )
    if tilt.max() > 60.0:
        doubts.append(
            f"the vehicle tilted by {tilt.max():.0f} deg: near 90 deg heading and pitch lose their "
            "meaning for the autopilot."
        )
    beyond = _beyond_tables(trajectory, packed)
    if beyond:
        doubts.append(beyond)
    return doubts


def _beyond_tables(trajectory: Trajectory, packed: PackedVehicle) -> str:
    """Tell when the inflow of a working thruster exceeded the fastest row of its table."""
    count = len(packed.thruster_names)
    if not count or packed.thrust_tables.shape[2] < 2:
        return ""
    direction = read(packed.vector, "thruster_direction")[:count]
    kinds = read(packed.vector, "thruster_type")[:count].astype(int)
    share = read(packed.vector, "inflow_fraction")[:count]
    along = trajectory.nu[:, :3] @ direction.T * np.sign(trajectory.actuator) * share
    last = (packed.thrust_tables.shape[2] - 1) * packed.steps[kinds, 0]
    over = along - last
    if over.max() <= 0.0:
        return ""
    return (
        f"the inflow of a thruster exceeded the fastest speed of its tables by {over.max():.2f} "
        "m/s; there its thrust goes on falling along a line."
    )
