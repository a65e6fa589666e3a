"""Raw load-test files of a vehicle -> one checked record."""

from pipeline.ingest.load_test import read_load_tests
from pipeline.records.measurements import LoadTestRecord
from pipeline.stages.job import Job, leaves_record


@leaves_record
def run(job: Job) -> LoadTestRecord:
    """Read all files; a refused one is named in the record and the others are kept."""
    return job.measured(read_load_tests)
