"""The static family T(N, V) and Table 2 (Kostenko 2023, fig. 7, eq. 4)."""

from collections.abc import Sequence

import numpy as np

from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic, StaticRow
from pipeline.records.intervals import largest_thrust_interval
from pipeline.report.blocks import (
    Block,
    Details,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.comparison import (
    Coefficient,
    coefficients,
    compare_table2,
    table2_row,
)
from pipeline.report.curves import speed_index, table2_thrust
from pipeline.report.figures.static import family_figure
from pipeline.report.numbers import as_printed, code, fixed, signed, speed, with_interval
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import coefficient_table, explained, share_inside
from pipeline.vehicle.bench_schema import Published, PublishedTable2, PublishedTable4

ANCHOR, TITLE = "static", "Static characteristic: thrust against code and speed, Table 2"


def static_section(results: VehicleResults) -> Section:
    """Show the family, Table 2 in the paper's layout, and the differences in newtons."""
    static = results.static
    if static is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["static"])
    published = results.vehicle.published
    table2 = published.table2 if published else None
    blocks: list[Block] = [
        family_figure(results, static, table2),
        _layout(static, table2),
    ]
    rows = _coefficient_rows(static, table2)
    if any(one.published is not None for one in rows):
        blocks.append(Paragraph(share_inside(rows, _why_outside(static))))
    blocks.append(
        Details(
            "Coefficients of Table 2 with intervals",
            (
                coefficient_table(
                    "Coefficients of Table 2",
                    rows,
                    note="K_F0 in N, K_F1 in N per code, K_F2 in N per code². The intervals carry "
                    "the bench's noise through both fits; the misfit of the quadratic form itself "
                    "is in the residual column of the quality table.",
                    points="fig-static-family",
                ),
                _quality(static.table2),
            ),
        )
    )
    if published is not None and table2 is not None:
        blocks += _difference(static, table2)
    blocks.append(_full_code(static, published, results.inverse))
    if static.explanations:
        blocks += explained(static.explanations)
    return Section(ANCHOR, TITLE, tuple(blocks))


def _why_outside(static: StaticCharacteristic) -> str:
    misfit = max(row.fit.quality.residual_std for row in static.table2)
    return (
        "The intervals carry the bench's noise alone. A quadratic follows the family only to "
        f"{fixed(misfit, 2)} N (standard deviation at the worst speed), so the coefficients depend "
        "on which codes a fit takes in, and those of one speed lean on each other: a constant that "
        "is lower is made up for by a slope that is higher. The thrusts, compared in newtons "
        "below, are what to read."
    )


def comparison_codes(static: StaticCharacteristic) -> list[float]:
    """Tens up to the largest code, and the largest code."""
    largest = static.code[-1]
    step = max(10.0 * round(largest / 120), 1.0) if largest >= 60 else max(largest / 10, 1.0)
    return [*(float(c) for c in np.arange(2 * step, largest - step / 4, step)), largest]


def _layout(static: StaticCharacteristic, published: PublishedTable2 | None) -> Table:
    rows: list[tuple[str, ...]] = []
    classes = []
    for index, name in enumerate(("K_F0, N", "K_F1, N per code", "K_F2, N per code²")):
        texts = [
            with_interval(row.fit.coefficients[index], row.fit.ci95[index])[0]
            for row in static.table2
        ]
        rows.append((name, *texts))
        classes.append("")
        if published is not None:
            cells = []
            for row in static.table2:
                column = speed_index(published.speed_mps, row.speed_mps)
                printed = None if column is None else table2_row(published, column)[index]
                cells.append("–" if printed is None else as_printed(printed))
            rows.append(("published", *cells))
            classes.append("published")
    rows.append(("dead zone to code", *(fixed(row.dead_zone_code, 1) for row in static.table2)))
    classes.append("")
    if published is not None:
        rows.append(("published", *(_printed_edge(published, r.speed_mps) for r in static.table2)))
        classes.append("published")
    return Table(
        "Table 2. T = K_F0 sign N + K_F1 N + K_F2 N|N|",
        ("Coefficient", *(f"{speed(row.speed_mps)} m/s" for row in static.table2)),
        tuple(rows),
        row_classes=tuple(classes),
        links={(row, 0): "#fig-static-family" for row, kind in enumerate(classes) if not kind},
        note="The dead zone ends where the polynomial turns positive. The paper prints the "
        "condition |N| ≤ K_F0, but K_F0 is a thrust, not a code.",
    )


def _printed_edge(published: PublishedTable2, speed_mps: float) -> str:
    index = speed_index(published.speed_mps, speed_mps)
    if index is None:
        return "–"
    printed = table2_row(published, index)
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


def _quality(rows: Sequence[StaticRow]) -> Table:
    return Table(
        "How well the quadratic follows the family",
        ("Speed, m/s", "Codes fitted", "Points", "Residual std, N", "R²"),
        tuple(
            (
                speed(row.speed_mps),
                f"{code(row.fit.quality.valid_range[0])} to {code(row.fit.quality.valid_range[1])}",
                str(row.fit.quality.points),
                fixed(row.fit.quality.residual_std, 3),
                f"{row.fit.quality.r_squared:.6f}",
            )
            for row in rows
        ),
    )


def _difference(static: StaticCharacteristic, published: PublishedTable2) -> list[Block]:
    compared = compare_table2(static, published, comparison_codes(static))
    everywhere = compare_table2(static, published, static.code)
    if not compared:
        return [Paragraph("The published Table 2 has no speed in common with ours.")]
    rows = []
    for index, value in enumerate(compared[0].code.tolist()):
        cells = []
        for one in compared:
            printed, ours = float(one.published_n[index]), float(one.family_n[index])
            if np.isnan(ours):
                cells.append("none")
            elif printed <= 0 and ours <= 0:
                cells.append("dead")
            else:
                cells.append(f"{fixed(ours, 2)} ({signed(ours - printed, 2)})")
        rows.append((code(value), *cells))
    table = Table(
        "Thrust of our family in N, and (in brackets) its difference to the published Table 2",
        ("Code", *(f"{speed(one.speed_mps)} m/s" for one in compared)),
        tuple(rows),
        note="dead: both give no thrust; none: our drive and propeller curves do not meet.",
    )
    family = [(d, one.speed_mps) for one in everywhere if (d := one.largest_family_difference())]
    own = [(d, one.speed_mps) for one in everywhere if (d := one.largest_polynomial_difference())]
    sentences = []
    for name, found in (("the family", family), ("our quadratic Table 2", own)):
        if found:
            (difference, at_code), at_speed = max(found, key=lambda item: abs(item[0][0]))
            sentences.append(
                f"{name} differs by at most {fixed(abs(difference), 2)} N "
                f"(at code {code(at_code)}, {speed(at_speed)} m/s)"
            )
    return [
        table,
        Paragraph(
            "Over all codes where the published thrust is over 0.5 N, "
            f"{' and '.join(sentences)} from the published Table 2."
        ),
    ]


def _full_code(
    static: StaticCharacteristic,
    published: Published | None,
    inverse: InverseCharacteristic | None,
) -> Table:
    largest = static.code[-1]
    table2 = published.table2 if published else None
    table4 = published.table4 if published else None
    header: tuple[str, ...] = ("Speed, m/s", "T_max, N", "95 % interval")
    if table2 is not None:
        header += ("Published Table 2, N", "Difference, N")
    if table4 is not None:
        header += ("Published Table 4, N", "Difference, N")
    rows = []
    for row in static.table2:
        value, interval = with_interval(row.thrust_max_n, largest_thrust_interval(row, inverse))
        cells = [speed(row.speed_mps), value, interval]
        if table2 is not None:
            index = speed_index(table2.speed_mps, row.speed_mps)
            if index is None:
                cells += ["–", "–"]
            else:
                printed = table2_row(table2, index)
                thrust = float(table2_thrust(np.asarray(printed), largest))
                cells += [fixed(thrust, 2), signed(row.thrust_max_n - thrust, 2)]
        if table4 is not None:
            at = speed_index(table4.speed_mps, row.speed_mps)
            if at is None:
                cells += ["–", "–"]
            else:
                thrust = table4.T_max_n[at]
                cells += [as_printed(thrust), signed(row.thrust_max_n - thrust, 2)]
        rows.append(tuple(cells))
    return Table(
        f"Thrust at the largest code, {code(largest)}",
        header,
        tuple(rows),
        note=_how_far_apart(table2, table4, largest),
    )


def _how_far_apart(
    table2: PublishedTable2 | None, table4: PublishedTable4 | None, largest: float
) -> str:
    if table2 is None or table4 is None:
        return ""
    gaps = []
    for index, speed_mps in enumerate(table2.speed_mps):
        other = speed_index(table4.speed_mps, speed_mps)
        if other is not None:
            printed = table2_row(table2, index)
            thrust = float(table2_thrust(np.asarray(printed), largest))
            gaps.append(abs(thrust - table4.T_max_n[other]))
    if not gaps:
        return ""
    return f"The two published tables differ from each other by up to {fixed(max(gaps), 2)} N here."
