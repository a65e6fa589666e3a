"""Horizontal bars with intervals: one drawing for gains, probabilities and loads."""

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
_GAINS = (-1.5, 2.5)


@dataclass(frozen=True)
class Bar:
    """A value with its interval where there is one, and how it is named."""

    label: str
    value: float
    ci95: tuple[float, float] | None = None
    colour: str = plotting.BLUE
    text: str = ""
    """Written at its end."""


def bars_figure(
    name: str,
    lead: str,
    alt: str,
    caption: str,
    bars: Sequence[Bar],
    *,
    x_label: str,
    x_range: tuple[float, float],
    mark: float | None = None,
) -> Figure:
    """Draw a bar from 0 for each value, its interval across its end.

    Parameters
    ----------
    name : str
        Unique on the page, of letters, digits and hyphens.
    lead, alt, caption : str
        The sentence above, the text for those who do not see the picture, and what is drawn how.
    bars : sequence of Bar
        From top to bottom.
    x_label : str
        With its unit.
    x_range : (float, float)
        What lies beyond is drawn at the edge.
    mark : float, optional
        Where a dashed line stands.
    """
    low, high = x_range

    def inside(value: float) -> float:
        return min(max(value, low), high)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for row, bar in enumerate(bars):
            axes.barh(row, inside(bar.value), color=bar.colour, height=0.55)
            if bar.ci95 is not None:
                ends = [inside(end) for end in bar.ci95]
                axes.plot(ends, [row, row], "|-", color=plotting.INK, lw=1.2, ms=6)
            if bar.text:
                axes.annotate(
                    bar.text,
                    (inside(bar.value), row),
                    xytext=(3, 0),
                    textcoords="offset points",
                    va="center",
                    fontsize=8,
                )
        if mark is not None:
            axes.axvline(mark, color=plotting.SOFT, lw=1.0, ls="--")
        axes.axvline(0.0, color=plotting.SOFT, lw=0.8)
        axes.set_yticks(range(len(bars)), [bar.label for bar in bars], fontsize=8)
        axes.set(xlabel=x_label, xlim=x_range)
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")

    lines = sum(1 + 0.55 * bar.label.count("\n") for bar in bars)
    svg = plotting.draw(name, alt, paint, height_in=0.8 + 0.27 * lines)
    return Figure(name, lead, svg, caption)


def gains_figure(
    name: str,
    gains: Sequence[tuple[str, float | None, tuple[float, float] | None]],
    lead: str,
    one_is: str = "as the vehicle file says",
) -> Figure:
    """Draw gains of thrusters; those whose interval does not hold 1 are orange.

    Parameters
    ----------
    name : str
        Unique on the page.
    gains : sequence of (str, float or None, interval or None)
        What each is called, its value and its 95 % interval; what has none is left out.
    lead : str
        What to see.
    one_is : str
        What a gain of 1 means.
    """
    bars = [
        Bar(
            label,
            value,
            ci95,
            plotting.BLUE if ci95[0] <= 1.0 <= ci95[1] else plotting.ORANGE,
        )
        for label, value, ci95 in gains
        if value is not None and ci95 is not None
    ]
    own = translate(one_is)
    ends = [end for bar in bars for end in bar.ci95 or ()]
    reach = (
        max(min([0.0, *ends]) - 0.05, _GAINS[0]),
        min(max([1.2, *ends]) + 0.05, _GAINS[1]),
    )
    return bars_figure(
        name,
        lead,
        f"Bars: what each thruster gives; lines: 95 % intervals; dashed: {own}. "
        "The same numbers are in the table.",
        f"Bar: thrust given; line: 95 % interval. Dashed: {own}. Orange: the interval does not "
        "hold 1.",
        bars,
        x_label=f"thrust, 1: {own}  [1]",
        x_range=reach,
        mark=1.0,
    )
