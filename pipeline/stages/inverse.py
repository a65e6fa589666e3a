"""Static characteristic and mooring record -> Tables 3 and 4 and the firmware form."""

from pipeline.identify.inverse import inverse_characteristic
from pipeline.plan import TITLES
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.measurements import MooringRecord
from pipeline.stages.job import Job, NotMeasuredError, leaves_record


@leaves_record
def run(job: Job) -> InverseCharacteristic:
    """Fit the inverse from whatever of the two is there."""
    static = job.envelope("static", StaticCharacteristic)
    mooring = job.envelope("mooring", MooringRecord)
    if static.record is None and mooring.record is None:
        raise NotMeasuredError(
            f"There is neither a {TITLES['static']} nor a {TITLES['mooring']}. "
            f"{static.why_not} {mooring.why_not}"
        )
    return inverse_characteristic(static.record, mooring.record, job.vehicle())
