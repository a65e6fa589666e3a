"""What the thrusters of a packed vehicle give when settled, over arrays of samples."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.physics.parameters import read, write
from pipeline.simulate.applied_wrench import levers
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def calm_vehicle(packed: PackedVehicle) -> PackedVehicle:
    """Return the vehicle in open water, with thrust that falls with speed as its tables have it.

    Walls are far away, and the inflow of every thruster counts, less its wake fraction: where the
    nominal model leaves it out there would be nothing to compensate.
    """
    vector = packed.vector.copy()
    write(vector, "wall_count", 0.0)
    share = np.zeros_like(read(vector, "inflow_fraction"))
    share[: len(packed.thruster_names)] = packed.context.inflow_shares or 1.0
    write(vector, "inflow_fraction", share)
    return replace(packed, vector=vector)


def inflow_speed(packed: PackedVehicle, nu: FloatArray) -> FloatArray:
    """Speed of the water along each thruster, (k, n), for velocities (k, 6) through the water."""
    # the velocity of a point along a direction is the wrench's transpose: d.(v + w x r)
    return np.asarray(nu @ levers(packed))


def settled_thrust(packed: PackedVehicle, codes: FloatArray, inflow_mps: FloatArray) -> FloatArray:
    """Thrust (k, n) of codes (k, n) at inflow speeds (k, n), as the kernel has it without lag. [N].

    Bilinear in the thrust tables; against the motion the row at rest holds, or the drag where that
    is more. `inflow_mps` is the speed of the water past the hull: what each thruster has of its own
    (wake, gains, dead zone) is taken off here.
    """
    out, count = np.zeros(codes.shape), codes.shape[1]
    lost, largest = (read(packed.vector, slot)[:count] for slot in ("dead_zone", "code_max"))
    left = np.maximum(np.abs(codes) - lost, 0.0) * largest / (largest - lost)
    codes = np.where(lost > 0.0, np.sign(codes) * left, codes)
    kinds = read(packed.vector, "thruster_type")[:count].astype(int)
    ahead, reverse = (read(packed.vector, slot)[:count] for slot in ("thrust_gain", "reverse_gain"))
    at_blades = inflow_mps * read(packed.vector, "inflow_fraction")[:count]
    for kind in np.unique(kinds):
        of_kind = kinds == kind
        for side, sign in ((0, 1.0), (1, -1.0)):
            mask = of_kind[None, :] & ((sign * codes > 0.0) | ((codes == 0.0) & (side == 0)))
            grid = Grid(packed.thrust_tables[kind, side], *packed.steps[kind])
            along = sign * at_blades[mask]
            value = grid.at(np.maximum(along, 0.0), np.abs(codes[mask]))
            drag = np.maximum(-grid.at(np.abs(along), np.zeros(along.shape)), 0.0)
            own = np.broadcast_to(ahead * (reverse if side else 1.0), codes.shape)[mask]
            driven = np.maximum(own * np.maximum(value, 0.0), np.where(along < 0.0, drag, 0.0))
            out[mask] = sign * np.where(value < 0.0, np.maximum(value, -drag), driven)
    return out


@dataclass(frozen=True)
class Grid:
    """Values (rows, columns) on a regular grid from (0, 0); beyond the last row along its slope."""

    values: FloatArray
    row_step: float
    column_step: float

    def at(self, row: FloatArray, column: FloatArray) -> FloatArray:
        """Bilinear values at places in the units of the steps."""
        rows, columns = self.values.shape
        c = np.clip(column / self.column_step, 0.0, columns - 1.0)
        j = np.minimum(c.astype(int), columns - 2)
        c = c - j
        if rows == 1:
            return np.asarray(self.values[0, j] * (1 - c) + self.values[0, j + 1] * c)
        r = np.maximum(row / self.row_step, 0.0)
        i = np.minimum(r.astype(int), rows - 2)
        r = r - i
        low = self.values[i, j] * (1 - c) + self.values[i, j + 1] * c
        high = self.values[i + 1, j] * (1 - c) + self.values[i + 1, j + 1] * c
        return np.asarray(low + r * (high - low))


def thrust_limits(packed: PackedVehicle, speed_mps: float) -> FloatArray:
    """Largest thrust forward and in reverse that each thruster can give at a surge speed. [N].

    Shape (2, n), both positive, at the ends of the codes; against the motion no more is promised
    than along it, as the firmware's limits are. A drive without negative codes gives nothing in
    reverse.
    """
    size = np.abs(inflow_speed(packed, np.eye(6)[:1] * speed_mps))[0]
    codes = packed.code_limits.T.copy()
    reverse, forward = settled_thrust(packed, codes, np.stack([-size, size]))
    return np.asarray(np.maximum(np.stack([forward, -reverse]), 0.0))
