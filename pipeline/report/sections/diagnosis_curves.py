"""Held-out runs over time: measured, the model before and after, and what either leaves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.language import as_it_is
from pipeline.records.day_findings import DayFinding
from pipeline.records.diagnosis import BenchDiagnosisRecord, DiagnosisRecord, FoundEvent, Series
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.diagnosis_words import (
    capital,
    channel_name,
    identifiers,
    of_bench,
    short_name,
    shown_unit,
)
from pipeline.report.numbers import general
from pipeline.report.sections.run_comparison import FEW_READINGS
from pipeline.report.zoomable import Panel, Resolution, Style, Trace, zoomable_figure
from pipeline.types import BoolArray, FloatArray

_CURVES = 5
_ANGLES = frozenset({"phi", "theta", "psi"})


@dataclass(frozen=True)
class HeldOut:
    """One channel of one held-out run; all (k,), in units that a person reads.

    Of a mooring table all codes are drawn; `apart` (k,) tells which of them took no part, where
    not another table was held out.
    """

    run: str
    channel: str
    unit: str
    time_s: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    apart: BoolArray | None = None

    @property
    def errors(self) -> tuple[float, float]:
        """Root mean square of model less measured, before and after, of what took no part."""
        chosen = slice(None) if self.apart is None else self.apart
        left = [(self.measured - model)[chosen] for model in (self.before, self.after)]
        first, second = (
            float(np.sqrt(np.nanmean(one**2))) if np.isfinite(one).any() else float("nan")
            for one in left
        )
        return first, second


def curves(record: DiagnosisRecord) -> tuple[HeldOut, ...]:
    """Return what there is to draw: over time of pool runs, over the code of a mooring table."""
    if not isinstance(record, BenchDiagnosisRecord):
        return held_out(record.series)
    name, found = identifiers(record.runs), []
    for one in record.by_code:
        series = (one.code, one.measured, one.before, one.after)
        order = np.argsort(one.code)
        x, measured, before, after = np.array(series, float)[:, order]
        apart = np.asarray(one.held_out, bool)[order] if any(one.held_out) else None
        found.append(HeldOut(name, one.channel, one.unit, x, measured, before, after, apart))
    return tuple(found)


def held_out(series: Sequence[Series]) -> tuple[HeldOut, ...]:
    """Join the windows of each run and channel, in the order of the channels' first mention."""
    grouped: dict[tuple[str, str], list[Series]] = {}
    for one in series:
        if one.time_s:
            grouped.setdefault((one.channel, one.run), []).append(one)
    found = []
    for (channel, run), windows in grouped.items():
        unit, factor = shown_unit(windows[0].unit)
        parts: list[FloatArray] = []
        for one in sorted(windows, key=lambda one: one.time_s[0]):
            columns = np.array([one.time_s, one.measured, one.before, one.after], float)
            # every window starts anew: no line is drawn from one to the next
            parts += [np.array([[columns[0, 0]], [np.nan], [np.nan], [np.nan]]), columns]
        time_s, measured, *models = np.hstack(parts[1:])
        if channel in _ANGLES:
            there, turned = np.isfinite(measured), measured.copy()
            turned[there] = np.unwrap(measured[there])
            models = [turned - np.angle(np.exp(1j * (measured - own))) for own in models]
            measured = turned
        shown = (factor * own for own in (measured, *models))
        found.append(HeldOut(run, channel, unit, time_s, *shown))
    return tuple(found)


def curves_in_order(record: DiagnosisRecord) -> list[HeldOut]:
    """Return the curves, channels that carry the gap first, and of those the largest error."""

    def place(one: HeldOut) -> tuple[bool, float, str, str]:
        before, floor = one.errors[0], healthy_floor(record, one.channel)
        known = 1.0 if floor is None else floor
        largest = before / known if np.isfinite(before) and known > 0.0 else 0.0
        return one.channel not in record.gap.where.channels, -largest, one.channel, one.run

    return sorted(curves(record), key=place)


def resolution(count: int) -> Resolution:
    """Share the page's points among its figures.

    >>> resolution(2).zoom, resolution(48).zoom
    (1000, 187)
    """
    return Resolution.shared(_CURVES * count)


def run_figure(record: DiagnosisRecord, one: HeldOut, number: int, detail: Resolution) -> Figure:
    """Draw a channel of a held-out run: above the curves, below what the models leave."""
    floor, bench = healthy_floor(record, one.channel), of_bench(record)
    name, lead = f"fig-held-out-{number}", _lead(record, one)
    return _figure(name, lead, one, floor, detail, bench=bench)


def finding_figure(finding: DayFinding, run: str = "") -> Figure | None:
    """Draw the readings in which a finding is to be seen best; None where there are none.

    On the page of a run these are readings of that run.
    """
    if finding.event is not None:
        return _event_figure(finding.event) if run in {"", finding.event.run} else None
    drawn = held_out([one for one in finding.shown if run in {"", one.run}])
    if not drawn:
        return None
    one = drawn[0]
    _, factor = shown_unit(finding.shown[0].unit)
    floor = None if finding.shown_floor is None else factor * finding.shown_floor
    before, after = (f"{general(error, 2)} {one.unit}" for error in one.errors)
    what = f"{capital(channel_name(one.channel))} in {as_it_is(one.run)}"
    said = f"{what}: the simulation is off by {before}."
    if not finding.is_sound and not np.array_equal(one.before, one.after, equal_nan=True):
        said = f"{what}: the simulation is off by {before}, with this cause by {after}."
    elif floor is not None:
        ordinary = f"{general(floor, 2)} {one.unit}"
        said = f"{what}: the simulation is off by {before}; a sound vehicle leaves {ordinary}."
    return _figure("fig-shown", said, one, floor, Resolution())


def _event_figure(event: FoundEvent) -> Figure:
    time_s = np.array(event.time_s)
    step = np.where(time_s >= event.at_s, event.step[1], event.step[0])
    what = f"{event.axis} {'force' if event.unit == 'N' else 'moment'}"
    lead = f"{capital(what)} that the vehicle file lacks, in {as_it_is(event.run)}."
    traces = (
        Trace("measured", time_s, np.array(event.force), plotting.INK, "line", 1.4),
        Trace("mean", time_s, step, plotting.BLUE),
    )
    return zoomable_figure(
        "fig-shown",
        lead,
        f"{lead} Black (white on a dark page): by the measured motion. Blue: its mean before and "
        "after.",
        (Panel(f"{event.axis}  [{event.unit}]", traces, height=1.3),),
        x_label="time in the run  [s]",
    )


def _figure(
    name: str, lead: str, one: HeldOut, floor: float | None, detail: Resolution, *,
    bench: bool = False,
) -> Figure:  # fmt: skip
    style: Style = "points" if one.time_s.size < FEW_READINGS // 4 or bench else "line"
    band = None if floor is None else 2.0 * floor
    # a verdict that adds nothing to the model leaves it as it was: one curve, not two on another
    same = np.array_equal(one.before, one.after, equal_nan=True)
    models = [("expected", one.before, plotting.VERMILLION)]
    if not same:
        models.append(("with the answer", one.after, plotting.BLUE))
    drawn = [Trace("measured", one.time_s, one.measured, plotting.INK, style, 1.4)]
    drawn += [Trace(model, one.time_s, own, colour) for model, own, colour in models]
    errors = tuple(replace(own, values=one.measured - own.values) for own in drawn[1:])
    ends = _error_range(one, band)
    panels = (
        Panel(f"{short_name(one.channel)}  [{one.unit}]", drawn, height=1.3),
        Panel(f"error  [{one.unit}]", errors, height=0.8, band=band, y_range=ends),
    )
    relative = one.channel in _ANGLES and not np.any(one.measured[np.isfinite(one.measured)])
    turned = " Shown is the rotation away from the measured attitude." if relative else ""
    channel, run = channel_name(one.channel), as_it_is(one.run)
    added = "" if same else " Blue: with the answer added."
    grey = "; grey: twice what a sound vehicle leaves" if band is not None else ""
    return zoomable_figure(
        name,
        lead,
        f"{capital(channel)} in {run}. Black (white on a dark page): measured. Orange: what "
        f"is expected of it.{added} Below: measured less model{grey}.{turned}",
        panels,
        x_label="control code  [–]" if bench else "time in the run  [s]",
        resolution=detail,
    )


def healthy_floor(record: DiagnosisRecord, channel: str) -> float | None:
    """Return what a sound vehicle leaves of a channel, in units that a person reads.

    That of the held-out readings, which are what is drawn: over the whole runs it is another,
    as they are predicted over other times ahead.
    """
    gap = record.gap.channels.get(channel)
    if gap is None:
        return None
    _, factor = shown_unit(gap.unit)
    of_held_out = record.shrink.channels.get(channel)
    return factor * (gap.healthy_floor if of_held_out is None else of_held_out.noise_floor)


def _error_range(one: HeldOut, band: float | None) -> tuple[float, float] | None:
    """Range of the errors' axis: errors far below the floor are still seen."""
    errors = np.concatenate([one.measured - one.before, one.measured - one.after])
    errors = errors[np.isfinite(errors)]
    largest = float(np.max(np.abs(errors))) if errors.size else 0.0
    if largest == 0.0:
        return None
    half = max(1.15 * largest, min(1.1 * (band or 0.0), 3.0 * largest))
    low = -half if float(errors.min()) < -0.2 * largest or half > 1.15 * largest else -0.3 * half
    high = half if float(errors.max()) > 0.2 * largest or half > 1.15 * largest else 0.3 * half
    return low, high


def _lead(record: DiagnosisRecord, one: HeldOut) -> str:
    name, run = channel_name(one.channel), as_it_is(one.run)
    before, after = (f"{general(error, 2)} {one.unit}" for error in one.errors)
    if not of_bench(record):
        text = f"{name} in {run}: error {before} before, {after} after"
    elif one.apart is None:
        text = f"{name} in {run}, which was used for the fit: error {before} before, {after} after"
    else:
        text = (
            f"{name} in {run}, where it was not used for the fit: "
            f"error {before} before, {after} after"
        )
    floor = healthy_floor(record, one.channel)
    if floor is not None:
        shown = general(floor, 2)
        text += f"; a sound vehicle leaves {shown} {one.unit}"
    return f"{capital(text)}."
