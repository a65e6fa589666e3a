"""Panels as data and layout of plotly.js."""

import base64
import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from pipeline.language import ENGLISH, current, translate
from pipeline.report.panels import ZOOM_BUCKETS, Axis, Panel, Trace, thinned
from pipeline.report.plotting import SOFT, VERMILLION
from pipeline.types import FloatArray

Json = dict[str, Any]

_PANEL_PX = 170
_SYMBOLS = {
    ".": "circle", "o": "circle", "x": "x-thin-open", "^": "triangle-up", "v": "triangle-down",
    "s": "square", "D": "diamond",
}  # fmt: skip


def plotly_figure(
    panels: Sequence[Panel], x_label: str, buckets: int = ZOOM_BUCKETS, x_axis: Axis | None = None
) -> Json:
    """Return data and layout as plotly.js takes them; texts are escaped, arrays are float32.

    >>> x = np.arange(3.0)
    >>> found = plotly_figure([Panel("u [m/s]", (Trace("<b>", x, x, "#000"),))], "time [s]")
    >>> found["data"][0]["name"], found["layout"]["xaxis"]["title"]["text"]
    ('&lt;b&gt;', 'time [s]')
    """
    whole = sum(panel.height for panel in panels)
    axis = x_axis or Axis()
    data: list[Json] = []
    shapes: list[Json] = []
    ends: list[Json] = []
    x_axis_of: Json = {"title": {"text": text_of(x_label), "standoff": 8}}
    x_axis_of["anchor"] = f"y{len(panels)}" if len(panels) > 1 else "y"
    if axis.ends is not None:
        x_axis_of["range"] = list(axis.ends)
    if axis.names:
        names = [text_of(name) for name in axis.names]
        x_axis_of |= {"tickvals": list(range(len(names))), "ticktext": names}
    # colours of axes, letters and paper stand in zoom.js
    layout = {
        "height": round(110 + _PANEL_PX * whole),
        "margin": {"l": 64, "r": 12, "t": 62, "b": 78 if axis.names else 48},
        **({} if current() == ENGLISH else {"separators": ", "}),
        "xaxis": x_axis_of,
        "shapes": shapes,
        "annotations": ends,
    }
    top, shown = 1.0, set[str]()
    for number, panel in enumerate(panels, start=1):
        share = panel.height / whole
        suffix = "" if number == 1 else str(number)
        bottom = 0.0 if number == len(panels) else top - share + min(0.04, 0.12 * share)
        layout[f"yaxis{suffix}"] = _y_axis(panel, [round(bottom, 4), round(top, 4)])
        shapes += _shapes(panel, suffix)
        for trace in panel.traces:
            legend = bool(trace.name) and trace.name not in shown
            data += [*_band(trace, suffix), _trace(trace, suffix, buckets, legend=legend)]
            ends += _end(trace, suffix)
            shown.add(trace.name)
        top -= share
    return {"data": data, "layout": layout}


def text_of(words: str) -> str:
    """Translate and escape a text: plotly.js takes markup."""
    return str(escape(translate(words)))


def _y_axis(panel: Panel, domain: list[float]) -> Json:
    own: Json = {"type": "log"} if panel.log else {"rangemode": "tozero"} if panel.from_zero else {}
    if panel.y_range is not None:
        own["range"] = list(panel.y_range)
    return {
        "title": {"text": text_of(panel.label).replace("\n", "<br>"), "standoff": 6},
        "automargin": True,
        "domain": domain,
        "zeroline": panel.band is not None and panel.middle == 0.0,
        **own,
    }


def _shapes(panel: Panel, suffix: str) -> list[Json]:

    def across(low: float, high: float, **more: object) -> Json:
        ends = {"x0": 0, "x1": 1, "y0": low, "y1": high}
        return {"xref": "paper", "yref": f"y{suffix}", "layer": "below", **ends, **more}

    def filled(colour: str, opacity: float) -> Json:
        return {"type": "rect", "fillcolor": colour, "opacity": opacity, "line": {"width": 0}}

    of_axes = {"xref": "x", "yref": f"y{suffix} domain"}
    found = [
        across(0, 1, **filled(span.colour, 0.10)) | of_axes | {"x0": span.start, "x1": span.end}
        for span in panel.spans
    ]
    if panel.band is not None:
        low, high = panel.middle - panel.band, panel.middle + panel.band
        found.append(across(low, high, **filled(SOFT, 0.18)))
        if panel.middle:
            line = {"color": SOFT, "width": 1}
            found.append(across(panel.middle, panel.middle, type="line", line=line))
    dotted = {"color": VERMILLION, "width": 1, "dash": "dot"}
    return found + [across(limit, limit, type="line", line=dotted) for limit in panel.limits]


def _band(trace: Trace, suffix: str) -> list[Json]:
    """Shade what lies between two lines that are not drawn."""
    if trace.band is None:
        return []
    own: Json = {"type": "scatter", "x": packed(trace.x), "yaxis": f"y{suffix}", "mode": "lines"}
    own |= {"line": {"width": 0}, "hoverinfo": "skip", "showlegend": False}
    own["legendgroup"] = text_of(trace.name)
    low, high = ({**own, "y": packed(edge)} for edge in trace.band)
    return [low, {**high, "fill": "tonexty", "fillcolor": f"{trace.colour}38"}]


def _end(trace: Trace, suffix: str) -> list[Json]:
    """Write what stands at the right end of a curve."""
    there = np.flatnonzero(np.isfinite(trace.values))
    if not trace.end or not there.size:
        return []
    at = {"x": float(trace.x[there[-1]]), "y": float(trace.values[there[-1]])}
    place = {**at, "yref": f"y{suffix}", "xanchor": "left", "xshift": 4, "showarrow": False}
    return [{**place, "text": text_of(trace.end), "font": {"size": 11}}]


def _trace(trace: Trace, suffix: str, buckets: int, *, legend: bool) -> Json:
    # a value with an interval, or one that is marked, is never left out
    whole = trace.bars is not None or trace.style in {"points", "both"}
    x, values = (trace.x, trace.values) if whole else thinned(trace.x, trace.values, buckets)
    name, colour = text_of(trace.name), trace.colour
    line = {"color": colour, "width": trace.width}
    line["shape"] = "hv" if trace.style == "steps" else "linear"
    if trace.dash:
        line["dash"] = trace.dash
    symbol = _SYMBOLS[trace.mark] + ("-open" if trace.hollow else "")
    size = 7 if trace.bars is not None else 4 if trace.mark == "." else 6
    bars: Json = {}
    if trace.bars is not None:
        low, high = map(packed, np.abs(trace.bars - trace.values))
        ends = {"type": "data", "symmetric": False, "array": high, "arrayminus": low}
        bars["error_y"] = {**ends, "color": colour, "thickness": 1.5, "width": 4}
    return {
        "type": "scatter",
        "name": name,
        "legendgroup": name,
        "showlegend": legend,
        "x": packed(x),
        "y": packed(values),
        "yaxis": f"y{suffix}",
        "mode": {"points": "markers", "both": "lines+markers"}.get(trace.style, "lines"),
        "line": line,
        "marker": {"color": colour, "size": size, "symbol": symbol},
        "hovertemplate": "%{y:.4g}",
        **bars,
    }


def packed(values: FloatArray) -> dict[str, str]:
    """Encode as plotly.js reads typed arrays; float32 carries seven digits."""
    own = np.ascontiguousarray(values, dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(own.tobytes()).decode("ascii")}


def data_block(figure: Json) -> Markup:
    """Return the data of an interactive figure as zoom.js finds them behind the still picture."""
    text = json.dumps(figure, separators=(",", ":"))
    # a data block ends at the first "</script": no markup may stand in it
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(  # noqa: S704 - escaped two lines above
        f'<script type="application/json" class="zoom-data">{text}</script>'
    )
