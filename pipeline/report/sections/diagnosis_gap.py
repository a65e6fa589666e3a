"""A diagnosis' page: where the gap lies, and how far it shrinks on what took no part."""

from collections.abc import Sequence

import numpy as np

from pipeline.language import as_it_is
from pipeline.records.diagnosis import DiagnosisRecord, RegimeShare, ShrinkFigures
from pipeline.report.blocks import Block, Details, Paragraph, Section, Table
from pipeline.report.diagnosis_words import (
    channel_name,
    closed_interval,
    closed_text,
    in_order,
    of_bench,
    ratio_text,
    regime_name,
    symbol,
)
from pipeline.report.figures.diagnosis_runs import (
    HeldOut,
    before_after_figure,
    curves,
    healthy_floor,
    resolution,
)
from pipeline.report.figures.gap_map import gap_map, map_rows
from pipeline.report.figures.run_channels import shown_unit
from pipeline.report.numbers import MINUS, fixed, general, percent, plural

#: Figures in the open where no channel carries the gap.
_FIRST_FIGURES = 3
#: Figures in the open at most; the others are folded away.
_MOST_FIGURES = 6
#: Figures of a page at most: each costs some 60 kB and a fifth of a second.
MOST_DRAWN = 36
#: A floor with the answer this many times the other is shown.
_NOTABLY = 1.2


def gap_section(record: DiagnosisRecord) -> Section:
    """Show the gap by channel, horizon and regime, and when it is there."""
    title = "Where the gap lies"
    if not record.gap.channels:
        text = "No channel of the motion could be compared."
        return Section("gap", title, (Paragraph(text, tone="warning"),), available=False)
    blocks: list[Block] = [gap_map(record), _channel_table(record)]
    where = record.gap.where
    if where.regimes:
        blocks.append(
            _regime_table(
                where.regimes, "Share of the codes" if of_bench(record) else "Share of the time"
            )
        )
    if where.times:
        blocks.append(
            Table(
                "Stretches of the runs that carry the gap",
                ("Run", "From [s]", "To [s]", "Share of the gap"),
                tuple(
                    (one.run, fixed(one.from_s, 1), fixed(one.to_s, 1), percent(one.share))
                    for one in where.times
                ),
                verbatim_columns=frozenset({0}),
                note="A gap that sets in at some time is another fault than one that is always "
                "there.",
            )
        )
    blocks.append(Details("The heat map as a table", (_map_table(record),)))
    return Section("gap", title, tuple(blocks))


def _regime_table(regimes: Sequence[RegimeShare], share_of_all: str) -> Table:
    """Tabulate the regimes; with the correlation where it was computed, as it is over windows."""
    rows = [
        (
            regime_name(one.regressor, one.unit, one.range),
            percent(one.share),
            percent(one.share_of_time),
        )
        for one in regimes
    ]
    columns = ("Regime", "Share of the gap", share_of_all)
    correlated = [one.correlation for one in regimes if one.correlation is not None]
    if len(correlated) < len(rows):
        return Table("Regimes that carry the gap", columns, tuple(rows))
    return Table(
        "Regimes that carry the gap",
        (*columns, "Rank correlation"),
        tuple((*row, fixed(value, 2)) for row, value in zip(rows, correlated, strict=True)),
        note="The rank correlation is that of the gap with the quantity, window by window: "
        "1 or −1 where it goes with it throughout.",
    )


def _channel_table(record: DiagnosisRecord) -> Table:
    carrying = set(record.gap.where.channels)
    rows = []
    names = in_order(record.gap.channels)
    for name in names:
        one = record.gap.channels[name]
        unit, factor = shown_unit(one.unit)
        rows.append(
            (
                f"{channel_name(name)} [{unit}]",
                general(factor * one.rmse, 3),
                general(factor * one.sensor_floor, 2),
                general(factor * one.healthy_floor, 2),
                ratio_text(one.ratio),
            )
        )
    return Table(
        "Prediction error and the two floors below it",
        ("Channel", "Error, rms", "Sensor floor", "Healthy floor", "Ratio"),
        tuple(rows),
        row_classes=tuple("warning" if name in carrying else "" for name in names),
        note="Sensor floor: the sensor's noise alone. Healthy floor: what a healthy vehicle of "
        "this kind leaves, with its ordinary parameter errors and disturbances. Ratio: error over "
        "healthy floor. Marked: the channels that carry the gap, or in which the answer, or what "
        "stands beside none, acts most.",
    )


def _map_table(record: DiagnosisRecord) -> Table:
    names = in_order(record.gap.channels)
    return Table(
        "Error over the healthy floor",
        ("Readings", *(symbol(name) for name in names)),
        tuple(
            (
                row.range_text,
                *(ratio_text(row.ratios[name]) if name in row.ratios else "–" for name in names),
            )
            for row in map_rows(record)
        ),
    )


def shrink_section(record: DiagnosisRecord) -> Section:
    """Show what the answer takes away, in figures and over time."""
    title = "Before and after, on what took no part"
    shrink = record.shrink
    blocks: list[Block] = [Paragraph(_said(record)), _shrink_table(record)]
    found = curves(record)
    if not found:
        blocks.append(Paragraph("No held-out curves were kept with this diagnosis.", tone="note"))
        return Section("shrink", title, tuple(blocks))
    every = sorted(found, key=lambda one: _place(record, one))
    runs = every[:MOST_DRAWN]
    detail = resolution(len(runs))
    figures = [before_after_figure(record, one, number, detail) for number, one in enumerate(runs)]
    carrying = record.gap.where.channels
    first = sum(one.channel in carrying for one in runs) or _FIRST_FIGURES
    first = min(first, _MOST_FIGURES)
    blocks += figures[:first]
    if figures[first:]:
        blocks.append(
            Details(f"{plural(len(figures) - first, 'more figure')}", tuple(figures[first:]))
        )
    if every[MOST_DRAWN:]:
        names = sorted({f"{one.channel} in {as_it_is(one.run)}" for one in every[MOST_DRAWN:]})
        blocks.append(Paragraph(f"Not drawn: {', '.join(names)}.", tone="note"))
    if shrink.held_out:
        blocks.append(Paragraph(f"Held out: {shrink.held_out.rstrip('.')}."))
    return Section("shrink", title, tuple(blocks))


def _place(record: DiagnosisRecord, one: HeldOut) -> tuple[bool, float, str, str]:
    """Order of the figures: channels that carry the gap first, and of those the largest error."""
    before, _ = one.errors
    known = healthy_floor(record, one.channel)
    floor = 1.0 if known is None else known
    largest = before / floor if np.isfinite(before) and floor > 0.0 else 0.0
    return one.channel not in record.gap.where.channels, -largest, one.channel, one.run


def _said(record: DiagnosisRecord) -> str:
    shrink = record.shrink
    before, after = over_floor(shrink)
    if record.verdict.effects in {("none",), ("unknown",)}:
        if before != after and not of_bench(record):
            return (
                "The verdict names no effect, so none is added to the model. What no vehicle file "
                "states of a thruster, how its lag and the inflow act, was found from the runs: "
                f"that takes the gap from {before} to {after} times the healthy floor."
            )
        return (
            f"The verdict names no effect, so nothing is added to the model and nothing is closed: "
            f"it leaves {before} times the healthy floor."
        )
    if shrink.gap_closed is None:
        return _said_of_one(record) or (
            f"There is next to nothing to close: the vehicle file's model leaves {before} times "
            "the healthy floor."
        )
    interval = closed_interval(shrink.ci95)
    return (
        f"Adding the answer brings the gap from {before} to {after} times the healthy floor, which "
        f"closes {closed_text(shrink.gap_closed)} of what can be closed{interval}."
    )


def _said_of_one(record: DiagnosisRecord) -> str:
    """Say what is closed in the channel that is off most, where over all channels nothing is."""
    closed = [
        (name, one)
        for name in record.gap.where.channels
        if (one := record.shrink.channels.get(name)) is not None and one.gap_closed is not None
    ]
    if not closed:
        return ""
    name, one = max(closed, key=lambda row: row[1].before / max(row[1].noise_floor, 1e-12))
    before, after = over_floor(one)
    of_all, left = over_floor(record.shrink)
    return (
        f"Adding the answer brings the gap of {channel_name(name)} from {before} to {after} times "
        f"its healthy floor. Over all channels it goes from {of_all} to {left}: as most of them "
        "are hardly off, there is next to nothing to close."
    )


def over_floor(shrink: ShrinkFigures) -> tuple[str, str]:
    """Write the gap before and after as multiples of the healthy floor."""
    floor = max(shrink.noise_floor, 1e-12)
    return fixed(shrink.before / floor, 2), fixed(shrink.after / floor, 2)


def _shrink_table(record: DiagnosisRecord) -> Table:
    def row(label: str, unit: str, factor: float, one: ShrinkFigures) -> tuple[str, ...]:
        return (
            f"{label} [{unit}]",
            general(factor * one.before, 3),
            general(factor * one.after, 3),
            _floor(factor, one),
            "–" if one.gap_closed is None else closed_text(one.gap_closed),
        )

    rows = []
    # of a mooring table the figures of the whole are those of its thrust
    if not of_bench(record):
        factor = 1.0 / max(record.shrink.noise_floor, 1e-12)
        rows.append(row("all channels", "healthy floors", factor, record.shrink))
    for name in in_order(record.shrink.channels):
        one = record.shrink.channels[name]
        gap = record.gap.channels.get(name)
        unit, factor = shown_unit(gap.unit) if gap is not None else ("–", 1.0)
        rows.append(row(channel_name(name), unit, factor, one))
    note = (
        f"Gap closed: (before {MINUS} after) / (before {MINUS} healthy floor), in healthy floors."
    )
    if any(_more_sensitive(one) for one in record.shrink.channels.values()):
        note += (
            " Where a second floor is given, healthy vehicles with the answer leave so much, and "
            "what is left after counts over it."
        )
    return Table(
        "Gap on held-out data",
        ("Channel", "Before, rms", "After, rms", "Healthy floor", "Gap closed"),
        tuple(rows),
        note=note,
    )


def _more_sensitive(one: ShrinkFigures) -> bool:
    """Whether healthy vehicles with the answer leave notably more."""
    return (one.noise_floor_after or 0.0) > _NOTABLY * one.noise_floor


def _floor(factor: float, one: ShrinkFigures) -> str:
    before = general(factor * one.noise_floor, 3)
    if not _more_sensitive(one):
        return before
    return f"{before} ({general(factor * (one.noise_floor_after or 0.0), 3)} with the answer)"
