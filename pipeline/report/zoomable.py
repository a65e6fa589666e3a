"""Curves over a common axis: a still picture in every page, with zoom where scripts may run.

One description is drawn twice: as SVG, which is there without scripts and on paper, and as the data
of an interactive figure that takes its place once the plotting library has loaded. The library
(plotly.js, MIT) lies beside the pages and is never fetched from a network.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from pipeline.language import translate
from pipeline.report.blocks import Figure
from pipeline.report.decimate import thinned
from pipeline.report.panels import Axis, Panel, Resolution, Trace, label_lines
from pipeline.report.plotly_data import plotly_figure
from pipeline.report.plotting import SOFT, VERMILLION, WIDTH, Canvas, Frame, Scale, path
from pipeline.types import FloatArray

#: Room beside and below the panels, height of one, and of that what parts it from the next. [pt]
_LEFT, _BOTTOM, _ROW, _GAP = 54.0, 20.0, 97.0, 9.0
#: Room for each line of a panel's label beyond the second. [pt]
_LINE = 10.5


def zoomable_figure(
    name: str,
    lead: str,
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
    lead, caption : str
        The sentence above, and what is drawn how, for those who do not see it as well.
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
    data = plotly_figure(panels, x_label, chosen.zoom, x_axis=axis)
    still = _still(panels, x_label, axis, chosen.still).finish(caption or lead)
    return Figure(name, lead, still, caption, zoom=_data_block(data))


def _still(panels: Sequence[Panel], x_label: str, axis: Axis, buckets: int) -> Canvas:
    legend = {one.name: one for panel in panels for one in reversed(panel.traces) if one.name}
    legend = {name: legend[name] for name in _names(panels)}
    canvas = Canvas(0.0)
    top = _legend(canvas, legend) + 6.0
    bottom = _BOTTOM + (22.0 if axis.names else 0.0)
    canvas.height = top + bottom + sum(_ROW * panel.height for panel in panels)
    left = _LEFT + _LINE * max(label_lines(panels) - 2, 0)
    ends = any(trace.end for panel in panels for trace in panel.traces)
    low, high = axis.ends or _range([trace.x for panel in panels for trace in panel.traces], 0.01)
    across = Scale(low, high, left, WIDTH - (22.0 if ends else 10.0))
    names = [(float(k), name) for k, name in enumerate(axis.names) if name] or None
    for panel in panels:
        end = top + _ROW * panel.height
        frame = Frame(canvas, across, Scale(*_heights(panel), end - _GAP, top, log=panel.log))
        _paint(frame, panel, buckets)
        frame.close(x_label if panel is panels[-1] else None, panel.label, x_ticks=names)
        top = end
    return canvas


def _names(panels: Sequence[Panel]) -> list[str]:
    names = (trace.name for panel in panels for trace in panel.traces if trace.name)
    return list(dict.fromkeys(names))


def _legend(canvas: Canvas, legend: dict[str, Trace]) -> float:
    """Write the names of the curves from left to right; return where their last line ends."""
    x, y = 4.0, 10.0
    for name, trace in legend.items():
        room = 26.0 + 5.4 * len(translate(name))
        if x > 4.0 and x + room > WIDTH:
            x, y = 4.0, y + 12.0
        at = x + np.array([6.5] if trace.style == "points" else [0.0, 13.0])
        _stroke(canvas, trace, at, np.full(at.size, y - 3.0))
        canvas.text(x + 17.0, y, name, size=8.5)
        x += room
    return y if legend else 0.0


def _range(values: Sequence[FloatArray], margin: float) -> tuple[float, float]:
    every = np.concatenate([np.ravel(one) for one in values]) if values else np.zeros(0)
    every = every[np.isfinite(every)]
    low, high = (float(every.min()), float(every.max())) if every.size else (0.0, 1.0)
    room = margin * (high - low) or 0.05 * abs(high) or 1.0
    return low - room, high + room


def _heights(panel: Panel) -> tuple[float, float]:
    """Return the ends of a panel's vertical axis: all that is drawn on it, with some room."""
    if panel.y_range is not None:
        return panel.y_range
    found = [one.values for one in panel.traces]
    found += [one for trace in panel.traces for one in (trace.band, trace.bars) if one is not None]
    found += [np.array([one]) for one in panel.limits]
    if panel.band is not None:
        found.append(panel.middle + np.array([-panel.band, panel.band]))
    if panel.log:
        low, high = _range([np.log10(one[one > 0.0]) for one in found], 0.05)
        return 10.0**low, 10.0**high
    low, high = _range(found, 0.05)
    return (0.0 if panel.from_zero and high > 0.0 else low), high


def _paint(frame: Frame, panel: Panel, buckets: int) -> None:
    inside, x, y = frame.inside, frame.x, frame.y
    for span in panel.spans:
        frame.down(span.start, span.end, span.colour, 0.1)
    if panel.band is not None:
        frame.across(panel.middle - panel.band, panel.middle + panel.band, SOFT, 0.22)
        inside.line(f"M{x.start:g} {float(y.at(panel.middle)):.1f}H{x.end:g}", SOFT, 0.7)
    for limit in panel.limits:
        inside.line(f"M{x.start:g} {float(y.at(limit)):.1f}H{x.end:g}", VERMILLION, 0.6, "dot")
    for trace in panel.traces:
        rising = trace.style in {"line", "steps"}
        own = thinned(trace.x, trace.values, buckets) if rising else (trace.x, trace.values)
        at, levels = x.at(own[0]), y.at(own[1])
        if trace.band is not None:
            there = np.isfinite(trace.band).all(axis=0)
            edge, (low, high) = x.at(trace.x[there]), (y.at(one[there]) for one in trace.band)
            around = np.concatenate([edge, edge[::-1]]), np.concatenate([low, high[::-1]])
            inside.area(path(*around), trace.colour, 0.22)
        if trace.bars is not None:
            for a, low, high in zip(x.at(trace.x), *(y.at(one) for one in trace.bars), strict=True):
                inside.line(
                    f"M{a:.1f} {low:.1f}V{high:.1f}m-2 0h4M{a - 2:.1f} {low:.1f}h4", trace.colour
                )
        _stroke(inside, trace, at, levels)
        if trace.end and np.isfinite(levels).any():
            last = np.flatnonzero(np.isfinite(levels))[-1]
            frame.canvas.text(float(at[last]) + 3, float(levels[last]) + 3, trace.end, size=8.0)


def _stroke(canvas: Canvas, trace: Trace, at: FloatArray, levels: FloatArray) -> None:
    """Draw a curve as its style says, at places on the canvas."""
    if trace.style != "points":
        d = path(at, levels, steps=trace.style == "steps")
        canvas.line(d, trace.colour, trace.width, trace.dash)
    if trace.style in {"points", "both"}:
        canvas.marks(at, levels, trace.colour, trace.mark, trace.hollow)


def _data_block(figure: dict[str, Any]) -> Markup:
    text = json.dumps(figure, separators=(",", ":"))
    # a data block ends at the first "</script": no markup may stand in it
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(  # noqa: S704 - escaped two lines above
        f'<script type="application/json" class="zoom-data">{text}</script>'
    )
