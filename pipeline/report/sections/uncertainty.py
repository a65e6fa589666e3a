"""From the noise of the rig to the thrust at a code: analytic against Monte Carlo."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.fits import StaticCharacteristic
from pipeline.records.intervals import static_factor
from pipeline.report import plotting
from pipeline.report.blocks import Figure, Paragraph, Section, Table, not_computed
from pipeline.report.curves import shown_speeds
from pipeline.report.numbers import code, fixed, general, speed
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.static import comparison_codes

if TYPE_CHECKING:
    import matplotlib.figure

_MOST_DECIMALS = 6
ANCHOR, TITLE = "uncertainty", "Uncertainty of the thrust"


def uncertainty_section(results: VehicleResults) -> Section:
    """Show the 95 % half-width of T at code and speed, and the Monte Carlo check."""
    static = results.static
    if static is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["static"])
    low, high = static.monte_carlo_ratio
    return Section(
        ANCHOR,
        TITLE,
        (
            _figure(results, static),
            Paragraph(
                "The covariance of both fits is carried to the thrust by the slopes of the torque "
                f"balance (analytic) and checked by {static.monte_carlo_draws} Monte Carlo draws: "
                f"the ratio of the two standard errors lies between {fixed(low, 3)} and "
                f"{fixed(high, 3)}. The intervals carry the scatter of the bench only; a true "
                "difference between bench and water is not in them (see the gap at rest)."
            ),
            _table(results, static),
        ),
    )


def _figure(results: VehicleResults, static: StaticCharacteristic) -> Figure:
    speeds = shown_speeds(static, results.vehicle.tables.speed_mps)
    halves = {
        v: np.where(
            np.isin(np.asarray(static.status[row]), ["live", "extrapolated"]),
            static_factor(static, results.drive) * np.asarray(static.thrust_std_n[row]),
            np.nan,
        )
        for v, row in speeds
    }
    top = {v: float(half[-1]) for v, half in halves.items()}
    finite = {v: half for v, half in top.items() if np.isfinite(half)}
    lead = (
        f"At code {code(static.code[-1])} the thrust is known to "
        f"±{general(min(finite.values()), 2)} to ±{general(max(finite.values()), 2)} N (95 %), "
        "depending on the speed."
        if finite
        else f"Code {code(static.code[-1])} has no working point at the tabulated speeds."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for (v, half), colour in zip(
            halves.items(), plotting.ordered_colours(len(halves)), strict=True
        ):
            axes.plot(static.code, half, color=colour, label=f"{speed(v)} m/s")
        axes.set(xlabel="code N  [–]", ylabel="95 % half-width of T  [N]")
        axes.set_ylim(bottom=0)
        plotting.legend_above(figure, axes, columns=5)

    alt = "Half-width of the 95 % interval of the thrust against code, one curve for each speed."
    return Figure(
        "fig-uncertainty",
        lead,
        plotting.draw("fig-uncertainty", alt, paint, height_in=3.1),
        "Half-width of the 95 % interval of T(N, V), propagated from both fits.",
    )


def _plus_minus(thrust_n: float, half_n: float) -> str:
    """Write a thrust with the half-width of its interval, to two figures of the latter.

    >>> _plus_minus(0.1183, 0.00412), _plus_minus(25.54, 0.197)
    ('0.1183 ± 0.0041', '25.54 ± 0.20')
    """
    last = 1 - math.floor(math.log10(half_n)) if half_n > 0 else 2
    decimals = min(max(last, 0), _MOST_DECIMALS)
    return f"{fixed(thrust_n, decimals)} ± {fixed(half_n, decimals)}"


def _table(results: VehicleResults, static: StaticCharacteristic) -> Table:
    speeds = shown_speeds(static, results.vehicle.tables.speed_mps)
    codes = comparison_codes(static)
    rows = []
    for value in codes:
        column = int(np.argmin(np.abs(np.asarray(static.code) - value)))
        cells = []
        for _, row in speeds:
            if static.status[row][column] in {"live", "extrapolated"}:
                half = static_factor(static, results.drive) * static.thrust_std_n[row][column]
                cells.append(_plus_minus(static.thrust_n[row][column], float(half)))
            else:
                cells.append("dead" if static.status[row][column] == "dead" else "–")
        rows.append((code(value), *cells))
    return Table(
        "Thrust with its 95 % interval, N",
        ("Code", *(f"{speed(v)} m/s" for v, _ in speeds)),
        tuple(rows),
    )
