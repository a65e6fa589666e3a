"""Bars of how probable each answer is, and how much of the gap it closes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pipeline.records.diagnosis import RankedEffect, Verdict
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.diagnosis_words import beside, probability_text

if TYPE_CHECKING:
    import matplotlib.figure

#: Answers that are drawn; the table has all.
MOST_DRAWN = 8


def ranking_figure(ranking: Sequence[RankedEffect], verdict: Verdict, lead: str) -> Figure:
    """Draw the most probable answers; those of the verdict are dark."""
    drawn = list(ranking[:MOST_DRAWN])
    said = set(verdict.effects)
    closed = sum(one.gap_closed is not None for one in drawn) > 1
    height_in = 0.75 + 0.26 * len(drawn)

    def paint(figure: matplotlib.figure.Figure) -> None:
        panels = figure.subplots(
            1, 2 if closed else 1, sharey=True, squeeze=False, width_ratios=[1.5, 1][: 1 + closed]
        )[0]
        at = range(len(drawn))
        colours = [
            plotting.BLUE
            if set(one.effect.split("+")) == said
            else plotting.ORANGE
            if beside(verdict, one.effect)
            else "#b9c2cc"
            for one in drawn
        ]
        left = panels[0]
        left.barh(at, [100 * one.probability for one in drawn], color=colours, height=0.66)
        for row, one in enumerate(drawn):
            left.annotate(
                probability_text(one.probability),
                (100 * one.probability, row),
                xytext=(3, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
        names = [one.effect.replace("+", "\n+ ") for one in drawn]
        left.set_yticks(at, names, fontsize=8)
        left.set(xlabel="probability  [%]", xlim=(0, 128), xticks=(0, 50, 100))
        left.invert_yaxis()
        left.grid(visible=False, axis="y")
        if closed:
            right = panels[1]
            for row, one in enumerate(drawn):
                if one.gap_closed is not None:
                    right.plot(100 * min(one.gap_closed, 1.0), row, "o", color=colours[row], ms=5.5)
            right.axvline(0.0, color=plotting.SOFT, lw=0.8)
            right.tick_params(axis="y", length=0)
            right.set(xlabel="gap closed  [%]")
            low = min(100 * one.gap_closed for one in drawn if one.gap_closed is not None)
            right.set_xlim(max(min(low - 8.0, -5.0), -110.0), 108.0)
            right.grid(visible=False, axis="y")

    return Figure(
        "fig-ranking",
        lead,
        plotting.draw(
            "fig-ranking",
            "Bars: probability of each answer; points: share of the held-out gap that it closes. "
            "The same numbers are in the table below.",
            paint,
            height_in=height_in,
        ),
        "Blue: the verdict. Orange: what these runs cannot tell from it. Right: share of the gap "
        "on held-out runs that is gone once the effect is added; 100 % reaches the healthy floor."
        if closed
        else "Blue: the verdict. Orange: what these data cannot tell from it.",
    )
