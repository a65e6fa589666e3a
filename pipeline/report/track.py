"""Where the vehicle went, from above and in depth, the gap to the simulation in colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
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
    views = [View(time_s, down, "time  [s]", "depth  [m]")]
    if position is not None:
        north, east = position[rows, :2].T
        views = [
            View(east, north, "east  [m]", "north  [m]", (0.0, 0.42), from_above=True),
            replace(views[0], share=(0.63, 1.0)),
        ]
    lead = "Where the vehicle went."
    caption = "Left: from above, the dot is the start. Right: depth."
    if top is not None:
        lead = (
            f"Where the vehicle went; its speed is up to {general(top, 2)} m/s off the simulation."
        )
        caption = (
            "Left: from above, the dot is the start. Right: depth. Bright: measured and simulated "
            "velocity differ."
        )

    def paint(figure: matplotlib.figure.Figure) -> None:
        left, right = 50.0, WIDTH - (58.0 if top is not None else 6.0)
        for view in views:
            low, high = (left + (right - left) * end for end in view.share)
            ticks = (2 if view.from_above else 4, 4)
            axes = axes_at(figure, low, 10.0, high, 122.0, view.x_label, view.y_label, ticks=ticks)
            shown = _line(axes, view.x, view.y, colour, top)
            if view.from_above:
                start = np.flatnonzero(np.isfinite(view.x + view.y))[0]
                axes.plot(view.x[start], view.y[start], "o", color=INK, ms=4)
                axes.set_aspect("equal", adjustable="datalim")
            else:
                axes.invert_yaxis()
        if shown is None:
            return
        bar = axes_at(figure, right + 24.0, 10.0, right + 30.0, 122.0)
        few = bar.yaxis.get_major_locator()
        figure.colorbar(shown, cax=bar, ticks=few)
        bar.tick_params(labelsize=8)
        figure.text(
            (right + 16.0) / WIDTH, 0.5, translate("gap in speed  [m/s]"), size=8, rotation=90,
            ha="center", va="center",
        )  # fmt: skip

    still = draw("fig-track", caption, 152.0, paint)
    return Figure("fig-track", lead, still, caption, data_block(_interactive(views, colour)))


@dataclass(frozen=True)
class View:
    """A view of the track: `y` over `x` (k,), in a share of the width.

    From above a metre is as long either way and the start is marked; else `y` counts downwards.
    """

    x: FloatArray
    y: FloatArray
    x_label: str
    y_label: str
    share: tuple[float, float] = (0.0, 1.0)
    from_above: bool = False


def _interactive(views: Sequence[View], colour: FloatArray | None) -> Json:
    marker: Json = {"color": BLUE}
    layout: Json = {"height": 360, "margin": {"l": 64, "r": 12, "t": 30, "b": 48}}
    if colour is not None:
        bar = {"title": {"text": text_of("gap in speed  [m/s]"), "side": "right"}}
        layout["coloraxis"] = {"cmin": 0, "colorbar": bar}
        marker = {"color": packed(np.append(colour, colour[-1:])), "coloraxis": "coloraxis"}
    data = []
    for k, view in enumerate(views, start=1):
        number = "" if k == 1 else str(k)
        x_title, y_title = (
            {"title": {"text": text_of(own), "standoff": 8}} for own in (view.x_label, view.y_label)
        )
        up = {"scaleanchor": f"x{number}"} if view.from_above else {"autorange": "reversed"}
        layout[f"xaxis{number}"] = {**x_title, "domain": [*view.share], "anchor": f"y{number}"}
        layout[f"yaxis{number}"] = {**y_title, **up, "anchor": f"x{number}", "zeroline": False}
        # the first point of the track from above is its start
        sizes = [10, *[5] * (view.x.size - 1)] if view.from_above else 5
        own = {"line": {"color": SOFT, "width": 1}, "marker": {**marker, "size": sizes}}
        axes = {"xaxis": f"x{number}", "yaxis": f"y{number}", "mode": "lines+markers"}
        data.append({"x": packed(view.x), "y": packed(view.y), **own, **axes})
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
