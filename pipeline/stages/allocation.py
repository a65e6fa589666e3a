"""Vehicle and inverse characteristic -> the allocator's error map."""

from pipeline.control.error_map import allocation_map
from pipeline.records.allocation import AllocationMap
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.stages.job import Job, NotMeasuredError, write_record


def run(job: Job) -> str:
    """Compare the allocator with and without speed compensation."""

    def compute() -> AllocationMap:
        vehicle = job.vehicle()
        if vehicle.allocator is None:
            raise NotMeasuredError("The vehicle file has no allocator section.")
        inverse = job.needed("inverse", InverseCharacteristic)
        static = job.needed("static", StaticCharacteristic)
        return allocation_map(vehicle, inverse, static)

    return write_record(job, compute)
