"""Raw load-test files of a vehicle -> one checked record."""

from pipeline.ingest.load_test import read_load_tests
from pipeline.records.measurements import LoadTestRecord
from pipeline.stages.job import Job, NotMeasuredError, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> LoadTestRecord:
        if not job.raw_files:
            raise NotMeasuredError(
                f"There are no load-test files in raw/{job.vehicle_name}/load_test."
            )
        return read_load_tests(job.raw_files, job.vehicle(), job.raw_root)

    return write_record(job, compute)
