"""A diagnosis' page: notes, ranking, what cannot be told apart, what to fly next."""

from collections.abc import Sequence

import numpy as np

from pipeline.language import as_it_is
from pipeline.records.diagnosis import VELOCITIES, DiagnosisRecord, Leftover, RankedEffect
from pipeline.report.blocks import Block, Bullets, Details, Paragraph, Section, Table
from pipeline.report.diagnosis_words import (
    REGRESSORS,
    beside,
    closed_interval,
    closed_text,
    identifiers,
    in_words,
    listed,
    of_bench,
    probability_text,
    unit_text,
    what_it_is,
)
from pipeline.report.figures.ranking import ranking_figure
from pipeline.report.numbers import fixed, general, plural, with_interval
from pipeline.report.sections.diagnosis_gap import over_floor

#: Answers shown in the open: so many, or as many as are this probable.
SHOWN, PROBABLE = 4, 0.01
#: Below this angle two effects are one answer. [deg]
ONE_ANSWER_DEG = 10.0


def notes_section(record: DiagnosisRecord) -> Section:
    """Begin with what must be known before the answer is used."""
    blocks: list[Block] = []
    if record.verdict.ambiguous_with:
        blocks.append(
            Paragraph(
                f"These data cannot tell {identifiers(record.verdict.effects)} from "
                f"{identifiers(record.verdict.ambiguous_with)}. Change nothing on the vehicle "
                "before they are told apart: see what comes next.",
                tone="warning",
            )
        )
    # the engine may have said it
    said = any("no healthy runs" in note.lower() for note in record.notes)
    if not record.evidence.healthy_runs and not said and not of_bench(record):
        blocks.append(
            Paragraph(
                "No healthy runs were given: what a healthy vehicle leaves was taken from the "
                "uncertainties and sensor figures of the vehicle file, and the answer rests on "
                "them. --healthy RUN gives measured ones.",
                tone="note",
            )
        )
    blocks.append(
        Bullets(record.notes) if record.notes else Paragraph("No further remarks on these data.")
    )
    return Section("notes", "Notes first", tuple(blocks))


def verdict_facts(record: DiagnosisRecord) -> tuple[str, ...]:
    """Lines under the verdict: where it sits, how far the gap shrinks, what to do."""
    verdict, lines = record.verdict, []
    detail = verdict.detail
    if detail.thruster:
        lines.append(f"Thruster: {detail.thruster}.")
    if detail.axes:
        words = {velocity: axis for axis, velocity in VELOCITIES.items()}
        lines.append(f"Axes: {listed([words[one] for one in detail.axes])}.")
    shrink = record.shrink
    named = verdict.effects not in {("none",), ("unknown",)}
    if shrink.gap_closed is not None and named:
        text = f"On what took no part it closes {closed_text(shrink.gap_closed)} of the gap"
        text += closed_interval(shrink.ci95)
        before, after = over_floor(shrink)
        lines.append(f"{text}: from {before} to {after} times the healthy floor.")
    if record.next_run is not None:
        doing = "measure" if of_bench(record) else "fly"
        lines.append(f"Next: {doing} {record.next_run.manoeuvre.replace('_', ' ')}.")
    return tuple(lines)


def ranking_section(record: DiagnosisRecord) -> Section:
    """Show every answer with its probability, its parameters and their intervals."""
    title = "Which effect"
    if not record.ranking:
        text = "No answer was ranked."
        return Section("ranking", title, (Paragraph(text, tone="warning"),), available=False)
    ranking = sorted(record.ranking, key=lambda one: -one.probability)
    probable = sum(one.probability >= PROBABLE for one in ranking)
    shown = max(SHOWN, probable)
    blocks: list[Block] = [
        ranking_figure(ranking, record.verdict, _lead(ranking)),
        _ranking_table("Answers, the most probable first", ranking[:shown], record),
    ]
    rest = ranking[shown:]
    if rest:
        most = probability_text(max(one.probability for one in rest))
        blocks.append(
            Details(
                f"{plural(len(rest), 'more answer')}, none above {most.removeprefix('<').strip()}",
                (_ranking_table("The other answers", rest, record),),
            )
        )
    return Section("ranking", title, tuple(blocks))


def _lead(ranking: list[RankedEffect]) -> str:
    first = ranking[0]
    text = f"{_words(first)} is the most probable, {_sure(first)}"
    if len(ranking) > 1:
        text += f"; next {_words(ranking[1])}, {_sure(ranking[1])}"
    return text[0].upper() + text[1:] + "."


def _words(one: RankedEffect) -> str:
    return listed([in_words(name) for name in one.effect.split("+")])


def _sure(one: RankedEffect) -> str:
    return probability_text(one.probability)


def _ranking_table(caption: str, ranking: list[RankedEffect], record: DiagnosisRecord) -> Table:
    said = set(record.verdict.effects)
    return Table(
        caption,
        (
            "Answer",
            "What it is",
            "Probability",
            "Parameters with 95 % intervals",
            "Gap closed",
            "Log evidence",
            "Held out",
        ),
        tuple(
            (
                one.effect.replace("+", " + "),
                _what(one),
                _sure(one),
                _parameters(one),
                "–" if one.gap_closed is None else closed_text(one.gap_closed),
                fixed(one.log_evidence, 1),
                "–" if one.held_out_log_evidence is None else fixed(one.held_out_log_evidence, 1),
            )
            for one in ranking
        ),
        text_columns=frozenset({1, 3}),
        verbatim_columns=frozenset({0}),
        row_classes=tuple(
            "chosen"
            if set(one.effect.split("+")) == said
            else "warning"
            if beside(record.verdict, one.effect)
            else ""
            for one in ranking
        ),
        note="Shaded: the verdict. Marked: what these data cannot tell from it. Gap closed: on "
        "what took no part. Log evidence: natural logarithm, against the vehicle file with its "
        "stated uncertainty; a difference of 3 is a factor of 20. Held out: log evidence of "
        "what took no part, against the best simpler answer; clearly below zero speaks against an "
        "answer.",
    )


def _what(one: RankedEffect) -> str:
    place = list(dict.fromkeys(one.thrusters.values()))
    place += [listed(one.axes)] if one.axes else []
    what = what_it_is(one.effect)
    return f"{what} ({'; '.join(place)})" if place else what


def _parameters(one: RankedEffect) -> str:
    parts = []
    for name, parameter in one.parameters.items():
        value, interval = with_interval(parameter.value, parameter.ci95)
        unit = "" if parameter.unit == "1" else f" {unit_text(parameter.unit)}"
        parts.append(f"{name} = {value}{unit} ({interval})")
    return "; ".join(parts) or "–"


def confusable_section(record: DiagnosisRecord) -> Section:
    """Name the effects that these runs cannot separate, known before the verdict."""
    title = "What cannot be told apart"
    pairs = sorted(record.confusable, key=lambda pair: -pair[2])
    if not pairs:
        return Section(
            "confusable",
            title,
            (Paragraph("Every two candidates leave traces of their own in these runs."),),
        )
    groups = confusable_groups(record.confusable)
    blocks: list[Block] = []
    if groups:
        blocks += [
            Paragraph(
                "Known from the runs alone, before the verdict: the traces of these effects in the "
                f"measured channels differ by less than {ONE_ANSWER_DEG:g} degrees, so each group "
                "is one answer."
            ),
            Bullets(tuple(identifiers(group) for group in groups)),
        ]
        told = _told_apart(record, groups)
        if told:
            blocks.append(Paragraph(told))
    else:
        blocks.append(
            Paragraph(
                f"No two effects come closer than {ONE_ANSWER_DEG:g} degrees; the closest pairs:"
            )
        )
    table = Table(
        "Closest pairs of effects",
        ("Effect", "and", "Angle [deg]", "Cosine"),
        tuple(
            (first, second, fixed(angle_deg(cosine), 1), fixed(cosine, 3))
            for first, second, cosine in pairs
        ),
        text_columns=frozenset({1}),
        verbatim_columns=frozenset({0, 1}),
        row_classes=tuple(
            "warning" if angle_deg(cosine) <= ONE_ANSWER_DEG else "" for *_, cosine in pairs
        ),
        note="Angle between what the two effects do to the readings, after everything that is "
        "ordinary has been taken away: 0 means the same trace, 90 nothing in common.",
    )
    blocks.append(table if len(pairs) <= 12 else Details(f"{len(pairs)} pairs", (table,)))
    return Section("confusable", title, tuple(blocks))


def _told_apart(record: DiagnosisRecord, groups: Sequence[Sequence[str]]) -> str:
    """Say of a verdict that stands in a group why it is told from the others all the same.

    What is alike to what the verdict explains is in its answer set; the angles here are the
    smallest of any parameter of an effect.
    """
    verdict = record.verdict
    if of_bench(record) or set(verdict.effects) & {"none", "unknown"}:
        return ""
    # errors of the DVL may have been settled by comparing instruments, which knows no angles
    mine = {name for name in verdict.effects if not name.startswith("dvl_")}
    near = {name for group in groups if mine & set(group) for name in group}
    others = sorted(near - {*verdict.effects, *verdict.ambiguous_with})
    if not others:
        return ""
    return (
        f"The verdict is told from {identifiers(others)} all the same: what it explains in these "
        f"runs lies more than {ONE_ANSWER_DEG:g} degrees away, and the small angle is of another "
        "thruster, axis or parameter."
    )


def angle_deg(cosine: float) -> float:
    """Angle of a cosine. [deg].

    >>> angle_deg(1.0), round(angle_deg(0.5), 6)
    (0.0, 60.0)
    """
    return float(np.degrees(np.arccos(np.clip(abs(cosine), 0.0, 1.0))))


def confusable_groups(pairs: tuple[tuple[str, str, float], ...]) -> tuple[tuple[str, ...], ...]:
    """Join pairs that are one answer into groups.

    >>> confusable_groups((("a", "b", 0.999), ("b", "c", 0.99), ("d", "e", 0.5)))
    (('a', 'b', 'c'),)
    """
    groups: list[set[str]] = []
    for first, second, cosine in pairs:
        if angle_deg(cosine) > ONE_ANSWER_DEG:
            continue
        touched = [group for group in groups if first in group or second in group]
        groups = [group for group in groups if group not in touched]
        groups.append({first, second}.union(*touched))
    return tuple(sorted(tuple(sorted(group)) for group in groups))


def next_section(record: DiagnosisRecord) -> Section:
    """Say what to fly next, and what is left."""
    bench = of_bench(record)
    title = "What to measure next" if bench else "What to fly next"
    following, left = record.next_run, record.leftover
    blocks: list[Block] = []
    if following is not None:
        first, second = (as_it_is(name) for name in following.separates)
        blocks.append(
            Paragraph(
                (
                    f"Measure {following.manoeuvre.replace('_', ' ')}: it shows"
                    if bench
                    else f"Fly {following.manoeuvre.replace('_', ' ')}: of the manoeuvres that the "
                    "vehicle can fly it shows best"
                )
                + f" the difference between {first} and {second}, by "
                f"{general(following.expected_separation_sigma, 2)} standard deviations."
            )
        )
        if following.expected_separation_sigma < 3.0:
            blocks.append(
                Paragraph("That is little: repeat it, or take more readings.", tone="warning")
            )
    elif "unknown" not in record.verdict.effects:
        blocks.append(Paragraph("Nothing more is needed to tell the answer from another one."))
    if "unknown" in record.verdict.effects:
        blocks.append(Paragraph(_dependence(record)))
        blocks.append(
            Paragraph(
                f"What is left: {left.time_course}."
                if bench
                else f"Time course: {left.time_course}."
            )
        )
    return Section("next", title, tuple(blocks))


def _dependence(record: DiagnosisRecord) -> str:
    left = record.leftover
    if left.depends_on is None:
        if of_bench(record):
            return "The thrust that is left goes neither with the code nor with its size."
        return (
            f"The force that is left lies mostly in {left.worst_axis} and goes with none of the "
            "quantities that were measured."
        )
    name = REGRESSORS.get(left.depends_on, left.depends_on)
    if of_bench(record):
        return f"The thrust that is left goes with the {name}{_correlated(left)}."
    return (
        f"The force that is left lies mostly in {left.worst_axis} and goes with {name}"
        f"{_correlated(left)}: vary {name} on its own in the next run."
    )


def _correlated(left: Leftover) -> str:
    if left.correlation is None:
        return ""
    return f" (rank correlation {fixed(left.correlation, 2)})"
