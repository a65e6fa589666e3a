"""Vehicle, static family and inverse -> the vehicle flown with its regenerated tables."""

from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from pipeline.errors import CannotComputeError
from pipeline.records.base import Record
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.measurements import LoadTestRecord
from pipeline.records.validation import AllocatorValidation
from pipeline.stages.job import Job, NotMeasuredError, leaves_record
from pipeline.vehicle.notes import opposed_thrusters
from pipeline.vehicle.schema import Vehicle

if TYPE_CHECKING:
    from pipeline.validate.power import PowerModel

R = TypeVar("R", bound=Record)


@leaves_record
def run(job: Job) -> AllocatorValidation:
    """Fly the allocator with and without speed compensation."""
    vehicle = job.vehicle()
    if vehicle.model is None:
        raise NotMeasuredError("vehicle.yaml has no model: section, so there is no vehicle to fly.")
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
    from pipeline.inputs.bench_models import bench_model
    from pipeline.simulate.pack import pack_vehicle
    from pipeline.validate.campaign import validate_allocator

    def needed(thruster_type: str, stage: str, kind: type[R]) -> R:
        return job.of_type(thruster_type).needed(stage, kind)

    # what was measured at rest is the truth at rest, whatever the simulation flies otherwise
    bench = bench_model(vehicle, needed, measured_at_rest=True)
    if bench is None:
        return validate_allocator(vehicle, pack_vehicle(vehicle))
    inverses = {name: needed(name, "inverse", InverseCharacteristic) for name in vehicle.used_types}
    return validate_allocator(
        vehicle,
        pack_vehicle(vehicle, bench),
        inverses[""] if vehicle.allocator is not None else None,
        _power(job, vehicle),
        {name: one for name, one in inverses.items() if name},
    )


def _power(job: Job, vehicle: Vehicle) -> "PowerModel | None":
    """Return what the benches know of the power, None where one of them knows nothing."""
    from pipeline.validate.power import power_model

    models = {}
    for name in vehicle.used_types:
        of_type = job.of_type(name)
        static = of_type.record("static", StaticCharacteristic)
        if static is None:
            return None
        models[name] = power_model(static, of_type.record("load_test", LoadTestRecord))
    types = enumerate(vehicle.type_of(one) or "" for one in vehicle.thrusters)
    return replace(models[""], others={i: models[name] for i, name in types if name})
