"""The drive's mechanical characteristic M(n, N) (Kostenko 2023, fig. 4)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.records.fit_values import SWEEPS_PER_TERM, drive_factor, drive_torque
from pipeline.records.fits import DriveFit
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Figure, Table, Text, chapter
from pipeline.report.numbers import code, fixed, general, percent, plural, signed
from pipeline.report.results import VehicleResults, needed
from pipeline.report.sections.tables import quality_line
from pipeline.report.zoomable import Panel, Trace, zoomable_figure

_BRANCHES = (("loading", "load rising", "o"), ("unloading", "load falling", "^"))


@chapter("drive", "Drive: torque against shaft speed and code")
def drive_section(results: VehicleResults) -> Blocks:
    """Show the surface over the bench's points, and its scatter by code."""
    record = results.load_test
    points = [p for p in record.points if not p.marks] if record is not None else []
    if results.drive is None and points:
        trace = _points("", points, plotting.BLUE)
        yield zoomable_figure(
            "fig-drive-raw",
            f"The bench covers {general(trace.values.max())} N m and {fixed(trace.x.max(), 0)} rpm "
            f"with {plural(len(points), 'point')}; they stand here as measured, nothing is fitted "
            "to them.",
            "Magnitudes of torque and shaft speed of every usable point.",
            (Panel("torque M  [N m]", (trace,), height=1.8, from_zero=True),),
            x_label="shaft speed n  [rpm]",
        )
    fit = needed(results, "drive", results.drive)
    yield _family(fit, *fitted_points(record, fit))
    yield Text(quality_line("M(n, N)", fit.quality, "codes"))
    yield _intervals(fit)
    if len(fit.torque_scale_by_file) > 1:
        yield Table.of(
            "Torque of each file against the common surface",
            fit.torque_scale_by_file.items(),
            lambda of: {
                "File": of[0],
                "Scale": fixed(of[1], 4),
                "Difference": f"{signed(100 * (of[1] - 1), 2)} %",
            },
            note=f"Standard deviation {percent(fit.torque_scale_std)}: the spread from drive to "
            "drive, which the intervals carry.",
        )
    yield Table.of(
        "Scatter about the surface, by code",
        fit.codes,
        "Code: {code:code} | Points: {points} | Shaft speed, rpm: {shaft_speed_rpm[0]:.0f} to "
        "{shaft_speed_rpm[1]:.0f} | Torque, N m: {torque_nm[0]:.3f} to {torque_nm[1]:.3f} | "
        "Residual std, mN m: {residual_std_nm:1000*.2f} | Rising less falling load, mN m: "
        "{loading_minus_unloading_nm:1000*+.2f}",
    )
    if fit.quality.order_reason:
        yield Text(fit.quality.order_reason)


def fitted_points(
    record: LoadTestRecord | None, fit: DriveFit
) -> tuple[list[LoadTestPoint], list[LoadTestPoint]]:
    """Points of the bench that were fitted, and the outliers that the fit named."""
    if record is None:
        return [], []
    named = {o.source for o in fit.quality.outliers if o.source is not None}
    usable = record.points_to_fit()
    fitted = [p for p in usable if p.source not in named]
    return fitted, [p for p in usable if p.source in named]


def _points(name: str, points: Sequence[LoadTestPoint], colour: str, mark: str = "o") -> Trace:
    """Magnitudes of torque over shaft speed."""
    rpm, torque = np.abs([(p.shaft_speed_rpm, p.torque_nm) for p in points]).T
    return Trace(name, rpm, torque, colour, "points", mark=mark)


def _family(
    fit: DriveFit, points: Sequence[LoadTestPoint], outliers: Sequence[LoadTestPoint]
) -> Figure:
    top = max(fit.codes, key=lambda spread: spread.code)
    ends = drive_torque(fit, np.array(top.shaft_speed_rpm), top.code)[0]
    factor = drive_factor(fit)
    shades = plotting.ordered_colours(len(fit.codes))
    above, below = list[Trace](), list[Trace]()
    for spread, colour in zip(fit.codes, shades, strict=True):
        for branch, name, mark in _BRANCHES:
            own = [p for p in points if p.branch == branch and abs(p.code or 0.0) == spread.code]
            if own:
                shown = _points(name, own, colour, mark)
                left = shown.values - drive_torque(fit, shown.x, spread.code)[0]
                above.append(shown)
                below.append(replace(shown, name="", values=1000.0 * left))
        rpm = np.linspace(*spread.shaft_speed_rpm, 60)
        torque, std = drive_torque(fit, rpm, spread.code)
        band = np.array([torque - factor * std, torque + factor * std])
        above.append(Trace("surface", rpm, torque, colour, band=band, end=code(spread.code)))
    if outliers:
        above.append(_points("outlier", outliers, plotting.VERMILLION, "x"))
    return zoomable_figure(
        "fig-drive-family",
        f"At code {code(top.code)} the torque falls from {fixed(float(ends[0]), 3)} to "
        f"{fixed(float(ends[1]), 3)} N m between {fixed(top.shaft_speed_rpm[0], 0)} and "
        f"{fixed(top.shaft_speed_rpm[1], 0)} rpm; one smooth surface follows the "
        f"{plural(len(fit.codes), 'measured code')} with a residual of "
        f"{fixed(1000 * fit.quality.residual_std, 1)} mN m.",
        "Mechanical characteristics (fig. 4, b of Kostenko 2023); the number at a line is its "
        "code. Bands: 95 % of the surface. Reverse sweeps are shown by their magnitudes.",
        (
            Panel("torque M  [N m]", above, height=2.0, from_zero=True),
            Panel("left over\n[mN m]", below, height=0.8, band=0.0),
        ),
        x_label="shaft speed n  [rpm]",
    )


def _intervals(fit: DriveFit) -> Text:
    """Say what the intervals count as independent."""
    terms = len(fit.coefficients)
    if fit.clustered and fit.clusters >= SWEEPS_PER_TERM * terms:
        return Text(
            f"The covariance is clustered by sweep ({fit.clusters} sweeps): the errors of one "
            "sweep go together."
        )
    return Text(
        f"The covariance is clustered by sweep, but the {fit.clusters} sweeps are fewer than two "
        f"for each of the {terms} terms of the surface: the 95 % intervals that rest on it hold "
        "the truth less often than that. Measure more codes, both branches, or a second drive."
        if fit.clustered
        else f"The {fit.clusters} sweeps are too few for the {terms} terms of the "
        "surface, so the covariance could not be clustered by sweep: it counts the points of a "
        "sweep as independent, and all intervals that rest on it are too narrow.",
        tone="warning",
    )
