"""The page of a comparison: what differs first, curves over each other, then everything asked."""

import numpy as np

from pipeline.language import as_it_is
from pipeline.records.base import Advice, Glance
from pipeline.records.comparison import Comparison, Difference, Side
from pipeline.report import plotting
from pipeline.report.bars import gains_figure
from pipeline.report.blocks import Blocks, Bullets, Details, Figure, Section, Table, Text, chapter
from pipeline.report.diagnosis_words import probability_text
from pipeline.report.page import Page
from pipeline.report.zoomable import Panel, Style, Trace, zoomable_figure

_MOST_ROWS = 40


def comparison_page(record: Comparison, assets: str = "") -> str:
    """Return the page as HTML text; the same record gives the same text."""
    figures = _figures(record)
    curves = Section("curves", "One over the other", tuple(figures[1:]))
    sections = curves, _codes(record), _asked(record)
    glance, word = comparison_glance(record)
    return Page(
        title=f"{as_it_is(record.a.name)} and {as_it_is(record.b.name)}",
        under=("B against A.", f"A: {_side(record.a)}.", f"B: {_side(record.b)}."),
        sections=tuple(one for one in sections if one.blocks),
        glance=glance,
        word=word,
        picture=figures[0] if figures else None,
        notes=tuple(Text(text, tone="note") for text in record.cautions),
        assets=assets,
    ).html()


def comparison_glance(record: Comparison) -> tuple[Glance, str]:
    """Say first what differs, and what to do about it; and the word beside the light."""
    if not record.why_not and not (record.differences or record.codes):
        return Glance(light="green", matter=record.verdict, short="nothing differs"), "The same"
    word, short = "Differs", "they differ"
    do = None
    if record.why_not:
        word, short = "Not comparable", "cannot be compared"
        do = Advice(text="Compare two that have this in common.")
    elif record.a.kind == "runs":
        runs = sorted({run for one in record.differences for run in one.where})
        # a side says more of its runs than their names
        names = runs or [held.partition(",")[0] for held in record.b.holds]
        command = f"rig2sea diagnose {record.b.vehicle} {' '.join(names)}"
        do = Advice(text="Ask for the cause.", command=command)
    elif record.codes:
        do = Advice(text="Load the firmware tables anew: their codes changed.")
    told = () if do is None else (do,)
    return Glance(light="amber", matter=record.verdict, short=short, do=told), word


def _side(side: Side) -> str:
    return f"{as_it_is(side.vehicle)}, {'; '.join(as_it_is(one) for one in side.holds)}"


def _figures(record: Comparison) -> list[Figure]:
    found: list[Figure] = []
    # what stands first, then each thruster in all of B: the rest is in the table
    widest = max((len(one.where) for one in record.asked), default=0)
    told = [*record.differences, *(one for one in record.asked if len(one.where) == widest)]
    bars = [
        (f"{_what(one)}, {_where(one)}", one.ratio, one.ci95)
        for one in dict.fromkeys(told)
        if one.kind == "thruster" and one.ratio is not None and one.ci95 is not None
    ]
    if bars:
        lead = "What each thruster gives, over what it gives in the other runs"
        found.append(gains_figure("fig-ratios", bars, lead, "as in the other runs"))
    panels = []
    for curve in record.curves:
        style: Style = "points" if curve.points else "line"
        traces = (
            Trace("A", np.array(curve.a_x), np.array(curve.a_y), plotting.BLUE, style),
            Trace("B", np.array(curve.b_x), np.array(curve.b_y), plotting.ORANGE, style),
        )
        panels.append(Panel(curve.y_label, traces, height=2.4 if len(record.curves) == 1 else 1.0))
    if panels:
        title = " and ".join(map(as_it_is, record.curves[0].title.split(" and ")))
        x_label, caption = record.curves[0].x_label, "Blue: A. Orange: B."
        found.append(zoomable_figure("fig-curves", title, caption, panels, x_label=x_label))
    return found


@chapter("codes", "Codes that changed")
def _codes(record: Comparison) -> Blocks:
    if record.codes_compared and not record.codes:
        yield Text(f"None of {record.codes_compared} thrusts at rest gets another code.")
    elif record.codes_compared:
        most = max(record.codes, key=lambda one: abs(one.b - one.a))
        yield Text(
            f"{len(record.codes)} of {record.codes_compared} thrusts at rest get another code, by "
            f"{abs(most.b - most.a)} at most ({most.a} and {most.b} at {most.thrust_n:.1f} N)."
        )
        pattern = "Thrust [N]: {thrust_n:.2f} | A: {a} | B: {b}"
        yield Details("Every one of them", (Table.of("Codes of both", record.codes, pattern),))


@chapter("asked", "What was asked")
def _asked(record: Comparison) -> Blocks:
    if record.asked:
        table = Table.of(
            "Every question and its answer",
            record.asked,
            lambda one: {
                "What": _what(one),
                "Where": _where(one),
                "A": _number(one.a),
                "B": _number(one.b),
                "Ratio, or difference (95 %)": _interval(one),
                "Chance by accident": "–"
                if one.p_value is None
                else probability_text(min(one.p_value, 1.0)),
            },
            note="The chance counts all questions; below 5 % a difference stands.",
        )
        yield Details("Every question and its answer", (table,))
    elif record.differences:
        yield Bullets(tuple(one.text for one in record.differences[:_MOST_ROWS]))


def _what(one: Difference) -> str:
    return as_it_is(one.what) if one.kind == "thruster" else one.what.replace("_", " ")


def _where(one: Difference) -> str:
    return as_it_is(one.where[0]) if len(one.where) == 1 else "all of B"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _interval(one: Difference) -> str:
    if one.ci95 is None:
        return "–"
    middle = one.ratio if one.ratio is not None else (one.b or 0.0) - (one.a or 0.0)
    return f"{middle:.3g} ({one.ci95[0]:.3g} to {one.ci95[1]:.3g})"
