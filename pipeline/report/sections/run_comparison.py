"""A pool run's page: every channel measured against simulated."""

from dataclasses import replace

import numpy as np

from pipeline.records.run_components import COMPONENTS, components, difference
from pipeline.records.run_table import RunTable
from pipeline.records.trial import ChannelError
from pipeline.report.blocks import (
    Block,
    Bullets,
    Details,
    Figure,
    Gallery,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.channels import channel_name, shown_unit
from pipeline.report.numbers import fixed, general, plural, signed
from pipeline.report.panels import Resolution
from pipeline.report.run_results import RunResults
from pipeline.report.sections.run_channels import (
    CURVES,
    ChannelSeries,
    channel_figure,
    command_figure,
    figure_name,
)
from pipeline.types import FloatArray

#: Quantities that are drawn in the open; the others are folded away.
FIRST = ("velocity", "angular_velocity", "attitude", "depth")
#: An error of so many times the noise is coloured.
FAR = 5.0


def comparison_section(results: RunResults) -> Section:
    """Give a table of errors and a figure for every quantity."""
    anchor, title, trial = "comparison", "Measured against simulated", results.trial
    if trial is None or trial.why_not or results.measured is None or results.windows is None:
        reason = (trial.why_not if trial is not None else "") or "the log could not be read."
        missing = (
            "The page shows the health of the data only. A vehicle file with a model: section "
            "(masses, added mass, damping, thrusters; docs/formats.md has the keys, "
            "raw/mmt300/vehicle.yaml a full one) adds this comparison."
            if results.vehicle.model is None
            else "What the vehicle file or the bench data lack for it is named above."
        )
        more = [] if results.stored is None else [Paragraph(missing)]
        return not_computed(anchor, title, reason, *more)
    figures = _figures(results)
    # one panel a channel: heights differ by a factor of five
    first, rest = (
        Gallery(tuple(one for name, one in figures if (name in FIRST) is wanted), level=False)
        for wanted in (True, False)
    )
    said = (
        f"Predicted: by the vehicle file, {trial.windows} times {trial.horizon_s or 0.0:g} s end "
        f"to end, each from a start that the {trial.lead_s or 0.0:g} s of readings before it "
        "give; this shows how good the model is. Free run: one simulation from the start, never "
        "corrected; it shows what adds up, and drifts with the best of models."
    )
    blocks: list[Block] = [Paragraph(said), _error_table(trial.channels)]
    blocks += [Bullets(trial.notes)] if trial.notes else []
    more_figures = plural(len(rest.figures), "more figure")
    blocks += [first, *([Details(more_figures, (rest,))] if rest.figures else [])]
    return Section(anchor, title, tuple(blocks))


def with_worst_apart(section: Section, results: RunResults) -> tuple[Section, Figure | None]:
    """Take out of the section the figure in which the simulation is off most, over the noise.

    Parameters
    ----------
    section : Section
        As `comparison_section` gives it.
    results : RunResults
        What is known of the run.
    """
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


def _error_table(channels: tuple[ChannelError, ...]) -> Table:
    far = [(one.over_noise or 0.0) > FAR or one.loses for one in channels]
    return Table.of(
        "Errors of the simulation",
        list(map(_error_row, channels)),
        row_classes=tuple("warning" if one else "" for one in far),
        links={(row, 3): f"#{figure_name(one.quantity)}" for row, one in enumerate(channels)},
        note="Noise with offset: what the vehicle file states for one reading, noise and offset "
        "of the sensor together. An error over noise of 1 is as good as the sensor can show. Last "
        "value kept: the error of predicting that nothing changes. Marked: more than "
        f"{FAR:g} times the noise, or clearly worse than keeping the last value.",
    )


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
        "Error over noise": "–" if ratio is None else general(ratio, 2),
        "Last value kept, rms": _or_dash(one.rmse_last_value, factor),
        "Free run, rms": _or_dash(one.rmse_free, factor),
        "Error, mean": signed(factor * one.mean_windows, decimals),
        "Error, largest": f"{general(factor * one.worst_windows, 3)} at "
        f"{fixed(one.worst_at_s, 1)} s",
    }


def _or_dash(value: float | None, factor: float) -> str:
    return "–" if value is None else general(factor * value, 3)


def _detail(results: RunResults) -> Resolution:
    """Share the page's points among all of its curves."""
    channels = len(results.trial.channels) if results.trial is not None else 0
    return Resolution.shared(CURVES * channels + len(results.vehicle.thrusters))


def _figures(results: RunResults) -> list[tuple[str, Figure]]:
    assert results.trial is not None  # noqa: S101 - the caller has seen to it
    assert results.measured is not None  # noqa: S101
    assert results.windows is not None  # noqa: S101
    by_quantity: dict[str, list[ChannelError]] = {}
    for one in results.trial.channels:
        by_quantity.setdefault(one.quantity, []).append(one)
    duration = float(results.measured.time_s[-1])
    found = []
    for quantity, errors in by_quantity.items():
        series = tuple(_series(results, one) for one in errors)
        figure = channel_figure(quantity, series, duration, _detail(results))
        found.append((quantity, figure))
    return found


def _series(results: RunResults, error: ChannelError) -> ChannelSeries:
    measured, windows = results.measured, results.windows
    assert measured is not None  # noqa: S101
    assert windows is not None  # noqa: S101
    names = [name for name, _ in COMPONENTS[error.quantity]] or list(measured.thrusters)
    column = names.index(error.channel)

    def values(table: RunTable) -> FloatArray:
        found = components(table, error.quantity)
        if error.quantity != "attitude":
            return found[:, column]
        # without the jumps at half a turn
        angle = found[:, column].copy()
        there = np.isfinite(angle)
        angle[there] = np.unwrap(angle[there])
        return angle

    own, short = values(measured), values(windows)
    residual = difference(error.quantity, own[:, None], short[:, None])[:, 0]
    if error.quantity == "attitude":
        short = own - residual
    rows = measured.valid[error.quantity] & np.isfinite(own)
    if error.quantity in measured.reading:
        rows &= measured.reading[error.quantity]
    free = np.full(own.shape, np.nan)
    if results.free is not None and error.quantity in results.free.values:
        free = values(results.free)
        if error.quantity == "attitude":
            both = rows & np.isfinite(free)
            if both.any():
                first = int(np.argmax(both))
                free = free + 2 * np.pi * np.round((own[first] - free[first]) / (2 * np.pi))
    return ChannelSeries(
        error, measured.time_s[rows], own[rows], short[rows], residual[rows], measured.time_s, free
    )


def commands_figure(results: RunResults) -> Figure | None:
    """Draw the commands, None where the log has none."""
    table = results.measured
    if table is None or "command" not in table.values or not table.valid["command"].any():
        return None
    thrusters = results.vehicle.thrusters
    command = np.where(table.valid["command"][:, None], table.values["command"], np.nan)
    names = table.thrusters or tuple(one.name for one in thrusters)
    drives = {one.name: results.vehicle.drives[one.drive] for one in thrusters}
    ends = {name: (float(one.code_min), float(one.code_max)) for name, one in drives.items()}
    # without thrusters in the vehicle file the names are those of the log
    limits = tuple(ends.get(name) for name in names)
    manoeuvres = results.trial.manoeuvres if results.trial is not None else ()
    return command_figure(names, limits, table.time_s, command, manoeuvres, detail=_detail(results))
