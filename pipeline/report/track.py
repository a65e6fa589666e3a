"""Where the vehicle went, from above and in depth, the gap to the simulation in colour."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from pipeline.language import translate
from pipeline.records.run_table import RunTable
from pipeline.report.blocks import Figure
from pipeline.report.numbers import general
from pipeline.report.plotly_data import Json, data_block, packed, text_of
from pipeline.report.plotting import BLUE, INK, SOFT, WIDTH, axes_at, draw
from pipeline.report.results import RunResults
from pipeline.types import FloatArray, IntArray

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

#: Pieces of the track; each has one colour.
_PIECES = 240


def track_figure(results: RunResults) -> Figure | None:
    """Draw the track; None where neither position nor depth was measured."""
    table = results.measured
    if table is None:
        return None
    position, depth = _of(table, "position"), _of(table, "depth")
    if position is None and depth is None:
        return None
    rows = np.unique(np.linspace(0, table.time_s.size - 1, _PIECES + 1).astype(int))
    time_s = table.time_s[rows]
    down = (depth[:, 0] if depth is not None else position[:, 2])[rows]  # type: ignore[index]
    colour = _gap(results, rows)
    top = None if colour is None else float(np.nanmax(colour))
    plane = None if position is None else position[rows, :2]

    def paint(figure: matplotlib.figure.Figure) -> None:
        right = WIDTH - (58.0 if top is not None else 6.0)
        if plane is not None:
            axes = axes_at(
                figure, 48.0, 10.0, 0.44 * right, 122.0, "east  [m]", "north  [m]", ticks=(2, 4)
            )
            _line(axes, plane[:, 1], plane[:, 0], colour, top)
            start = plane[np.isfinite(plane).all(axis=1)][0]
            axes.plot(start[1], start[0], "o", color=INK, ms=4)
            axes.set_aspect("equal", adjustable="datalim")  # a metre east as long as one north
        left = 52.0 if plane is None else 0.64 * right
        axes = axes_at(figure, left, 10.0, right, 122.0, "time  [s]", "depth  [m]", ticks=(4, 4))
        shown = _line(axes, time_s, down, colour, top)
        axes.invert_yaxis()
        if shown is not None:
            bar = axes_at(figure, right + 24.0, 10.0, right + 30.0, 122.0)
            few = bar.yaxis.get_major_locator()
            figure.colorbar(shown, cax=bar, ticks=few)
            bar.tick_params(labelsize=8)
            figure.text(
                (right + 16.0) / WIDTH, 0.5, translate("gap in speed  [m/s]"), size=8, rotation=90,
                ha="center", va="center",
            )  # fmt: skip

    lead, caption = (
        "Where the vehicle went.",
        "Left: from above, the dot is the start. Right: depth.",
    )
    if top is not None:
        lead = (
            f"Where the vehicle went; its speed is up to {general(top, 2)} m/s off the simulation."
        )
        caption = (
            "Left: from above, the dot is the start. Right: depth. Bright: measured and simulated "
            "velocity differ."
        )
    still = draw("fig-track", caption, 152.0, paint)
    ways = [(time_s, down, "time  [s]", "depth  [m]")]
    ways += [] if plane is None else [(plane[:, 1], plane[:, 0], "east  [m]", "north  [m]")]
    return Figure("fig-track", lead, still, caption, data_block(_interactive(ways, colour)))


def _interactive(
    ways: Sequence[tuple[FloatArray, FloatArray, str, str]], colour: FloatArray | None
) -> Json:
    """Return depth over time and, left of it where it is known, the track from above."""
    marker: Json = {"color": BLUE}
    layout: Json = {"height": 360, "margin": {"l": 64, "r": 12, "t": 12, "b": 48}}
    if colour is not None:
        bar = {"title": {"text": text_of("gap in speed  [m/s]"), "side": "right"}}
        layout["coloraxis"] = {"cmin": 0, "colorbar": bar}
        marker = {"color": packed(np.append(colour, colour[-1:])), "coloraxis": "coloraxis"}
    data = []
    for k, (x, y, x_label, y_label) in enumerate(ways, start=1):
        domain = [0.0, 1.0] if len(ways) == 1 else [0.58, 1.0] if k == 1 else [0.0, 0.42]
        titles = [{"title": {"text": text_of(own), "standoff": 8}} for own in (x_label, y_label)]
        direction = {"autorange": "reversed"} if k == 1 else {"scaleanchor": "x2"}
        number = "" if k == 1 else str(k)
        layout[f"xaxis{number}"] = {**titles[0], "domain": domain, "anchor": f"y{number}"}
        up = {**titles[1], **direction, "anchor": f"x{number}", "zeroline": False}
        layout[f"yaxis{number}"] = up
        axes = {"xaxis": f"x{number}", "yaxis": f"y{number}", "mode": "lines+markers"}
        # the first point of the track from above is its start
        sizes = 5 if k == 1 else [10, *[5] * (x.size - 1)]
        own = {**marker, "size": sizes}
        line = {"color": SOFT, "width": 1}
        data.append({"x": packed(x), "y": packed(y), "line": line, "marker": own, **axes})
    return {"data": data, "layout": {**layout, "showlegend": False, "hovermode": "closest"}}


def _of(table: RunTable, name: str) -> FloatArray | None:
    """Return valid readings of a quantity, (n, columns); None where there are none."""
    if name not in table.values:
        return None
    own = np.asarray(table.values[name], float).reshape(table.time_s.size, -1)
    found = np.where(np.asarray(table.valid[name], bool)[:, None], own, np.nan)
    return found if np.isfinite(found).any() else None


def _gap(results: RunResults, rows: IntArray) -> FloatArray | None:
    """Largest difference of the velocities between rows; None where it is not known. [m/s]."""
    measured, windows = results.measured, results.windows
    own = None if measured is None else _of(measured, "velocity")
    if own is None or windows is None or "velocity" not in windows.values:
        return None
    gap = np.linalg.norm(own - windows.values["velocity"], axis=1)
    pieces = np.array([np.fmax.reduce(gap[a:b]) for a, b in pairwise(rows)])
    return pieces if np.isfinite(pieces).any() else None


def _line(
    axes: Axes, x: FloatArray, y: FloatArray, colour: FloatArray | None, top: float | None
) -> LineCollection | None:
    from matplotlib.collections import LineCollection

    if colour is None or top is None:
        axes.plot(x, y, color=BLUE, lw=1.4)
        return None
    points = np.column_stack([x, y])
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    whole = np.isfinite(pieces).all(axis=(1, 2))
    lines = LineCollection(list(pieces[whole]), cmap="viridis", linewidths=1.8)
    lines.set_array(np.nan_to_num(colour[whole]))
    lines.set_clim(0.0, top)
    axes.add_collection(lines)
    axes.autoscale()
    return lines
