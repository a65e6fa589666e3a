"""Bars of the gain of each thruster, with intervals, beside what the vehicle file says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipeline.language import translate
from pipeline.report import plotting
from pipeline.report.blocks import Figure

if TYPE_CHECKING:
    import matplotlib.figure

#: Gains beyond this are drawn at the edge; the table has the number.
_LOW, _HIGH = -1.5, 2.5


@dataclass(frozen=True)
class Bar:
    """A gain with its interval, and how it is named."""

    label: str
    value: float
    ci95: tuple[float, float]


def gains_figure(
    name: str, bars: Sequence[Bar], lead: str, one_is: str = "as the vehicle file says"
) -> Figure:
    """Draw a bar from 0 for each gain, its interval across its end, and the file's 1.

    Parameters
    ----------
    name : str
        Unique on the page, of letters, digits and hyphens.
    bars : sequence of Bar
        From top to bottom.
    lead : str
        What to see.
    one_is : str
        What a gain of 1 means.
    """

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for row, bar in enumerate(bars):
            low, high = (min(max(one, _LOW), _HIGH) for one in bar.ci95)
            value = min(max(bar.value, _LOW), _HIGH)
            sure = bar.ci95[1] < 1.0 or bar.ci95[0] > 1.0
            axes.barh(row, value, color=plotting.ORANGE if sure else plotting.BLUE, height=0.55)
            axes.plot([low, high], [row, row], color=plotting.INK, lw=1.2)
            axes.plot([low, high], [row, row], "|", color=plotting.INK, ms=6)
        axes.axvline(1.0, color=plotting.SOFT, lw=1.0, ls="--")
        axes.axvline(0.0, color=plotting.SOFT, lw=0.8)
        axes.set_yticks(range(len(bars)), [bar.label for bar in bars], fontsize=8)
        axes.set(xlabel=f"gain, 1: {translate(one_is)}  [1]", xlim=(_LOW, _HIGH))
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")

    return Figure(
        name,
        lead,
        plotting.draw(
            name,
            f"Bars: gain of each thruster; lines: 95 % intervals; dashed: {translate(one_is)}. "
            "The same numbers are in the table.",
            paint,
            height_in=0.8 + 0.27 * len(bars),
        ),
        f"Bar: gain; line: 95 % interval. Dashed: {translate(one_is)}. Orange: the interval "
        "does not hold 1.",
    )
