"""Raw open-water files of a vehicle -> one checked record."""

from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import OpenWaterRecord
from pipeline.stages.job import Job, NotMeasuredError, write_record


def run(job: Job) -> str:
    """Read all files; a refused one is named in the record and the others are kept."""

    def compute() -> OpenWaterRecord:
        if not job.raw_files:
            raise NotMeasuredError(
                f"There are no open-water files in raw/{job.vehicle_name}/open_water."
            )
        return read_open_water(job.raw_files, job.vehicle(), job.raw_root)

    return write_record(job, compute)
