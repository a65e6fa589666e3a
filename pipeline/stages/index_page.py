"""The receipts of all pages -> the page that leads to them."""

import contextlib
import html
import re
from collections.abc import Iterable
from pathlib import Path

from pipeline.errors import InputError
from pipeline.provenance import read_envelope
from pipeline.records.pages import PageFile
from pipeline.report.html import safe_link
from pipeline.report.page import write_index
from pipeline.stages.diagnosis_links import diagnosis_links
from pipeline.stages.job import Job

#: The title stands before everything that is long.
_HEAD = 4000
_TITLE = re.compile(r"<title>(.{1,300}?)</title>", re.DOTALL)


def run(job: Job) -> str:
    """Write the index of every vehicle that has a page."""
    write_whole_index(job.inputs, job.output)
    return ""


def write_whole_index(receipts: Iterable[Path], index: Path) -> None:
    """Write the index of the vehicles with these receipts, and of what else lies beside it."""
    pages: list[PageFile] = []
    for path in receipts:
        # half-written, or of an earlier version and not part of this run: made anew by its own
        with contextlib.suppress(InputError):
            record = read_envelope(path, "vehicle_page", PageFile).record
            pages += [] if record is None else [record]
    reports, known = index.parent, {one.name for one in pages}
    write_index(
        sorted(pages, key=lambda one: one.href),
        index,
        diagnosis_links(reports),
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
