"""One pool-run log -> its record, and its channels on one time base as a file of arrays."""

from pipeline.ingest.log_files import day_of, is_log_name
from pipeline.ingest.pool_run import read_pool_run, resample, summarize
from pipeline.provenance import file_digest
from pipeline.records.trial import StoredRun
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.run_table_file import write_tables

#: Finer than the motion of any vehicle here; a sensor that is faster has its noise folded back.
TABLE_RATE_HZ = 50.0
#: A table has at most this many rows; a log that is longer gets a coarser one.
MOST_ROWS = 720_000
SLOWEST_RATE_HZ = 1.0


@leaves_record
def run(job: Job) -> StoredRun:
    """Read the log; one that cannot be read leaves its message and no table."""
    log = next(path for path in job.inputs if is_log_name(path.name))
    arrays = job.output.with_name(f"{job.output.stem}.npz")
    arrays.unlink(missing_ok=True)
    found = read_pool_run(log, job.vehicle(), job.raw_root)
    rate = min(TABLE_RATE_HZ, max(MOST_ROWS / max(found.duration_s, 1.0), SLOWEST_RATE_HZ))
    table = resample(found, rate, by_step=True)
    write_tables(arrays, {"measured": table})
    summary = summarize(found)
    return StoredRun.model_validate(
        {
            **{name: getattr(summary, name) for name in type(summary).model_fields},
            "run": job.output.stem,
            "day": day_of(log),
            "table_rate_hz": rate,
            "quantities": tuple(sorted(table.values)),
            "notes_of_table": table.notes,
            "files": {arrays.as_posix(): file_digest(arrays)},
        }
    )
