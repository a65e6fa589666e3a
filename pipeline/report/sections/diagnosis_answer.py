"""A diagnosis' page: notes, ranking, what to fly next."""

from pipeline.records.diagnosis import VELOCITIES, DiagnosisRecord, Leftover, RankedEffect
from pipeline.report import plotting
from pipeline.report.bars import Bar, bars_figure
from pipeline.report.blocks import Block, Bullets, Details, Figure, Paragraph, Section, Table
from pipeline.report.diagnosis_words import (
    REGRESSORS,
    beside,
    closed_interval,
    closed_text,
    effect_names,
    in_words,
    listed,
    of_bench,
    probability_text,
    said,
    unit_text,
    what_it_is,
)
from pipeline.report.numbers import general, plural, with_interval
from pipeline.report.sections.diagnosis_gap import over_floor

#: Answers shown in the open: so many, or as many as are this probable.
SHOWN, PROBABLE = 4, 0.01
#: Answers that are drawn; the table has all.
MOST_DRAWN = 8


def notes_section(record: DiagnosisRecord) -> Section:
    """Say what must be known before the answer is used."""
    blocks: list[Block] = []
    if record.verdict.ambiguous_with:
        blocks.append(
            Paragraph(
                f"These data cannot tell {effect_names(record.verdict.effects)} from "
                f"{effect_names(record.verdict.ambiguous_with)}. Change nothing on the vehicle "
                "before they are told apart: see what comes next.",
                tone="warning",
            )
        )
    # the engine may have said it
    said = any("no healthy runs" in note.lower() for note in record.notes)
    if not record.evidence.healthy_runs and not said and not of_bench(record):
        blocks.append(
            Paragraph(
                "No sound runs were given: what a sound vehicle leaves was taken from the "
                "uncertainties and sensor figures of the vehicle file, and the answer rests on "
                "them. --healthy RUN gives measured ones.",
                tone="note",
            )
        )
    blocks.append(
        Bullets(record.notes) if record.notes else Paragraph("No further remarks on these data.")
    )
    return Section("notes", "Notes", tuple(blocks))


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
        closed = closed_text(shrink.gap_closed)
        text = f"On data that were not used for the fit it closes {closed} of the gap"
        text += closed_interval(shrink.ci95)
        before, after = over_floor(shrink)
        lines.append(f"{text}: from {before} to {after} times what a sound vehicle leaves.")
    if record.next_run is not None:
        manoeuvre = said(record.next_run.manoeuvre.replace("_", " "))
        bench = of_bench(record)
        lines.append(f"Next: measure {manoeuvre}." if bench else f"Next: fly {manoeuvre}.")
    return tuple(lines)


def ranking_section(record: DiagnosisRecord) -> Section:
    """Show every answer with its probability, its parameters and their intervals."""
    title = "What it may be"
    if not record.ranking:
        text = "No answer was ranked."
        return Section("ranking", title, (Paragraph(text, tone="warning"),), available=False)
    ranking = sorted(record.ranking, key=lambda one: -one.probability)
    shown = max(SHOWN, sum(one.probability >= PROBABLE for one in ranking))
    blocks: list[Block] = [
        _figure(ranking, record),
        _table("Answers, the most probable first", ranking[:shown], record),
    ]
    rest = ranking[shown:]
    if rest:
        most = probability_text(max(one.probability for one in rest))
        blocks.append(
            Details(
                f"{plural(len(rest), 'more answer')}, none above {most.removeprefix('<').strip()}",
                (_table("The other answers", rest, record),),
            )
        )
    return Section("ranking", title, tuple(blocks))


def _figure(ranking: list[RankedEffect], record: DiagnosisRecord) -> Figure:
    bars = [
        Bar(
            _words(one),
            100 * one.probability,
            colour=_tone(one, record, (plotting.BLUE, plotting.ORANGE, "#b9c2cc")),
            text=probability_text(one.probability),
        )
        for one in ranking[:MOST_DRAWN]
    ]
    first = ranking[0]
    text = f"{_words(first)} is the most probable, {probability_text(first.probability)}"
    if len(ranking) > 1:
        text += f"; next {_words(ranking[1])}, {probability_text(ranking[1].probability)}"
    return bars_figure(
        "fig-ranking",
        text[0].upper() + text[1:] + ".",
        "Blue: the verdict. Orange: what these data cannot tell from it.",
        bars,
        x_label="probability  [%]",
        x_range=(0.0, 128.0),
    )


def _tone(one: RankedEffect, record: DiagnosisRecord, tones: tuple[str, str, str]) -> str:
    """Choose for the verdict, for what cannot be told from it, and for the rest."""
    if set(one.effect.split("+")) == set(record.verdict.effects):
        return tones[0]
    return tones[1] if beside(record.verdict, one.effect) else tones[2]


def _words(one: RankedEffect) -> str:
    return listed([said(in_words(name)) for name in one.effect.split("+")])


def _table(caption: str, ranking: list[RankedEffect], record: DiagnosisRecord) -> Table:
    return Table(
        caption,
        ("Answer", "What it is", "Probability", "Values with 95 % intervals", "Gap closed"),
        tuple(
            (
                _words(one),
                _what(one),
                probability_text(one.probability),
                _parameters(one),
                "–" if one.gap_closed is None else closed_text(one.gap_closed),
            )
            for one in ranking
        ),
        row_classes=tuple(_tone(one, record, ("chosen", "warning", "")) for one in ranking),
        note="Shaded: the verdict. Marked: what these data cannot tell from it. Gap closed: on "
        "readings that were kept aside.",
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
        key = name.rpartition(".")[2]
        words = key.rsplit("_", 1)[0] if unit and "_" in key else key
        parts.append(f"{said(words.replace('_', ' '))} {value}{unit} ({interval})")
    return "; ".join(parts) or "–"


def next_section(record: DiagnosisRecord) -> Section:
    """Say what to fly next, and what is left."""
    bench = of_bench(record)
    title = "What to measure next" if bench else "What to fly next"
    following, left = record.next_run, record.leftover
    blocks: list[Block] = []
    if following is not None:
        first, second = (in_words(name) for name in following.separates)
        manoeuvre = following.manoeuvre.replace("_", " ")
        what = (
            f"Measure {manoeuvre}: it shows"
            if bench
            else f"Fly {manoeuvre}: of the manoeuvres that the vehicle can fly it shows best"
        )
        sigma = general(following.expected_separation_sigma, 2)
        blocks.append(
            Paragraph(
                f"{what} the difference between {first} and {second}, by {sigma} standard "
                "deviations."
            )
        )
        if following.expected_separation_sigma < 3.0:
            blocks.append(
                Paragraph("That is little: repeat it, or take more readings.", tone="warning")
            )
    elif "unknown" not in record.verdict.effects:
        blocks.append(Paragraph("Nothing more is needed to tell the answer from another one."))
    if "unknown" in record.verdict.effects:
        course = "What is left" if bench else "Time course"
        blocks.append(Paragraph(_dependence(record)))
        blocks.append(Paragraph(f"{course}: {left.time_course}."))
    return Section("next", title, tuple(blocks))


def _dependence(record: DiagnosisRecord) -> str:
    left, bench = record.leftover, of_bench(record)
    if left.depends_on is None:
        if bench:
            return "The thrust that is left goes neither with the code nor with its size."
        return (
            f"The force that is left lies mostly in {left.worst_axis} and goes with none of the "
            "quantities that were measured."
        )
    name = REGRESSORS.get(left.depends_on, left.depends_on)
    if bench:
        return f"The thrust that is left goes with the {name}{correlated(left)}."
    return (
        f"The force that is left lies mostly in {left.worst_axis} and goes with {name}"
        f"{correlated(left)}: vary {name} on its own in the next run."
    )


def correlated(left: Leftover) -> str:
    """Say how closely what is left goes with what it goes with."""
    if left.correlation is None:
        return ""
    return f" (rank correlation {left.correlation:.2f})".replace("-", "\N{MINUS SIGN}")
