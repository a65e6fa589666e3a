"""A pool run's page: every channel measured against simulated."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.run_table import COMPONENTS, RunTable, components, difference
from pipeline.records.trial import ChannelError
from pipeline.report import plotting
from pipeline.report.blocks import (
    Blocks,
    Bullets,
    Details,
    Figure,
    Gallery,
    Section,
    Table,
    Text,
    chapter,
)
from pipeline.report.diagnosis_words import channel_name, short_name, shown_unit
from pipeline.report.numbers import fixed, general, plural, signed
from pipeline.report.results import RunResults
from pipeline.report.zoomable import Axis, Panel, Resolution, Style, Trace, zoomable_figure
from pipeline.types import FloatArray

#: Quantities that are drawn in the open; the others are folded away.
FIRST = ("velocity", "angular_velocity", "attitude", "depth")
#: An error of so many times the noise is coloured.
FAR = 5.0


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
#: Curves of one component: measured, windows, error.
CURVES = 3
TIME_LABEL = "time since the start of the log  [s]"


@dataclass(frozen=True)
class _Series:
    """One component to be drawn: readings, what was simulated at them, all (k,)."""

    error: ChannelError
    time_s: FloatArray
    measured: FloatArray
    windows: FloatArray
    residual: FloatArray


@chapter("comparison", "Measured against simulated")
def comparison_section(results: RunResults) -> Blocks:
    """Give a table of errors and a figure for every quantity."""
    trial = results.trial
    if trial is None or trial.why_not or results.measured is None or results.windows is None:
        reason = (trial.why_not if trial is not None else "") or "the log could not be read."
        missing = (
            "The page shows the health of the data only. A vehicle file with a model: section "
            "(masses, added mass, damping, thrusters; docs/formats.md has the keys, "
            "raw/mmt300/vehicle.yaml a full one) adds this comparison."
            if results.vehicle.model is None
            else "What the vehicle file or the bench data lack for it is named above."
        )
        yield None if results.stored is None else Text(missing)
        raise CannotComputeError(reason)
    yield Text(
        f"Predicted: by the vehicle file, {trial.windows} times {trial.horizon_s or 0.0:g} s end "
        f"to end, each from a start that the {trial.lead_s or 0.0:g} s of readings before it "
        "give; this shows how good the model is."
    )
    yield Table.of(
        "Errors of the simulation",
        trial.channels,
        _error_row,
        lambda one: (one.over_noise or 0.0) > FAR or one.loses,
        links={(row, 3): f"#{figure_name(one.quantity)}" for row, one in enumerate(trial.channels)},
        note="Noise with offset: what the vehicle file states for one reading, noise and offset "
        "of the sensor together. An error over noise of 1 is as good as the sensor can show. Last "
        "value kept: the error of predicting that nothing changes. Marked: more than "
        f"{FAR:g} times the noise, or clearly worse than keeping the last value.",
    )
    yield Bullets(trial.notes) if trial.notes else None
    by_quantity: dict[str, list[_Series]] = {}
    for one in trial.channels:
        own = _series(one, results.measured, results.windows)
        by_quantity.setdefault(one.quantity, []).append(own)
    figures = {
        name: zoomable_figure(
            figure_name(name),
            _lead(name, series),
            f"{TITLES[name]}. Black (white on a dark page): readings. Blue: predicted from the "
            "commands, time and again from a start that was estimated just before. Lower panels: "
            "reading less prediction; the grey band is twice the sensor's noise where the vehicle "
            "file states it.",
            [panel for one in series for panel in _panels(one)],
            x_label=TIME_LABEL,
            x_axis=Axis(ends=(0.0, float(results.measured.time_s[-1]))),
            resolution=resolution_of(results),
        )
        for name, series in by_quantity.items()
    }
    # one panel a channel: heights differ by a factor of five
    first, rest = (
        Gallery(tuple(o for name, o in figures.items() if (name in FIRST) is wanted), level=False)
        for wanted in (True, False)
    )
    yield first
    more_figures = plural(len(rest.figures), "more figure")
    yield Details(more_figures, (rest,)) if rest.figures else None


def with_worst_apart(section: Section, results: RunResults) -> tuple[Section, Figure | None]:
    """Take out of a comparison the figure in which the simulation is off most, over the noise."""
    channels = results.trial.channels if results.trial is not None else ()
    judged = [one for one in channels if one.quantity in FIRST and one.over_noise is not None]
    drawn = next((one for one in section.blocks if isinstance(one, Gallery)), None)
    if not judged or drawn is None:
        return section, None
    name = figure_name(max(judged, key=lambda one: one.over_noise or 0.0).quantity)
    rest = replace(drawn, figures=tuple(one for one in drawn.figures if one.name != name))
    blocks = tuple(rest if one is drawn else one for one in section.blocks)
    found = next((one for one in drawn.figures if one.name == name), None)
    return replace(section, blocks=blocks), found


def _error_row(one: ChannelError) -> dict[str, str]:
    unit, factor = shown_unit(one.unit)
    noise, ratio, rms = one.sensor_noise, one.over_noise, factor * one.rmse_windows
    decimals = int(np.clip(2 - np.floor(np.log10(rms)), 0, 6)) if rms > 0 else 2
    return {
        "Channel": channel_name(one.channel),
        "Unit": unit,
        "Readings": str(one.readings),
        "Error, rms": general(rms, 3),
        "Noise with offset": "not stated" if noise is None else general(factor * noise, 2),
        "Error over noise": general(ratio, 2),
        "Last value kept, rms": general(one.rmse_last_value and factor * one.rmse_last_value, 3),
        "Error, mean": signed(factor * one.mean_windows, decimals),
        "Error, largest": f"{general(factor * one.worst_windows, 3)} at "
        f"{fixed(one.worst_at_s, 1)} s",
    }


def resolution_of(results: RunResults) -> Resolution:
    """Share the page's points among all of its curves."""
    channels = len(results.trial.channels) if results.trial is not None else 0
    return Resolution.shared(CURVES * channels + len(results.vehicle.thrusters))


def figure_name(quantity: str) -> str:
    """Return the anchor of a quantity's figure on the page of a run."""
    return f"fig-{quantity.replace('_', '-')}"


def _panels(one: _Series) -> tuple[Panel, Panel]:
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
            Trace("predicted", one.time_s, factor * one.windows, plotting.BLUE),
        ),
        height=1.2,
        y_range=(low - margin, high + margin),
    )
    error = Trace("error", one.time_s, factor * one.residual, plotting.BLUE, style)
    # without a stated noise there is a line at zero alone
    band = 2 * factor * noise if noise is not None else 0.0
    return upper, Panel(f"error\n[{unit}]", (error,), height=0.7, band=band)


def _lead(quantity: str, series: list[_Series]) -> str:
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


def _series(error: ChannelError, measured: RunTable, windows: RunTable) -> _Series:
    quantity, turning = error.quantity, error.quantity == "attitude"
    names = [name for name, _ in COMPONENTS[quantity]] or list(measured.thrusters)
    column = names.index(error.channel)

    def values(table: RunTable) -> FloatArray:
        found = components(table, quantity)[:, column].copy()
        there = np.isfinite(found)
        if turning:  # without the jumps at half a turn
            found[there] = np.unwrap(found[there])
        return found

    own, short = values(measured), values(windows)
    residual = difference(quantity, own[:, None], short[:, None])[:, 0]
    short = own - residual if turning else short
    rows = measured.valid[quantity] & np.isfinite(own) & measured.reading.get(quantity, True)
    time_s, *shown = (one[rows] for one in (measured.time_s, own, short, residual))
    return _Series(error, time_s, shown[0], shown[1], shown[2])
