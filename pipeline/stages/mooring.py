"""Raw mooring files of a vehicle -> one checked record."""

from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import MooringRecord
from pipeline.stages.job import Job, leaves_record


@leaves_record
def run(job: Job) -> MooringRecord:
    """Read all files; a refused one is named in the record and the others are kept."""
    return job.measured(read_mooring_tables)
