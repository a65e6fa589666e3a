r"""What a vehicle's identified thrusters can hold, and the footprint that it holds on its cable.

For thrusts f that make the wanted forces and yawing moment, B f = w, the least t with
:math:`-t\,F^-_i \le f_i \le t\,F^+_i` is a linear programme (scipy `linprog`, HiGHS). Up to t = 1
the vehicle holds; its largest force in that direction is w / t.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq, linprog

from pipeline.design.tether_input import TetherInput
from pipeline.errors import CannotComputeError
from pipeline.physics.tether_footprint import Footprint, footprint_cable, ned_from_paper
from pipeline.records.design import HeldFootprint
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
        """Largest thrust of each thruster along and against its direction. [N]."""
        from pipeline.simulate.applied_wrench import inflow_speed, settled_thrust

        nu = np.concatenate([velocity_body, np.zeros(3)])
        ends = settled_thrust(self.packed, self.packed.code_limits.T, inflow_speed(self.packed, nu))
        return np.maximum(ends[1], 0.0), np.maximum(-ends[0], 0.0)

    def use(self, force_body: FloatArray, yaw_nm: float, velocity_body: FloatArray) -> float:
        """Least share of the thrusters that makes a force [N] and a yawing moment [N m]."""
        from pipeline.simulate.applied_wrench import levers

        count = len(self.packed.thruster_names)
        wanted = np.array([*force_body, yaw_nm])
        scale = float(np.abs(wanted).max())
        if scale < 1e-9:
            return 0.0
        ahead, astern = self.limits_n(velocity_body)
        matrix = np.column_stack([levers(self.packed)[[0, 1, 2, 5]], np.zeros(4)])
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


RADII = 7
#: The outermost radius as a share of the cable's reach: beyond, a taut cable pulls without bound.
SHARE_OF_REACH = 0.98
#: A flow so slow that no thruster feels it, as a share of the one asked for.
SLOWEST_SHARE = 1e-3
#: Radius next to the middle, as a share of the first one: in the middle itself there is no angle.
INNERMOST = 1e-2


def held_footprint(
    one: TetherInput, footprint: Footprint, held: HeldVehicle, angles_deg: Sequence[float]
) -> HeldFootprint:
    """Return the use of the thrusters over angle and radius, and the radius that is held.

    Held from the centre outwards: the radius at which the use first passes 1.

    Raises
    ------
    CannotComputeError
        When the water alone is more than the thrusters hold; the text has the speed that they do.
    """
    through = ned_from_paper(np.array(one.vehicle_velocity_mps) - np.array(one.current_mps))
    _refuse_too_strong(held, through)
    length = one.cable.length_m
    reach = float(np.sqrt(max(length**2 - one.footprint.height_m**2, 0.0)))
    stated = one.held.largest_radius_m if one.held is not None else None
    ends_with_cable = stated is None or stated >= SHARE_OF_REACH * reach
    outer = SHARE_OF_REACH * reach if ends_with_cable or stated is None else stated
    radii = np.linspace(outer / RADII, outer, RADII)
    use = np.zeros((len(angles_deg), RADII))
    edge: list[float] = []
    limit: list[str] = []
    for i, angle in enumerate(angles_deg):

        def over(radius: float, angle: float = angle) -> float:
            at = replace(footprint, radius_m=float(radius))
            pull = footprint_cable(at, one.flow, angle).force_on_start_n
            return held.use(*held.required(pull, through)) - 1.0

        use[i] = [over(r) + 1.0 for r in radii]
        beyond = np.flatnonzero(use[i] > 1.0)
        if not beyond.size:
            edge.append(float(outer))
            limit.append("cable" if ends_with_cable else "largest radius asked for")
            continue
        limit.append("thrusters")
        k = int(beyond[0])
        if k == 0:
            edge.append(_edge_within(over, float(radii[0])))
        else:
            edge.append(float(brentq(over, radii[k - 1], radii[k], xtol=5e-3 * outer)))
    return HeldFootprint(
        vehicle=held.packed.name,
        variant=one.flow,
        angle_deg=tuple(float(a) for a in angles_deg),
        radius_m=tuple(float(r) for r in radii),
        use=tuple(tuple(float(v) for v in row) for row in use),
        held_radius_m=tuple(edge),
        limit=tuple(limit),
        largest_force_n=held.largest_forces_n(),
    )


def _edge_within(over: Callable[[float], float], first_m: float) -> float:
    """Return the radius that is held where the first one is not; 0 if none is. [m]."""
    inner_m = INNERMOST * first_m
    try:
        if over(inner_m) > 0.0:
            return 0.0
        return float(brentq(over, inner_m, first_m, xtol=inner_m))
    except CannotComputeError:  # a slack cable has no equilibrium there
        return 0.0


def _refuse_too_strong(held: HeldVehicle, through_ned: FloatArray) -> None:
    """Refuse a flow that the hull alone cannot be held in."""
    none = np.zeros(3)

    def use(scale: float) -> float:
        return held.use(*held.required(none, scale * through_ned))

    if use(1.0) <= 1.0:
        return
    name, speed = held.packed.name, float(np.linalg.norm(through_ned))
    if use(0.0) > 1.0:
        raise CannotComputeError(
            f"The thrusters of {name} do not even hold its residual buoyancy of "
            f"{held.buoyancy_n:.3g} N at rest.\nBallast the vehicle, or check its thrusters."
        )
    # at a crawl: in a fast flow a thruster gives nothing, whichever side it comes from
    if use(SLOWEST_SHARE) >= MOST_USE:
        raise CannotComputeError(
            f"The thrusters of {name} cannot push against a flow from that side without turning "
            "the vehicle: whatever the current, it holds 0 m/s there.\nHead it into the flow "
            "(held.heading_deg)."
        )
    scale = float(brentq(lambda s: use(s) - 1.0, 0.0, 1.0, xtol=1e-4))
    raise CannotComputeError(
        f"Current and own speed make {speed:.3g} m/s through the water, and without any cable the "
        f"thrusters of {name} hold {scale * speed:.3g} m/s in that direction.\nTake a weaker "
        "current, a lower speed, or another heading (held.heading_deg)."
    )
