"""Records of the bench -> propeller, drive, static family, inverse, allocator's errors, tables."""

from pipeline.control.error_map import allocation_map
from pipeline.errors import CannotComputeError
from pipeline.identify.drive import fit_drive
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.propeller import fit_propeller
from pipeline.identify.static import static_characteristic
from pipeline.plan import TITLES
from pipeline.provenance import tables_text, write_atomically
from pipeline.records.base import Record
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.records.validation import AllocationMap
from pipeline.stages.job import Job, NotMeasuredError, leave_record
from pipeline.tables.build import build_tables


def run(job: Job) -> str:
    """Compute what the stage is named after; curves that never meet are an error of the inputs."""
    if job.stage == "tables":
        return _write_tables(job)
    return leave_record(job, lambda: _computed(job), failure_is_error=job.stage == "static")


def _computed(job: Job) -> Record:
    if job.stage == "propeller":
        return fit_propeller(job.needed("open_water", OpenWaterRecord), job.vehicle())
    if job.stage == "drive":
        return fit_drive(job.needed("load_test", LoadTestRecord), job.vehicle())
    if job.stage == "static":
        propeller, drive = job.needed("propeller", PropellerFit), job.needed("drive", DriveFit)
        return static_characteristic(propeller, drive, job.vehicle())
    return _inverse(job) if job.stage == "inverse" else _allocation(job)


def _write_tables(job: Job) -> str:
    """Write the file that others read, with what it was made from."""
    digests = job.input_digests()
    propeller = job.envelope("propeller", PropellerFit)
    static = job.envelope("static", StaticCharacteristic)
    inverse = job.envelope("inverse", InverseCharacteristic)
    every = (propeller, static, inverse)
    reasons = {one.kind: one.why_not for one in every if one.why_not is not None}
    body = build_tables(job.vehicle(), propeller.record, static.record, inverse.record, reasons)
    write_atomically(job.output, tables_text(body, inputs=digests, code=job.code))
    return ""


def _inverse(job: Job) -> InverseCharacteristic:
    """Fit the inverse from whatever of static characteristic and mooring test is there."""
    static = job.envelope("static", StaticCharacteristic)
    mooring = job.envelope("mooring", MooringRecord)
    if static.record is None and mooring.record is None:
        raise NotMeasuredError(
            f"There is neither a {TITLES['static']} nor a {TITLES['mooring']}. "
            f"{static.why_not} {mooring.why_not}"
        )
    return inverse_characteristic(static.record, mooring.record, job.vehicle())


def _allocation(job: Job) -> AllocationMap:
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
