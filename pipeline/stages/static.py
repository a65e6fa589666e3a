"""Propeller and drive -> the static characteristic T(N, V) and Table 2."""

from pipeline.identify.static import static_characteristic
from pipeline.records.fits import DriveFit, PropellerFit, StaticCharacteristic
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Find the working points; curves that never meet are an error of the inputs."""

    def compute() -> StaticCharacteristic:
        propeller = job.needed("propeller", PropellerFit)
        drive = job.needed("drive", DriveFit)
        return static_characteristic(propeller, drive, job.vehicle())

    return write_record(job, compute, failure_is_error=True)
