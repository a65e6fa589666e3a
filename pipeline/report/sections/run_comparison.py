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
    title = "Measured against simulated"
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
        blocks: tuple[Block, ...] = (Paragraph(f"Not computed: {reason}", tone="warning"),)
        if results.stored is not None:
            blocks += (Paragraph(missing),)
        return Section("comparison", title, blocks, available=False)
    figures = _figures(results)
    ahead, behind = trial.horizon_s or 0.0, trial.lead_s or 0.0
    return Section(
        "comparison",
        title,
        (
            Paragraph(
                "The commands of the log were simulated with the vehicle file as it is. Predicted: "
                f"{trial.windows} times {ahead:g} s end to end, each from a "
                f"start that the {behind:g} s of readings before it give; this shows how "
                "good the model is. Free run: one simulation from the start, never corrected; it "
                "shows what adds up, and drifts with the best of models."
            ),
            _error_table(trial.channels),
            *([Bullets(trial.notes)] if trial.notes else []),
            # one panel a channel: heights differ by a factor of five
            Gallery(
                tuple(figure for quantity, figure in figures if quantity in FIRST), level=False
            ),
            *_rest([figure for quantity, figure in figures if quantity not in FIRST]),
        ),
    )


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
    if not judged:
        return section, None
    worst = max(judged, key=lambda one: one.over_noise or 0.0)
    name = figure_name(worst.quantity)
    found: Figure | None = None
    blocks: list[Block] = []
    for block in section.blocks:
        if not isinstance(block, Gallery):
            blocks.append(block)
            continue
        found = next((one for one in block.figures if one.name == name), found)
        rest = tuple(one for one in block.figures if one.name != name)
        blocks.append(replace(block, figures=rest))
    return replace(section, blocks=tuple(blocks)), found


def _rest(figures: list[Figure]) -> list[Block]:
    if not figures:
        return []
    return [Details(plural(len(figures), "more figure"), (Gallery(tuple(figures), level=False),))]


def _error_table(channels: tuple[ChannelError, ...]) -> Table:
    rows, classes = [], []
    for one in channels:
        unit, factor = shown_unit(one.unit)
        ratio = one.over_noise
        rows.append(
            (
                channel_name(one.channel),
                unit,
                str(one.readings),
                general(factor * one.rmse_windows, 3),
                "not stated" if one.sensor_noise is None else general(factor * one.sensor_noise, 2),
                "–" if ratio is None else general(ratio, 2),
                _or_dash(one.rmse_last_value, factor),
                _or_dash(one.rmse_free, factor),
                signed(factor * one.mean_windows, _decimals(factor * one.rmse_windows)),
                f"{general(factor * one.worst_windows, 3)} at {fixed(one.worst_at_s, 1)} s",
            )
        )
        far = ratio is not None and ratio > FAR
        classes.append("warning" if far or one.loses else "")
    return Table(
        "Errors of the simulation",
        (
            "Channel",
            "Unit",
            "Readings",
            "Error, rms",
            "Noise with offset",
            "Error over noise",
            "Last value kept, rms",
            "Free run, rms",
            "Error, mean",
            "Error, largest",
        ),
        tuple(rows),
        row_classes=tuple(classes),
        links={(row, 3): f"#{figure_name(one.quantity)}" for row, one in enumerate(channels)},
        note="Noise with offset: what the vehicle file states for one reading, noise and offset of "
        "the sensor together, because nothing is taken off the readings here; trial days, where "
        "offsets are estimated, show the noise without them. An error over noise of 1 is as "
        "good as the sensor can show. Last value kept: the error of predicting that nothing "
        f"changes. Marked: more than {FAR:g} times the noise, or clearly worse than keeping the "
        "last value.",
    )


def _or_dash(value: float | None, factor: float) -> str:
    return "–" if value is None else general(factor * value, 3)


def _decimals(size: float) -> int:
    return int(np.clip(2 - np.floor(np.log10(size)), 0, 6)) if size > 0 else 2


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
