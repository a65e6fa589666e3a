"""The gap between the mooring test and the calculation at rest, shown and not hidden."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.fit_values import (
    CodeGap,
    code_gaps,
    speed_index,
    static_factor,
    static_std,
    static_thrust,
)
from pipeline.records.fits import StaticCharacteristic
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Figure, Table, Text, chapter
from pipeline.report.numbers import code, fixed
from pipeline.report.results import VehicleResults, mooring_points_of_tables, needed
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


@chapter("gap", "Mooring test against the calculation at rest")
def gap_section(results: VehicleResults) -> Blocks:
    """Compare thrust at rest by both routes, each sign apart."""
    needed(results, "mooring", results.mooring)
    static = needed(results, "static", results.static)
    gaps = code_gaps(mooring_points_of_tables(results), static, results.drive)
    if not gaps:
        none = "no code of the mooring test has a calculated working point at rest."
        raise CannotComputeError(none)
    worst = max(gaps, key=lambda gap: abs(gap.gap_n))
    outside = sum(abs(gap.gap_n) > gap.half_width_n for gap in gaps)
    largest = f"{fixed(abs(worst.gap_n), 2)} N at code {code(worst.code)}"
    said = (
        f"The two routes to the thrust at rest differ by up to {largest}. At {outside} of "
        f"{len(gaps)} codes the difference is larger than the 95 % interval of calculation and "
        "mooring mean together: it is not scatter, but a true difference between the mooring test "
        "and the route over load test and open-water curves."
        if outside
        else f"The two routes agree at rest within {fixed(abs(worst.gap_n), 2)}"
        " N, inside their 95 % intervals at every code."
    )
    yield _figure(results, static, gaps)
    yield Text(said, tone="warning" if outside else "plain")
    yield Table.of(
        "Thrust at rest by both routes",
        gaps,
        "Code: {code:code} | Points: {points} | Mooring test, N: {measured_n:.2f} | "
        "Calculated, N: {calculated_n:.2f} | ± 95 %, N: {half_width_n:.2f} | "
        "Measured less calculated, N: {gap_n:+.2f}",
        note="Thrusts as magnitudes; the calculation holds for both signs.",
    )


def _figure(
    results: VehicleResults, static: StaticCharacteristic, gaps: Sequence[CodeGap]
) -> Figure:
    top, bottom = (pick(gaps, key=lambda gap: gap.code) for pick in (max, min))
    worst = max(gaps, key=lambda gap: abs(gap.gap_n))
    measured = f"{fixed(top.measured_n, 1)} N at code {code(top.code)}"
    if bottom.code < 0:
        astern = f"−{fixed(bottom.measured_n, 1)} N at code {code(bottom.code)}"
        measured = f"{measured} and {astern}"
    row = speed_index(static.speed_mps, 0.0) or 0
    grid = np.linspace(-static.code[-1], static.code[-1], 401)
    thrust = static_thrust(static, row, grid)
    half = static_factor(static, results.drive) * static_std(static, row, grid)
    band = np.array([thrust - half, thrust + half])
    above = [Trace("calculated at rest", grid, thrust, plotting.BLUE, band=band)]
    for sweep, way, mark in (("up", "rising", "^"), ("down", "falling", "v")):
        points = [p for p in mooring_points_of_tables(results) if p.sweep == sweep]
        own = np.array([(p.code, p.thrust_n) for p in points]).T
        if own.size:
            name = f"mooring test, |N| {way}"
            above.append(Trace(name, own[0], own[1], plotting.VERMILLION, "points", mark=mark))
    at, gap, width = np.array([(one.code, one.gap_n, one.half_width_n) for one in gaps]).T
    around = np.array([-width, width])
    below = (
        Trace("", at, np.zeros_like(at), plotting.BLUE, band=around),
        Trace("", at, gap, plotting.VERMILLION, "both", mark="o"),
    )
    return zoomable_figure(
        "fig-mooring",
        f"At rest the mooring test measured {measured}; "
        f"load test and open-water curves together give {fixed(top.calculated_n, 1)} N. "
        f"The largest gap, {fixed(abs(worst.gap_n), 2)} N, is at code {code(worst.code)}.",
        "Thrust at rest (fig. 7, a of Kostenko 2023). Below, as magnitudes: mean of the mooring "
        "points at each code less the calculation; band: 95 % of both.",
        (Panel("thrust T  [N]", above, height=1.8), Panel("gap  [N]", below, height=0.9)),
        x_label="code N  [–]",
    )
