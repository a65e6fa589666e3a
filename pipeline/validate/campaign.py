"""All flights of one vehicle, and the record of them."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from pipeline.control.inverse import rounded
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.validation import (
    AllocatorValidation,
    CodeComparison,
    FlightTrace,
    KeepingFlight,
    SettingFlight,
    Variant,
)
from pipeline.simulate.fly import CONTROL_PERIOD_S
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.validate import plan
from pipeline.validate.closed_loop import VARIANTS, ClosedLoop
from pipeline.validate.flight import Flight
from pipeline.validate.power import PowerModel
from pipeline.vehicle.schema import Vehicle

#: Every so many samples of a flight go into the picture.
_TRACE_STEP = 2
#: With more of its surge demands cut than this a flight is not one of keeping a speed any more.
_MOSTLY = 0.5


def validate_allocator(
    vehicle: Vehicle,
    packed: PackedVehicle,
    inverse: InverseCharacteristic | None = None,
    power: PowerModel | None = None,
    others: Mapping[str, InverseCharacteristic] = MappingProxyType({}),
) -> AllocatorValidation:
    """Fly a vehicle with and without speed compensation.

    One with an allocator section and thrusters from bench tables is flown by eq. (6) with the
    regenerated tables `inverse`, and `others`, those of further types of thruster; every other by
    the general allocator. `power` is there where the bench knows the power of the thrusters.

    Raises
    ------
    CannotComputeError
        When there is nothing to compare: thrust known at rest only, or no surge force.
    """
    if packed.thrust_tables.shape[2] < 2:
        raise CannotComputeError(
            "The thrust of the thrusters is known at rest only: with and without speed "
            "compensation the codes are the same."
        )
    field = ClosedLoop.of(vehicle, packed, inverse, power, others)
    flown = {(v, name): field.fly(field.member(name), v) for v in field.speeds for name in VARIANTS}
    kept = tuple(field.keeping(name, flight) for (_, name), flight in flown.items())
    at = field.speeds[-2]
    return AllocatorValidation(
        allocator="general" if field.geometry is None else "paper",
        mooring_inverse=field.controllers.mooring_name,
        compensated_inverse=field.controllers.compensated_name,
        speed_mps=field.speeds,
        portions=field.portions,
        form="" if field.geometry is None else field.geometry.form,
        flight_s=plan.KEEPING_S,
        control_period_s=CONTROL_PERIOD_S,
        disturbance=tuple(field.amplitude.tolist()),
        disturbance_period_s=tuple(plan.DISTURBANCE_PERIOD_S.tolist()),
        range_n_nm=tuple(tuple(field.ranges[v].tolist()) for v in field.speeds),
        heading_step_deg=plan.HEADING_STEP_DEG,
        depth_step_m=plan.DEPTH_STEP_M,
        large_step_deg=plan.LARGE_STEP_DEG,
        keeping=kept,
        steps=tuple(step for v in field.speeds for step in field.steps(v)),
        settings=tuple(
            SettingFlight(setting=text, flight=field.keeping("compensated", field.fly(one, at)))
            for text, one in field.controllers.settings
        ),
        settings_at_mps=at,
        portions_flown=tuple(field.portioned(at)),
        fixed_point=_codes(field, [flown[v, "compensated"] for v in field.speeds]),
        traces=tuple(_trace(name, flown[at, name]) for name in VARIANTS),
        traces_at_mps=at,
        electrical=None if power is None else power.electrical,
        power_text=_power_text(power),
        explanations=(*field.explanations, *_out_of_reach(kept)),
    )


def _out_of_reach(kept: tuple[KeepingFlight, ...]) -> tuple[str, ...]:
    """Say at which speeds the flights were no keeping, and what that does to the rest."""
    cut = sorted({one.speed_mps for one in kept if one.cut_surge_share > _MOSTLY})
    if not cut:
        return ()
    return (
        (
            f"At {', '.join(f'{v:g}' for v in cut)} m/s most demands are cut by a portion or a "
            "limit: the speed is out of reach, and its error says how far. The autopilot stops "
            "all its integrals while a demand is cut, those of the other channels as well; depth "
            "and course errors there are partly its doing, with either inverse."
        ),
    )


def _trace(name: Variant, flight: Flight) -> FlightTrace:
    part = slice(None, None, _TRACE_STEP)

    def values(column: FloatArray) -> tuple[float, ...]:
        return tuple(round(float(x), 5) for x in column[part])

    return FlightTrace(
        variant=name,
        time_s=values(flight.time_s),
        speed_mps=values(flight.motion[:, 0]),
        heading_deg=values(np.degrees(flight.motion[:, 2])),
        depth_m=values(flight.motion[:, 1]),
    )


def _codes(field: ClosedLoop, flights: list[Flight]) -> CodeComparison | None:
    """Compare the codes of the flown thrusts in floating and in fixed point."""
    fixed = field.controllers.fixed
    if fixed is None:
        return None
    off = [
        np.abs(
            fixed.code(flight.wanted_n, flight.inflow_mps)
            - rounded(fixed.floating.code(flight.wanted_n, flight.inflow_mps))
        )
        for flight in flights
    ]
    every = np.concatenate([one.ravel() for one in off])
    return CodeComparison(
        commands=every.size,
        differing_share=float((every > 0.0).mean()),
        largest_difference=int(every.max()),
    )


def _power_text(power: PowerModel | None) -> str:
    if power is None:
        return (
            "Power: thrust times inflow speed only. Torque and shaft speed of the thrusters are "
            "not known, so neither is the power at the shafts or at the supply."
        )
    shaft = (
        "Power at the shafts: 2 pi n M of the static family at the code behind the lag and the "
        "inflow speed; a thruster at code 0 counts nothing."
    )
    if power.electrical is None:
        return shaft + " Power at the supply is not known: the load test has no current or voltage."
    return (
        shaft + " Power at the supply: that and the losses of the drive, fitted to the load test "
        f"(residual {power.electrical.residual_rms_w:.1f} W rms a drive)."
    )
