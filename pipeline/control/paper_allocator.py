"""The allocator of Kostenko 2023, eq. (6), behind the autopilot of the simulation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.control.allocation import (
    ChannelThrusts,
    Demand,
    ThrustLimits,
    beyond_dead_zone,
    demanded_channels,
    limited_channels,
    within_reach,
)
from pipeline.control.inverse import CodeRange, Inverse, firmware_grid, mooring_cubic, rounded
from pipeline.records.fits import InverseCharacteristic
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator, Vehicle

#: A thruster with less of its thrust than this is not asked for any.
_LEAST_GAIN = 0.01


def stern_places(geometry: Allocator, names: Sequence[str]) -> list[int]:
    """Places of the upper, lower, left and right thruster among `names`."""
    roles = (geometry.upper, geometry.lower, geometry.left, geometry.right)
    return [names.index(role) for role in roles]


def divided(geometry: Allocator, demand: FloatArray) -> tuple[ChannelThrusts, float]:
    """Divide a wrench (6,) by eqs. (5) and (6): channels of the stern, thrust of the bow up [N]."""
    pitch, up = float(demand[4]), 0.0
    if geometry.bow is not None:
        arms = (geometry.bow_arm_m or 0.0) + geometry.stern_arm_m
        up = (pitch - geometry.stern_arm_m * float(demand[2])) / arms
        stern_up = -float(demand[2]) - up
        pitch = -stern_up * geometry.stern_arm_m
    return demanded_channels(Demand(float(demand[0]), pitch, float(demand[5])), geometry), up


@dataclass(frozen=True)
class PaperAllocator:
    """Eq. (6) for four stern thrusters and a bow one, in the order of the vehicle's thrusters.

    Eq. (6) leaves heave out and does not take back the pitch moment of the bow thruster. Heave and
    pitch of a demand are therefore first divided between bow and stern by eq. (5): with q the
    stern's upward force,

        T_b + q = -Z,    T_b L_b - q L_s = M

    and the stern is asked for the moment -q L_s, the bow for T_b. A bow thruster without a stated
    arm is taken to make no moment, as in eq. (5) here. Sway and roll are out of reach, and without
    a bow thruster heave as well. They are left out and not said to be cut: they always would be,
    and the autopilot stops its integrals while a demand is cut.

    With `direction` (n, 3) every thruster is taken at the inflow along it (its length less than 1
    in the wake), as the exported allocator does; without, the stern ones at V_x as in the paper and
    the bow one at rest. `corrections` are those of `corrections_of`. `others` are the inverses of
    thrusters of another type than that of `inverse`, by their place.
    """

    allocator: Allocator
    inverse: Inverse
    thruster_names: tuple[str, ...]
    round_codes: bool = True
    direction: FloatArray | None = None
    corrections: "Corrections | None" = None
    others: Mapping[int, Inverse] = field(default_factory=dict)

    def along(self, nu_relative: FloatArray) -> FloatArray:
        """Speed at which each thruster is taken, (n,). [m/s]."""
        if self.direction is not None:
            return np.asarray(self.direction @ nu_relative[:3])
        a = self.allocator
        stern = [name in {a.upper, a.lower, a.left, a.right} for name in self.thruster_names]
        return np.where(stern, float(nu_relative[0]), 0.0)

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,), the thrusts (n,) [N] they are meant to give, and whether a limit cut."""
        a, names = self.allocator, self.thruster_names
        along, own = self.along(nu_relative), self.corrections or Corrections.none(len(names))
        gain = own.gain
        found = [self.others.get(i, self.inverse).limits(float(v)) for i, v in enumerate(along)]
        low = -np.array([one.reverse_n for one in found]) * gain[:, 1]
        high = np.array([one.forward_n for one in found]) * gain[:, 0]
        stern = stern_places(a, names)
        limits = ThrustLimits(float(high[stern].min()), float(-low[stern].max()))
        channels, up = divided(a, demand)
        thrust = np.zeros(len(names))
        thrust[stern] = limited_channels(channels, limits, a).stern_thrust_n()
        cut = not bool(within_reach(channels, limits, a))
        if a.bow is not None:
            bow = names.index(a.bow)
            thrust[bow] = min(max(up, low[bow]), high[bow])
            cut = cut or not low[bow] <= up <= high[bow]
        asked = thrust / own.divisor(thrust)
        code = self.inverse.code(asked, along)
        for i, other in self.others.items():
            code[i] = other.code(asked[i], along[i])
        code = beyond_dead_zone(code, own.lost_code, own.code_max)
        return rounded(code) if self.round_codes else code, thrust, cut


@dataclass(frozen=True)
class Corrections:
    """What each thruster gives of that of the tables, `gain` (n, 2) ahead and in reverse.

    Thrust deduction included; 0 for a dead one. `lost_code`, `code_max` (n,): its own dead zone,
    and the largest code.
    """

    gain: FloatArray
    lost_code: FloatArray
    code_max: FloatArray

    @classmethod
    def none(cls, count: int) -> "Corrections":
        """Return those of thrusters that are as the tables say."""
        return cls(np.ones((count, 2)), np.zeros(count), np.ones(count))

    def divisor(self, thrust_n: FloatArray) -> FloatArray:
        """Return what thrusts (..., n) are divided by before the tables are asked."""
        gain = np.where(thrust_n < 0.0, self.gain[:, 1], self.gain[:, 0])
        return np.where(gain > 0.0, gain, 1.0)


def corrections_of(vehicle: Vehicle) -> Corrections:
    """Take the corrections of a vehicle's thrusters from its file."""
    every = vehicle.thrusters
    gain = np.array([(one.gain_ahead, one.gain_reverse) for one in every], float).reshape(-1, 2)
    if vehicle.model is not None:
        deduction = np.array([vehicle.model.thrust_deduction.of(one.name) for one in every])
        gain *= 1.0 - deduction[:, None]
    return Corrections(
        np.where(gain < _LEAST_GAIN, 0.0, gain),
        np.array([one.dead_zone_code for one in every], float),
        np.array([vehicle.drives[one.drive].code_max for one in every], float),
    )


def inflow_of_velocity(vehicle: Vehicle) -> FloatArray:
    """(n, 3): what makes the inflow speed of each thruster of u, v, w, wake fraction included."""
    direction = np.array([one.direction for one in vehicle.thrusters], float)
    unit = direction / np.linalg.norm(direction, axis=1)[:, None]
    if vehicle.model is None:
        return np.asarray(unit)
    wake = [vehicle.model.wake_fraction.of(one.name) for one in vehicle.thrusters]
    return np.asarray((1.0 - np.array(wake))[:, None] * unit)


def other_inverses(
    vehicle: Vehicle,
    records: Mapping[str, InverseCharacteristic],
    form: Callable[[InverseCharacteristic, Vehicle], Inverse],
) -> dict[int, Inverse]:
    """Return the inverse of each thruster of a further type, by its place.

    `records` by type of thruster, of one that has none `tables` holds; `form` makes an inverse of a
    record and of what `Vehicle.of_type` returns.
    """
    made = {name: form(record, vehicle.of_type(name)) for name, record in records.items() if name}
    types = enumerate(vehicle.type_of(one) or "" for one in vehicle.thrusters)
    return {i: made[name] for i, name in types if name in made}


def rest_inverse(record: InverseCharacteristic, vehicle: Vehicle) -> Inverse:
    """Return the inverse without speed compensation: eq. (7) from the mooring test.

    Without mooring data it is the row at rest of the firmware grid, used at every speed. The
    vehicle of the same bench gives dead thrust and range of codes.

    Raises
    ------
    CannotComputeError
        If there is neither.
    """
    cubic = mooring_cubic(record, CodeRange.of(vehicle))
    return firmware_grid(record, at_rest=True) if cubic is None else cubic
