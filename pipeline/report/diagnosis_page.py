"""The page of a diagnosis: the verdict first, then where, how far it shrinks, and why so."""

from dataclasses import replace
from pathlib import Path

from pipeline.language import as_it_is
from pipeline.records.day_diagnosis import DayFinding
from pipeline.records.day_findings import day_findings
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.records.glance import Glance
from pipeline.report.assets import placed
from pipeline.report.blocks import Figure, absent, arranged, fold
from pipeline.report.diagnosis_words import (
    identifiers,
    in_words,
    listed,
    of_bench,
    probability_text,
    verdict_sentence,
)
from pipeline.report.first_screen import first_screen
from pipeline.report.glance import diagnosis_glance
from pipeline.report.html import render, write_page
from pipeline.report.numbers import plural
from pipeline.report.sections.diagnosis_answer import (
    next_section,
    notes_section,
    ranking_section,
    verdict_facts,
)
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.sections.diagnosis_evidence import (
    confusable_section,
    evidence_section,
    files_section,
)
from pipeline.report.sections.diagnosis_gap import gap_section, shrink_section

Labels = tuple[tuple[str, str], ...]


def diagnosis_page(
    record: DiagnosisRecord, *, crumbs: Labels = (), files: Labels = (), assets: str = ""
) -> str:
    """Return the page as HTML text; the same record gives the same text.

    Parameters
    ----------
    record : DiagnosisRecord
        The answer.
    crumbs, files : tuple of (label, address)
        The way back, and files of the diagnosis; relative to the page and quoted.
    assets : str
        Address of the folder with the scripts, relative to the page; none without.
    """
    gap = gap_section(record)
    ranking = ranking_section(record)
    glance = None if of_bench(record) else glance_of(record)
    picture = None if glance is None else finding_figure(finding_of(record))
    if picture is None:
        picture = next((one for one in ranking.blocks if isinstance(one, Figure)), None)
        blocks = tuple(one for one in ranking.blocks if one is not picture)
        ranking = replace(ranking, blocks=blocks)
    sections = (
        ranking,
        shrink_section(record),
        fold(gap),
        fold(confusable_section(record)),
        next_section(record) if glance is None else fold(next_section(record)),
        fold(notes_section(record)),
        fold(evidence_section(record)),
        fold(files_section(record, files)),
    )
    return render(
        "diagnosis.html.j2",
        title=f"Diagnosis of {as_it_is(record.vehicle)}",
        under=f"{_counted(record)}: {identifiers(record.runs)}",
        crumbs=crumbs,
        sentence=verdict_sentence(record.verdict).partition(": "),
        probability=_probability(record),
        facts=verdict_facts(record),
        tone=tone(record),
        told=first_screen(glance),
        picture=picture,
        sections=arranged(sections),
        absent=absent(sections),
        assets=assets,
    )


def glance_of(record: DiagnosisRecord) -> Glance:
    """Say first what a diagnosis of pool runs found."""
    return diagnosis_glance(record, finding_of(record))


def finding_of(record: DiagnosisRecord) -> DayFinding:
    """Return the answer as the finding of its runs."""
    return day_findings({record.runs[0]: record})[0]


def write_diagnosis_page(
    record: DiagnosisRecord,
    path: Path,
    assets: Path | None,
    *,
    crumbs: Labels = (),
    files: Labels = (),
) -> None:
    """Write the page, whole or not at all, and the scripts that it shares with others.

    Parameters
    ----------
    record : DiagnosisRecord
        The answer.
    path : Path
        E.g. ``reports/<vehicle>/diagnoses/<name>/index.html``.
    assets : Path or None
        Folder of the scripts, e.g. ``reports/assets``; without it figures cannot be zoomed.
    crumbs, files : tuple of (label, address)
        As in `diagnosis_page`.

    Raises
    ------
    InputError
        If a folder cannot be written to.
    """
    write_page(
        diagnosis_page(record, crumbs=crumbs, files=files, assets=placed(assets, path)), path
    )


def tone(record: DiagnosisRecord) -> str:
    """Return the colour class of the verdict."""
    if record.verdict.effects == ("none",):
        return "good"
    return "error" if record.verdict.effects == ("unknown",) else "warning"


def diagnosis_line(record: DiagnosisRecord) -> str:
    """Say in one line what a list of diagnoses says of this one."""
    effects = listed([in_words(name) for name in record.verdict.effects])
    text = f"{effects} ({probability_text(record.verdict.probability)})"
    if record.verdict.ambiguous_with:
        others = listed([in_words(name) for name in record.verdict.ambiguous_with])
        text += f", not to be told from {others}"
    return f"{text}; {identifiers(record.runs)}"


def _counted(record: DiagnosisRecord) -> str:
    count = len(record.runs)
    return plural(count, "mooring table") if of_bench(record) else plural(count, "run")


def _probability(record: DiagnosisRecord) -> str:
    # the sentence says it, if the engine wrote one as it should
    if "probability" in record.verdict.sentence:
        return ""
    return f"Probability {probability_text(record.verdict.probability)}."
