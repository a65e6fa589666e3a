"""A diagnosis -> its page, in the folder asked for or among the reports."""

import os
import shutil
from collections.abc import Sequence
from pathlib import Path

from pipeline.language import as_it_is
from pipeline.plan import report_file
from pipeline.provenance import unwritable, write_record
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report.diagnosis_page import diagnosis_line, diagnosis_page
from pipeline.report.html import address_from, crumbs, placed
from pipeline.report.html import write_page as write_text
from pipeline.stages.index_page import (
    RECEIPT,
    DiagnosisReceipt,
    Question,
    write_index_again,
)

#: Ending -> what the link says.
_LABELS = {
    ".json": "The whole answer, for machines (JSON)",
    ".yaml": "Vehicle file with the effect",
}
#: What follows the run's name in the name of a log with the effect.
OVERLAY_END = "_with_effect.mcap"


def write_page(
    record: DiagnosisRecord,
    question: Question,
    out: Path,
    to: Path | None,
    files: Sequence[Path] = (),
) -> Path:
    """Write the page of a diagnosis; returns where.

    A folder that the user asked for, `to`, gets ``diagnosis.html``. Without, the page goes to
    ``reports/<vehicle>/diagnoses/``, by its question, and the index leads to it. Its links lead to
    `files`, what else was written; among the reports these are kept beside it: what they lie in
    gets those of the next diagnosis.
    """
    if to is not None:
        page = to / "diagnosis.html"
        text = diagnosis_page(record, files=_links(files, page), assets=placed(to / "assets", page))
        write_text(text, page)
        return page
    reports = out / "reports"
    page = reports / record.vehicle / "diagnoses" / question.name / "index.html"
    own = out / report_file(record.vehicle)
    there = ((record.vehicle, own),) if own.is_file() else ()
    trail = crumbs(page, *there, index=reports / "index.html")
    kept = _kept(files, page.parent)
    scripts = placed(reports / "assets", page)
    text = diagnosis_page(record, crumbs=trail, files=_links(kept, page), assets=scripts)
    write_text(text, page)
    receipt = DiagnosisReceipt(vehicle=record.vehicle, line=diagnosis_line(record))
    write_record(page.with_name(RECEIPT), receipt)
    write_index_again(out)
    return page


def _kept(files: Sequence[Path], folder: Path) -> list[Path]:
    """Keep the files in the page's folder, in place of those of an earlier answer.

    Logs are large: they get a second name for the same file where the disk can give one. Whoever
    writes the first name again makes a new file, so what is kept stays as it is. A text may be
    edited in its place, and is copied.
    """
    for old in folder.glob("*"):
        if (old.suffix in _LABELS and old.name != RECEIPT) or old.name.endswith(OVERLAY_END):
            try:
                old.unlink()
            except OSError as error:
                raise unwritable(old, error) from error
    kept = []
    for file in files:
        own = folder / file.name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _second(file, own)
        except FileNotFoundError:
            continue
        except OSError as error:
            raise unwritable(own, error) from error
        kept.append(own)
    return kept


def _second(file: Path, own: Path) -> None:
    """Give a log a second name, or where that cannot be, and any other file, a copy."""
    if file.name.endswith(OVERLAY_END):
        try:
            os.link(file, own)
        except OSError:
            pass
        else:
            return
    shutil.copyfile(file, own)


def _links(files: Sequence[Path], page: Path) -> tuple[tuple[str, str], ...]:
    return tuple((_label(file), address_from(page, file)) for file in files if file.is_file())


def _label(file: Path) -> str:
    if file.name.endswith(OVERLAY_END):
        run = as_it_is(file.name.removesuffix(OVERLAY_END))
        return f"Log of {run}: measured, and simulated with the effect, for a log viewer (MCAP)"
    return _LABELS.get(file.suffix, file.name)
