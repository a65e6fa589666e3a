"""Raw open-water files of a vehicle -> one checked record."""

from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import OpenWaterRecord
from pipeline.stages.job import Job, leaves_record


@leaves_record
def run(job: Job) -> OpenWaterRecord:
    """Read all files; a refused one is named in the record and the others are kept."""
    return job.measured(read_open_water)
