"""Heat map of the gap: channels across, horizons and regimes down."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.diagnosis_words import (
    REGRESSORS,
    channel_name,
    in_order,
    of_bench,
    ratio_text,
    regime_name,
    symbol,
)
from pipeline.report.numbers import percent
from pipeline.types import FloatArray

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes

#: The darkest colour stands for this ratio or more.
_DARKEST = 20.0
#: A regime whose share of the gap is below this many times its share of the time hardly stands out.
_HARDLY_MORE = 1.25
_PARTS = {1: ("all",), 2: ("low", "high"), 3: ("low", "middle", "high")}
_HORIZONS = {"0.5": "0.5 s ahead", "2": "2 s ahead", "10": "10 s ahead", "run": "whole run"}


@dataclass(frozen=True)
class MapRow:
    """One row: `label` beside the picture, `range_text` in full for the table, ratio by channel."""

    label: str
    range_text: str
    ratios: dict[str, float]
    begins: bool = False


def map_rows(record: DiagnosisRecord) -> list[MapRow]:
    """Return the rows: all readings, the horizons, then each regressor's parts."""
    channels = record.gap.channels
    whole = {name: one.ratio for name, one in channels.items()}
    rows = [MapRow("all readings", "all readings", whole)]
    for key, label in _HORIZONS.items():
        own = {
            name: one.horizons[key].ratio for name, one in channels.items() if key in one.horizons
        }
        if own:
            rows.append(MapRow(label, label, own, begins=len(rows) == 1))
    parts = Counter(regime.regressor for regime in record.gap.by_regime)
    before, number = "", 0
    for regime in record.gap.by_regime:
        begins = regime.regressor != before
        number = 0 if begins else number + 1
        before = regime.regressor
        name = REGRESSORS.get(regime.regressor, regime.regressor.replace("_", " "))
        words = _PARTS.get(parts[regime.regressor], ())
        part = words[number] if number < len(words) else str(number + 1)
        rows.append(
            MapRow(
                f"{name}, {part}",
                regime_name(regime.regressor, regime.unit, regime.range),
                dict(regime.ratios),
                begins=begins,
            )
        )
    return rows


def gap_map(record: DiagnosisRecord) -> Figure:
    """Draw error over healthy floor, by channel, horizon and regime."""
    rows = map_rows(record)
    names = in_order(record.gap.channels)
    values = np.array([[row.ratios.get(name, np.nan) for name in names] for row in rows], float)
    height_in = 0.75 + 0.2 * len(rows)

    def paint(figure: matplotlib.figure.Figure) -> None:
        from matplotlib.colors import LogNorm

        axes = figure.subplots()
        # below 1 there is nothing to explain: paper
        shaded = np.where(values > 1.0, values, np.nan)
        picture = axes.imshow(
            shaded, cmap="YlOrRd", norm=LogNorm(1.0, _DARKEST), aspect="auto", alpha=0.9
        )
        axes.grid(visible=False)
        axes.tick_params(length=0, labelsize=8)
        axes.xaxis.tick_top()
        axes.set_xticks(range(len(names)), [symbol(name) for name in names])
        axes.set_yticks(range(len(rows)), [row.label for row in rows], fontsize=7.5)
        for number, row in enumerate(rows):
            if row.begins:
                axes.axhline(number - 0.5, color=plotting.SOFT, lw=0.8)
        _write(axes, values)
        bar = figure.colorbar(
            picture, ax=axes, location="bottom", aspect=30, pad=0.02, fraction=0.5 / height_in
        )
        bar.set_ticks([1, 2, 5, 10, 20], labels=["1", "2", "5", "10", "≥ 20"])
        bar.set_label("error over the healthy floor  [–]", fontsize=8.5)
        bar.ax.tick_params(labelsize=8)
        bar.ax.minorticks_off()

    alt = (
        "Heat map of the prediction error over the healthy floor: a column for each channel, a row "
        "for each horizon and regime. The same numbers are in the tables below."
    )
    return Figure(
        "fig-gap-map",
        gap_lead(record),
        plotting.draw("fig-gap-map", alt, paint, height_in=height_in),
        "Root mean square error of the vehicle file's model over the healthy floor, which is what "
        "a healthy vehicle of this kind leaves: 1 and below (no colour) means nothing to explain. "
        + (
            "Low, middle and high are thirds of the windows; the table has their ranges."
            if record.gap.by_regime
            else ""
        ),
    )


def _write(axes: Axes, values: FloatArray) -> None:
    """Write the number into every cell."""
    for i, j in zip(*np.nonzero(np.isfinite(values)), strict=True):
        colour = "white" if values[i, j] > 7.0 else plotting.INK
        text = axes.text(
            j, i, ratio_text(values[i, j]), ha="center", va="center", fontsize=7, color=colour
        )
        # measuring hundreds of texts takes seconds, and they lie inside anyway
        text.set_in_layout(False)


def gap_lead(record: DiagnosisRecord) -> str:
    """Say where the gap is largest, and which regime carries it."""
    channels = record.gap.channels
    if not channels:
        return "No channel could be compared."
    worst = max(channels, key=lambda name: channels[name].ratio)
    ratio = channels[worst].ratio
    named, verdict = record.gap.where.channels, record.verdict
    if not named or verdict.effects == ("none",):
        text = (
            f"No channel stands out: the largest error, {channel_name(worst)}, is "
            f"{ratio_text(ratio)} times the healthy floor."
        )
        if not named or not verdict.ambiguous_with:
            return text
        listed = ", ".join(channel_name(name) for name in named)
        return f"{text} What cannot be told from none would show most in: {listed}."
    text = f"{channel_name(worst)} is off most, {ratio_text(ratio)} times the healthy floor"
    if record.gap.where.regimes:
        first = record.gap.where.regimes[0]
        text += (
            f"; {percent(first.share)} of the gap lies at "
            f"{regime_name(first.regressor, first.unit, first.range)}, in "
            f"{percent(first.share_of_time)} of the {'codes' if of_bench(record) else 'time'}"
        )
        if first.share < _HARDLY_MORE * first.share_of_time:
            text += ": hardly more than elsewhere"
    return text[0].upper() + text[1:] + "."
