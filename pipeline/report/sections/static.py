"""The static family T(N, V), Table 2 (Kostenko 2023, fig. 7, eq. 4), its gap to the mooring."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.fit_values import (
    CodeGap,
    code_gaps,
    largest_thrust_interval,
    shown_speeds,
    speed_index,
    static_factor,
    static_std,
    static_thrust,
    table2_thrust,
)
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Details, Figure, Table, Text, chapter
from pipeline.report.numbers import as_printed, code, fixed, signed, speed, with_interval
from pipeline.report.results import VehicleResults, mooring_points_of_tables, needed
from pipeline.report.sections import tables
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.vehicle.bench_schema import Published, PublishedTable2


@chapter("static", "Thrust against code and speed, Table 2")
def static_section(results: VehicleResults) -> Blocks:
    """Show the family, Table 2 in the paper's layout, and the thrust at the largest code."""
    static = needed(results, "static", results.static)
    published = results.vehicle.published
    table2 = published.table2 if published else None
    columns = [tables.Column(r.speed_mps, r.fit, table2) for r in static.table2]
    rows = [row for one in columns for row in one.coefficients(("K_F0", "K_F1", "K_F2"))]
    dead = (
        "dead zone to code",
        [fixed(row.dead_zone_code, 1) for row in static.table2],
        ["–" if one.printed is None else _edge(one.printed) for one in columns],
    )
    yield _family(results, static, table2)
    yield tables.paper_table(
        "Table 2. T = K_F0 sign N + K_F1 N + K_F2 N|N|",
        columns,
        [*tables.paper_rows(("K_F0, N", "K_F1, N per code", "K_F2, N per code²"), columns), dead],
        "The dead zone ends where the polynomial turns positive. The paper prints the "
        "condition |N| ≤ K_F0, but K_F0 is a thrust, not a code.",
        "fig-static-family",
    )
    if table2 is not None:
        yield Text(f"{_against_published(static, table2)} {tables.share_inside(rows)}".strip())
    table = tables.coefficient_table(
        "Coefficients of Table 2",
        rows,
        note="K_F0 in N, K_F1 in N per code, K_F2 in N per code². The intervals carry the bench's "
        "noise through both fits, not the misfit of the quadratic form itself.",
        points="fig-static-family",
    )
    yield Details("Coefficients of Table 2 with intervals", (table,))
    yield _largest_code(static, published, results.inverse)
    yield Text(
        "The intervals carry the scatter of the bench alone, through both fits by the slopes "
        "of the torque balance. A true difference between bench and water is not in them: see the "
        "mooring test against the calculation."
    )
    yield tables.explained(static.explanations)


def _family(
    results: VehicleResults, static: StaticCharacteristic, published: PublishedTable2 | None
) -> Figure:
    speeds = shown_speeds(static, results.vehicle.tables.speed_mps)
    grid, most = np.asarray(static.code), static.code[-1]
    first, last = speeds[0], speeds[-1]
    factor = static_factor(static, results.drive)
    above, below = list[Trace](), list[Trace]()
    ours = {r.speed_mps: r.fit.coefficients for r in static.table2}
    colours = plotting.ordered_colours(len(speeds))
    for (speed_mps, row), colour in zip(speeds, colours, strict=True):
        thrust, status = np.asarray(static.thrust_n[row]), np.asarray(static.status[row])
        half = factor * np.asarray(static.thrust_std_n[row])
        live = np.where(np.isin(status, ["live", "dead"]), thrust, np.nan)
        beyond = np.where(status == "extrapolated", thrust, np.nan)
        working = np.isin(status, ["live", "extrapolated"])
        band = np.where(working, [thrust - half, thrust + half], np.nan)
        above.append(Trace(f"{speed(speed_mps)} m/s", grid, live, colour, width=2.0, band=band))
        if np.isfinite(beyond).any():
            above.append(Trace("", grid, beyond, colour, dash="dot"))
        # of the published Table 2, or of our own where none is published
        coefficients = (
            tables.printed_row(published, speed_mps) if published else ours.get(speed_mps)
        )
        if coefficients is None:
            continue
        other = table2_thrust(coefficients, static.code)
        if published is not None:
            shown = np.where(other > 0, other, np.nan)
            above.append(Trace("published", grid, shown, plotting.INK, dash="dash"))
        scored = (other if published is not None else thrust) > tables.THRUST_FROM_N
        off = thrust - other if published is not None else other - thrust
        below.append(Trace("", grid, np.where(scored, off, np.nan), colour))
    at_top = [abs(p.thrust_n) for p in mooring_points_of_tables(results) if p.code >= 0.99 * most]
    promise = (
        f"the mooring test alone would promise {fixed(float(np.mean(at_top)), 1)} N throughout."
        if at_top
        else "a table taken at rest would promise the first value throughout."
    )
    return zoomable_figure(
        "fig-static-family",
        f"Thrust at code {code(most)} falls from {fixed(static.thrust_n[first[1]][-1], 1)} to "
        f"{fixed(static.thrust_n[last[1]][-1], 1)} N between {speed(first[0])} and "
        f"{speed(last[0])} m/s; {promise}",
        "Static family (fig. 7, b of Kostenko 2023). Solid: working points within the bench's "
        "range; dotted: extrapolated; at zero: dead zone; bands: 95 %. Thrust and motion have the "
        "same sign. "
        + (
            "Below: the family less the published Table 2."
            if published is not None
            else "Below: our quadratic Table 2 less the family."
        ),
        (
            Panel("thrust T  [N]", above, height=2.0, from_zero=True),
            Panel("difference\n[N]", below, height=0.7, band=0.0),
        ),
        x_label="code N  [–]",
    )


def _edge(printed: Sequence[float]) -> str:
    at = np.linspace(0, 400, 40001)
    positive = np.flatnonzero(table2_thrust(printed, at) > 0)
    return fixed(float(at[positive[0]]), 1) if positive.size else "–"


def _against_published(static: StaticCharacteristic, published: PublishedTable2) -> str:
    worst: dict[str, tuple[float, float, float]] = {}
    every = list(tables.table2_differences(static, published, static.code))
    for name, at_speed, difference in every:
        found = tables.largest(static.code, difference)
        if found is not None:
            worst[name] = max(worst.get(name, (0.0, 0.0, 0.0)), (*found, at_speed))
    if not every:
        return "The published Table 2 has no speed in common with ours."
    sentences = [
        f"{name} differs by at most {fixed(size, 2)} N (at code {code(at)}, {speed(at_speed)} m/s)"
        for name, (size, at, at_speed) in worst.items()
    ]
    return (
        "Over all codes where the published thrust is over 0.5 N, "
        f"{' and '.join(sentences)} from the published Table 2."
    )


def _largest_code(
    static: StaticCharacteristic, published: Published | None, inverse: InverseCharacteristic | None
) -> Table:
    most = static.code[-1]
    table2, table4 = (published.table2, published.table4) if published else (None, None)
    rows, gaps = [], []
    for row in static.table2:
        value, interval = with_interval(row.thrust_max_n, largest_thrust_interval(row, inverse))
        cells = {"Speed, m/s": speed(row.speed_mps), "T_max, N": value, "95 % interval": interval}
        thrusts: dict[str, tuple[float, str] | None] = {}
        if table2 is not None:
            printed = tables.printed_row(table2, row.speed_mps)
            thrust = None if printed is None else float(table2_thrust(printed, most))
            thrusts["2"] = None if thrust is None else (thrust, fixed(thrust, 2))
        if table4 is not None:
            at = speed_index(table4.speed_mps, row.speed_mps)
            own = None if at is None else table4.T_max_n[at]
            thrusts["4"] = None if own is None else (own, as_printed(own))
        for name, found in thrusts.items():
            cells[f"Published Table {name}, N"] = "–" if found is None else found[1]
            off = "–" if found is None else signed(row.thrust_max_n - found[0], 2)
            cells[f"Less Table {name}, N"] = off
        rows.append(cells)
        both = [found[0] for found in thrusts.values() if found is not None]
        gaps += [abs(both[0] - both[1])] if len(both) == 2 else []
    note = (
        f"The two published tables differ from each other by up to {fixed(max(gaps), 2)} N here."
        if gaps
        else ""
    )
    return Table.of(f"Thrust at the largest code, {code(most)}", rows, note=note)


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
