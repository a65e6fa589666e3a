"""Raw open-water files of a vehicle -> one checked record."""

from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import OpenWaterRecord
from pipeline.stages.job import Job, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> OpenWaterRecord:
        misnamed = job.misnamed_files()
        record = read_open_water(job.raw_files("open-water"), job.vehicle(), job.raw_root)
        return record.model_copy(update={"problems": (*misnamed, *record.problems)})

    return write_record(job, compute)
