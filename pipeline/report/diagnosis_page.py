"""The page of a diagnosis: the verdict first, then where, how far it shrinks, and why so."""

from dataclasses import replace

from pipeline.language import as_it_is
from pipeline.records.base import Advice, Glance, Light
from pipeline.records.day_findings import DayFinding, day_findings
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report import diagnosis_words as words
from pipeline.report.blocks import Figure, Links, Section, fold
from pipeline.report.glance import diagnosis_glance
from pipeline.report.numbers import plural
from pipeline.report.page import Labels, Page
from pipeline.report.plain_words import what_to_look_at
from pipeline.report.sections.diagnosis_answer import (
    evidence_section,
    next_section,
    notes_section,
    ranking_section,
)
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.sections.diagnosis_gap import (
    confusable_section,
    gap_section,
    over_floor,
    shrink_section,
)


def diagnosis_page(
    record: DiagnosisRecord, *, crumbs: Labels = (), files: Labels = (), assets: str = ""
) -> str:
    """Return the page as HTML text; `files` are links to those of the diagnosis, as `crumbs`."""
    ranking = ranking_section(record)
    bench = words.of_bench(record)
    picture = None if bench else finding_figure(finding_of(record))
    if picture is None:
        picture = next((one for one in ranking.blocks if isinstance(one, Figure)), None)
        blocks = tuple(one for one in ranking.blocks if one is not picture)
        ranking = replace(ranking, blocks=blocks)
    following, count = next_section(record), len(record.runs)
    counted = plural(count, "mooring table") if bench else plural(count, "run")
    return Page(
        title=f"Diagnosis of {as_it_is(record.vehicle)}",
        under=(f"{counted}: {words.identifiers(record.runs)}",),
        sections=(
            ranking,
            shrink_section(record),
            fold(gap_section(record)),
            fold(confusable_section(record)),
            following if bench else fold(following),
            fold(notes_section(record)),
            fold(evidence_section(record)),
            *([fold(Section("files", "Files", (Links(files),)))] if files else []),
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
    sentence = words.verdict_sentence(verdict)
    # the engine says it, if it wrote the sentence as it should
    if "probability" not in sentence:
        sentence += f" Probability {words.probability_text(verdict.probability)}."
    look = what_to_look_at(finding_of(record))
    return Glance(
        light=light,
        matter=sentence,
        short=diagnosis_line(record),
        do=(*([look] if look else ()), *(Advice(text=text) for text in _bench_facts(record))),
    )


def _bench_facts(record: DiagnosisRecord) -> list[str]:
    """Say which thruster it is, how far the gap shrinks, and what to measure."""
    shrink, lines = record.shrink, []
    if record.verdict.detail.thruster:
        lines.append(f"Thruster: {record.verdict.detail.thruster}.")
    if shrink.gap_closed is not None and record.verdict.effects not in {("none",), ("unknown",)}:
        closed = (
            f"{words.closed_text(shrink.gap_closed)} of the gap{words.closed_interval(shrink.ci95)}"
        )
        before, after = over_floor(shrink)
        lines.append(
            f"On data that were not used for the fit it closes {closed}: from {before} to {after} "
            "times what a sound vehicle leaves."
        )
    if record.next_run is not None:
        lines.append(f"Next: measure {words.said(record.next_run.manoeuvre.replace('_', ' '))}.")
    return lines


def diagnosis_line(record: DiagnosisRecord) -> str:
    """Say in one line what a list of diagnoses says of this one."""
    effects = words.listed([words.in_words(name) for name in record.verdict.effects])
    text = f"{effects} ({words.probability_text(record.verdict.probability)})"
    if record.verdict.ambiguous_with:
        others = words.listed([words.in_words(name) for name in record.verdict.ambiguous_with])
        text += f", not to be told from {others}"
    return f"{text}; {words.identifiers(record.runs)}"
