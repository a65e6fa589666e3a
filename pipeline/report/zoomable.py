"""Curves over a common axis: a still picture in every page, with zoom where scripts may run.

One description is drawn twice: as SVG, which is there without scripts and on paper, and as the data
of an interactive figure that takes its place once the plotting library has loaded. The library
(plotly.js, MIT) lies beside the pages and is never fetched from a network.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.decimate import thinned
from pipeline.report.panels import Panel, Resolution, Span, Style, Trace, label_lines
from pipeline.report.plotly_data import Axis, plotly_figure

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes

__all__ = [
    "Axis",
    "Panel",
    "Resolution",
    "Span",
    "Style",
    "Trace",
    "plotly_figure",
    "zoomable_figure",
]

_LEFT_IN, _RIGHT_IN, _TOP_IN, _BOTTOM_IN, _ROW_IN = 0.68, 0.08, 0.32, 0.46, 1.35
#: Of the legend: names in a line, letters that fit into one, height of a further line.
_COLUMNS, _LETTERS, _LEGEND_IN = 4, 44, 0.17
#: Room for each line of a panel's label beyond the second.
_LINE_IN = 0.3


def zoomable_figure(
    name: str,
    lead: str,
    alt: str,
    caption: str,
    panels: Sequence[Panel],
    *,
    x_label: str,
    x_axis: Axis | None = None,
    resolution: Resolution | None = None,
) -> Figure:
    """Draw panels above each other over a common horizontal axis.

    Parameters
    ----------
    name : str
        Unique on the page, of letters, digits and hyphens.
    lead, alt, caption : str
        The sentence above, the text for those who do not see the picture, and what is drawn how.
    panels : sequence of Panel
        From above to below; curves of one name share a line of the legend.
    x_label : str
        With its unit.
    x_axis : Axis, optional
        Ends, or names in the place of numbers.
    resolution : Resolution, optional
        Coarser where a page has many figures.

    Returns
    -------
    Figure
        With the still picture and the data of the interactive one.
    """
    chosen = resolution if resolution is not None else Resolution()
    axis = x_axis if x_axis is not None else Axis()
    names = dict.fromkeys(trace.name for panel in panels for trace in panel.traces if trace.name)
    columns = max(min(_COLUMNS, _LETTERS // (max(map(len, names), default=1) + 4)), 1)
    top_in = _TOP_IN + _LEGEND_IN * max(-(-len(names) // columns) - 1, 0)
    rows_in = _ROW_IN * sum(panel.height for panel in panels)
    height_in = top_in + _BOTTOM_IN + (0.3 if axis.names else 0.0) + rows_in
    frame = _Frame(x_label, axis, chosen.still, height_in, top_in, columns)
    svg = plotting.draw(name, alt, _painter(panels, frame), height_in=height_in)
    data = plotly_figure(panels, x_label, chosen.zoom, x_axis=axis)
    return Figure(name, lead, svg, caption, zoom=_data_block(data))


@dataclass(frozen=True)
class _Frame:
    """What stands around the panels."""

    x_label: str
    axis: Axis
    buckets: int
    height_in: float
    top_in: float
    columns: int


def _painter(panels: Sequence[Panel], frame: _Frame) -> Callable[[matplotlib.figure.Figure], None]:
    axis, height_in = frame.axis, frame.height_in

    def paint(figure: matplotlib.figure.Figure) -> None:
        # margins by hand: finding the room for every label takes seconds a page
        figure.set_layout_engine(None)
        left_in = _LEFT_IN + _LINE_IN * max(label_lines(panels) - 2, 0)
        figure.subplots_adjust(
            left=left_in / plotting.WIDTH_IN,
            right=1.0 - _RIGHT_IN / plotting.WIDTH_IN,
            top=1.0 - frame.top_in / height_in,
            bottom=(_BOTTOM_IN + (0.3 if axis.names else 0.0)) / height_in,
            hspace=0.14,
        )
        rows = figure.subplots(
            len(panels),
            1,
            sharex=True,
            squeeze=False,
            height_ratios=[panel.height for panel in panels],
        )[:, 0]
        named: dict[str, Any] = {}
        for axes, panel in zip(rows, panels, strict=True):
            _paint_panel(axes, panel, frame.buckets, named)
        rows[-1].set_xlabel(frame.x_label)
        rows[-1].margins(x=0.01)
        if axis.ends is not None:
            rows[-1].set_xlim(axis.ends)
        if axis.names:
            rows[-1].set_xticks(range(len(axis.names)), axis.names, rotation=30, ha="right")
        figure.legend(
            named.values(),
            named.keys(),
            loc="upper left",
            ncols=frame.columns,
            bbox_to_anchor=(0.0, 1.0),
        )

    return paint


def _paint_panel(axes: Axes, panel: Panel, buckets: int, named: dict[str, Any]) -> None:
    from matplotlib.ticker import MaxNLocator

    for span in panel.spans:
        axes.axvspan(span.start, span.end, color=span.colour, alpha=0.10, lw=0)
    if panel.band is not None:
        low, high = panel.middle - panel.band, panel.middle + panel.band
        axes.axhspan(low, high, color=plotting.SOFT, alpha=0.22, lw=0)
        axes.axhline(panel.middle, color=plotting.SOFT, lw=0.7)
    for limit in panel.limits:
        axes.axhline(limit, color=plotting.VERMILLION, lw=0.6, ls=":")
    for trace in panel.traces:
        _paint_trace(axes, trace, buckets, named)
    if panel.y_range is not None:
        axes.set_ylim(panel.y_range)
    elif panel.from_zero:
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel(panel.label)
    axes.yaxis.set_label_coords(-0.14, 0.5)
    if panel.log:
        plotting.plain_log_axis(axes)
    else:
        axes.yaxis.set_major_locator(MaxNLocator(nbins=4, steps=[1, 2, 5, 10], min_n_ticks=2))


def _paint_trace(axes: Axes, trace: Trace, buckets: int, named: dict[str, Any]) -> None:
    rising = trace.style in {"line", "steps"}
    x, values = thinned(trace.x, trace.values, buckets) if rising else (trace.x, trace.values)
    if trace.band is not None:
        axes.fill_between(trace.x, *trace.band, color=trace.colour, alpha=0.22, lw=0)
    (line,) = axes.plot(
        x,
        values,
        color=trace.colour,
        lw=0.8 * trace.width,
        ls="" if trace.style == "points" else {"": "-", "dash": "--", "dot": ":"}[trace.dash],
        marker="" if rising else trace.mark,
        mfc="white" if trace.hollow else trace.colour,
        ms=3 if trace.mark == "." else 4,
        drawstyle="steps-post" if trace.style == "steps" else "default",
        rasterized=len(x) > plotting.VECTOR_POINTS_MAX and not rising,
    )
    if trace.bars is not None:
        axes.errorbar(
            trace.x,
            trace.values,
            yerr=np.abs(trace.bars - trace.values),
            fmt="none",
            ecolor=trace.colour,
            elinewidth=1.2,
            capsize=2,
        )
    if trace.end and len(x):
        plotting.line_end_label(axes, x, values, trace.end)
    if trace.name:
        named.setdefault(trace.name, line)


def _data_block(figure: dict[str, Any]) -> Markup:
    text = json.dumps(figure, separators=(",", ":"))
    # a data block ends at the first "</script": no markup may stand in it
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(  # noqa: S704 - escaped two lines above
        f'<script type="application/json" class="zoom-data">{text}</script>'
    )
