"""Load-test record -> the drive's mechanical characteristic."""

from pipeline.identify.drive import fit_drive
from pipeline.records.fits import DriveFit
from pipeline.records.measurements import LoadTestRecord
from pipeline.stages.job import Job, leaves_record


@leaves_record
def run(job: Job) -> DriveFit:
    """Fit M(n, N)."""
    return fit_drive(job.needed("load_test", LoadTestRecord), job.vehicle())
