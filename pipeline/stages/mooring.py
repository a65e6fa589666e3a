"""Raw mooring files of a vehicle -> one checked record."""

from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import MooringRecord
from pipeline.stages.job import Job, NotMeasuredError, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> MooringRecord:
        if not job.raw_files:
            raise NotMeasuredError(f"There are no mooring files in raw/{job.vehicle_name}/mooring.")
        return read_mooring_tables(job.raw_files, job.vehicle(), job.raw_root)

    return write_record(job, compute)
