"""The figure of the static family."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.fits import StaticCharacteristic
from pipeline.records.intervals import static_factor
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.comparison import THRUST_FROM_N, table2_row
from pipeline.report.curves import shown_speeds, speed_index, table2_thrust
from pipeline.report.numbers import code, fixed, speed
from pipeline.report.results import VehicleResults, mooring_points_of_tables
from pipeline.vehicle.bench_schema import PublishedTable2

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes


def family_figure(
    results: VehicleResults, static: StaticCharacteristic, published: PublishedTable2 | None
) -> Figure:
    """Draw T(N) for each speed with its band, the published one dashed, mooring data as points."""
    speeds = shown_speeds(static, results.vehicle.tables.speed_mps)
    largest = static.code[-1]
    first, last = speeds[0], speeds[-1]
    lead = (
        f"Thrust at code {code(largest)} falls from {fixed(static.thrust_n[first[1]][-1], 1)} to "
        f"{fixed(static.thrust_n[last[1]][-1], 1)} N between {speed(first[0])} and "
        f"{speed(last[0])} m/s; {_mooring_promise(results, largest)}"
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes, low = figure.subplots(2, 1, sharex=True, height_ratios=(3.2, 1))
        grid = np.asarray(static.code)
        for (speed_mps, row), colour in zip(
            speeds, plotting.ordered_colours(len(speeds)), strict=True
        ):
            thrust, status = np.asarray(static.thrust_n[row]), np.asarray(static.status[row])
            half = static_factor(static, results.drive) * np.asarray(static.thrust_std_n[row])
            working = np.isin(status, ["live", "extrapolated"])
            axes.fill_between(
                grid, thrust - half, thrust + half, where=working, color=colour, alpha=0.25, lw=0
            )
            label = f"{speed(speed_mps)} m/s"
            for names, style in ((("live",), "-"), (("extrapolated",), ":"), (("dead",), "-")):
                mask = np.isin(status, names)
                width = 0.8 if names == ("dead",) else 1.6
                axes.plot(
                    grid, np.where(mask, thrust, np.nan), style, color=colour, lw=width, label=label
                )
                label = "_"
            if published is not None:
                index = speed_index(published.speed_mps, speed_mps)
                if index is not None:
                    printed = table2_row(published, index)
                    values = table2_thrust(np.asarray(printed), grid)
                    axes.plot(
                        grid,
                        np.where(values > 0, values, np.nan),
                        "--",
                        color=plotting.INK,
                        lw=0.8,
                        label="published" if speed_mps == speeds[-1][0] else None,
                    )
            _lower_panel(low, static, (speed_mps, row), colour=colour, published=published)
        low.axhline(0, color=plotting.SOFT, lw=0.8)
        axes.set(ylabel="thrust T  [N]", xlim=(0, largest))
        low.set(xlabel="code N  [–]", ylabel="difference\n[N]")
        highest = max(float(np.max(static.thrust_n[row])) for _, row in speeds)
        axes.set_ylim(-0.5, 1.06 * highest)
        plotting.legend_above(figure, axes, columns=3)

    alt = (
        "Thrust against code, one curve for each speed with its 95 % band; the published curves "
        "dashed; flat at zero inside the dead zone."
    )
    return Figure(
        "fig-static-family",
        lead,
        plotting.draw("fig-static-family", alt, paint, height_in=4.8),
        "Static family (fig. 7, b of Kostenko 2023). Solid: working points within the bench's "
        "range; dotted: extrapolated; thin at zero: dead zone, where the drive cannot bring the "
        "propeller to positive thrust; bands: 95 %. Thrust and motion have the same sign. "
        + (
            "Below: the family less the published Table 2."
            if published is not None
            else "Below: our quadratic Table 2 less the family."
        ),
    )


def _lower_panel(
    axes: Axes,
    static: StaticCharacteristic,
    at: tuple[float, int],
    *,
    colour: str,
    published: PublishedTable2 | None,
) -> None:
    speed_mps, row = at
    grid, thrust = np.asarray(static.code), np.asarray(static.thrust_n[row])
    if published is not None:
        index = speed_index(published.speed_mps, speed_mps)
        if index is None:
            return
        printed = table2_row(published, index)
        other = table2_thrust(np.asarray(printed), grid)
        shown = np.where(other > THRUST_FROM_N, thrust - other, np.nan)
    else:
        own = next((r for r in static.table2 if abs(r.speed_mps - speed_mps) < 1e-6), None)
        if own is None:
            return
        other = table2_thrust(np.asarray(own.fit.coefficients), grid)
        shown = np.where(thrust > THRUST_FROM_N, other - thrust, np.nan)
    axes.plot(grid, shown, color=colour, lw=1.2)


def _mooring_promise(results: VehicleResults, largest: float) -> str:
    if results.mooring is None:
        return "a table taken at rest would promise the first value throughout."
    at_top = [
        abs(p.thrust_n)
        for p in mooring_points_of_tables(results)
        if p.code > 0 and p.code >= 0.99 * largest
    ]
    if not at_top:
        return "a table taken at rest would promise the first value throughout."
    return f"the mooring test alone would promise {fixed(float(np.mean(at_top)), 1)} N throughout."
