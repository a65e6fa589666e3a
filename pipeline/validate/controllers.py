"""The allocators that fly a vehicle: with the mooring inverse, compensated, and with changes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from pipeline.control.allocation import ThrustLimits
from pipeline.control.bounded_allocation import GeneralAllocator
from pipeline.control.inverse import (
    FirmwareGrid,
    Inverse,
    firmware_grid,
    speed_cubic,
)
from pipeline.control.paper_allocator import Corrections, PaperAllocator, divided, stern_places
from pipeline.errors import CannotComputeError
from pipeline.export import fixed_point
from pipeline.export.fixed_point import Q16_ONE, FixedTables, fixed_tables
from pipeline.export.grid_check import check_characteristic
from pipeline.records.fits import InverseCharacteristic
from pipeline.simulate.applied_wrench import inflow_speed, levers, settled_thrust
from pipeline.simulate.fly import CodeAllocator, general_allocator
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import ArrayLike, BoolArray, FloatArray
from pipeline.validate.plan import SURGE_PORTIONS, thrust_limits
from pipeline.vehicle.schema import Allocator, Portions

#: Limits are worked out once for each step of speed. [m/s]
_SPEED_STEP = 1e-3


@dataclass(frozen=True)
class Remembered:
    """An inverse whose limits are kept for speeds to the millimetre per second: they are slow."""

    inverse: Inverse
    _limits: dict[int, ThrustLimits] = field(default_factory=dict, init=False, repr=False)

    @property
    def name(self) -> str:
        """That of the inverse within."""
        return self.inverse.name

    def limits(self, speed_mps: float) -> ThrustLimits:
        """Limits at the nearest millimetre per second."""
        key = round(speed_mps / _SPEED_STEP)
        if key not in self._limits:
            self._limits[key] = self.inverse.limits(key * _SPEED_STEP)
        return self._limits[key]

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Return that of the inverse within."""
        return self.inverse.code(thrust_n, speed_mps)


@dataclass(frozen=True)
class FixedPoint:
    """The firmware's fixed-point code, bit for bit: whole codes, limits as the C functions say."""

    tables: FixedTables
    floating: Inverse
    """For the limits against the motion, which the C code leaves to its caller."""
    name: str = "firmware grid in fixed point"

    def limits(self, speed_mps: float) -> ThrustLimits:
        """Limits of the grid."""
        return self.floating.limits(speed_mps)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Whole codes."""
        thrust = np.rint(np.asarray(thrust_n, float) * Q16_ONE).astype(np.int64)
        speed = np.rint(np.asarray(speed_mps, float) * Q16_ONE).astype(np.int64)
        codes = fixed_point.code_from_thrust(self.tables, np.atleast_1d(thrust), speed)
        return codes.reshape(thrust.shape).astype(float)


#: Of further types of thruster, where there are none.
_NONE: Mapping[int, Inverse] = MappingProxyType({})
_NO_MOORING = (
    "There is no mooring test: the flights without compensation use the row at rest of the "
    "calculated N(T, V)."
)


@dataclass(frozen=True)
class Controllers:
    """Everyone who may fly a vehicle.

    `thrust_of_wrench` (n, 6): how a unit of each axis is shared out. `settings` and `portioned`
    are the compensated allocator with one thing changed.
    """

    mooring: CodeAllocator
    compensated: CodeAllocator
    mooring_name: str
    compensated_name: str
    thrust_of_wrench: FloatArray
    settings: tuple[tuple[str, CodeAllocator], ...] = ()
    portioned: tuple[tuple[Portions, CodeAllocator], ...] = ()
    explanations: tuple[str, ...] = ()
    fixed: FixedPoint | None = None


@dataclass(frozen=True)
class GeneralDecide:
    """The general allocator with its inverse at rest, or with inverse and limits at the inflow.

    `gives` (2, n): whether a thruster gives thrust ahead and in reverse at all. Where it does not,
    its limit is that of `base`, which leaves its share of a demand out.
    """

    packed: PackedVehicle
    base: GeneralAllocator
    compensated: bool
    gives: BoolArray

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """As `GeneralAllocator.decide`."""
        if not self.compensated:
            return self.base.decide(demand, np.zeros(6))
        inflow = inflow_speed(self.packed, nu_relative)
        ends = settled_thrust(self.packed, self.packed.code_limits.T, inflow)
        ahead, astern = self.gives
        limits = (
            np.where(astern, np.minimum(ends[0], -1e-9), self.base.smallest_n),
            np.where(ahead, np.maximum(ends[1], 1e-9), self.base.largest_n),
        )
        return self.base.decide(demand, nu_relative, limits)


def general_controllers(packed: PackedVehicle) -> Controllers:
    """Return the general allocator at rest and compensated; any arrangement of thrusters."""
    base, gives = general_allocator(packed), thrust_limits(packed, 0.0) > 0.0
    matrix = levers(packed)
    shared = base.thrust_of_wrench
    out_of_reach = np.abs(matrix @ shared - np.eye(6)).max(axis=0) > 1e-6
    return Controllers(
        mooring=GeneralDecide(packed, base, compensated=False, gives=gives),
        compensated=GeneralDecide(packed, base, compensated=True, gives=gives),
        mooring_name="inverse of the characteristic at rest, at every speed",
        compensated_name="inverse of the characteristic at the inflow speed of each thruster",
        thrust_of_wrench=np.where(out_of_reach[None, :], 0.0, shared),
    )


def paper_controllers(
    packed: PackedVehicle,
    geometry: Allocator,
    inverse: InverseCharacteristic,
    direction: FloatArray,
    corrections: Corrections | None = None,
    *,
    moored: Inverse,
    others: tuple[Mapping[int, Inverse], Mapping[int, Inverse]] = (_NONE, _NONE),
) -> Controllers:
    """Eq. (6) with Table 3, and with the firmware's grid at the speed along each thruster.

    Both know what each thruster gives of that of the tables. `moored` is the inverse at rest,
    `others` are those of thrusters of further types, at rest and compensated.

    Raises
    ------
    CannotComputeError
        When the record has no firmware grid, and so no tables that hold under way.
    """
    grid = firmware_grid(inverse)
    names = packed.thruster_names

    def controllers(
        one: Inverse,
        *,
        shape: Allocator = geometry,
        round_codes: bool = True,
        along: FloatArray | None = direction,
    ) -> PaperAllocator:
        rest, under_way = others
        beside = {
            i: Remembered(inverse) for i, inverse in (rest if one is moored else under_way).items()
        }
        kept = floating if one is grid else Remembered(one)
        return PaperAllocator(shape, kept, names, round_codes, along, corrections, beside)

    floating = Remembered(grid)
    fixed = _fixed(inverse, floating)
    settings: list[tuple[str, CodeAllocator]] = [
        ("codes not rounded", controllers(grid, round_codes=False)),
        (
            "speed given as V_x for every stern thruster, as in the paper",
            controllers(grid, along=None),
        ),
    ]
    if fixed is not None:
        settings.append(("firmware grid in fixed point", controllers(fixed)))
    if inverse.table4:
        cubic = speed_cubic(inverse, grid.codes)
        settings.append(("cubic (8), Table 4, in place of the grid", controllers(cubic)))
    other = "scaled" if geometry.form == "limit" else "limit"
    settings.append(
        (f'form "{other}" of the portions', controllers(grid, shape=_changed(geometry, form=other)))
    )
    return Controllers(
        mooring=controllers(moored),
        compensated=controllers(grid),
        mooring_name=moored.name,
        compensated_name=grid.name,
        thrust_of_wrench=paper_shares(geometry, names),
        settings=tuple(settings),
        portioned=tuple(
            (one.portions, controllers(grid, shape=one))
            for one in (
                _changed(
                    geometry,
                    portions={"surge": surge, "heading": rest, "pitch": rest},
                )
                for surge in SURGE_PORTIONS
                for rest in (round(1.0 - surge, 9),)
            )
        ),
        explanations=(_NO_MOORING,) if isinstance(moored, FirmwareGrid) else (),
        fixed=fixed,
    )


def _fixed(inverse: InverseCharacteristic, floating: Inverse) -> FixedPoint | None:
    """Return the fixed-point form; None where the grid does not fit into it."""
    if inverse.firmware is None:
        return None
    try:
        check_characteristic(inverse.firmware)
    except CannotComputeError:
        return None
    tables: FixedTables = fixed_tables(inverse.firmware)
    return FixedPoint(tables, floating)


def _changed(geometry: Allocator, **changes: object) -> Allocator:
    return Allocator.model_validate(geometry.model_dump() | changes)


def paper_shares(geometry: Allocator, names: tuple[str, ...]) -> FloatArray:
    """Thrusts (n, 6) for a unit of each axis, as `PaperAllocator` shares it out without limits."""
    shares = np.zeros((len(names), 6))
    stern = stern_places(geometry, names)
    for axis in (0, 2, 4, 5):
        channels, up = divided(geometry, np.eye(6)[axis])
        shares[stern, axis] = channels.stern_thrust_n()
        if geometry.bow is not None:
            shares[names.index(geometry.bow), axis] = up
    return shares
