"""In which directions a vehicle may have changed, and how far each differs between sound runs."""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.diagnose.coordinates import Coordinate, coordinates
from pipeline.effects.effect import Effect
from pipeline.effects.library import unstated
from pipeline.measured.inject import READINGS
from pipeline.physics.parameters import read
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.schema import Vehicle

#: Shafts that take their time are no force of a known motion.
NOT_ASKED = frozenset({"shaft_inertia"})
#: Effects that change the thrust of all thrusters.
OF_ALL_THRUSTERS = frozenset(
    {"advance_speed_loss", "reverse_thrust", "thrust_deduction", "voltage_sag"}
)
#: Between runs all thrusters, and a single one, differ by a share of what the file says of the
#: thrust; of what no file states a share of half the plausible range is ordinary. A module on
#: board never is, and a cable that nobody stated hardly.
_OF_ALL, _OF_ONE, _UNSTATED, NEVER, _CABLE = 0.75, 0.2, 0.15, 1e-3, 0.03

#: How well a DVL is known to sit and to read, where nothing else is stated.
_MOUNTED = {
    **dict.fromkeys(("x_m", "y_m", "z_m"), 0.05),
    **dict.fromkeys(("roll_deg", "pitch_deg", "yaw_deg"), 0.5),
    "delay_s": 0.02,
    "scale": 0.01,
}
#: Share that a stated lag is known to.
_LAG_SHARE = 0.3


def directions_of(
    vehicle: Vehicle, packed: PackedVehicle, effects: Mapping[str, Effect]
) -> tuple[Coordinate, ...]:
    """List the directions: one a parameter of an effect and thruster.

    What no vehicle file states is ordinary on every vehicle; it is among them and never asked.
    """
    asked = {name: one for name, one in effects.items() if name not in NOT_ASKED}
    asked |= unstated(packed.context)
    uncertainty = model_of(vehicle).uncertainty or Uncertainty()
    # a volume alone is residual buoyancy, and one of the water's weight shows as added mass does
    every = coordinates(packed, asked, uncertainty)
    return tuple(one for one in every if not one.parameter.together_with)


def stated_widths(vehicle: Vehicle, directions: Sequence[Coordinate]) -> FloatArray:
    """By how much each direction differs between runs before any was seen, in its units (d,)."""
    thrust = (model_of(vehicle).uncertainty or Uncertainty()).thrust
    found = []
    for one in directions:
        own = one.ordinary if one.ordinary > 0.0 else _UNSTATED
        if one.effect.id == "tether":
            own = _CABLE
        if one.effect.id == "payload":
            own = NEVER  # what trim is off by stands under residual buoyancy
        if one.effect.id == "thruster_degraded":
            own = max(_OF_ONE * thrust / one.unit_size, NEVER)
        elif one.effect.id in OF_ALL_THRUSTERS:
            own = max(_OF_ALL * thrust / one.unit_size, NEVER)
        found.append(own)
    return np.array(found)


def file_widths(packed: PackedVehicle, directions: Sequence[Coordinate]) -> FloatArray:
    """By how much a vehicle differs from its file along each direction, in its units (d,)."""
    count = len(packed.thruster_names)
    lag_s = float(read(packed.vector, "lag")[:count].mean()) if count else 0.0
    found = []
    for one in directions:
        own = one.ordinary
        if one.effect.id in READINGS:
            own = _MOUNTED[one.parameter.name] / one.unit_size
        if one.effect.id == "thruster_lag":
            own = max(own, _LAG_SHARE * lag_s / one.unit_size)
        found.append(max(own, NEVER))
    return np.array(found)
