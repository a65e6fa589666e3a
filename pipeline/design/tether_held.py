"""The footprint that a vehicle can hold on its cable with its identified thrusters."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from pipeline.design.tether_input import TetherInput
from pipeline.design.tether_thrusters import MOST_USE, HeldVehicle
from pipeline.errors import CannotComputeError
from pipeline.physics.tether_footprint import Footprint, footprint_cable, ned_from_paper
from pipeline.records.design import HeldFootprint
from pipeline.types import FloatArray

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
