"""The receipts of all pages -> the page that leads to them."""

from pipeline.provenance import read_envelope
from pipeline.report.site import IndexEntry, Status, write_index
from pipeline.stages.job import Job
from pipeline.stages.receipt import PageFile


def run(job: Job) -> str:
    """Write the index of every vehicle that has a page."""
    records = [read_envelope(path, "vehicle_page", PageFile).record for path in job.inputs]
    entries = [
        IndexEntry(
            title=record.title,
            name=record.name,
            href=record.href,
            status=Status(
                record.errors, record.warnings, record.failed_checks, record.not_computed
            ),
            data_note=record.data_note,
        )
        for record in records
        if record is not None
    ]
    write_index(sorted(entries, key=lambda entry: entry.href), job.output)
    return ""
