"""The page of a comparison: what differs first, curves over each other, then everything asked."""

from pathlib import Path

from pipeline.language import as_it_is
from pipeline.records.comparison import Comparison, Curve, Difference
from pipeline.report import plotting
from pipeline.report.assets import placed
from pipeline.report.bars import gains_figure
from pipeline.report.blocks import Block, Bullets, Details, Figure, Paragraph, Section, Table
from pipeline.report.diagnosis_words import probability_text
from pipeline.report.html import render, write_page
from pipeline.report.panels import Panel, Style, Trace
from pipeline.report.zoomable import zoomable_figure

_MOST_ROWS = 40


def write_comparison_page(record: Comparison, path: Path, assets: Path | None) -> None:
    """Write the page, whole or not at all, and the scripts in `assets`; raises `InputError`."""
    write_page(comparison_page(record, placed(assets, path)), path)


def comparison_page(record: Comparison, assets: str = "") -> str:
    """Return the page as HTML text; the same record gives the same text."""
    sections = [_section("curves", "One over the other", _figures(record))]
    if record.codes_compared:
        sections.append(_section("codes", "Codes that changed", _codes(record)))
    sections.append(_section("asked", "What was asked", _asked(record)))
    first, _, rest = record.verdict.partition(": ")
    return render(
        "answer.html.j2",
        title=f"{as_it_is(record.a.name)} and {as_it_is(record.b.name)}",
        under=f"B against A. A: {_side(record, 'a')}. B: {_side(record, 'b')}.",
        crumbs=(),
        sentence=(first, ": " if rest else "", rest),
        facts=record.cautions,
        tone="warning" if record.why_not or record.differences or record.codes else "good",
        sections=tuple(one for one in sections if one.blocks),
        assets=assets,
    )


def _side(record: Comparison, which: str) -> str:
    side = record.a if which == "a" else record.b
    return f"{as_it_is(side.vehicle)}, {'; '.join(as_it_is(one) for one in side.holds)}"


def _section(anchor: str, title: str, blocks: list[Block]) -> Section:
    return Section(anchor, title, tuple(blocks))


def _figures(record: Comparison) -> list[Block]:
    found: list[Block] = []
    # what stands first, then each thruster in all of B: the rest is in the table
    widest = max((len(one.where) for one in record.asked), default=0)
    told = [*record.differences, *(one for one in record.asked if len(one.where) == widest)]
    bars = [
        (_named(one), one.ratio, one.ci95)
        for one in dict.fromkeys(told)
        if one.kind == "thruster" and one.ratio is not None and one.ci95 is not None
    ]
    if bars:
        lead = "What each thruster gives, over what it gives in the other runs"
        found.append(gains_figure("fig-ratios", bars, lead, "as in the other runs"))
    if record.curves:
        found.append(_curves(record.curves))
    return found


def _named(one: Difference) -> str:
    return f"{one.what}, {'all of B' if len(one.where) != 1 else one.where[0]}"


def _curves(curves: tuple[Curve, ...]) -> Figure:
    import numpy as np

    panels = []
    for curve in curves:
        style: Style = "points" if curve.points else "line"
        sides = ((curve.a_x, curve.a_y), (curve.b_x, curve.b_y))
        traces = tuple(
            Trace(name, np.array(x), np.array(y), colour, style)
            for name, (x, y), colour in zip(
                "AB", sides, (plotting.BLUE, plotting.ORANGE), strict=True
            )
        )
        panels.append(Panel(curve.y_label, traces, height=2.4 if len(curves) == 1 else 1.0))
    return zoomable_figure(
        "fig-curves",
        as_it_is(curves[0].title),
        "Blue: A. Orange: B.",
        tuple(panels),
        x_label=curves[0].x_label,
    )


def _codes(record: Comparison) -> list[Block]:
    if not record.codes:
        return [Paragraph(f"None of {record.codes_compared} thrusts at rest gets another code.")]
    most = max(record.codes, key=lambda one: abs(one.b - one.a))
    text = (
        f"{len(record.codes)} of {record.codes_compared} thrusts at rest get another code, by "
        f"{abs(most.b - most.a)} at most ({most.a} and {most.b} at {most.thrust_n:.1f} N)."
    )
    rows = tuple((f"{one.thrust_n:.2f}", str(one.a), str(one.b)) for one in record.codes)
    table = Table("Codes of both", ("Thrust [N]", "A", "B"), rows)
    return [Paragraph(text), Details("Every one of them", (table,))]


def _asked(record: Comparison) -> list[Block]:
    if record.asked:
        rows = tuple(
            (
                one.what.replace("_", " "),
                ", ".join(one.where) if len(one.where) == 1 else "all of B",
                _number(one.a),
                _number(one.b),
                _interval(one),
                "–" if one.p_value is None else probability_text(min(one.p_value, 1.0)),
            )
            for one in record.asked
        )
        table = Table(
            "Every question and its answer",
            (
                "What",
                "Where",
                "A",
                "B",
                "Ratio, or difference (95 %)",
                "Chance by accident",
            ),
            rows,
            text_columns=frozenset({1}),
            verbatim_columns=frozenset({0, 1}),
            note="The chance counts all questions; below 5 % a difference stands.",
        )
        return [Details("Every question and its answer", (table,))]
    texts = tuple(one.text for one in record.differences)
    return [Bullets(texts[:_MOST_ROWS])] if texts else []


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _interval(one: Difference) -> str:
    if one.ci95 is None:
        return "–"
    middle = one.ratio if one.ratio is not None else (one.b or 0.0) - (one.a or 0.0)
    return f"{middle:.3g} ({one.ci95[0]:.3g} to {one.ci95[1]:.3g})"
