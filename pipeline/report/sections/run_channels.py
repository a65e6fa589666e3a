"""Figures of one pool run: commands, and every channel measured and simulated with its residual."""

from dataclasses import dataclass

import numpy as np

from pipeline.records.manoeuvre import ManoeuvreFound
from pipeline.records.trial import ChannelError
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.channels import channel_name, short_name, shown_unit
from pipeline.report.numbers import code, general
from pipeline.report.zoomable import Axis, Panel, Resolution, Span, Style, Trace, zoomable_figure
from pipeline.types import FloatArray

#: Quantity -> what it is called.
TITLES: dict[str, str] = {
    "velocity": "Velocity over ground, body axes",
    "angular_velocity": "Angular velocity, body axes",
    "attitude": "Attitude",
    "depth": "Depth",
    "position": "Position",
    "specific_force": "Specific force",
    "shaft_speed": "Shaft speed",
    "voltage": "Supply voltage",
}
#: Fewer readings than this are drawn as points.
FEW_READINGS = 400
#: A longer name does not stand beside a thruster's panel.
LONGEST_LABEL = 12
#: Curves of one component: measured, free run, windows, error.
CURVES = 4
TIME_LABEL = "time since the start of the log  [s]"


@dataclass(frozen=True)
class ChannelSeries:
    """One component to be drawn: readings, what was simulated at them, all (k,)."""

    error: ChannelError
    time_s: FloatArray
    measured: FloatArray
    windows: FloatArray
    residual: FloatArray
    free_time_s: FloatArray
    free: FloatArray


def channel_figure(
    quantity: str, series: tuple[ChannelSeries, ...], duration_s: float, detail: Resolution
) -> Figure:
    """Draw a quantity: above measured, predicted over windows and flown freely; below the error."""
    panels = tuple(panel for one in series for panel in _panels(one))
    return zoomable_figure(
        figure_name(quantity),
        _lead(quantity, series),
        f"{TITLES[quantity]}. Black (white on a dark page): readings. Blue: predicted from the "
        "commands, time and again from a start that was estimated just before. Orange: one "
        "free run from the start of the log, as far as the axis reaches. Lower panels: reading "
        "less prediction; the grey band is twice the sensor's noise where the vehicle file states "
        "it.",
        panels,
        x_label=TIME_LABEL,
        x_axis=Axis(ends=(0.0, duration_s)),
        resolution=detail,
    )


def figure_name(quantity: str) -> str:
    """Return the anchor of a quantity's figure on the page of a run."""
    return f"fig-{quantity.replace('_', '-')}"


def _panels(one: ChannelSeries) -> tuple[Panel, Panel]:
    unit, factor = shown_unit(one.error.unit)
    style: Style = "points" if one.time_s.size < FEW_READINGS else "line"
    both = factor * np.concatenate([one.measured, one.windows])
    low, high = float(np.nanmin(both)), float(np.nanmax(both))
    margin = 0.12 * (high - low) + 0.02 * max(abs(low), abs(high)) + 1e-9
    noise = one.error.sensor_noise
    upper = Panel(
        f"{short_name(one.error.channel)}  [{unit}]",
        (
            Trace("measured", one.time_s, factor * one.measured, plotting.INK, style, 1.4),
            Trace("free run", one.free_time_s, factor * one.free, plotting.ORANGE),
            Trace("predicted", one.time_s, factor * one.windows, plotting.BLUE),
        ),
        height=1.2,
        y_range=(low - margin, high + margin),
    )
    error = Trace("error", one.time_s, factor * one.residual, plotting.BLUE, style)
    # without a stated noise there is a line at zero alone
    band = 2 * factor * noise if noise is not None else 0.0
    return upper, Panel(f"error\n[{unit}]", (error,), height=0.7, band=band)


def _lead(quantity: str, series: tuple[ChannelSeries, ...]) -> str:
    """Say how well each component was predicted."""
    parts = []
    for one in series:
        unit, factor = shown_unit(one.error.unit)
        error = general(factor * one.error.rmse_windows, 2)
        text = f"{channel_name(one.error.channel)} to {error} {unit}"
        noise = one.error.sensor_noise
        if noise:
            text += f" ({general(one.error.rmse_windows / noise, 2)} times the noise)"
        parts.append(text)
    return f"{TITLES[quantity]}: simulated {', '.join(parts)} (rms)."


def command_figure(
    names: tuple[str, ...],
    limits: tuple[tuple[float, float] | None, ...],
    time_s: FloatArray,
    command: FloatArray,
    manoeuvres: tuple[ManoeuvreFound, ...],
    *,
    detail: Resolution,
) -> Figure:
    """Draw the commanded codes of all thrusters, the manoeuvres found behind them.

    `limits` are the ends of each thruster's range, None where they are not known.
    """
    duration = float(time_s[-1]) if time_s.size else 1.0
    spans = tuple(
        Span(stretch.from_s, stretch.to_s, (plotting.BLUE, plotting.GREEN)[number % 2])
        for number, stretch in enumerate(manoeuvres)
    )
    panels = tuple(
        Panel(
            name if len(name) <= LONGEST_LABEL else f"{name[: LONGEST_LABEL - 1]}…",
            (Trace("commanded code", time_s, own, plotting.INK, "steps"),),
            height=0.62,
            y_range=None if ends is None else (1.08 * ends[0], 1.08 * ends[1]),
            limits=ends or (),
            spans=spans,
        )
        for name, ends, own in zip(names, limits, command.T, strict=True)
    )
    lead = "No commands."
    if np.isfinite(command).any():
        furthest = int(np.nanargmax(np.abs(command)))
        busiest = names[furthest % command.shape[1]]
        lead = (
            f"Commanded codes over {general(duration, 3)} s; {busiest} went furthest, to "
            f"{code(float(command.flat[furthest]))}."
        )
    return zoomable_figure(
        "fig-commands",
        lead,
        "Commanded codes [–], one panel a thruster. Dotted: ends of the range, where the vehicle "
        "file gives it. Shaded: the manoeuvres of the table.",
        panels,
        x_label=TIME_LABEL,
        x_axis=Axis(ends=(0.0, duration)),
        resolution=detail,
    )
