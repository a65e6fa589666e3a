"""A diagnosis -> its page, in the folder asked for or among the reports."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.plan import report_file
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report.diagnosis_page import diagnosis_line, write_diagnosis_page
from pipeline.report.links import address_from
from pipeline.stages.diagnosis_links import DiagnosisReceipt, diagnosis_name, write_receipt
from pipeline.stages.index_page import write_index_again

#: Ending -> what the link says.
_LABELS = {
    ".json": "The whole answer, for machines (JSON)",
    ".yaml": "Vehicle file with the effect",
    ".mcap": "Log with measured, before and after, for a log viewer (MCAP)",
}


def write_page(
    record: DiagnosisRecord, out: Path, to: Path | None, files: Sequence[Path] = ()
) -> Path:
    """Write the page of a diagnosis.

    Parameters
    ----------
    record : DiagnosisRecord
        The answer.
    out : Path
        Folder of ``processed/`` and ``reports/``.
    to : Path or None
        Folder that the user asked for: gets ``diagnosis.html``. None: the page goes to
        ``reports/<vehicle>/diagnoses/`` and the index of reports leads to it.
    files : sequence of Path
        What else was written, for the links of the page.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If a folder cannot be written to.
    """
    if to is not None:
        page = to / "diagnosis.html"
        write_diagnosis_page(record, page, to / "assets", files=_links(files, page))
        return page
    reports = out / "reports"
    name = diagnosis_name(record.runs, record.holdout, record.evidence.healthy_runs)
    page = reports / record.vehicle / "diagnoses" / name / "index.html"
    crumbs = [("All vehicles", address_from(page, reports / "index.html"))]
    own = out / report_file(record.vehicle)
    if own.is_file():
        crumbs.append((record.vehicle, address_from(page, own)))
    write_diagnosis_page(
        record, page, reports / "assets", crumbs=tuple(crumbs), files=_links(files, page)
    )
    write_receipt(
        page.parent, DiagnosisReceipt(vehicle=record.vehicle, line=diagnosis_line(record))
    )
    write_index_again(out)
    return page


def _links(files: Sequence[Path], page: Path) -> tuple[tuple[str, str], ...]:
    return tuple(
        (_LABELS.get(file.suffix, file.name), address_from(page, file))
        for file in files
        if file.is_file()
    )
