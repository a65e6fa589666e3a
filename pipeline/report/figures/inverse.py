"""Figures of the inverse characteristics and of the round trip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.physics.propeller import polynomial
from pipeline.physics.thrust_grid import code_from_thrust
from pipeline.records.fits import InverseCharacteristic, PolynomialFit, StaticCharacteristic
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.comparison import THRUST_FROM_N, table4_row
from pipeline.report.curves import (
    polynomial_band,
    speed_index,
    static_thrust,
    table4_code,
)
from pipeline.report.numbers import code, fixed, plural, speed
from pipeline.report.results import VehicleResults
from pipeline.types import FloatArray

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes


def mooring_figure(results: VehicleResults, inverse: InverseCharacteristic) -> Figure:
    """N(T) at rest for both signs of thrust, with residuals below."""
    published = results.vehicle.published.table3 if results.vehicle.published else None
    sides = [
        (fit, colour, printed)
        for fit, colour, printed in (
            (
                inverse.table3_positive,
                plotting.VERMILLION,
                published.positive if published else None,
            ),
            (inverse.table3_negative, plotting.PURPLE, published.negative if published else None),
        )
        if fit is not None
    ]
    spread = max(fit.quality.residual_std for fit, _, _ in sides)
    points = sum(fit.quality.points for fit, _, _ in sides)
    lead = (
        f"The cubics follow {plural(points, 'mooring point')} with a residual of "
        f"{fixed(spread, 2)} codes; the dead zone ends at about code "
        + " and ".join(
            code(round(abs(float(polynomial(sign * THRUST_FROM_N, np.asarray(fit.coefficients))))))
            + (" for positive" if sign > 0 else " for negative")
            for fit, _, _ in sides
            for sign in [1 if fit is inverse.table3_positive else -1]
        )
        + " thrust."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        top, low = figure.subplots(2, 1, sharex=True, height_ratios=(3.2, 1))
        for fit, colour, printed in sides:
            _curve_and_residuals(top, low, fit, colour, printed, first=fit is sides[0][0])
        low.axhline(0, color=plotting.SOFT, lw=0.8)
        top.set_ylabel("code N  [–]")
        low.set(xlabel="thrust T at rest  [N]", ylabel="residual  [–]")
        plotting.legend_above(figure, top, columns=4)

    alt = (
        "Code against thrust at rest for both signs: mooring points, cubic fits with 95 % bands, "
        "published cubics dashed, residuals below."
    )
    return Figure(
        "fig-inverse-rest",
        lead,
        plotting.draw("fig-inverse-rest", alt, paint, height_in=4.4),
        "Inverse mooring characteristic (fig. 9 of Kostenko 2023). Below: measured less fitted "
        "code.",
    )


def _curve_and_residuals(
    top: Axes,
    low: Axes,
    fit: PolynomialFit,
    colour: str,
    printed: Sequence[float] | None,
    *,
    first: bool,
) -> None:
    thrust = np.linspace(*fit.quality.valid_range, 200)
    value, half = polynomial_band(fit, thrust)
    top.fill_between(thrust, value - half, value + half, color=colour, alpha=0.25, lw=0)
    top.plot(thrust, value, color=colour, label="fit" if first else None)
    for outlier, marker in ((False, "o"), (True, "x")):
        own = [p for p in fit.points if p.outlier is outlier]
        raster = len(own) > plotting.VECTOR_POINTS_MAX
        label = ("outlier" if outlier else "measured") if first and own else None
        top.plot(
            [p.x for p in own],
            [p.measured for p in own],
            marker,
            color=colour,
            ms=2.8,
            alpha=0.6,
            label=label,
            rasterized=raster,
        )
        if not outlier:
            low.plot(
                [p.x for p in own],
                [p.measured - p.fitted for p in own],
                marker,
                color=colour,
                ms=2.4,
                alpha=0.6,
                rasterized=raster,
            )
    if printed is not None:
        top.plot(
            thrust,
            polynomial(thrust, np.asarray(printed)),
            "--",
            color=plotting.INK,
            lw=0.9,
            label="published" if first else None,
        )


def family_figure(
    results: VehicleResults, inverse: InverseCharacteristic, static: StaticCharacteristic
) -> Figure:
    """N(T, V): the family, the cubic of Table 4, the firmware form, the published cubic."""
    published = results.vehicle.published.table4 if results.vehicle.published else None
    rows = inverse.table4
    shared = min(row.thrust_max_n for row in rows)
    probe = float(np.floor(shared)) if shared > 2 else shared
    first = float(table4_code(np.asarray(rows[0].coefficients), probe))
    last = float(table4_code(np.asarray(rows[-1].coefficients), probe))
    lead = (
        f"For {fixed(probe, 0)} N the code must rise from {fixed(first, 0)} to {fixed(last, 0)} "
        f"between {speed(rows[0].speed_mps)} and {speed(rows[-1].speed_mps)} m/s"
        + _without_compensation(static, first, rows[-1].speed_mps)
        + "."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes, low = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        for row, colour in zip(rows, plotting.ordered_colours(len(rows)), strict=True):
            thrust = np.linspace(min(THRUST_FROM_N, row.thrust_max_n), row.thrust_max_n, 150)
            axes.plot(
                thrust,
                table4_code(np.asarray(row.coefficients), thrust),
                color=colour,
                label=f"{speed(row.speed_mps)} m/s",
            )
            _family_points(axes, static, row.speed_mps, colour)
            if inverse.firmware is not None:
                codes = code_from_thrust(
                    thrust,
                    row.speed_mps,
                    positive=thrust_grid(inverse.firmware.positive),
                    negative=thrust_grid(inverse.firmware.negative),
                    thrust_dead_n=inverse.firmware.thrust_dead_n,
                )
                family = _family_code(static, row.speed_mps, thrust)
                if family is not None:
                    off = np.where(codes > 0, codes - family, np.nan)
                    low.plot(thrust, off, ":", color=plotting.VERMILLION, lw=1.2)
            family = _family_code(static, row.speed_mps, thrust)
            if family is not None:
                cubic = table4_code(np.asarray(row.coefficients), thrust)
                low.plot(thrust, cubic - family, color=colour, lw=1.1)
            printed = table4_row(published, row.speed_mps) if published else None
            if printed is not None:
                axes.plot(
                    thrust,
                    table4_code(np.asarray(printed), thrust),
                    "--",
                    color=plotting.INK,
                    lw=0.8,
                    label="published" if row is rows[-1] else None,
                )
        if inverse.firmware is not None:
            axes.plot([], [], ":", color=plotting.VERMILLION, label="firmware form")
        low.axhline(0, color=plotting.SOFT, lw=0.8)
        axes.set_ylabel("code N  [–]")
        low.set(xlabel="thrust T  [N]", ylabel="off the\nfamily  [–]")
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        plotting.legend_above(figure, axes, columns=4)

    alt = "Code against thrust, one curve for each speed; published curves dashed."
    return Figure(
        "fig-inverse-family",
        lead,
        plotting.draw("fig-inverse-family", alt, paint, height_in=4.9),
        "Inverse family (fig. 10 of Kostenko 2023). Solid: cubic of Table 4; dots: the family "
        "itself; dashed: published Table 4. Below, in codes: how far the cubic (solid) and the "
        "firmware form (dotted) are off the family.",
    )


def _without_compensation(static: StaticCharacteristic, at_code: float, speed_mps: float) -> str:
    row = speed_index(static.speed_mps, speed_mps)
    if row is None:
        return ""
    thrust = float(static_thrust(static, row, at_code))
    return f"; the code found at rest gives {fixed(thrust, 1)} N at {speed(speed_mps)} m/s"


def _family_code(
    static: StaticCharacteristic, speed_mps: float, thrust_n: FloatArray
) -> FloatArray | None:
    """Code of the family at a thrust, by inverting its own grid."""
    index = speed_index(static.speed_mps, speed_mps)
    if index is None:
        return None
    thrust = np.asarray(static.thrust_n[index])
    live = np.isin(np.asarray(static.status[index]), ["live", "extrapolated"])
    if live.sum() < 2:
        return None
    codes = np.asarray(static.code)[live]
    return np.asarray(np.interp(thrust_n, thrust[live], codes, left=np.nan, right=np.nan))


def _family_points(axes: Axes, static: StaticCharacteristic, speed_mps: float, colour: str) -> None:
    index = speed_index(static.speed_mps, speed_mps)
    if index is None:
        return
    thrust, grid = np.asarray(static.thrust_n[index]), np.asarray(static.code)
    live = np.isin(np.asarray(static.status[index]), ["live", "extrapolated"])
    step = max(int(live.sum()) // 14, 1)
    axes.plot(thrust[live][::step], grid[live][::step], "o", color=colour, ms=2.6)


def round_trip_figure(inverse: InverseCharacteristic) -> Figure:
    """Largest round-trip error by speed for every form, on a logarithmic scale."""
    rows = inverse.round_trip
    firmware = max(r.firmware_n for r in rows)
    cubic = [(r.speed_mps, r.cubic_n) for r in rows if r.cubic_n is not None]
    printed = [(r.speed_mps, r.published_n) for r in rows if r.published_n is not None]
    parts = [f"{fixed(firmware, 3)} N for the firmware form before rounding"]
    if cubic:
        parts.append(f"{fixed(max(e for _, e in cubic), 2)} N for the cubic")
    if printed:
        parts.append(f"{fixed(max(e for _, e in printed), 2)} N for the published tables")
    lead = "Thrust to code to thrust is off by at most " + ", ".join(parts) + "."

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        floor = 1e-4
        for data, label, marker, colour in (
            (printed, "published tables", "s", plotting.INK),
            (cubic, "cubic of Table 4", "o", plotting.BLUE),
            (
                [(r.speed_mps, r.firmware_n) for r in rows],
                "firmware form",
                "D",
                plotting.VERMILLION,
            ),
        ):
            if data:
                axes.plot(
                    [v for v, _ in data],
                    [max(e, floor) for _, e in data],
                    marker=marker,
                    lw=0.8,
                    color=colour,
                    label=label,
                )
        plotting.plain_log_axis(axes)
        axes.set(xlabel="speed V  [m/s]", ylabel="largest round-trip error  [N]")
        plotting.legend_above(figure, axes)

    alt = "Largest error of thrust to code to thrust against speed, for each form, logarithmic."
    return Figure(
        "fig-round-trip",
        lead,
        plotting.draw("fig-round-trip", alt, paint, height_in=3.0),
        "Round trip T(N(T, V), V) over 0.5 N < T ≤ T_max, before the code is rounded to an "
        "integer; values under 0.0001 N are drawn there.",
    )
