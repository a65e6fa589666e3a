"""Horizontal bars with intervals: one drawing for gains, probabilities and loads."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.language import as_it_is, translate
from pipeline.report.blocks import Figure
from pipeline.report.plotting import BLUE, INK, ORANGE, SOFT, WIDTH, Canvas, Frame, Scale

#: Gains beyond this are drawn at the edge; the table has the number.
_GAINS = (-1.5, 2.5)


@dataclass(frozen=True)
class Bar:
    """A value with its interval where there is one, and how it is named."""

    label: str
    value: float
    ci95: tuple[float, float] | None = None
    colour: str = BLUE
    text: str = ""
    """Written at its end."""


def bars_figure(
    name: str,
    lead: str,
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
    lead, caption : str
        The sentence above, and what is drawn how, for those who do not see it as well.
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
    labels = [translate(bar.label).split("\n") for bar in bars]
    left = 12.0 + 4.9 * max((len(line) for lines in labels for line in lines), default=0)
    rows = [14.0 + 9.0 * len(lines) for lines in labels]
    canvas = Canvas(sum(rows) + 34.0)
    across = Scale(low, high, min(left, 0.55 * WIDTH), WIDTH - 8.0)
    frame = Frame(canvas, across, Scale(0.0, 1.0, sum(rows) + 4.0, 4.0))
    inside, zero, top = frame.inside, float(across.at(min(max(0.0, low), high))), 4.0
    for bar, lines, room in zip(bars, labels, rows, strict=True):
        middle, end = top + room / 2, float(across.at(min(max(bar.value, low), high)))
        inside.area(f"M{zero:.1f} {middle - 6:g}H{end:.1f}v12H{zero:.1f}", bar.colour)
        if bar.ci95 is not None:
            a, b = across.at([min(max(one, low), high) for one in bar.ci95])
            inside.line(f"M{a:.1f} {middle:g}H{b:.1f}m0-4v8M{a:.1f} {middle - 4:g}v8", INK, 1.2)
        if bar.text:
            inside.text(end + 4, middle + 3, bar.text, size=8.0)
        for number, line in enumerate(lines):
            level = middle + 3 + 9.0 * (number - (len(lines) - 1) / 2)
            canvas.text(across.start - 5, level, as_it_is(line), "end", 8.0)
        top += room
    for value, dash in ((0.0, ""), *(() if mark is None else ((mark, "dash"),))):
        inside.line(f"M{float(across.at(value)):.1f} 4V{top:g}", SOFT, 0.8, dash)
    frame.close(x_label, grid=False)
    return Figure(name, lead, canvas.finish(caption), caption)


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
            BLUE if ci95[0] <= 1.0 <= ci95[1] else ORANGE,
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
        f"Bar: thrust given; line: 95 % interval. Dashed: {own}. Orange: the interval does not "
        "hold 1.",
        bars,
        x_label=f"thrust, 1: {own}  [1]",
        x_range=reach,
        mark=1.0,
    )
