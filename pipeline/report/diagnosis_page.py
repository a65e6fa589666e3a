"""The page of a diagnosis: the verdict first, then where, how far it shrinks, and why so."""

from dataclasses import replace

from pipeline.language import as_it_is
from pipeline.records.day_diagnosis import DayFinding
from pipeline.records.day_findings import day_findings
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.records.glance import Advice, Glance, Light
from pipeline.report.blocks import Figure, fold
from pipeline.report.diagnosis_words import (
    identifiers,
    in_words,
    listed,
    of_bench,
    probability_text,
    verdict_sentence,
)
from pipeline.report.glance import diagnosis_glance
from pipeline.report.numbers import plural
from pipeline.report.page import Labels, Page
from pipeline.report.plain_words import what_to_look_at
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


def diagnosis_page(
    record: DiagnosisRecord, *, crumbs: Labels = (), files: Labels = (), assets: str = ""
) -> str:
    """Return the page as HTML text; `files` are links to those of the diagnosis, as `crumbs`."""
    ranking = ranking_section(record)
    bench = of_bench(record)
    picture = None if bench else finding_figure(finding_of(record))
    if picture is None:
        picture = next((one for one in ranking.blocks if isinstance(one, Figure)), None)
        blocks = tuple(one for one in ranking.blocks if one is not picture)
        ranking = replace(ranking, blocks=blocks)
    following = next_section(record)
    return Page(
        title=f"Diagnosis of {as_it_is(record.vehicle)}",
        under=(f"{_counted(record)}: {identifiers(record.runs)}",),
        sections=(
            ranking,
            shrink_section(record),
            fold(gap_section(record)),
            fold(confusable_section(record)),
            following if bench else fold(following),
            fold(notes_section(record)),
            fold(evidence_section(record)),
            fold(files_section(record, files)),
        ),
        glance=bench_glance(record) if bench else glance_of(record),
        picture=picture,
        crumbs=crumbs,
        assets=assets,
    ).html()


def glance_of(record: DiagnosisRecord) -> Glance:
    """Say first what a diagnosis of pool runs found."""
    return diagnosis_glance(record, finding_of(record))


def finding_of(record: DiagnosisRecord) -> DayFinding:
    """Return the answer as the finding of its runs."""
    return day_findings({record.runs[0]: record})[0]


def bench_glance(record: DiagnosisRecord) -> Glance:
    """Say first what a mooring table shows of its thruster."""
    verdict = record.verdict
    light: Light = "amber"
    if verdict.effects == ("none",):
        light = "green"
    elif verdict.effects != ("unknown",) and not verdict.ambiguous_with:
        light = "red"
    sentence = verdict_sentence(verdict)
    # the engine says it, if it wrote the sentence as it should
    if "probability" not in sentence:
        sentence += f" Probability {probability_text(verdict.probability)}."
    look = what_to_look_at(finding_of(record))
    return Glance(
        light=light,
        matter=sentence,
        short=diagnosis_line(record),
        do=(*([look] if look else ()), *(Advice(text=text) for text in verdict_facts(record))),
    )


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
