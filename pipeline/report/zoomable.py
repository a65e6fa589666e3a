"""Curves over a common axis: a still picture in every page, with zoom where scripts may run.

One description is drawn twice: by matplotlib, as SVG that is there without scripts and on paper,
and as the data of an interactive figure that takes its place once plotly.js has loaded. That
library (MIT) lies beside the pages and is never fetched from a network.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from pipeline.language import translate
from pipeline.report.blocks import Figure
from pipeline.report.panels import Axis, Panel, Resolution, Span, Style, Trace, thinned
from pipeline.report.plotly_data import data_block, plotly_figure
from pipeline.report.plotting import GRID, SOFT, VERMILLION, WIDTH, axes_at, draw, log_ticks

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

__all__ = ["Axis", "Panel", "Resolution", "Span", "Style", "Trace", "zoomable_figure"]

#: Room beside and below the panels, height of one, and of that what parts it from the next. [pt]
_LEFT, _BOTTOM, _ROW, _GAP = 43.0, 20.0, 97.0, 9.0
#: Further room for each line of a panel's label, and for each of the legend. [pt]
_LINE, _ENTRY = 10.5, 12.0
#: More points are embedded as a picture: the page stays small.
_VECTOR_POINTS = 500


def zoomable_figure(
    name: str, lead: str, caption: str, panels: Sequence[Panel], *, x_label: str,
    x_axis: Axis | None = None, resolution: Resolution | None = None,
) -> Figure:  # fmt: skip
    """Draw panels above each other over a common horizontal axis, still and interactive.

    `name` is unique on the page, of letters, digits and hyphens; `lead` the sentence above and
    `caption` what is drawn how, for those who do not see it as well. Curves of one name share a
    line of the legend. `resolution` is coarser where a page has many figures.
    """
    chosen = resolution if resolution is not None else Resolution()
    axis = x_axis if x_axis is not None else Axis()
    data = plotly_figure(panels, x_label, chosen.zoom, x_axis=axis)
    still = _still(name, caption or lead, panels, x_label, axis, chosen.still)
    return Figure(name, lead, still, caption, zoom=data_block(data))


def _still(  # noqa: PLR0917 - what is drawn, and how it is called
    name: str, alt: str, panels: Sequence[Panel], x_label: str, axis: Axis, buckets: int
) -> Markup:
    traces = [one for panel in panels for one in panel.traces]
    names = list(dict.fromkeys(translate(one.name) for one in traces if one.name))
    columns = _columns(names)
    top = 6.0 + _ENTRY * -(-len(names) // columns)
    left = _LEFT + _LINE * max(1 + panel.label.count("\n") for panel in panels)
    right = WIDTH - (22.0 if any(one.end for one in traces) else 10.0)
    words = [translate(one) for one in axis.names]
    slanted = max(map(len, words), default=0) > 7
    bottom = _BOTTOM + (2.5 * max(map(len, words)) if slanted else 0.0)

    x = np.concatenate([np.zeros(0), *(one.x[np.isfinite(one.x)] for one in traces)])
    first, last = (float(x.min()), float(x.max())) if x.size else (0.0, 1.0)
    room = 0.01 * (last - first) or 1.0
    ends = axis.ends or (first - room, last + room)

    def paint(figure: matplotlib.figure.Figure) -> None:
        low = top
        rows: list[Axes] = []
        named: dict[str, Line2D] = {}
        for panel in panels:
            high, low = low, low + _ROW * panel.height
            below = x_label if panel is panels[-1] else None
            plain = not (panel.log or words)
            rows.append(
                axes_at(figure, left, high, right, low - _GAP, below, panel.label, plain=plain)
            )
            rows[-1].set_xlim(ends)
            _paint_panel(rows[-1], panel, buckets, named)
        lowest = rows.pop()
        if words:
            at = [k for k, one in enumerate(words) if one]
            lowest.set_xticks(at, [words[k] for k in at])
            if slanted:
                lowest.tick_params(axis="x", rotation=30)
        for axes in rows:  # one collection of lines costs less than an axis with ticks
            places = axes.get_xaxis_transform()
            axes.vlines(lowest.get_xticks(), 0.0, 1.0, GRID, lw=0.6, transform=places, zorder=0.5)
        if named:
            figure.legend(list(named.values()), names, loc="upper left", ncols=columns)

    return draw(name, alt, top + sum(_ROW * panel.height for panel in panels) + bottom, paint)


def _columns(names: Sequence[str]) -> int:
    """Return the columns of a legend that fit into the width."""
    for count in range(len(names), 1, -1):
        letters = [max(map(len, own)) for own in np.array_split(np.array(names, object), count)]
        if sum(28.0 + 5.2 * own for own in letters) < WIDTH:
            return count
    return 1


def _paint_panel(axes: Axes, panel: Panel, buckets: int, named: dict[str, Line2D]) -> None:
    if panel.log:
        axes.set_yscale("log", nonpositive="mask")
    for span in panel.spans:
        axes.axvspan(span.start, span.end, color=span.colour, alpha=0.1, lw=0)
    if panel.band is not None:
        low, high = panel.middle - panel.band, panel.middle + panel.band
        axes.axhspan(low, high, color=SOFT, alpha=0.22, lw=0)
        axes.axhline(panel.middle, color=SOFT, lw=0.7)
    for limit in panel.limits:
        axes.axhline(limit, color=VERMILLION, lw=0.6, ls=":")
    for trace in panel.traces:
        line = _paint_trace(axes, trace, buckets)
        if trace.name:
            named.setdefault(translate(trace.name), line)
    if panel.y_range is not None:
        axes.set_ylim(panel.y_range)
    elif panel.from_zero and axes.get_ylim()[1] > 0.0:
        axes.set_ylim(bottom=0.0)
    if panel.log:
        log_ticks(axes)


def _paint_trace(axes: Axes, trace: Trace, buckets: int) -> Line2D:
    rising = trace.style in {"line", "steps"}
    x, values = thinned(trace.x, trace.values, buckets) if rising else (trace.x, trace.values)
    if trace.band is not None:
        axes.fill_between(trace.x, *trace.band, color=trace.colour, alpha=0.22, lw=0)
    if trace.bars is not None:
        reach = np.abs(trace.bars - trace.values)
        axes.errorbar(
            trace.x, trace.values, reach, fmt="none", ecolor=trace.colour, elinewidth=0.8,
            capsize=2,
        )  # fmt: skip
    (line,) = axes.plot(
        x,
        values,
        color=trace.colour,
        lw=trace.width,
        ls="" if trace.style == "points" else {"": "-", "dash": "--", "dot": ":"}[trace.dash],
        marker="" if rising else trace.mark,
        mfc="white" if trace.hollow else trace.colour,
        ms=4.4 if trace.mark == "." else 4.0,
        mew=0.8,
        drawstyle="steps-post" if trace.style == "steps" else "default",
        rasterized=not rising and len(x) > _VECTOR_POINTS,
    )
    there = np.flatnonzero(np.isfinite(values))
    if trace.end and there.size:
        at = (float(x[there[-1]]), float(values[there[-1]]))
        axes.annotate(
            translate(trace.end), at, (3, 0), textcoords="offset points", va="center", fontsize=7
        )
    return line
