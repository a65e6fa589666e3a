"""Horizontal bars with intervals: one drawing for gains, probabilities and loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from pipeline.language import translate
from pipeline.report.blocks import Figure
from pipeline.report.plotly_data import Json, data_block, text_of
from pipeline.report.plotting import BLUE, INK, ORANGE, SOFT, WIDTH, axes_at, draw

if TYPE_CHECKING:
    import matplotlib.figure

#: Gains beyond this are drawn at the edge; the table has the number.
_GAINS = (-1.5, 2.5)
#: A longer name of a bar goes on below.
_LETTERS = 30


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
    name: str, lead: str, caption: str, bars: Sequence[Bar], *, x_label: str,
    x_range: tuple[float, float], mark: float | None = None,
) -> Figure:  # fmt: skip
    """Draw a bar from 0 for each value, from top to bottom, its interval across its end.

    What lies beyond `x_range` is drawn at the edge; `mark` is where a dashed line stands.
    """
    labels = [
        fill(translate(bar.label), _LETTERS, break_on_hyphens=False, break_long_words=False)
        for bar in bars
    ]
    letters = max((len(line) for label in labels for line in label.split("\n")), default=0)
    left = min(12.0 + 4.9 * letters, 0.55 * WIDTH)
    rows = np.array([14.0 + 9.0 * (1 + label.count("\n")) for label in labels])
    levels, whole = np.cumsum(rows) - rows / 2, float(rows.sum())
    values = np.clip([bar.value for bar in bars], *x_range)
    sure = [k for k, bar in enumerate(bars) if bar.ci95 is not None]
    ends = np.clip(np.array([bar.ci95 for bar in bars if bar.ci95]).reshape(-1, 2), *x_range)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = axes_at(figure, left, 4.0, WIDTH - 8.0, whole + 4.0, x_label)
        axes.barh(levels, values, 12.0, color=[bar.colour for bar in bars])
        middle, half = ends.mean(axis=1), np.diff(ends)[:, 0] / 2
        axes.errorbar(
            middle, levels[sure], xerr=half, fmt="none", ecolor=INK, elinewidth=1.2, capsize=3
        )
        for bar, value, level in zip(bars, values, levels, strict=True):
            if bar.text:
                axes.annotate(
                    translate(bar.text), (value, level), (4, 0), textcoords="offset points",
                    va="center", fontsize=8,
                )  # fmt: skip
        axes.axvline(0.0, color=SOFT, lw=0.8)
        if mark is not None:
            axes.axvline(mark, color=SOFT, lw=0.8, ls="--")
        axes.set_yticks(levels, labels, fontsize=8)
        axes.set(xlim=x_range, ylim=(whole, 0.0))
        axes.grid(visible=False, axis="y")

    low, high = np.array([bar.ci95 or (bar.value, bar.value) for bar in bars]).reshape(-1, 2).T
    own = np.array([bar.value for bar in bars])
    data: Json = {
        "type": "bar", "orientation": "h", "x": own.tolist(), "y": list(range(len(bars))),
        "customdata": [text_of(bar.label) for bar in bars],
        "text": [text_of(bar.text) for bar in bars], "textposition": "outside",
        "marker": {"color": [bar.colour for bar in bars]},
        "hovertemplate": "%{x:.4g}<extra></extra>",
    }  # fmt: skip
    if sure:
        ends_of = {"array": (high - own).tolist(), "arrayminus": (own - low).tolist()}
        data["error_x"] = {"type": "data", "symmetric": False, "color": INK, **ends_of}
    names = [text_of(label).replace("\n", "<br>") for label in labels]
    bare = {"showgrid": False, "zeroline": False}
    dashed = {"color": SOFT, "width": 1, "dash": "dash"}
    line = {"type": "line", "yref": "paper", "x0": mark, "x1": mark, "y0": 0, "y1": 1}
    layout = {
        "height": round(80 + 1.6 * whole),
        "margin": {"l": 24 + 7 * letters, "r": 12, "t": 30, "b": 48},
        "xaxis": {"title": {"text": text_of(x_label), "standoff": 8}, "range": list(x_range)},
        "yaxis": {"tickvals": data["y"], "ticktext": names, "autorange": "reversed", **bare},
        "hovermode": "closest",
        "shapes": [] if mark is None else [{**line, "line": dashed}],
    }  # fmt: skip
    still = draw(name, caption, whole + 34.0, paint)
    return Figure(name, lead, still, caption, data_block({"data": [data], "layout": layout}))


def gains_figure(
    name: str,
    gains: Sequence[tuple[str, float | None, tuple[float, float] | None]],
    lead: str,
    one_is: str = "as the vehicle file says",
) -> Figure:
    """Draw gains (name, value, interval); those whose interval does not hold 1 are orange.

    What has no interval is left out; `one_is` says what a gain of 1 means.
    """
    bars = [
        Bar(label, value, ci95, BLUE if ci95[0] <= 1.0 <= ci95[1] else ORANGE)
        for label, value, ci95 in gains
        if value is not None and ci95 is not None
    ]
    own = translate(one_is)
    ends = [end for bar in bars for end in bar.ci95 or ()]
    low, high = min([0.0, *ends]) - 0.05, max([1.2, *ends]) + 0.05
    reach = max(low, _GAINS[0]), min(high, _GAINS[1])
    return bars_figure(
        name,
        lead,
        f"Bar: thrust given; line: 95 % interval. Dashed: {own}. Orange: the interval does not "
        "hold 1.",
        bars,
        x_label=f"thrust, 1: {own}  [–]",
        x_range=reach,
        mark=1.0,
    )
