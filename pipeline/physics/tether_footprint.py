r"""The manoeuvring footprint of a tethered vehicle: Kostenko and Mokeeva 2009, Tables 2 and 3.

A vehicle hangs on a neutral cable from a fixed garage, at a given depth below it, anywhere on a
circle, and moves on with a velocity of its own in a current. The cable is solved in the water that
streams past it: at the vehicle by the current less the vehicle's velocity, at the garage by the
current alone. How the vehicle's share falls off in between is an assumption, so there are three:

- ``"paper"``: eq. (1). The flow has one direction everywhere, that at the vehicle; its size falls
  by |V_a| between vehicle and garage, linearly with the ordinate (the distance from the line
  through the garage along that flow). At the garage |V| - |V_a| remains, whatever flows there.
- ``"uniform"``: the flow at the vehicle, everywhere.
- ``"vector"``: the vehicle's velocity, as a vector, falls linearly with the same ordinate; at the
  garage the current remains. The cable leaves its plane.

The paper's frame is X forward, Y up, Z starboard; it is kept in the inputs and results of this file
and mapped to NED (x, z, -y) at the call of the solver.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.tether_cable import Cable, TetherSolution
from pipeline.physics.tether_static import FlowField, solve_tether
from pipeline.types import FloatArray

Variant = Literal["paper", "uniform", "vector"]
VARIANTS: tuple[Variant, ...] = ("paper", "uniform", "vector")

#: The cable of Table 2.
PAPER_CABLE = Cable(200.0, 0.014, 1.8, 0.025)


def largest_pull(on_vehicle_n: FloatArray) -> tuple[float, float, float, float]:
    """Return the largest size of each component and of the whole (Table 4).

    >>> largest_pull(np.array([[-3.0, 4.0, 0.0], [1.0, 2.0, -2.0]]))
    (3.0, 4.0, 2.0, 5.0)
    """
    x, y, z = np.max(np.abs(on_vehicle_n), axis=0)
    whole = np.max(np.linalg.norm(on_vehicle_n, axis=1))
    return float(x), float(y), float(z), float(whole)


def hull_drag_n(
    speed_mps: float, displacement_m3: float, density_kgpm3: float, coefficient: float = 1.0
) -> float:
    r"""Return the hull's drag, eq. (4): :math:`C \rho V^2 U^{2/3} / 2`.

    >>> round(hull_drag_n(1.0, 0.05, 1025.0), 1), round(hull_drag_n(0.5, 0.05, 1025.0), 1)
    (69.6, 17.4)
    """
    return (
        0.5
        * coefficient
        * density_kgpm3
        * speed_mps
        * abs(speed_mps)
        * float(displacement_m3 ** (2 / 3))
    )


@dataclass(frozen=True)
class Footprint:
    """The deployment of Table 2, in the paper's frame; the defaults are the paper's.

    Cable of 200 m and 14 mm, k_n = 1.8, k_tau = 0.025, neutral; `height_m` is Y of the vehicle
    above the garage, Table 2 prints the depth, 50; V_a and V_m. Of the water the paper states no
    density; Tables 5 and 6 follow with 1025.
    """

    cable: Cable = PAPER_CABLE
    radius_m: float = 50.0
    height_m: float = -50.0
    vehicle_velocity_mps: tuple[float, float, float] = (0.5, -0.5, 0.5)
    current_mps: tuple[float, float, float] = (-0.5, 0.0, 0.0)
    density_kgpm3: float = 1025.0

    def position_m(self, angle_deg: float) -> FloatArray:
        """Return the vehicle's place (R sin, Y_a, R cos) at an angle, as in the paper's fig. 3."""
        angle = np.radians(angle_deg)
        return np.array(
            [self.radius_m * np.sin(angle), self.height_m, self.radius_m * np.cos(angle)]
        )


def ned_from_paper(vector: FloatArray) -> FloatArray:
    """Turn vectors of the paper's frame (X forward, Y up, Z starboard) to north, east, down.

    >>> ned_from_paper(np.array([1.0, 2.0, 3.0])).tolist()
    [1.0, 3.0, -2.0]
    """
    return np.stack([vector[..., 0], vector[..., 2], -vector[..., 1]], axis=-1)


def paper_from_ned(vector: FloatArray) -> FloatArray:
    """Turn north, east, down back to the paper's frame.

    >>> paper_from_ned(ned_from_paper(np.array([1.0, 2.0, 3.0]))).tolist()
    [1.0, 2.0, 3.0]
    """
    return np.stack([vector[..., 0], -vector[..., 2], vector[..., 1]], axis=-1)


def footprint_cable(footprint: Footprint, variant: Variant, angle_deg: float) -> TetherSolution:
    """Return the cable's shape and tension, NED, from the vehicle at an angle to the garage.

    Raises
    ------
    CannotComputeError
        From `solve_tether`, e.g. a cable that does not reach; the text begins with the place.
    """
    vehicle = ned_from_paper(footprint.position_m(angle_deg))
    try:
        return solve_tether(
            footprint.cable,
            start_m=vehicle,
            end_m=np.zeros(3),
            flow=_flow(footprint, variant, vehicle),
            density_kgpm3=footprint.density_kgpm3,
        )
    except CannotComputeError as error:
        place = f"angle {angle_deg:g} deg, radius {footprint.radius_m:.4g} m"
        raise CannotComputeError(f"Footprint at {place}: {error}") from error


def _flow(footprint: Footprint, variant: Variant, vehicle: FloatArray) -> FlowField:
    """Return the flow past the cable for one place of the vehicle, all in NED."""
    own = ned_from_paper(np.asarray(footprint.vehicle_velocity_mps, float))
    current = ned_from_paper(np.asarray(footprint.current_mps, float))
    at_vehicle = current - own
    speed = float(np.linalg.norm(at_vehicle))
    if variant == "uniform" or speed == 0.0:
        return lambda position: np.broadcast_to(at_vehicle, position.shape)
    ahead = at_vehicle / speed
    perpendicular = vehicle - (vehicle @ ahead) * ahead
    ordinate = float(perpendicular @ perpendicular)
    if ordinate == 0.0:  # the vehicle lies straight downstream: the ordinate says nothing
        return lambda position: np.broadcast_to(at_vehicle, position.shape)

    def share(position: FloatArray) -> FloatArray:
        """Return 1 at the vehicle's ordinate and 0 at the garage's, shape (n, 1)."""
        return np.asarray(position @ perpendicular / ordinate, dtype=float)[:, None]

    if variant == "vector":
        return lambda position: current - share(position) * own
    own_speed = float(np.linalg.norm(own))
    return lambda position: ahead * (speed - own_speed * (1.0 - share(position)))
