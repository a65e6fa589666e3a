"""The receipts of all pages -> the page that leads to them."""

import contextlib
import html
import re
from collections.abc import Iterable
from pathlib import Path

from pipeline.errors import InputError
from pipeline.provenance import read_envelope
from pipeline.report.html import safe_link
from pipeline.report.page import IndexEntry, Status, write_index
from pipeline.report.results import TrialDayLink
from pipeline.stages.diagnosis_links import diagnosis_links
from pipeline.stages.job import Job
from pipeline.stages.receipt import PageFile

#: The title stands before everything that is long.
_HEAD = 4000
_TITLE = re.compile(r"<title>(.{1,300}?)</title>", re.DOTALL)


def run(job: Job) -> str:
    """Write the index of every vehicle that has a page."""
    write_whole_index(job.inputs, job.output)
    return ""


def write_whole_index(receipts: Iterable[Path], index: Path) -> None:
    """Write the index of the vehicles with these receipts, and of what else lies beside it."""
    records = []
    for path in receipts:
        # half-written, or of an earlier version and not part of this run: made anew by its own
        with contextlib.suppress(InputError):
            records.append(read_envelope(path, "vehicle_page", PageFile).record)
    reports = index.parent
    diagnoses = diagnosis_links(reports)
    entries = [
        IndexEntry(
            title=record.title,
            name=record.name,
            href=record.href,
            status=Status(
                record.errors, record.warnings, record.failed_checks, record.not_computed
            ),
            data_note=record.data_note,
            glance=record.glance,
            days=tuple(TrialDayLink(**dict(day)) for day in record.days),
            trend_href=record.trend_href,
            diagnoses=diagnoses.pop(record.name, ()),
        )
        for record in records
        if record is not None
    ]
    known = {entry.name for entry in entries}
    write_index(
        sorted(entries, key=lambda entry: entry.href),
        index,
        sorted(diagnoses.items()),
        designs=design_links(reports),
        earlier=tuple(
            (page.parent.name, safe_link(page.relative_to(reports).as_posix()))
            for page in sorted(reports.glob("*/index.html"))
            if page.parent.name not in known
        ),
        assets=reports / "assets",
    )


def write_index_again(out: Path) -> None:
    """Write the index anew from what is there, after a page that the workflow does not know of."""
    receipts = sorted((out / "processed").glob("*/vehicle_page.json"))
    write_whole_index(receipts, out / "reports" / "index.html")


def design_links(reports: Path) -> tuple[tuple[str, str], ...]:
    """Return label and address, from `reports`, of each page of a design calculation, by title."""
    found = []
    for page in reports.glob("design/*.html"):
        with page.open(encoding="utf-8", errors="replace") as text:
            title = _TITLE.search(text.read(_HEAD))
        label = html.unescape(title[1]).strip() if title else page.stem
        found.append((label, safe_link(page.relative_to(reports).as_posix())))
    return tuple(sorted(found))
