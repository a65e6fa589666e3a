"""The receipts of all pages -> the page that leads to them, with those of diagnoses and designs."""

import contextlib
import hashlib
import html
import re
from collections.abc import Iterable
from dataclasses import astuple, dataclass
from pathlib import Path

from pydantic import ValidationError

from pipeline.errors import InputError
from pipeline.provenance import canonical_json, read_envelope
from pipeline.records.base import PageFile, Record
from pipeline.report.html import safe_link
from pipeline.report.page import write_index
from pipeline.stages.job import Job

RECEIPT = "receipt.json"
#: Diagnoses of a vehicle that a list shows.
_MOST_LISTED = 20
_LARGEST_RECEIPT = 20_000


class DiagnosisReceipt(Record):
    """Stands beside the page of a diagnosis: the line that leads to it."""

    vehicle: str
    line: str


@dataclass(frozen=True)
class Question:
    """The files that a diagnosis was asked of, as seen from the output folder."""

    runs: tuple[str, ...]
    holdout: tuple[str, ...] = ()
    healthy: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the folder of its page: the same question keeps its place.

        >>> Question(("pool/zig-zag.mcap", "pool/surge.mcap"), (), ("first day.mcap",)).name
        'surge-f5d014cd'
        >>> Question(("pool/surge.mcap", "pool/zig-zag.mcap"), (), ("first day.mcap",)).name
        'surge-f5d014cd'
        """
        asked = canonical_json([sorted(files) for files in astuple(self)])
        first = min(Path(file).stem for file in self.runs)
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", first)[:60].strip("-")
        return f"{plain or 'runs'}-{hashlib.sha256(asked.encode()).hexdigest()[:8]}"


def diagnosis_links(reports: Path) -> dict[str, tuple[tuple[str, str], ...]]:
    """Return label and address, from `reports`, of each vehicle's diagnoses, the latest first."""
    found: dict[str, list[tuple[float, str, str]]] = {}
    for path in sorted(reports.glob(f"*/diagnoses/*/{RECEIPT}")):
        page = path.with_name("index.html")
        if not page.is_file() or path.stat().st_size > _LARGEST_RECEIPT:
            continue
        try:
            receipt = DiagnosisReceipt.model_validate_json(path.read_bytes())
        except ValidationError:
            continue  # of another version: its page is still there, and is made anew on demand
        address = safe_link(page.relative_to(reports).as_posix())
        found.setdefault(receipt.vehicle, []).append((page.stat().st_mtime, receipt.line, address))
    return {
        vehicle: tuple((line, address) for _, line, address in sorted(own, reverse=True))[
            :_MOST_LISTED
        ]
        for vehicle, own in found.items()
    }


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
