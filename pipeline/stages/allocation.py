"""Vehicle and inverse characteristic -> the allocator's error map."""

from pipeline.control.error_map import allocation_map
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.validation import AllocationMap
from pipeline.stages.job import Job, NotMeasuredError, leaves_record


@leaves_record
def run(job: Job) -> AllocationMap:
    """Compare the allocator with and without speed compensation."""
    vehicle = job.vehicle()
    if vehicle.allocator is None:
        raise NotMeasuredError("The vehicle file has no allocator section.")
    stern = {getattr(vehicle.allocator, role) for role in ("upper", "lower", "left", "right")}
    types = {vehicle.type_of(one) or "" for one in vehicle.thrusters if one.name in stern}
    if len(types) > 1:
        raise CannotComputeError("The stern thrusters are of several types.")
    (of_stern,) = types
    of_type = job.of_type(of_stern)
    vehicle = vehicle.model_copy(update={"tables": vehicle.of_type(of_stern).tables})
    inverse = of_type.needed("inverse", InverseCharacteristic)
    static = of_type.needed("static", StaticCharacteristic)
    return allocation_map(vehicle, inverse, static)
