"""Table 1: the propeller's open-water curves (Kostenko 2023, fig. 2 and table 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.physics.propeller import efficiency, polynomial
from pipeline.records.fits import PolynomialFit, PropellerFit
from pipeline.records.measurements import OpenWaterRecord
from pipeline.report import plotting
from pipeline.report.blocks import Block, Details, Figure, Paragraph, Section, not_computed
from pipeline.report.comparison import coefficients, largest_relative_difference
from pipeline.report.curves import efficiency_curve, polynomial_band
from pipeline.report.numbers import fixed, percent
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import (
    coefficient_table,
    order_table,
    quality_line,
    share_inside,
)
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import PublishedTable1

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes

ANCHOR, TITLE = "propeller", "Propeller: K_T(J) and K_M(J), Table 1"
#: The published comparison is scored up to this advance ratio.
COMPARED_TO_J = 0.6


def propeller_section(results: VehicleResults) -> Section:
    """Show the fit with its data, residuals, Table 1 and the published curves."""
    fit = results.propeller
    if fit is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["propeller"])
    published = results.vehicle.published.table1 if results.vehicle.published else None
    blocks: list[Block] = [_figure(fit, results.open_water, published), *_table1(fit, published)]
    blocks.append(Paragraph(quality_line("K_T", fit.thrust.quality, "J")))
    blocks.append(Paragraph(quality_line("K_M", fit.torque.quality, "J")))
    orders = tuple(
        order_table(f"Order of {name}", curve.quality)
        for name, curve in (("K_T", fit.thrust), ("K_M", fit.torque))
        if curve.quality.orders
    )
    if orders:
        blocks.append(Details("Why this order", orders))
    return Section(ANCHOR, TITLE, tuple(blocks))


def _table1(fit: PropellerFit, published: PublishedTable1 | None) -> list[Block]:
    names_t, names_m = ("K_T0", "K_T1", "K_T2", "K_T3"), ("K_M0", "K_M1", "K_M2", "K_M3")
    thrust, torque = fit.thrust, fit.torque
    both = (
        *coefficients(
            names_t, thrust.coefficients, thrust.ci95, published.KT if published else None
        ),
        *coefficients(
            names_m, torque.coefficients, torque.ci95, published.KM if published else None
        ),
    )
    blocks: list[Block] = [
        coefficient_table(
            "Table 1. Propeller coefficients",
            both,
            note=f"Diameter {fixed(fit.diameter_m, 3)} m. K_M is the English K_Q.",
            points="fig-propeller",
        )
    ]
    if published is not None:
        k_t = largest_relative_difference(thrust, published.KT, COMPARED_TO_J)
        k_m = largest_relative_difference(torque, published.KM, COMPARED_TO_J)
        blocks.append(
            Paragraph(
                f"Against the published curves over J = 0 to {COMPARED_TO_J}: K_T differs by at "
                f"most {percent(k_t)} of K_T0, K_M by at most {percent(k_m)} of K_M0. "
                + share_inside(
                    both,
                    "The coefficients of one curve lean on each other: a slope that is a little "
                    "smaller is made up for by a curvature that is larger, so the difference of "
                    "the curves is what to read.",
                )
            )
        )
    return blocks


def _figure(
    fit: PropellerFit, record: OpenWaterRecord | None, published: PublishedTable1 | None
) -> Figure:
    low = min(fit.thrust.quality.valid_range[0], fit.torque.quality.valid_range[0])
    high = max(fit.thrust.quality.valid_range[1], fit.torque.quality.valid_range[1])
    j = np.linspace(low, high, 200)
    eta = efficiency_curve(fit, j)
    best = int(np.nanargmax(eta)) if np.isfinite(eta).any() else None
    k_t = polynomial(j, np.asarray(fit.thrust.coefficients))
    best_text = (
        f"; efficiency is largest, {fixed(float(eta[best]), 2)}, at J = {fixed(float(j[best]), 2)}"
        if best is not None
        else ""
    )
    lead = (
        f"K_T falls from {fixed(float(k_t[0]), 3)} to {fixed(float(k_t[-1]), 3)} between "
        f"J = {fixed(float(j[0]), 2)} and {fixed(float(j[-1]), 2)}{best_text}."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        top, low_t, low_m = figure.subplots(
            3, 1, sharex=True, height_ratios=(4.2, 1, 1), squeeze=True
        )
        _curves(top, fit, j, eta, published)
        _efficiency_points(top, record)
        _residuals(low_t, fit.thrust, 1.0, "$K_T$", plotting.BLUE)
        _residuals(low_m, fit.torque, 10.0, r"$10\,K_M$", plotting.VERMILLION)
        low_m.set_xlabel("advance ratio J  [–]")
        plotting.legend_above(figure, top, columns=4)

    alt = (
        "Thrust and torque coefficients and efficiency against the advance ratio: measured points, "
        "fits with 95 % bands, published curves dashed, residuals below."
    )
    return Figure(
        "fig-propeller",
        lead,
        plotting.draw("fig-propeller", alt, paint, height_in=4.9),
        "Open-water curves (fig. 2 of Kostenko 2023). Points: data; lines: fits; bands: 95 % of "
        "the fit; dashed: published; crosses: outliers. Below: residuals on the same axis.",
    )


def _curves(
    axes: Axes, fit: PropellerFit, j: FloatArray, eta: FloatArray, published: PublishedTable1 | None
) -> None:
    for curve, scale, label, colour, printed in (
        (fit.thrust, 1.0, "$K_T$", plotting.BLUE, published.KT if published else None),
        (fit.torque, 10.0, r"$10\,K_M$", plotting.VERMILLION, published.KM if published else None),
    ):
        value, half = polynomial_band(curve, j)
        axes.fill_between(
            j, scale * (value - half), scale * (value + half), color=colour, alpha=0.2, lw=0
        )
        axes.plot(j, scale * value, color=colour, label=label)
        for outlier, marker in ((False, "o"), (True, "x")):
            points = [p for p in curve.points if p.outlier is outlier]
            axes.plot(
                [p.x for p in points],
                [scale * p.measured for p in points],
                marker,
                color=colour,
                ms=4.5 if outlier else 3.2,
                alpha=0.75,
                rasterized=len(points) > plotting.VECTOR_POINTS_MAX,
            )
        if printed is not None:
            axes.plot(
                j,
                scale * polynomial(j, np.asarray(printed)),
                "--",
                color=plotting.INK,
                lw=1.0,
                label="published" if scale == 1.0 else None,
            )
    axes.plot(j, eta, color=plotting.GREEN, label="efficiency")
    axes.axhline(0, color=plotting.SOFT, lw=0.8)
    axes.set_ylabel(r"$K_T$, $10\,K_M$, efficiency  [–]")
    axes.set_ylim(bottom=min(-0.05, float(np.nanmin(axes.get_ylim()[0]))))


def _efficiency_points(axes: Axes, record: OpenWaterRecord | None) -> None:
    if record is None:
        return
    points = [
        (p.advance_ratio, p.thrust_coefficient, p.torque_coefficient)
        for p in record.points
        if not p.marks and p.thrust_coefficient is not None and p.torque_coefficient is not None
    ]
    useful = [(j, k_t, k_m) for j, k_t, k_m in points if k_t > 0 and k_m > 0]
    if useful:
        j, k_t, k_m = (np.array(column) for column in zip(*useful, strict=True))
        axes.plot(j, efficiency(j, k_t, k_m), "o", color=plotting.GREEN, ms=2.6, alpha=0.6)


def _residuals(axes: Axes, curve: PolynomialFit, scale: float, label: str, colour: str) -> None:
    kept = [p for p in curve.points if not p.outlier]
    axes.axhline(0, color=plotting.SOFT, lw=0.8)
    axes.plot(
        [p.x for p in kept],
        [scale * (p.measured - p.fitted) for p in kept],
        "o",
        color=colour,
        ms=2.8,
        alpha=0.75,
    )
    axes.set_ylabel(f"{label}\nresidual", fontsize=8.5)
    axes.margins(y=0.2)
