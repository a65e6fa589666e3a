"""A diagnosis' page: where the gap lies, how far it shrinks, what cannot be told apart."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.language import as_it_is
from pipeline.records.diagnosis import DiagnosisRecord, ShrinkFigures
from pipeline.report import diagnosis_words as words
from pipeline.report.blocks import Blocks, Details, Gallery, Table, Text, chapter
from pipeline.report.diagnosis_words import channel_name, in_order, shown_unit
from pipeline.report.numbers import MINUS, fixed, general, percent, plural
from pipeline.report.sections.diagnosis_curves import curves_in_order, resolution, run_figure

#: Figures of a page at most: each costs some 60 kB and a fifth of a second.
MOST_DRAWN = 36
#: A floor with the answer this many times the other is shown.
_NOTABLY = 1.2
#: A regime whose share of the gap is below this many times its share of the time hardly stands out.
_HARDLY_MORE = 1.25
#: Below this angle two effects are one answer. [deg]
ONE_ANSWER_DEG = 10.0
#: More pairs than this are folded away.
_PAIRS = 12
_HORIZONS = {"0.5": "0.5 s ahead", "2": "2 s ahead", "10": "10 s ahead", "run": "whole run"}
#: Ratio from which a cell is shaded, the darkest first.
_SHADES = ((10.0, "hot3"), (4.0, "hot2"), (1.5, "hot1"))


@chapter("gap", "Where the gap lies")
def gap_section(record: DiagnosisRecord) -> Blocks:
    """Show the gap by channel, horizon and regime, and when it is there."""
    channels, carrying = record.gap.channels, set(record.gap.where.channels)
    if not channels:
        raise CannotComputeError("no channel of the motion could be compared.")
    names = in_order(channels)

    def errors(name: str) -> dict[str, str]:
        one = channels[name]
        unit, factor = shown_unit(one.unit)
        return {
            "Channel": f"{channel_name(name)} [{unit}]",
            "Error, rms": general(factor * one.rmse, 3),
            "Sensor noise": general(factor * one.sensor_floor, 2),
            "A sound vehicle leaves": general(factor * one.healthy_floor, 2),
            "Ratio": words.ratio_text(one.ratio),
        }

    yield Text(gap_lead(record))
    yield Table.of(
        "Error of the prediction, and what is ordinary",
        names,
        errors,
        lambda name: name in carrying,
        note="A sound vehicle of this kind leaves so much, with its ordinary parameter errors and "
        "disturbances. Ratio: error over that. Marked: the channels that carry the gap, or in "
        "which the answer, or what stands beside none, acts most.",
    )
    rows = map_rows(record)
    yield Table.of(
        "Error over what a sound vehicle leaves",
        rows,
        lambda row: {
            "Readings": row[0],
            **{
                words.SYMBOLS.get(o, o): words.ratio_text(row[1][o]) if o in row[1] else "–"
                for o in names
            },
        },
        cell_classes={
            (i, j): next(shade for least, shade in _SHADES if ratios[name] >= least)
            for i, (_, ratios) in enumerate(rows)
            for j, name in enumerate(names, start=1)
            if ratios.get(name, 0.0) >= _SHADES[-1][0]
        },
        note="1 and below: nothing to explain; the darker, the more. Columns: the channels of the "
        "table above, by their symbols.",
    )
    times = Table.of(
        "Stretches of the runs that carry the gap",
        record.gap.where.times,
        "Run: {run:name} | From [s]: {from_s:.1f} | To [s]: {to_s:.1f} | "
        "Share of the gap: {share:percent}",
        note="A gap that sets in at some time is another fault than one that is always there.",
    )
    yield times if times.rows else None


def map_rows(record: DiagnosisRecord) -> list[tuple[str, dict[str, float]]]:
    """Return ratios by channel: of all readings, of the horizons, of each regressor's parts."""
    channels = record.gap.channels
    rows = [("all readings", {name: one.ratio for name, one in channels.items()})]
    for key, label in _HORIZONS.items():
        own = {
            name: one.horizons[key].ratio for name, one in channels.items() if key in one.horizons
        }
        if own:
            rows.append((label, own))
    rows += [
        (words.regime_name(one.regressor, one.unit, one.range), dict(one.ratios))
        for one in record.gap.by_regime
    ]
    return rows


def gap_lead(record: DiagnosisRecord) -> str:
    """Say where the gap is largest, and which regime carries it."""
    channels = record.gap.channels
    worst = max(channels, key=lambda name: channels[name].ratio)
    ratio = words.ratio_text(channels[worst].ratio)
    named, verdict = record.gap.where.channels, record.verdict
    if not named or verdict.effects == ("none",):
        text = (
            f"No channel stands out: the largest error, {channel_name(worst)}, is "
            f"{ratio} times what a sound vehicle leaves."
        )
        if not named or not verdict.ambiguous_with:
            return text
        listed = ", ".join(channel_name(name) for name in named)
        return f"{text} What cannot be told from none would show most in: {listed}."
    text = f"{channel_name(worst)} is off most, {ratio} times what a sound vehicle leaves"
    if record.gap.where.regimes:
        first = record.gap.where.regimes[0]
        text += (
            f"; {percent(first.share)} of the gap lies at "
            f"{words.regime_name(first.regressor, first.unit, first.range)}, in "
            f"{percent(first.share_of_time)} of the {'codes' if words.of_bench(record) else 'time'}"
        )
        if first.correlation is not None:
            text += f" (rank correlation {fixed(first.correlation, 2)})"
        if first.share < _HARDLY_MORE * first.share_of_time:
            text += ": hardly more than elsewhere"
    return f"{words.capital(text)}."


@chapter("shrink", "Before and after")
def shrink_section(record: DiagnosisRecord) -> Blocks:
    """Show what the answer takes away, in figures and over time."""
    yield Text(_said(record))
    yield _shrink_table(record)
    every = curves_in_order(record)
    if not every:
        yield Text("No curves were kept with this diagnosis.", tone="note")
        return
    detail = resolution(len(every[:MOST_DRAWN]))
    figures = [run_figure(record, one, k, detail) for k, one in enumerate(every[:MOST_DRAWN])]
    # the first of pool runs stands at the top of the page
    first, rest = (figures[:1], figures[1:]) if words.of_bench(record) else ([], figures)
    yield from first
    if rest:
        more = f"Measured, before and after: {plural(len(rest), 'figure')}"
        yield Details(more, (Gallery(tuple(rest), level=False),))
    if every[MOST_DRAWN:]:
        names = sorted({f"{one.channel} in {as_it_is(one.run)}" for one in every[MOST_DRAWN:]})
        yield Text(f"Not drawn: {', '.join(names)}.", tone="note")
    if record.shrink.held_out:
        yield Text(f"Kept aside: {record.shrink.held_out.rstrip('.')}.")


def _said(record: DiagnosisRecord) -> str:
    shrink = record.shrink
    before, after = over_floor(shrink)
    if record.verdict.effects in {("none",), ("unknown",)}:
        if before != after and not words.of_bench(record):
            return (
                "The verdict names no effect, so none is added to the model. What no vehicle file "
                "states of a thruster, how its lag and the inflow act, was found from the runs: "
                f"that takes the gap from {before} to {after} times what a sound vehicle leaves."
            )
        return (
            f"The verdict names no effect, so nothing is added to the model and nothing is closed: "
            f"it leaves {before} times what a sound vehicle leaves."
        )
    if shrink.gap_closed is None:
        return _said_of_one(record) or (
            f"There is next to nothing to close: the vehicle file's model leaves {before} times "
            "what a sound vehicle leaves."
        )
    return (
        f"Adding the answer brings the gap from {before} to {after} times what a sound vehicle "
        f"leaves, which closes {words.closed_text(shrink.gap_closed)} of what can be closed"
        f"{words.closed_interval(shrink.ci95)}."
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
        f"what a sound vehicle leaves. Over all channels it goes from {of_all} to {left}: as most "
        "of them are hardly off, there is next to nothing to close."
    )


def over_floor(shrink: ShrinkFigures) -> tuple[str, str]:
    """Write the gap before and after as multiples of what a sound vehicle leaves."""
    floor = max(shrink.noise_floor, 1e-12)
    return fixed(shrink.before / floor, 2), fixed(shrink.after / floor, 2)


def _shrink_table(record: DiagnosisRecord) -> Table:
    def row(label: str, factor: float, one: ShrinkFigures) -> dict[str, str]:
        floor = general(factor * one.noise_floor, 3)
        if _more_sensitive(one):
            floor += f" ({general(factor * (one.noise_floor_after or 0.0), 3)} with the answer)"
        return {
            "Channel": label,
            "Before, rms": general(factor * one.before, 3),
            "After, rms": general(factor * one.after, 3),
            "A sound vehicle leaves": floor,
            "Gap closed": "–" if one.gap_closed is None else words.closed_text(one.gap_closed),
        }

    shrink, channels = record.shrink, record.shrink.channels
    whole = row("all channels, sound = 1", 1.0 / max(shrink.noise_floor, 1e-12), shrink)
    # of a mooring table the figures of the whole are those of its thrust
    rows = [] if words.of_bench(record) else [whole]
    for name in in_order(channels):
        gap = record.gap.channels.get(name)
        unit, factor = shown_unit(gap.unit) if gap is not None else ("–", 1.0)
        rows.append(row(f"{channel_name(name)} [{unit}]", factor, channels[name]))
    note = (
        f"Gap closed: (before {MINUS} after) / (before {MINUS} what a sound vehicle leaves), "
        "counted in the latter."
    )
    if any(map(_more_sensitive, channels.values())):
        note += (
            " Where a second number is given, sound vehicles with the answer leave so much, and "
            "what is left after counts over it."
        )
    return Table.of("Gap on readings that were kept aside", rows, note=note)


def _more_sensitive(one: ShrinkFigures) -> bool:
    """Whether sound vehicles with the answer leave notably more."""
    return (one.noise_floor_after or 0.0) > _NOTABLY * one.noise_floor


@chapter("confusable", "What cannot be told apart")
def confusable_section(record: DiagnosisRecord) -> Blocks:
    """Name the effects that these runs cannot separate, known before the verdict."""
    pairs = sorted(record.confusable, key=lambda pair: -pair[2])
    if not pairs:
        yield Text("Every two candidates leave traces of their own in these runs.")
        return
    found = [(words.in_words(a), words.in_words(b), angle_deg(cosine)) for a, b, cosine in pairs]
    table = Table.of(
        "Closest pairs of effects",
        found,
        "Effect: {0} | and: {1} | Angle [deg]: {2:.1f}",
        lambda pair: pair[2] <= ONE_ANSWER_DEG,
        note="Angle between what the two effects do to the readings, after everything that is "
        "ordinary has been taken away: 0 means the same trace, 90 nothing in common.",
    )
    yield Text(
        f"Known from the runs alone, before the verdict. Marked: closer than {ONE_ANSWER_DEG:g} "
        "degrees, one answer unless the verdict names a thruster, axis or size that tells them "
        "apart."
        if min(angle for *_, angle in found) <= ONE_ANSWER_DEG
        else f"No two effects come closer than {ONE_ANSWER_DEG:g} degrees; the closest pairs:"
    )
    yield table if len(pairs) <= _PAIRS else Details(f"{len(pairs)} pairs", (table,))


def angle_deg(cosine: float) -> float:
    """Angle of a cosine. [deg].

    >>> angle_deg(1.0), round(angle_deg(0.5), 6)
    (0.0, 60.0)
    """
    return float(np.degrees(np.arccos(np.clip(abs(cosine), 0.0, 1.0))))
