r"""What a vehicle's thrusters can hold: the smallest largest use over all allocations.

For thrusts f that make the wanted forces and yawing moment, B f = w, the least t with
:math:`-t\,F^-_i \le f_i \le t\,F^+_i` is a linear programme (scipy `linprog`, HiGHS). Up to t = 1
the vehicle holds; its largest force in that direction is w / t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linprog

from pipeline.physics.parameters import read
from pipeline.types import FloatArray

if TYPE_CHECKING:
    from pipeline.simulate.pack import PackedVehicle

#: Stands for a use without bound: the thrusters cannot push there at all.
MOST_USE = 1e3


@dataclass(frozen=True)
class HeldVehicle:
    """A vehicle, packed, with the hull forces and the buoyancy of its file.

    `linear`, `quadratic` (3,) along body x, y, z; `buoyancy_n` residual, up; `heading_rad` from
    north; `attachment_m` (3,) of the cable, body axes.
    """

    packed: PackedVehicle
    linear: FloatArray
    quadratic: FloatArray
    buoyancy_n: float
    heading_rad: float
    attachment_m: FloatArray

    def to_body(self, ned: FloatArray) -> FloatArray:
        """Turn a NED vector into body axes; the vehicle is level."""
        c, s = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return np.array([c * ned[0] + s * ned[1], -s * ned[0] + c * ned[1], ned[2]])

    def drag_n(self, velocity_body: FloatArray) -> FloatArray:
        """Force of the water on the hull at a velocity through the water, body axes. [N]."""
        return -(self.linear + self.quadratic * np.abs(velocity_body)) * velocity_body

    def limits_n(self, velocity_body: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest thrust of each thruster along and against its direction. [N].

        Beyond the last speed of its table the thrust goes on falling, as it does in simulation.
        """
        packed = self.packed
        count = len(packed.thruster_names)
        kinds = read(packed.vector, "thruster_type")[:count].astype(int)
        direction = read(packed.vector, "thruster_direction")[:count]
        share = read(packed.vector, "inflow_fraction")[:count]
        inflow = share * (direction @ velocity_body)
        limits = np.zeros((2, count))
        for i, kind in enumerate(kinds):
            for side, sign in ((0, 1.0), (1, -1.0)):
                column = packed.thrust_tables[kind, side, :, :]
                code = abs(packed.code_limits[i, 1 - side])
                at = np.arange(column.shape[1]) * packed.steps[kind, 1]
                by_speed = np.array([np.interp(code, at, row) for row in column])
                speeds = np.arange(column.shape[0]) * packed.steps[kind, 0]
                along = max(sign * float(inflow[i]), 0.0)
                value = float(np.interp(along, speeds, by_speed))
                if along > speeds[-1] and speeds.size > 1:
                    slope = (by_speed[-1] - by_speed[-2]) / (speeds[-1] - speeds[-2])
                    value += float(slope) * (along - float(speeds[-1]))
                limits[side, i] = max(value, 0.0)
        return limits[0], limits[1]

    def use(self, force_body: FloatArray, yaw_nm: float, velocity_body: FloatArray) -> float:
        """Least share of the thrusters that makes a force [N] and a yawing moment [N m]."""
        packed = self.packed
        count = len(packed.thruster_names)
        direction = read(packed.vector, "thruster_direction")[:count]
        position = read(packed.vector, "thruster_position")[:count]
        yaw = position[:, 0] * direction[:, 1] - position[:, 1] * direction[:, 0]
        wanted = np.array([*force_body, yaw_nm])
        scale = float(np.abs(wanted).max())
        if scale < 1e-9:
            return 0.0
        ahead, astern = self.limits_n(velocity_body)
        matrix = np.column_stack([np.vstack([direction.T, yaw]), np.zeros(4)])
        above = np.column_stack([np.eye(count), -ahead])
        below = np.column_stack([-np.eye(count), -astern])
        found = linprog(
            np.append(np.zeros(count), 1.0),
            A_ub=np.vstack([above, below]),
            b_ub=np.zeros(2 * count),
            A_eq=matrix,
            b_eq=wanted / scale,
            bounds=[(None, None)] * count + [(0, None)],
            method="highs",
        )
        if found.status != 0 or found.x is None:
            return MOST_USE
        return float(min(found.x[-1] * scale, MOST_USE))

    def required(
        self, cable_ned: FloatArray, velocity_ned: FloatArray
    ) -> tuple[FloatArray, float, FloatArray]:
        """Thrust (3,) and yawing moment that hold cable, drag and buoyancy; velocity, body."""
        velocity = self.to_body(velocity_ned)
        cable = self.to_body(cable_ned)
        buoyancy = np.array([0.0, 0.0, -self.buoyancy_n])
        yaw = self.attachment_m[0] * cable[1] - self.attachment_m[1] * cable[0]
        return -(cable + self.drag_n(velocity) + buoyancy), -float(yaw), velocity

    def largest_forces_n(self) -> tuple[float, ...]:
        """Largest thrust at rest: forward, backward, up, down, starboard, port. [N]."""
        found = []
        for axis, sign in ((0, 1), (0, -1), (2, -1), (2, 1), (1, 1), (1, -1)):
            unit = np.zeros(3)
            unit[axis] = float(sign)
            use = self.use(unit, 0.0, np.zeros(3))
            found.append(0.0 if use >= MOST_USE else 1.0 / use)
        return tuple(found)
