"""Vehicle, static family and inverse -> the vehicle flown with its regenerated tables."""

from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.errors import CannotComputeError
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import LoadTestRecord
from pipeline.records.validation import AllocatorValidation
from pipeline.stages.job import Job, NotMeasuredError, write_record
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.notes import opposed_thrusters
from pipeline.vehicle.schema import Vehicle

if TYPE_CHECKING:
    from pipeline.physics.drive import TorqueSurface
    from pipeline.physics.torque_balance import OpenWaterPropeller


def run(job: Job) -> str:
    """Fly the allocator with and without speed compensation."""

    def compute() -> AllocatorValidation:
        vehicle = job.vehicle()
        if vehicle.model is None:
            raise NotMeasuredError(
                "vehicle.yaml has no model: section, so there is no vehicle to fly."
            )
        if not vehicle.thrusters:
            raise NotMeasuredError("vehicle.yaml names no thrusters: there is nothing to fly with.")
        opposed = opposed_thrusters(vehicle)
        if opposed:
            raise CannotComputeError(
                f"Thruster {', '.join(opposed)} pushes the other way than its role in allocator: "
                "says, so every loop that is closed over it would run away. Turn its direction "
                "round, or give it its right role."
            )
        # the compiled kernel takes a while to load: only for vehicles that are flown
        from pipeline.simulate.bench_model import BenchModel
        from pipeline.simulate.pack import pack_vehicle
        from pipeline.validate.campaign import validate_allocator
        from pipeline.validate.power import power_model

        if not _from_bench(vehicle, vehicle.model):
            return validate_allocator(vehicle, pack_vehicle(vehicle))
        static = job.record("static", StaticCharacteristic)
        if static is None and _kinds(vehicle, vehicle.model) & {"tables"}:
            static = job.needed("static", StaticCharacteristic)
        # what was measured at rest is the truth at rest, whatever the simulation flies otherwise
        inverse = job.needed("inverse", InverseCharacteristic)
        bench = replace(
            BenchModel(static, *_ingredients(job, vehicle, vehicle.model)), family=inverse.family
        )
        return validate_allocator(
            vehicle,
            pack_vehicle(vehicle, bench),
            inverse if vehicle.allocator is not None else None,
            None
            if static is None
            else power_model(static, job.record("load_test", LoadTestRecord)),
        )

    return write_record(job, compute)


def _from_bench(vehicle: Vehicle, model: Model) -> bool:
    """Tell whether any thruster takes its thrust from the bench."""
    return bool(_kinds(vehicle, model) - {"bollard"})


def _kinds(vehicle: Vehicle, model: Model) -> set[str]:
    used = [model.thrusters[one.drive] for one in vehicle.thrusters]
    return {"tables" if one.balance_in_time else one.characteristic.kind for one in used}


def _ingredients(
    job: Job, vehicle: Vehicle, model: Model
) -> "tuple[OpenWaterPropeller, TorqueSurface] | tuple[()]":
    """Return propeller and drive where a balance is solved in time."""
    if not any(model.thrusters[one.drive].balance_in_time for one in vehicle.thrusters):
        return ()
    from pipeline.identify.static import thruster_model

    fitted = thruster_model(
        job.needed("propeller", PropellerFit), job.needed("drive", DriveFit), vehicle
    )
    return fitted.propeller, fitted.surface
