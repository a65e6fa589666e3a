"""Table 1: the propeller's open-water curves (Kostenko 2023, fig. 2 and table 1)."""

import numpy as np

from pipeline.physics.propeller import efficiency, polynomial
from pipeline.records.fits import PropellerFit
from pipeline.records.measurements import OpenWaterRecord
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Figure, Paragraph, chapter
from pipeline.report.curves import efficiency_curve, fit_panels
from pipeline.report.numbers import fixed, percent
from pipeline.report.results import VehicleResults, needed
from pipeline.report.sections.tables import (
    Coefficient,
    coefficient_table,
    coefficients,
    largest_relative_difference,
    quality_line,
    share_inside,
)
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.vehicle.bench_schema import PublishedTable1

#: The published comparison is scored up to this advance ratio.
COMPARED_TO_J = 0.6


@chapter("propeller", "Propeller: K_T(J) and K_M(J), Table 1")
def propeller_section(results: VehicleResults) -> Blocks:
    """Show the fit with its data, residuals, Table 1 and the published curves."""
    fit = needed(results, "propeller", results.propeller)
    published = results.vehicle.published.table1 if results.vehicle.published else None
    yield _figure(fit, results.open_water, published)
    yield from _table1(fit, published)
    for name, curve in (("K_T", fit.thrust), ("K_M", fit.torque)):
        yield Paragraph(quality_line(name, curve.quality, "J"))
        if curve.quality.order_reason:
            yield Paragraph(curve.quality.order_reason)


def _table1(fit: PropellerFit, published: PublishedTable1 | None) -> Blocks:
    curves = {
        "K_T": (fit.thrust, published.KT if published else None),
        "K_M": (fit.torque, published.KM if published else None),
    }
    rows: list[Coefficient] = []
    off = []
    for name, (curve, printed) in curves.items():
        names = [f"{name}{i}" for i in range(4)]
        rows += coefficients(names, curve.coefficients, curve.ci95, printed)
        if printed is not None:
            share = percent(largest_relative_difference(curve, printed, COMPARED_TO_J))
            off.append(f"{name} differs by at most {share} of {name}0")
    yield coefficient_table(
        "Table 1. Propeller coefficients",
        rows,
        note=f"Diameter {fixed(fit.diameter_m, 3)} m. K_M is the English K_Q.",
        points="fig-propeller",
    )
    if off:
        over = f"Against the published curves over J = 0 to {COMPARED_TO_J}"
        yield Paragraph(f"{over}: {', '.join(off)}. {share_inside(rows)}")


def _figure(
    fit: PropellerFit, record: OpenWaterRecord | None, published: PublishedTable1 | None
) -> Figure:
    lows, highs = zip(*(own.quality.valid_range for own in (fit.thrust, fit.torque)), strict=True)
    j = np.linspace(min(lows), max(highs), 200)
    eta = efficiency_curve(fit, j)
    best = int(np.nanargmax(eta)) if np.isfinite(eta).any() else None
    k_t = polynomial(j, np.asarray(fit.thrust.coefficients))
    best_text = (
        f"; efficiency is largest, {fixed(float(eta[best]), 2)}, at J = {fixed(float(j[best]), 2)}"
        if best is not None
        else ""
    )
    k_t_printed, k_m_printed = (published.KT, published.KM) if published else (None, None)
    thrust, left_t = fit_panels(fit.thrust, "K_T", plotting.BLUE, k_t_printed)
    torque, left_m = fit_panels(fit.torque, "10 K_M", plotting.VERMILLION, k_m_printed, scale=10.0)
    curves = (*thrust, *torque, Trace("efficiency", j, eta, plotting.GREEN), *_measured(record))
    return zoomable_figure(
        "fig-propeller",
        f"K_T falls from {fixed(float(k_t[0]), 3)} to {fixed(float(k_t[-1]), 3)} between "
        f"J = {fixed(float(j[0]), 2)} and {fixed(float(j[-1]), 2)}{best_text}.",
        "Open-water curves (fig. 2 of Kostenko 2023). Points: data; lines: fits; bands: 95 % of "
        "the fit; dashed: published; crosses: outliers. Below: residuals on the same axis.",
        (
            Panel("K_T, 10 K_M,\nefficiency  [–]", curves, height=2.0, from_zero=True),
            Panel("K_T\nresidual", (left_t,), height=0.6, band=0.0),
            Panel("10 K_M\nresidual", (left_m,), height=0.6, band=0.0),
        ),
        x_label="advance ratio J  [–]",
    )


def _measured(record: OpenWaterRecord | None) -> tuple[Trace, ...]:
    """Efficiency of the single points."""
    points = [
        (p.advance_ratio, p.thrust_coefficient, p.torque_coefficient)
        for p in (record.points if record is not None else ())
        if not p.marks and p.thrust_coefficient is not None and p.torque_coefficient is not None
    ]
    useful = [(j, k_t, k_m) for j, k_t, k_m in points if k_t > 0 and k_m > 0]
    if not useful:
        return ()
    j, k_t, k_m = (np.array(column) for column in zip(*useful, strict=True))
    return (Trace("", j, efficiency(j, k_t, k_m), plotting.GREEN, "points"),)
