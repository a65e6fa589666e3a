"""The static family T(N, V) and Table 2 (Kostenko 2023, fig. 7, eq. 4)."""

import numpy as np

from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.intervals import largest_thrust_interval, static_factor
from pipeline.report import plotting
from pipeline.report.blocks import Block, Details, Figure, Paragraph, Section, Table, not_computed
from pipeline.report.comparison import (
    THRUST_FROM_N,
    Coefficient,
    coefficients,
    compare_table2,
    table2_row,
)
from pipeline.report.curves import shown_speeds, speed_index, table2_thrust
from pipeline.report.numbers import as_printed, code, fixed, signed, speed, with_interval
from pipeline.report.results import VehicleResults, missing_reasons, mooring_points_of_tables
from pipeline.report.sections.tables import coefficient_table, explained, share_inside
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import Published, PublishedTable2

ANCHOR, TITLE = "static", "Thrust against code and speed, Table 2"


def static_section(results: VehicleResults) -> Section:
    """Show the family, Table 2 in the paper's layout, and the thrust at the largest code."""
    static = results.static
    if static is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["static"])
    published = results.vehicle.published
    table2 = published.table2 if published else None
    rows = _coefficient_rows(static, table2)
    blocks: list[Block] = [_family(results, static, table2), _layout(static, table2)]
    if table2 is not None:
        blocks.append(Paragraph(_against_published(static, table2)))
    if any(one.published is not None for one in rows):
        blocks.append(Paragraph(share_inside(rows, _why_outside(static))))
    table = coefficient_table(
        "Coefficients of Table 2",
        rows,
        note="K_F0 in N, K_F1 in N per code, K_F2 in N per code². The intervals carry the bench's "
        "noise through both fits, not the misfit of the quadratic form itself.",
        points="fig-static-family",
    )
    low, high = static.monte_carlo_ratio
    blocks += [
        Details("Coefficients of Table 2 with intervals", (table,)),
        _largest_code(static, published, results.inverse),
        Paragraph(
            "The intervals carry the scatter of the bench alone, through both fits by the slopes "
            f"of the torque balance; {static.monte_carlo_draws} Monte Carlo draws give "
            f"{fixed(low, 3)} to {fixed(high, 3)} of the same. A true difference between bench and "
            "water is not in them: see the mooring test against the calculation."
        ),
        *explained(static.explanations),
    ]
    return Section(ANCHOR, TITLE, tuple(blocks))


def _family(
    results: VehicleResults, static: StaticCharacteristic, published: PublishedTable2 | None
) -> Figure:
    """Draw T(N) for each speed with its band, the published one dashed."""
    speeds = shown_speeds(static, results.vehicle.tables.speed_mps)
    grid, largest = np.asarray(static.code), static.code[-1]
    first, last = speeds[0], speeds[-1]
    factor = static_factor(static, results.drive)
    above: list[Trace] = []
    below: list[Trace] = []
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
        other = _other(static, speed_mps, published)
        if other is None:
            continue
        if published is not None:
            shown = np.where(other > 0, other, np.nan)
            above.append(Trace("published", grid, shown, plotting.INK, dash="dash"))
        scored = (other if published is not None else thrust) > THRUST_FROM_N
        off = thrust - other if published is not None else other - thrust
        below.append(Trace("", grid, np.where(scored, off, np.nan), colour))
    return zoomable_figure(
        "fig-static-family",
        f"Thrust at code {code(largest)} falls from {fixed(static.thrust_n[first[1]][-1], 1)} to "
        f"{fixed(static.thrust_n[last[1]][-1], 1)} N between {speed(first[0])} and "
        f"{speed(last[0])} m/s; {_mooring_promise(results, largest)}",
        "Static family (fig. 7, b of Kostenko 2023). Solid: working points within the bench's "
        "range; dotted: extrapolated; at zero: dead zone; bands: 95 %. Thrust and motion have the "
        "same sign. "
        + (
            "Below: the family less the published Table 2."
            if published is not None
            else "Below: our quadratic Table 2 less the family."
        ),
        (
            Panel("thrust T  [N]", tuple(above), height=2.0, from_zero=True),
            Panel("difference\n[N]", tuple(below), height=0.7, band=0.0),
        ),
        x_label="code N  [–]",
    )


def _other(
    static: StaticCharacteristic, speed_mps: float, published: PublishedTable2 | None
) -> FloatArray | None:
    """Thrust of the published Table 2, or of our own where none is published."""
    if published is not None:
        index = speed_index(published.speed_mps, speed_mps)
        return None if index is None else _thrust(table2_row(published, index), static.code)
    own = next((r for r in static.table2 if abs(r.speed_mps - speed_mps) < 1e-6), None)
    return None if own is None else _thrust(own.fit.coefficients, static.code)


def _thrust(row: tuple[float, ...], codes: tuple[float, ...] | float) -> FloatArray:
    return table2_thrust(np.asarray(row), codes)


def _mooring_promise(results: VehicleResults, largest: float) -> str:
    at_top = [
        abs(p.thrust_n) for p in mooring_points_of_tables(results) if p.code >= 0.99 * largest
    ]
    if not at_top:
        return "a table taken at rest would promise the first value throughout."
    return f"the mooring test alone would promise {fixed(float(np.mean(at_top)), 1)} N throughout."


def _why_outside(static: StaticCharacteristic) -> str:
    misfit = max(row.fit.quality.residual_std for row in static.table2)
    return (
        "The intervals carry the bench's noise alone. A quadratic follows the family only to "
        f"{fixed(misfit, 2)} N (standard deviation at the worst speed), so the coefficients depend "
        "on which codes a fit takes in, and those of one speed lean on each other: a constant that "
        "is lower is made up for by a slope that is higher. The thrusts in newtons are what to "
        "read."
    )


def _layout(static: StaticCharacteristic, published: PublishedTable2 | None) -> Table:
    rows: list[tuple[str, ...]] = []
    classes: list[str] = []

    def add(name: str, ours: list[str], printed: list[str]) -> None:
        rows.append((name, *ours))
        classes.append("")
        if published is not None:
            rows.append(("published", *printed))
            classes.append("published")

    columns = [
        None if published is None else speed_index(published.speed_mps, row.speed_mps)
        for row in static.table2
    ]
    printed_rows = [
        None if published is None or at is None else table2_row(published, at) for at in columns
    ]
    for index, name in enumerate(("K_F0, N", "K_F1, N per code", "K_F2, N per code²")):
        ours = [
            with_interval(row.fit.coefficients[index], row.fit.ci95[index])[0]
            for row in static.table2
        ]
        add(name, ours, ["–" if row is None else as_printed(row[index]) for row in printed_rows])
    dead = [fixed(row.dead_zone_code, 1) for row in static.table2]
    add("dead zone to code", dead, ["–" if row is None else _edge(row) for row in printed_rows])
    return Table(
        "Table 2. T = K_F0 sign N + K_F1 N + K_F2 N|N|",
        ("Coefficient", *(f"{speed(row.speed_mps)} m/s" for row in static.table2)),
        tuple(rows),
        row_classes=tuple(classes),
        links={(row, 0): "#fig-static-family" for row, kind in enumerate(classes) if not kind},
        note="The dead zone ends where the polynomial turns positive. The paper prints the "
        "condition |N| ≤ K_F0, but K_F0 is a thrust, not a code.",
    )


def _edge(printed: tuple[float, ...]) -> str:
    at = np.linspace(0, 400, 40001)
    positive = np.flatnonzero(table2_thrust(np.asarray(printed), at) > 0)
    return fixed(float(at[positive[0]]), 1) if positive.size else "–"


def _coefficient_rows(
    static: StaticCharacteristic, published: PublishedTable2 | None
) -> tuple[Coefficient, ...]:
    rows: list[Coefficient] = []
    for row in static.table2:
        index = None if published is None else speed_index(published.speed_mps, row.speed_mps)
        printed = None if published is None or index is None else table2_row(published, index)
        names = [f"{name} at {speed(row.speed_mps)} m/s" for name in ("K_F0", "K_F1", "K_F2")]
        rows += coefficients(names, row.fit.coefficients, row.fit.ci95, printed)
    return tuple(rows)


def _against_published(static: StaticCharacteristic, published: PublishedTable2) -> str:
    everywhere = compare_table2(static, published, static.code)
    if not everywhere:
        return "The published Table 2 has no speed in common with ours."
    family = [
        (d, one.speed_mps) for one in everywhere if (d := one.largest_difference(one.family_n))
    ]
    own = [
        (d, one.speed_mps) for one in everywhere if (d := one.largest_difference(one.polynomial_n))
    ]
    sentences = []
    for name, found in (("the family", family), ("our quadratic Table 2", own)):
        if found:
            (difference, at_code), at_speed = max(found, key=lambda item: abs(item[0][0]))
            sentences.append(
                f"{name} differs by at most {fixed(abs(difference), 2)} N "
                f"(at code {code(at_code)}, {speed(at_speed)} m/s)"
            )
    return (
        "Over all codes where the published thrust is over 0.5 N, "
        f"{' and '.join(sentences)} from the published Table 2."
    )


def _largest_code(
    static: StaticCharacteristic,
    published: Published | None,
    inverse: InverseCharacteristic | None,
) -> Table:
    largest = static.code[-1]
    table2 = published.table2 if published else None
    table4 = published.table4 if published else None
    header = ["Speed, m/s", "T_max, N", "95 % interval"]
    header += ["Published Table 2, N", "Difference, N"] if table2 is not None else []
    header += ["Published Table 4, N", "Difference, N"] if table4 is not None else []
    rows, gaps = [], []
    for row in static.table2:
        value, interval = with_interval(row.thrust_max_n, largest_thrust_interval(row, inverse))
        cells, both = [speed(row.speed_mps), value, interval], []
        for table in (table2, table4):
            if table is None:
                continue
            index = speed_index(table.speed_mps, row.speed_mps)
            if index is None:
                cells += ["–", "–"]
                continue
            if isinstance(table, PublishedTable2):
                thrust = float(_thrust(table2_row(table, index), largest))
                cells.append(fixed(thrust, 2))
            else:
                thrust = table.T_max_n[index]
                cells.append(as_printed(thrust))
            cells.append(signed(row.thrust_max_n - thrust, 2))
            both.append(thrust)
        rows.append(tuple(cells))
        if len(both) == 2:
            gaps.append(abs(both[0] - both[1]))
    note = (
        f"The two published tables differ from each other by up to {fixed(max(gaps), 2)} N here."
        if gaps
        else ""
    )
    caption = f"Thrust at the largest code, {code(largest)}"
    return Table(caption, tuple(header), tuple(rows), note=note)
