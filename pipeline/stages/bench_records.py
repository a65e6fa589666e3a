"""Raw files of a vehicle's bench -> one checked record a kind of test."""

from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.stages.job import Job, RawRecord, leaves_record
from pipeline.vehicle.schema import Vehicle

#: Kind of test -> the reader of its files.
READERS: dict[str, Callable[[Sequence[Path], Vehicle, Path], RawRecord]] = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}


@leaves_record
def run(job: Job) -> RawRecord:
    """Read all files; a refused one is named in the record and the others are kept."""
    return job.measured(READERS[job.stage])
