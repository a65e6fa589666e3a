"""The inverse characteristics N(T) and N(T, V): Tables 3 and 4 (Kostenko 2023, figs. 9 and 10)."""

from collections.abc import Sequence

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fits import (
    InverseCharacteristic,
    PolynomialFit,
    SpeedInverse,
    StaticCharacteristic,
)
from pipeline.report import plotting
from pipeline.report.blocks import (
    Block,
    Bullets,
    Details,
    Figure,
    Heading,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.comparison import (
    THRUST_FROM_N,
    Coefficient,
    coefficients,
    table3_difference,
    table4_difference,
    table4_row,
)
from pipeline.report.curves import fit_panels, speed_index, static_thrust, table4_code
from pipeline.report.numbers import as_printed, code, fixed, plural, speed, with_interval
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import (
    coefficient_table,
    explained,
    quality_line,
    share_inside,
)
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import Published, PublishedTable3, PublishedTable4

ANCHOR, TITLE = "inverse", "Code from thrust, Tables 3 and 4"


def inverse_section(results: VehicleResults) -> Section:
    """Show Tables 3 and 4, the firmware form, and how well each closes the round trip."""
    inverse = results.inverse
    if inverse is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["inverse"])
    published = results.vehicle.published
    blocks: list[Block] = [Heading("At rest: N(T), Table 3", "table3")]
    blocks += _table3(results, inverse, published.table3 if published else None)
    blocks.append(Heading("Under way: N(T, V), Table 4", "table4"))
    blocks += _table4(results, inverse, published)
    if inverse.round_trip:
        blocks += [Heading("Round trip", "round-trip"), _round_trip_table(results, inverse)]
    if inverse.firmware is not None:
        firmware = inverse.firmware
        blocks.append(
            Paragraph(
                f"For each sign of thrust the firmware holds the largest thrust at "
                f"{plural(len(firmware.positive.speed_mps), 'speed')} and the code at "
                f"{len(firmware.positive.fraction)} fractions of it, linear in between, "
                "so that N(T, V) and T(N, V) are exact inverses of each other and rise together. "
                f"At and below {fixed(firmware.thrust_dead_n, 2)} N it sends code 0."
            )
        )
        texts = {"Positive": firmware.positive, "Negative": firmware.negative}
        against = {f"{sign} thrust: {b.against_motion}" for sign, b in texts.items()}
        if firmware.positive.against_motion == firmware.negative.against_motion:
            against = {firmware.positive.against_motion}
        blocks.append(Bullets(tuple(sorted(against, reverse=True))))
    blocks += explained(inverse.explanations)
    return Section(ANCHOR, TITLE, tuple(blocks))


Side = tuple[str, int, PolynomialFit, Sequence[float] | None]


def _sides(inverse: InverseCharacteristic, published: PublishedTable3 | None) -> list[Side]:
    both = (
        ("positive", 1, inverse.table3_positive, published.positive if published else None),
        ("negative", -1, inverse.table3_negative, published.negative if published else None),
    )
    return [(name, sign, fit, printed) for name, sign, fit, printed in both if fit is not None]


def _table3(
    results: VehicleResults, inverse: InverseCharacteristic, published: PublishedTable3 | None
) -> list[Block]:
    sides = _sides(inverse, published)
    if not sides:
        reason = missing_reasons(results).get("mooring", "the mooring data do not support it.")
        return [Paragraph(f"Table 3 was not computed: {reason}", tone="warning")]
    rows: list[Coefficient] = []
    for _, sign, fit, printed in sides:
        names = [f"K_N{0 if sign > 0 else 1}{i}" for i in range(len(fit.coefficients))]
        rows += coefficients(names, fit.coefficients, fit.ci95, printed)
    blocks: list[Block] = [
        _at_rest(sides),
        coefficient_table(
            "Table 3. N = K_0 + K_1 T + K_2 T² + K_3 T³ at rest, each sign apart",
            rows,
            note="K_N0i: positive thrust; K_N1i: negative thrust, with its sign, as printed.",
            points="fig-inverse-rest",
        ),
    ]
    if published is not None:
        blocks += [Paragraph(_table3_sentence(sides)), Paragraph(share_inside(rows))]
    for name, _, fit, _ in sides:
        blocks.append(Paragraph(quality_line(f"N(T), {name} thrust", fit.quality, "T, N,")))
    there = {name for name, *_ in sides}
    blocks += [
        Paragraph(f"No fit for {name} thrust: the test has no such points.", tone="warning")
        for name in ("positive", "negative")
        if name not in there
    ]
    return blocks


def _at_rest(sides: Sequence[Side]) -> Figure:
    """Draw N(T) at rest for both signs of thrust, with residuals below."""
    above: list[Trace] = []
    below: list[Trace] = []
    for name, sign, fit, printed in sides:
        colour = plotting.VERMILLION if sign > 0 else plotting.PURPLE
        curves, left = fit_panels(fit, f"{name} thrust", colour, printed)
        above += curves
        below.append(left)
    spread = max(fit.quality.residual_std for _, _, fit, _ in sides)
    points = sum(fit.quality.points for _, _, fit, _ in sides)
    dead = (
        f"{code(round(abs(float(polynomial(s * THRUST_FROM_N, np.asarray(fit.coefficients))))))} "
        f"for {name}"
        for name, s, fit, _ in sides
    )
    return zoomable_figure(
        "fig-inverse-rest",
        f"The cubics follow {plural(points, 'mooring point')} with a residual of "
        f"{fixed(spread, 2)} codes; the dead zone ends at about code {' and '.join(dead)} thrust.",
        "Inverse mooring characteristic (fig. 9 of Kostenko 2023). Below: measured less fitted "
        "code.",
        (
            Panel("code N  [–]", tuple(above), height=2.0),
            Panel("residual  [–]", tuple(below), height=0.7, band=0.0),
        ),
        x_label="thrust T at rest  [N]",
    )


def _table3_sentence(sides: Sequence[Side]) -> str:
    parts = []
    for name, sign, fit, printed in sides:
        if printed is None:
            continue
        largest = max(abs(end) for end in fit.quality.valid_range)
        thrust = np.linspace(THRUST_FROM_N, largest, 400)
        difference = np.abs(table3_difference(fit, printed, sign * thrust))
        worst = int(np.argmax(difference))
        parts.append(
            f"{fixed(float(difference[worst]), 2)} codes for {name} thrust "
            f"(at {fixed(float(thrust[worst]), 1)} N)"
        )
    return (
        f"Over {THRUST_FROM_N} N to the largest measured thrust our Table 3 differs from the "
        f"published one by at most {' and '.join(parts)}."
    )


def _table4(
    results: VehicleResults, inverse: InverseCharacteristic, published: Published | None
) -> list[Block]:
    if not inverse.table4:
        reason = missing_reasons(results).get("static", "there is no static family.")
        return [Paragraph(f"Table 4 was not computed: {reason}", tone="warning")]
    table4 = published.table4 if published else None
    blocks: list[Block] = []
    if results.static is not None:
        blocks.append(_under_way(inverse.table4, results.static, table4))
    blocks.append(_table4_layout(inverse.table4, table4))
    rows: list[Coefficient] = []
    for row in inverse.table4:
        names = [f"K_N{i} at {speed(row.speed_mps)} m/s" for i in range(len(row.coefficients))]
        printed = table4_row(table4, row.speed_mps) if table4 else None
        rows += coefficients(names, row.coefficients, row.ci95, printed)
    if table4 is not None:
        common = [r for r in inverse.table4 if table4_row(table4, r.speed_mps) is not None]
        said = (
            f"{_table4_sentence(common, table4)} {share_inside(rows, _why_outside(inverse))}"
            if common
            else "The published Table 4 has no speed in common with ours."
        )
        blocks.append(Paragraph(said))
    points = "fig-inverse-family" if results.static is not None else ""
    table = coefficient_table("Coefficients of Table 4", rows, points=points)
    return [*blocks, Details("Coefficients of Table 4 with intervals", (table,))]


def _under_way(
    rows: Sequence[SpeedInverse], static: StaticCharacteristic, published: PublishedTable4 | None
) -> Figure:
    """Draw N(T, V): the family, the cubic of Table 4, the published cubic."""
    shared = min(row.thrust_max_n for row in rows)
    probe = float(np.floor(shared)) if shared > 2 else shared
    first, last = (
        float(table4_code(np.asarray(row.coefficients), probe)) for row in (rows[0], rows[-1])
    )
    fastest = rows[-1].speed_mps
    index = speed_index(static.speed_mps, fastest)
    kept = ""
    if index is not None:
        thrust = float(static_thrust(static, index, first))
        kept = f"; the code found at rest gives {fixed(thrust, 1)} N at {speed(fastest)} m/s"
    above: list[Trace] = []
    below: list[Trace] = []
    for row, colour in zip(rows, plotting.ordered_colours(len(rows)), strict=True):
        own = np.linspace(min(THRUST_FROM_N, row.thrust_max_n), row.thrust_max_n, 150)
        cubic = table4_code(np.asarray(row.coefficients), own)
        above.append(Trace(f"{speed(row.speed_mps)} m/s", own, cubic, colour))
        family = _family_code(static, row.speed_mps, own)
        if family is not None:
            above.append(Trace("family", own[::10], family[::10], colour, "points", mark="o"))
            below.append(Trace("", own, cubic - family, colour))
        printed = table4_row(published, row.speed_mps) if published else None
        if printed is not None:
            other = table4_code(np.asarray(printed), own)
            above.append(Trace("published", own, other, plotting.INK, dash="dash"))
    return zoomable_figure(
        "fig-inverse-family",
        f"For {fixed(probe, 0)} N the code must rise from {fixed(first, 0)} to {fixed(last, 0)} "
        f"between {speed(rows[0].speed_mps)} and {speed(fastest)} m/s{kept}.",
        "Inverse family (fig. 10 of Kostenko 2023). Solid: cubic of Table 4; dots: the family "
        "itself; dashed: published Table 4. Below, in codes: how far the cubic is off the family.",
        (
            Panel("code N  [–]", tuple(above), height=2.0, from_zero=True),
            Panel("off the\nfamily  [–]", tuple(below), height=0.7, band=0.0),
        ),
        x_label="thrust T  [N]",
    )


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


def _why_outside(inverse: InverseCharacteristic) -> str:
    """Explain published coefficients that ours do not reach, as far as the numbers show it."""
    both = [r for r in inverse.round_trip if r.cubic_n is not None and r.published_n is not None]
    ours = max((r.cubic_n or 0.0 for r in both), default=0.0)
    printed = max((r.published_n or 0.0 for r in both), default=0.0)
    if printed <= ours:
        return (
            "The coefficients of one speed lean on each other; the difference in codes is what to "
            "read."
        )
    return (
        f"The published Table 4 is not the inverse of the published Table 2: sent through both, a "
        f"thrust comes back up to {fixed(printed, 2)} N off, through ours {fixed(ours, 2)} N. A "
        "table that inverts its own family has other coefficients, and the intervals, which carry "
        "the bench's noise alone, do not reach across that."
    )


def _table4_layout(rows: Sequence[SpeedInverse], published: PublishedTable4 | None) -> Table:
    body: list[tuple[str, ...]] = []
    classes: list[str] = []

    def add(name: str, ours: list[str], printed: Sequence[float] | None) -> None:
        body.append((name, *ours))
        classes.append("")
        if published is not None and printed is not None:
            at = [speed_index(published.speed_mps, row.speed_mps) for row in rows]
            cells = ["–" if index is None else as_printed(printed[index]) for index in at]
            body.append(("published", *cells))
            classes.append("published")

    largest = [fixed(row.thrust_max_n, 2) for row in rows]
    add("T_max, N", largest, published.T_max_n if published else None)
    for index, name in enumerate(("KN0", "KN1", "KN2", "KN3")):
        ours = [with_interval(row.coefficients[index], row.ci95[index])[0] for row in rows]
        add(f"K_N{index}", ours, getattr(published, name) if published else None)
    note = "K_Ni in codes per N to the power i."
    if published is not None:
        note += (
            " The paper prints the K_N2 row under the name of K_N3; it is read here by its unit."
        )
    return Table(
        "Table 4. N = K_N0 sign T + K_N1 T + K_N2 T|T| + K_N3 T³",
        ("Coefficient", *(f"{speed(row.speed_mps)} m/s" for row in rows)),
        tuple(body),
        row_classes=tuple(classes),
        note=note,
    )


def _table4_sentence(rows: Sequence[SpeedInverse], published: PublishedTable4) -> str:
    worst: tuple[float, float, float] | None = None
    for row in rows:
        thrust = np.linspace(THRUST_FROM_N, row.thrust_max_n, 400)
        difference = table4_difference(row, published, thrust.tolist())
        if difference is None or np.isnan(difference).all():
            continue
        index = int(np.nanargmax(np.abs(difference)))
        if worst is None or abs(difference[index]) > abs(worst[0]):
            worst = (float(difference[index]), float(thrust[index]), row.speed_mps)
    if worst is None:
        return f"Our Table 4 and the published one have no thrust over {THRUST_FROM_N} N in common."
    return (
        f"Our Table 4 differs from the published one by at most {fixed(abs(worst[0]), 1)} codes "
        f"(at {fixed(worst[1], 1)} N, {speed(worst[2])} m/s)."
    )


def _round_trip_table(results: VehicleResults, inverse: InverseCharacteristic) -> Table:
    tabulated = results.vehicle.tables.speed_mps
    rows = [r for r in inverse.round_trip if speed_index(tabulated, r.speed_mps) is not None]
    others = [r for r in inverse.round_trip if r not in rows]
    printed = any(r.published_n is not None for r in rows)
    header = ("Speed, m/s", "Cubic, N", "Firmware form, N", "Firmware form after rounding, codes")
    body = []
    for row in rows:
        cells = [
            speed(row.speed_mps),
            "–" if row.cubic_n is None else fixed(row.cubic_n, 3),
            fixed(row.firmware_n, 4),
            fixed(row.firmware_rounded_codes, 2),
        ]
        if printed:
            cells.append("–" if row.published_n is None else fixed(row.published_n, 2))
        body.append(tuple(cells))
    note = ""
    if others:
        note = (
            f"Between the tabulated speeds ({len(others)} more) the firmware form is off by at "
            f"most {fixed(max(r.firmware_n for r in others), 4)} N before rounding and "
            f"{fixed(max(r.firmware_rounded_codes for r in others), 2)} codes after it."
        )
    return Table(
        f"Largest error of T(N(T, V), V) over {THRUST_FROM_N} N < T ≤ T_max",
        (*header, "Published tables, N") if printed else header,
        tuple(body),
        note=note,
    )
