"""What the exported allocator needs of a vehicle: thrusters, matrices, geometry of eq. (6)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pipeline.control.bounded_allocation import Allocation, allocation_of
from pipeline.control.paper_allocator import (
    Corrections,
    corrections_of,
    inflow_of_velocity,
    stern_places,
)
from pipeline.errors import CannotComputeError
from pipeline.records.fits import FirmwareCharacteristic
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.bench_schema import Pwm
from pipeline.vehicle.schema import Allocator, Vehicle

#: Entries of the matrices are Q7.24 in the fixed-point variant.
LARGEST_ENTRY = 127.0
#: An entry of a matrix that should be zero. [-]
_ZERO = 1e-12


@dataclass(frozen=True)
class AllocatorLayout:
    """Thrusters in the order of the vehicle file.

    `direction` (n, 3) unit vectors; `flow` (n, 3) what makes the inflow speed of each of the
    velocity, the direction less its wake fraction; `corrections` what each gives of the tables';
    `largest_n` the unit of the bounded allocation, a power of two [N]; `stern` (4,) and `bow`
    indices into the thrusters, where eq. (6) divides the demand.
    """

    names: tuple[str, ...]
    position_m: FloatArray
    direction: FloatArray
    flow: FloatArray
    corrections: Corrections
    allocation: Allocation
    largest_n: float
    pulses: tuple[Pwm, ...]
    """Of the type of `tables`, then of each of `types`."""
    types: tuple[str, ...] = ()
    """Further types of thruster."""
    volts: tuple[float | None, ...] = ()
    """Of each of `types`: the voltage of its tables [V] where it has some at others, too."""
    kind: tuple[int, ...] = ()
    """Of each thruster: 0 that of `tables`, then places in `types` from 1."""
    code_range: tuple[tuple[int, int], ...] = ()
    """Of each thruster, smallest and largest."""
    paper: Allocator | None = None
    stern: tuple[int, ...] = ()
    bow: int | None = None

    @property
    def count(self) -> int:
        """How many thrusters."""
        return len(self.names)

    @property
    def gain(self) -> FloatArray:
        """Thrust of each over that of the tables, (n, 2): ahead, in reverse."""
        return self.corrections.gain

    @property
    def divisor(self) -> FloatArray:
        """What a thrust is divided by before the tables are asked, (n, 2); 1 of a dead thruster."""
        return np.where(self.gain > 0.0, self.gain, 1.0)

    @property
    def lost_q8(self) -> IntArray:
        """Dead zone of each thruster's own, (n,), in 1/256 of a code."""
        rounded: IntArray = np.rint(256.0 * self.corrections.lost_code).astype(np.int64)
        return rounded

    @property
    def shift(self) -> int:
        """`largest_n` as a power of two."""
        return round(float(np.log2(self.largest_n)))


def allocator_layout(
    vehicle: Vehicle,
    characteristic: FirmwareCharacteristic,
    others: Mapping[str, FirmwareCharacteristic] = MappingProxyType({}),
    several_voltages: Collection[str] = (),
) -> AllocatorLayout:
    """Take the layout from the vehicle file and the grid of the type of `tables`.

    `others` are the grids of its further types, `several_voltages` those of them that have tables
    at several supply voltages.

    Raises
    ------
    CannotComputeError
        When the tables do not hold for one of the thrusters, or a matrix does not fit the formats.
    """
    if not vehicle.thrusters:
        raise CannotComputeError("vehicle.yaml names no thrusters, so there is no allocator.")
    types = ("", *others)
    kinds: list[int] = []
    for one in vehicle.thrusters:
        of_type = vehicle.type_of(one)
        if of_type not in types:
            there = "; ".join(f"{drive} and {propeller}" for drive, propeller in vehicle.kinds)
            raise CannotComputeError(
                f"There is no allocator: thruster {one.name} has drive {one.drive} and propeller "
                f"{one.propeller}, and the tables are for {there}."
            )
        kinds.append(types.index(of_type))
    names = tuple(one.name for one in vehicle.thrusters)
    position = np.array([one.position_m for one in vehicle.thrusters], float)
    direction = np.array([one.direction for one in vehicle.thrusters], float)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    corrections = corrections_of(vehicle)
    gain = corrections.gain
    # a dead thruster is left out of every demand
    alive = np.any(gain > 0.0, axis=1).astype(float)
    clean = np.where(np.abs(direction) < _ZERO, 0.0, direction)
    allocation = allocation_of(position, clean * alive[:, None])
    for what, values in (("inverse", allocation.inverse), ("scale", allocation.scale)):
        if np.abs(values).max() > LARGEST_ENTRY:
            raise CannotComputeError(
                f"There is no allocator: the {what} of the configuration matrix has an entry of "
                f"{np.abs(values).max():.0f}, at most {LARGEST_ENTRY:.0f} is expected. Are the "
                "thrusters' positions in metres? Do two of them lie almost in one place?"
            )
    largest = [
        (max(one.positive.thrust_max_n), max(one.negative.thrust_max_n))
        for one in (characteristic, *others.values())
    ]
    strongest = float((gain * np.array(largest)[kinds]).max())
    geometry = vehicle.allocator
    return AllocatorLayout(
        names=names,
        position_m=position,
        direction=direction,
        flow=inflow_of_velocity(vehicle),
        corrections=corrections,
        allocation=allocation,
        largest_n=2.0 ** max(int(np.ceil(np.log2(strongest))), 0),
        pulses=tuple(vehicle.of_type(one).columns.mooring.pwm_range for one in types),
        types=tuple(others),
        volts=tuple(
            made.supply_voltage_v if one in several_voltages else None
            for one, made in others.items()
        ),
        kind=tuple(kinds),
        code_range=tuple(
            (vehicle.drives[one.drive].code_min, vehicle.drives[one.drive].code_max)
            for one in vehicle.thrusters
        ),
        paper=geometry,
        stern=() if geometry is None else tuple(stern_places(geometry, names)),
        bow=names.index(geometry.bow) if geometry is not None and geometry.bow else None,
    )


@dataclass(frozen=True)
class PaperConstants:
    """Constants of eqs. (5) and (6) as the C code holds them.

    `surge` and `moment` make the thrust of each stern thruster from a force [N] and a moment
    [N m]; `bow_share` = 1 / (L_s + L_b) divides heave and pitch between bow and stern.
    """

    surge: float
    moment_1pm: float
    stern_arm_m: float
    bow_share_1pm: float
    portions: tuple[float, float, float]
    """Of surge, heading, pitch."""

    @classmethod
    def of(cls, geometry: Allocator) -> "PaperConstants":
        """Work them out."""
        delta = np.radians(geometry.delta_deg)
        portions = geometry.portions
        return cls(
            surge=float(1.0 / (4.0 * np.cos(delta))),
            moment_1pm=float(1.0 / (2.0 * geometry.stern_arm_m * np.sin(delta))),
            stern_arm_m=geometry.stern_arm_m,
            bow_share_1pm=1.0 / ((geometry.bow_arm_m or 0.0) + geometry.stern_arm_m),
            portions=(portions.surge, portions.heading, portions.pitch),
        )
