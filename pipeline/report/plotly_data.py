"""Panels as data and layout of plotly.js."""

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import escape

from pipeline.language import ENGLISH, current, translate
from pipeline.report import plotting
from pipeline.report.decimate import thinned
from pipeline.report.panels import ZOOM_BUCKETS, Axis, Panel, Trace, label_lines
from pipeline.report.plotting import Mark
from pipeline.types import FloatArray

_PANEL_PX = 170
#: Room for each line of a panel's label beyond the second.
_LINE_PX = 20
_SYMBOLS: dict[Mark, str] = {
    ".": "circle",
    "o": "circle",
    "x": "x-thin-open",
    "^": "triangle-up",
    "v": "triangle-down",
    "s": "square",
    "D": "diamond",
}
_INK, _GRID = plotting.INK, "#dfe3e8"


def plotly_figure(
    panels: Sequence[Panel],
    x_label: str,
    buckets: int = ZOOM_BUCKETS,
    *,
    x_axis: Axis | None = None,
) -> dict[str, Any]:
    """Return data and layout as plotly.js takes them; texts are escaped, arrays are float32.

    Examples
    --------
    >>> x = np.arange(3.0)
    >>> found = plotly_figure([Panel("u [m/s]", (Trace("<b>", x, x, "#000"),))], "time [s]")
    >>> found["data"][0]["name"], found["layout"]["xaxis"]["title"]["text"]
    ('&lt;b&gt;', 'time [s]')
    """
    whole = sum(panel.height for panel in panels)
    data: list[dict[str, Any]] = []
    layout = _layout(x_label, round(110 + _PANEL_PX * whole), len(panels), x_axis or Axis())
    layout["margin"]["l"] += _LINE_PX * max(label_lines(panels) - 2, 0)
    shapes: list[dict[str, Any]] = []
    top = 1.0
    shown: set[str] = set()
    for number, panel in enumerate(panels, start=1):
        share = panel.height / whole
        suffix = "" if number == 1 else str(number)
        gap = min(0.04, 0.12 * share)
        bottom = 0.0 if number == len(panels) else top - share + gap
        layout[f"yaxis{suffix}"] = {
            "title": {
                "text": str(escape(translate(panel.label))).replace("\n", "<br>"),
                "standoff": 6,
            },
            "domain": [round(bottom, 4), round(top, 4)],
            "gridcolor": _GRID,
            "zeroline": panel.band is not None and panel.middle == 0.0,
            "zerolinecolor": plotting.SOFT,
            "zerolinewidth": 1,
            "nticks": 6,
            "automargin": False,
            **({"range": list(panel.y_range)} if panel.y_range is not None else {}),
            **({"rangemode": "tozero"} if panel.from_zero else {}),
            **({"type": "log"} if panel.log else {}),
        }
        shapes += _shapes(panel, suffix)
        for trace in panel.traces:
            if trace.band is not None:
                data += _band(trace, suffix)
            legend = bool(trace.name) and trace.name not in shown
            data.append(_trace(trace, suffix, buckets, legend=legend))
            shown.add(trace.name)
        top -= share
    return {"data": data, "layout": {**layout, "shapes": shapes}}


def _layout(x_label: str, height_px: int, panels: int, axis: Axis) -> dict[str, Any]:
    own: dict[str, Any] = {}
    if axis.ends is not None:
        own["range"] = list(axis.ends)
    if axis.names:
        own["tickvals"] = list(range(len(axis.names)))
        own["ticktext"] = [str(escape(translate(name))) for name in axis.names]
    return {
        "height": height_px,
        "margin": {"l": 64, "r": 12, "t": 62, "b": 78 if axis.names else 48},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": _INK},
        "hovermode": "x",
        **({} if current() == ENGLISH else {"separators": ", "}),
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": plotting.SOFT, "activecolor": _INK},
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": 1.0,
            "yanchor": "bottom",
            "itemwidth": 30,
            "font": {"size": 11},
        },
        "xaxis": {
            "title": {"text": str(escape(translate(x_label))), "standoff": 8},
            "anchor": f"y{panels}" if panels > 1 else "y",
            "gridcolor": _GRID,
            "zeroline": False,
            "hoverformat": ".2f",
            **own,
        },
    }


def _shapes(panel: Panel, suffix: str) -> list[dict[str, Any]]:
    """Draw what stands behind the curves."""
    across = {"xref": "paper", "x0": 0, "x1": 1, "yref": f"y{suffix}", "layer": "below"}
    found: list[dict[str, Any]] = [
        {
            "type": "rect",
            "xref": "x",
            "x0": span.start,
            "x1": span.end,
            "yref": f"y{suffix} domain",
            "y0": 0,
            "y1": 1,
            "fillcolor": span.colour,
            "opacity": 0.10,
            "line": {"width": 0},
            "layer": "below",
        }
        for span in panel.spans
    ]
    if panel.band is not None:
        found.append(
            {
                **across,
                "type": "rect",
                "y0": panel.middle - panel.band,
                "y1": panel.middle + panel.band,
                "fillcolor": plotting.SOFT,
                "opacity": 0.18,
                "line": {"width": 0},
            }
        )
        if panel.middle:
            line = {"color": plotting.SOFT, "width": 1}
            ends = {"y0": panel.middle, "y1": panel.middle}
            found.append({**across, **ends, "type": "line", "line": line})
    found += [
        {
            **across,
            "type": "line",
            "y0": limit,
            "y1": limit,
            "line": {"color": plotting.VERMILLION, "width": 1, "dash": "dot"},
        }
        for limit in panel.limits
    ]
    return found


def _band(trace: Trace, suffix: str) -> list[dict[str, Any]]:
    """Shade what lies between two lines that are not drawn."""
    assert trace.band is not None  # noqa: S101 - the caller has seen to it
    own = {
        "type": "scatter",
        "x": _packed(trace.x),
        "yaxis": f"y{suffix}",
        "mode": "lines",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
        "legendgroup": str(escape(translate(trace.name))),
    }
    fill = {"fill": "tonexty", "fillcolor": f"{trace.colour}38"}
    return [{**own, "y": _packed(trace.band[0])}, {**own, **fill, "y": _packed(trace.band[1])}]


def _trace(trace: Trace, suffix: str, buckets: int, *, legend: bool) -> dict[str, Any]:
    # a value with an interval, or one that is marked, is never left out
    whole = trace.bars is not None or trace.style in {"points", "both"}
    x, values = (trace.x, trace.values) if whole else thinned(trace.x, trace.values, buckets)
    name = str(escape(translate(trace.name)))
    bars = {}
    if trace.bars is not None:
        low, high = np.abs(trace.bars - trace.values)
        bars["error_y"] = {
            "type": "data",
            "symmetric": False,
            "array": _packed(high),
            "arrayminus": _packed(low),
            "color": trace.colour,
            "thickness": 1.5,
            "width": 4,
        }
    return {
        "type": "scatter",
        "name": name,
        "legendgroup": name,
        "showlegend": legend,
        "x": _packed(x),
        "y": _packed(values),
        "yaxis": f"y{suffix}",
        "mode": {"points": "markers", "both": "lines+markers"}.get(trace.style, "lines"),
        "line": {
            "color": trace.colour,
            "width": trace.width,
            "shape": "hv" if trace.style == "steps" else "linear",
            **({"dash": trace.dash} if trace.dash else {}),
        },
        "marker": {
            "color": trace.colour,
            "size": 7 if trace.bars is not None else 4 if trace.mark == "." else 6,
            "symbol": _SYMBOLS[trace.mark] + ("-open" if trace.hollow else ""),
        },
        "hovertemplate": "%{y:.4g}",
        **bars,
    }


def _packed(values: FloatArray) -> dict[str, str]:
    """Encode as plotly.js reads typed arrays; float32 carries seven digits."""
    own = np.ascontiguousarray(values, dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(own.tobytes()).decode("ascii")}
