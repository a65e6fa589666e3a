"""Propeller and drive -> the static characteristic T(N, V) and Table 2."""

from pipeline.identify.static import static_characteristic
from pipeline.records.fits import DriveFit, PropellerFit
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Find the working points; curves that never meet are an error of the inputs."""
    return write_record(
        job,
        lambda: static_characteristic(
            job.needed("propeller", PropellerFit), job.needed("drive", DriveFit), job.vehicle()
        ),
        failure_is_error=True,
    )
