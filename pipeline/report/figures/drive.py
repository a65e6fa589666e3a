"""Figures of the drive's mechanical characteristic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.fits import DriveFit
from pipeline.records.intervals import drive_factor
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.curves import drive_torque
from pipeline.report.numbers import code, fixed, general, plural
from pipeline.types import FloatArray

if TYPE_CHECKING:
    import matplotlib.figure


def raw_figure(record: LoadTestRecord | None) -> Figure | None:
    """Torque against shaft speed as measured, for a bench whose family cannot be fitted."""
    points = [p for p in record.points if not p.marks] if record is not None else []
    if not points:
        return None
    fastest = max(abs(p.shaft_speed_rpm) for p in points)
    strongest = max(abs(p.torque_nm) for p in points)
    lead = (
        f"The bench covers {general(strongest)} N m and {fixed(fastest, 0)} rpm with "
        f"{plural(len(points), 'point')}; they stand here as measured, nothing is fitted to them."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        axes.plot(
            [abs(p.shaft_speed_rpm) for p in points],
            [abs(p.torque_nm) for p in points],
            "o",
            color=plotting.BLUE,
            ms=2.6,
            alpha=0.6,
            rasterized=len(points) > plotting.VECTOR_POINTS_MAX,
        )
        axes.set(xlabel="shaft speed n  [rpm]", ylabel="torque M  [N m]")
        axes.set_ylim(bottom=0)

    alt = "Torque against shaft speed of all usable points of the bench."
    return Figure(
        "fig-drive-raw",
        lead,
        plotting.draw("fig-drive-raw", alt, paint),
        "Magnitudes of torque and shaft speed of every usable point.",
    )


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


def _codes_of(points: list[LoadTestPoint]) -> list[float]:
    return [abs(p.code) for p in points if p.code is not None]


def _code_colours(codes: FloatArray) -> dict[float, str]:
    """Colour of each code, dark to light."""
    return dict(zip(codes.tolist(), plotting.ordered_colours(codes.size), strict=True))


def family_figure(
    fit: DriveFit, points: list[LoadTestPoint], outliers: list[LoadTestPoint]
) -> Figure:
    """Draw the bench's points by branch, the surface at each code, and the outliers."""
    codes = np.array([spread.code for spread in fit.codes])
    colours = _code_colours(codes)
    top = max(fit.codes, key=lambda spread: spread.code)
    ends = drive_torque(fit, np.array(top.shaft_speed_rpm), top.code)[0]
    lead = (
        f"At code {code(top.code)} the torque falls from {fixed(float(ends[0]), 3)} to "
        f"{fixed(float(ends[1]), 3)} N m between {fixed(top.shaft_speed_rpm[0], 0)} and "
        f"{fixed(top.shaft_speed_rpm[1], 0)} rpm; one smooth surface follows the "
        f"{plural(len(fit.codes), 'measured code')} with a residual of "
        f"{fixed(1000 * fit.quality.residual_std, 1)} mN m."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        raster = len(points) > plotting.VECTOR_POINTS_MAX
        for branch, marker in (("loading", "o"), ("unloading", "^")):
            own = [p for p in points if p.branch == branch]
            axes.scatter(
                [abs(p.shaft_speed_rpm) for p in own],
                [abs(p.torque_nm) for p in own],
                c=[colours.get(value, plotting.SOFT) for value in _codes_of(own)],
                marker=marker,
                s=9,
                alpha=0.6,
                lw=0,
                rasterized=raster,
            )
        axes.plot(
            [abs(p.shaft_speed_rpm) for p in outliers],
            [abs(p.torque_nm) for p in outliers],
            "x",
            color=plotting.VERMILLION,
            ms=5,
            label="outlier" if outliers else None,
        )
        factor = drive_factor(fit)
        for spread in fit.codes:
            rpm = np.linspace(*spread.shaft_speed_rpm, 60)
            torque, std = drive_torque(fit, rpm, spread.code)
            colour = colours[spread.code]
            axes.fill_between(
                rpm,
                torque - factor * std,
                torque + factor * std,
                color=colour,
                alpha=0.2,
                lw=0,
            )
            axes.plot(rpm, torque, color=colour, lw=1.2)
            plotting.line_end_label(axes, rpm.tolist(), torque.tolist(), code(spread.code))
        axes.plot([], [], "o", color=plotting.SOFT, label="load rising")
        axes.plot([], [], "^", color=plotting.SOFT, label="load falling")
        axes.plot([], [], "-", color=plotting.SOFT, label="surface M(n, N)")
        axes.set(xlabel="shaft speed n  [rpm]", ylabel="torque M  [N m]")
        axes.set_ylim(bottom=0)
        plotting.legend_above(figure, axes)

    alt = "Torque against shaft speed for each control code: bench points and the fitted surface."
    return Figure(
        "fig-drive-family",
        lead,
        plotting.draw("fig-drive-family", alt, paint, height_in=4.0),
        "Mechanical characteristics (fig. 4, b of Kostenko 2023); the number at a line is its "
        "code. Bands: 95 % of the surface. Reverse sweeps are shown by their magnitudes.",
    )


def residual_figure(fit: DriveFit, points: list[LoadTestPoint]) -> Figure:
    """Draw the residuals of the surface against shaft speed, and their scatter by code."""
    codes = np.array([spread.code for spread in fit.codes])
    colours = _code_colours(codes)
    rpm = np.array([abs(p.shaft_speed_rpm) for p in points])
    at = np.array(_codes_of(points))
    torque = np.array([abs(p.torque_nm) for p in points])
    residual = 1000 * (torque - drive_torque(fit, rpm, at)[0]) if points else torque
    worst = max(fit.codes, key=lambda spread: spread.residual_std_nm)
    lead = (
        f"The residuals show no code standing apart by more than its scatter: the largest, "
        f"{fixed(1000 * worst.residual_std_nm, 1)} mN m, is at code {code(worst.code)}; the mean "
        "of rising and falling load is what the surface follows."
    )
    gaps = [
        abs(s.loading_minus_unloading_nm)
        for s in fit.codes
        if s.loading_minus_unloading_nm is not None
    ]
    if gaps:
        lead = (
            f"The scatter is largest at code {code(worst.code)} "
            f"({fixed(1000 * worst.residual_std_nm, 1)} mN m); rising and falling load differ by "
            f"up to {fixed(1000 * max(gaps), 1)} mN m at one code, and the surface follows their "
            "mean."
        )

    def paint(figure: matplotlib.figure.Figure) -> None:
        top, low = figure.subplots(2, 1, height_ratios=(2.2, 1))
        raster = len(points) > plotting.VECTOR_POINTS_MAX
        for branch, marker in (("loading", "o"), ("unloading", "^")):
            mask = np.array([p.branch == branch for p in points], dtype=bool)
            top.scatter(
                rpm[mask],
                residual[mask],
                c=[colours.get(value, plotting.SOFT) for value in at[mask].tolist()],
                marker=marker,
                s=9,
                alpha=0.6,
                lw=0,
                rasterized=raster,
            )
        top.axhline(0, color=plotting.SOFT, lw=0.8)
        top.plot([], [], "o", color=plotting.SOFT, label="load rising")
        top.plot([], [], "^", color=plotting.SOFT, label="load falling")
        top.set(xlabel="shaft speed n  [rpm]", ylabel="residual of M  [mN m]")
        low.bar(
            codes,
            [1000 * s.residual_std_nm for s in fit.codes],
            width=0.55 * float(np.min(np.diff(codes))) if codes.size > 1 else 4.0,
            color=[colours[c] for c in codes.tolist()],
        )
        low.set(xlabel="code N  [–]", ylabel="std  [mN m]")
        plotting.legend_above(figure, top)

    alt = "Residuals of the drive surface against shaft speed, and their scatter by code."
    return Figure(
        "fig-drive-residuals",
        lead,
        plotting.draw("fig-drive-residuals", alt, paint, height_in=4.0),
        "Measured less fitted torque against shaft speed (colour: code, violet is low), and the "
        "standard deviation of the residuals at each code.",
    )
