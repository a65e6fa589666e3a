"""The allocator of Kostenko 2023, eq. (6), behind the autopilot of the simulation."""

from dataclasses import dataclass

import numpy as np

from pipeline.control.allocate import allocate
from pipeline.control.allocation import Demand, demanded_channels, within_reach
from pipeline.control.inverse import Inverse, firmware_grid, mooring_cubic
from pipeline.records.fits import InverseCharacteristic
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator, Vehicle


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
    """

    allocator: Allocator
    inverse: Inverse
    thruster_names: tuple[str, ...]
    round_codes: bool = True

    def codes(self, demand: FloatArray, nu_relative: FloatArray) -> tuple[FloatArray, bool]:
        """Codes (n,) for a wrench (6,) at a relative velocity (6,), and whether a limit cut it."""
        codes, _, cut = self.decide(demand, nu_relative)
        return codes, cut

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,), the thrusts (n,) [N] they are meant to give, and whether a limit cut."""
        allocator, speed = self.allocator, float(nu_relative[0])
        heave, pitch, up = 0.0, float(demand[4]), 0.0
        if allocator.bow is not None:
            arms = (allocator.bow_arm_m or 0.0) + allocator.stern_arm_m
            up = (pitch - allocator.stern_arm_m * float(demand[2])) / arms
            stern_up = -float(demand[2]) - up
            heave, pitch = -up, -stern_up * allocator.stern_arm_m
        wanted = Demand(float(demand[0]), pitch, float(demand[5]), heave)
        given = allocate(
            wanted, speed, allocator=allocator, inverse=self.inverse, round_codes=self.round_codes
        )
        reached = within_reach(
            demanded_channels(wanted, allocator), self.inverse.limits(speed), allocator
        )
        rest = self.inverse.limits(0.0)
        cut = not bool(reached) or not -rest.reverse_n <= up <= rest.forward_n
        roles = (allocator.upper, allocator.lower, allocator.left, allocator.right)
        code = dict(zip(roles, given.stern_code.tolist(), strict=True))
        thrust = dict(zip(roles, given.stern_thrust_n.tolist(), strict=True))
        if allocator.bow is not None:
            code[allocator.bow] = float(given.bow_code)
            thrust[allocator.bow] = float(given.bow_thrust_n)
        names = self.thruster_names
        return (
            np.array([code.get(name, 0.0) for name in names]),
            np.array([thrust.get(name, 0.0) for name in names]),
            cut,
        )


def rest_inverse(record: InverseCharacteristic, vehicle: Vehicle) -> Inverse:
    """Return the inverse without speed compensation: eq. (7) from the mooring test.

    Without mooring data it is the row at rest of the firmware grid, used at every speed.

    Parameters
    ----------
    record : InverseCharacteristic
        What the bench gave.
    vehicle : Vehicle
        Of the same bench: dead thrust, range of codes.

    Raises
    ------
    CannotComputeError
        If there is neither.
    """
    cubic = mooring_cubic(
        record,
        thrust_dead_n=vehicle.tables.thrust_dead_n,
        code_max=vehicle.drive.code_max,
        code_min=vehicle.drive.code_min,
    )
    return firmware_grid(record, at_rest=True) if cubic is None else cubic
