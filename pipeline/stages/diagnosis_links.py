"""Where the pages of diagnoses are, and what lists say of them."""

import hashlib
import re
from dataclasses import astuple, dataclass
from pathlib import Path

from pydantic import ValidationError

from pipeline.provenance import canonical_json, write_atomically
from pipeline.records.base import Record
from pipeline.report.html import safe_link

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


def write_receipt(folder: Path, receipt: DiagnosisReceipt) -> None:
    """Write the receipt beside the page."""
    write_atomically(folder / RECEIPT, canonical_json(receipt.model_dump(mode="json")) + "\n")


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
