"""A line for each page that a run has made: what it says, and where it is."""

from collections.abc import Iterator
from pathlib import Path

from pipeline.errors import InputError
from pipeline.provenance import read_envelope
from pipeline.records.trial import PageReceipt
from pipeline.workflow.pool_runs import result_file
from pipeline.workflow.run import Result


def page_lines(result: Result, out: Path) -> Iterator[str]:
    """Yield a line for each new page of a run or day: what it says and where it is."""
    receipts = {page: _receipt(page, out) for page in result.pages}
    # what a day says of its runs is known when it is diagnosed, after their own receipts
    runs = {run.page: run for one in receipts.values() if one is not None for run in one.runs}
    for page, record in receipts.items():
        _, vehicle, kind, file = page.split("/", 3)
        what = "run" if kind == "runs" else "trial day"
        line = "done"
        if record is not None:
            told = runs[page].glance if page in runs else record.glance
            line = record.line if told is None else f"{told.short}; {record.line}"
        yield f"{vehicle}: {what} {file.removesuffix('.html')}: {line}: {out / page}"
    if result.done and result.complete and not result.pages:
        yield f"{', '.join(result.vehicles)}: up to date: {out / 'reports' / 'index.html'}"


def _receipt(page: str, out: Path) -> PageReceipt | None:
    """Return what a page of a run or a day left of itself; None where that cannot be read."""
    _, vehicle, kind, file = page.split("/", 3)
    stage = "run_page" if kind == "runs" else "trial_page"
    try:
        path = out / result_file(vehicle, stage, file.removesuffix(".html"))
        return read_envelope(path, stage, PageReceipt).record
    except InputError:
        return None
