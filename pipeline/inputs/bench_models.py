"""What the bench results of a vehicle's types of thruster say, for the simulation."""

from dataclasses import replace
from typing import Protocol, TypeVar

from pipeline.errors import CannotComputeError
from pipeline.records.base import Record
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
    ThrustFamily,
)
from pipeline.simulate.context import BenchModel, model_of
from pipeline.vehicle.model_schema import ThrusterModel
from pipeline.vehicle.schema import Vehicle

R = TypeVar("R", bound=Record)


class Results(Protocol):
    """Where results of a type of thruster are read; "" is the type of `tables` itself."""

    def __call__(self, thruster_type: str, stage: str, kind: type[R], /) -> R:
        """Return a result, or raise `CannotComputeError` with the reason why there is none."""
        ...


def bench_model(
    vehicle: Vehicle, results: Results, *, measured_at_rest: bool = False
) -> BenchModel | None:
    """Return what the bench says of the thrusters, None where no model asks for it.

    With `measured_at_rest` what was measured at rest is the truth there for every thruster of the
    tables.
    """
    used: dict[str, list[ThrusterModel]] = {}
    for one in vehicle.thrusters:
        drive = model_of(vehicle).thrusters[one.drive]
        if drive.balance_in_time or drive.characteristic.kind != "bollard":
            used.setdefault(vehicle.type_of(one) or "", []).append(drive)
    if not used:
        return None
    found = {
        name: _of_type(vehicle, name, drives, results, measured_at_rest=measured_at_rest)
        for name, drives in used.items()
    }
    others = {vehicle.tables.types[name].kind: one for name, one in found.items() if name}
    return replace(found.get("", BenchModel(None)), others=others)


def _of_type(
    vehicle: Vehicle,
    name: str,
    drives: list[ThrusterModel],
    results: Results,
    *,
    measured_at_rest: bool,
) -> BenchModel:
    kinds = {drive.characteristic.kind for drive in drives}
    in_time = any(drive.balance_in_time for drive in drives)
    static, family = None, None
    if in_time or "tables" in kinds:
        static = results(name, "static", StaticCharacteristic)
    if measured_at_rest or "mooring" in kinds:
        inverse = results(name, "inverse", InverseCharacteristic)
        family = measured(inverse) if "mooring" in kinds else inverse.family
    if not in_time:
        return BenchModel(static, family=family)
    from pipeline.identify.static import thruster_model

    fitted = thruster_model(
        results(name, "propeller", PropellerFit),
        results(name, "drive", DriveFit),
        vehicle.of_type(name),
    )
    return BenchModel(static, fitted.propeller, fitted.surface, family)


def measured(inverse: InverseCharacteristic) -> ThrustFamily:
    """Return the family in which a mooring test has a part."""
    family = inverse.family
    if family is None or "measured" not in {family.positive.basis, family.negative.basis}:
        raise CannotComputeError(
            '"kind: mooring" takes the thrust from the mooring test, and there is none that could '
            "be used. " + " ".join(inverse.explanations)
        )
    return family
