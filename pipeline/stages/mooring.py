"""Raw mooring files of a vehicle -> one checked record."""

from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import MooringRecord
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> MooringRecord:
        misnamed = job.misnamed_files()
        record = read_mooring_tables(job.raw_files("mooring"), job.vehicle(), job.raw_root)
        return record.model_copy(update={"problems": (*misnamed, *record.problems)})

    return write_record(job, compute)
