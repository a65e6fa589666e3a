"""Load-test record -> the drive's mechanical characteristic."""

from pipeline.identify.drive import fit_drive
from pipeline.records.fits import DriveFit
from pipeline.records.measurements import LoadTestRecord
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Fit M(n, N)."""

    def compute() -> DriveFit:
        return fit_drive(job.needed("load_test", LoadTestRecord), job.vehicle())

    return write_record(job, compute)
