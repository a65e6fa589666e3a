"""Raw load-test files of a vehicle -> one checked record."""

from pipeline.ingest.load_test import read_load_tests
from pipeline.records.measurements import LoadTestRecord
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> LoadTestRecord:
        misnamed = job.misnamed_files()
        record = read_load_tests(job.raw_files("load-test"), job.vehicle(), job.raw_root)
        return record.model_copy(update={"problems": (*misnamed, *record.problems)})

    return write_record(job, compute)
