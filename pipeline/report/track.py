"""Where the vehicle went, from above and in depth, the gap to the simulation in colour."""

from itertools import pairwise

import numpy as np

from pipeline.report.blocks import Figure
from pipeline.report.numbers import general
from pipeline.report.plotting import BLUE, INK, WIDTH, Canvas, Frame, Scale, path, shades
from pipeline.report.run_results import RunResults
from pipeline.types import BoolArray, FloatArray

#: Pieces of the track; each has one colour.
_PIECES = 240


def track_figure(results: RunResults) -> Figure | None:
    """Draw the track; None where neither position nor depth was measured."""
    table = results.measured
    if table is None:
        return None
    position = _of(table.values, table.valid, "position", 3)
    depth = _of(table.values, table.valid, "depth", 1)
    down = depth[:, 0] if depth is not None else None if position is None else position[:, 2]
    if down is None:
        return None
    gap = _gap(results)
    rows = np.unique(np.linspace(0, table.time_s.size - 1, _PIECES + 1).astype(int))
    time_s, down = table.time_s[rows], down[rows]
    colour = None if gap is None else np.array([_largest(gap[a:b]) for a, b in pairwise(rows)])
    top = None if colour is None or not np.isfinite(colour).any() else float(np.nanmax(colour))
    plane = None if position is None else position[rows, :2]

    canvas = Canvas(152.0)
    right = WIDTH - (58.0 if top is not None else 6.0)
    ends = (0.44 * right, 0.64 * right) if plane is not None else (0.0, 52.0)
    if plane is not None:
        # one metre is as long to the east as to the north
        low, high = np.nanmin(plane, axis=0), np.nanmax(plane, axis=0)
        middle, wide, tall = (low + high) / 2, ends[0] - 48.0, 112.0
        metres = 1.1 * max(float((high - low)[1]) / wide, float((high - low)[0]) / tall, 1e-3)
        half = metres * np.array([tall, wide]) / 2
        east = Scale(middle[1] - half[1], middle[1] + half[1], 48.0, ends[0])
        north = Scale(middle[0] - half[0], middle[0] + half[0], 122.0, 10.0)
        frame = Frame(canvas, east, north)
        _line(frame, plane[:, 1], plane[:, 0], colour, top)
        start = plane[np.isfinite(plane).all(axis=1)][:1]
        frame.inside.marks(east.at(start[:, 1]), north.at(start[:, 0]), INK)
        frame.close("east  [m]", "north  [m]", most=2)
    room = 0.05 * float(np.nanmax(down) - np.nanmin(down)) + 1e-6
    deep = Scale(float(np.nanmax(down)) + room, float(np.nanmin(down)) - room, 122.0, 10.0)
    frame = Frame(canvas, Scale(float(time_s[0]), float(time_s[-1]), ends[1], right), deep)
    _line(frame, time_s, down, colour, top)
    frame.close("time  [s]", "depth  [m]", most=4)
    if top is not None:
        _colour_bar(canvas, right + 24.0, top)
    lead = (
        "Where the vehicle went."
        if top is None
        else f"Where the vehicle went; its speed is up to {general(top, 2)} m/s off the simulation."
    )
    return Figure(
        "fig-track",
        lead,
        canvas.finish(
            "Track of the vehicle from above, and its depth against time; bright where the "
            "simulation is off."
        ),
        "Left: from above, the dot is the start. Right: depth. Bright: measured and simulated "
        "velocity differ."
        if top is not None
        else "Left: from above, the dot is the start. Right: depth.",
    )


def _of(
    values: dict[str, FloatArray], valid: dict[str, BoolArray], name: str, columns: int
) -> FloatArray | None:
    own = values.get(name)
    if own is None:
        return None
    found = np.asarray(own, float).reshape(len(own), -1)[:, :columns]
    found = np.where(np.asarray(valid[name], bool)[:, None], found, np.nan)
    return found if np.isfinite(found).any() else None


def _gap(results: RunResults) -> FloatArray | None:
    """Length of the difference of the velocities, (m,). [m/s]."""
    measured, windows = results.measured, results.windows
    if measured is None or windows is None or "velocity" not in windows.values:
        return None
    if "velocity" not in measured.values:
        return None
    own = np.where(measured.valid["velocity"][:, None], measured.values["velocity"], np.nan)
    return np.asarray(np.linalg.norm(own - windows.values["velocity"], axis=1))


def _largest(values: FloatArray) -> float:
    there = values[np.isfinite(values)]
    return float(there.max()) if there.size else float("nan")


def _line(
    frame: Frame, x: FloatArray, y: FloatArray, colour: FloatArray | None, top: float | None
) -> None:
    """Draw a track, each piece in the colour of its gap."""
    at, levels = frame.x.at(x), frame.y.at(y)
    if colour is None or top is None:
        frame.inside.line(path(at, levels), BLUE, 1.4)
        return
    for k, shade in enumerate(shades(np.nan_to_num(colour) / max(top, 1e-12))):
        frame.inside.line(path(at[k : k + 2], levels[k : k + 2]), shade, 1.8)


def _colour_bar(canvas: Canvas, left: float, top: float) -> None:
    scale = Scale(0.0, top, 122.0, 10.0)
    for k, shade in enumerate(shades(np.linspace(0.0, 1.0, 28))):
        canvas.area(f"M{left:g} {122 - 4 * k:g}h6v-4h-6", shade)
    for value, text in scale.ticks(4):
        canvas.text(left + 9, float(scale.at(value)) + 3, text, size=8.0)
    canvas.text(left - 4, 66, "gap in speed  [m/s]", "middle", 8.0, -90.0)
