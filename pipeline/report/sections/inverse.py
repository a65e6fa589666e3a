"""The inverse characteristics N(T) and N(T, V): Tables 3 and 4 (Kostenko 2023, figs. 9 and 10)."""

from collections.abc import Sequence

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records import fits
from pipeline.records.fit_values import family_code, speed_index, static_thrust, table4_code
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Bullets, Details, Figure, Heading, Table, Text, chapter
from pipeline.report.numbers import as_printed, code, fixed, plural, speed
from pipeline.report.panels import fit_panels
from pipeline.report.results import VehicleResults, missing_reasons, needed
from pipeline.report.sections import tables
from pipeline.report.sections.tables import THRUST_FROM_N
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.vehicle.bench_schema import PublishedTable3, PublishedTable4

Side = tuple[str, int, fits.PolynomialFit, Sequence[float] | None]


@chapter("inverse", "Code from thrust, Tables 3 and 4")
def inverse_section(results: VehicleResults) -> Blocks:
    """Show Tables 3 and 4, the firmware form, and how well each closes the round trip."""
    inverse = needed(results, "inverse", results.inverse)
    published = results.vehicle.published
    yield Heading("At rest: N(T), Table 3", "table3")
    yield from _table3(results, inverse, published.table3 if published else None)
    yield Heading("Under way: N(T, V), Table 4", "table4")
    yield from _table4(results, inverse, published.table4 if published else None)
    if inverse.round_trip:
        yield Heading("Round trip", "round-trip")
        yield _round_trip_table(results, inverse)
        # both numbers, where the published tables do not belong together
        both = [r for r in inverse.round_trip if None not in {r.cubic_n, r.published_n}]
        ours = max((r.cubic_n or 0.0 for r in both), default=0.0)
        printed = max((r.published_n or 0.0 for r in both), default=0.0)
        if printed > ours:
            yield Text(
                "The published Table 4 is not the inverse of the published Table 2: sent through "
                f"both, a thrust comes back up to {fixed(printed, 2)} N off, through ours "
                f"{fixed(ours, 2)} N."
            )
    if inverse.firmware is not None:
        ahead, astern = inverse.firmware.positive, inverse.firmware.negative
        yield Text(
            f"For each sign of thrust the firmware holds the largest thrust at "
            f"{plural(len(ahead.speed_mps), 'speed')} and the code at {len(ahead.fraction)} "
            "fractions of it, linear in between, so that N(T, V) and T(N, V) are exact inverses "
            "of each other and rise together. "
            f"At and below {fixed(inverse.firmware.thrust_dead_n, 2)} N it sends code 0."
        )
        sides = {"Positive": ahead.against_motion, "Negative": astern.against_motion}
        each = tuple(f"{sign} thrust: {text}" for sign, text in sides.items())
        yield Bullets(each if len({*sides.values()}) > 1 else (ahead.against_motion,))
    yield tables.explained(inverse.explanations)


def _table3(
    results: VehicleResults, inverse: fits.InverseCharacteristic, published: PublishedTable3 | None
) -> Blocks:
    both = (
        ("positive", 1, inverse.table3_positive, published.positive if published else None),
        ("negative", -1, inverse.table3_negative, published.negative if published else None),
    )
    sides = [(name, sign, fit, printed) for name, sign, fit, printed in both if fit is not None]
    if not sides:
        reason = missing_reasons(results).get("mooring", "the mooring data do not support it.")
        yield Text(f"Table 3 was not computed: {reason}", tone="warning")
        return
    rows: list[tables.Coefficient] = []
    for _, sign, fit, printed in sides:
        names = [f"K_N{0 if sign > 0 else 1}{i}" for i in range(len(fit.coefficients))]
        rows += tables.coefficients(names, fit.coefficients, fit.ci95, printed)
    yield _at_rest(sides)
    yield tables.coefficient_table(
        "Table 3. N = K_0 + K_1 T + K_2 T² + K_3 T³ at rest, each sign apart",
        rows,
        note="K_N0i: positive thrust; K_N1i: negative thrust, with its sign, as printed.",
        points="fig-inverse-rest",
    )
    if published is not None:
        yield from map(Text, (_table3_sentence(sides), tables.share_inside(rows)))
    for name, _, own, _ in both:
        yield (
            Text(f"No fit for {name} thrust: the test has no such points.", tone="warning")
            if own is None
            else Text(tables.quality_line(f"N(T), {name} thrust", own.quality, "T, N,"))
        )


def _at_rest(sides: Sequence[Side]) -> Figure:
    above, below = list[Trace](), list[Trace]()
    for name, sign, fit, printed in sides:
        colour = plotting.VERMILLION if sign > 0 else plotting.PURPLE
        curves, left = fit_panels(fit, f"{name} thrust", colour, printed)
        above += curves
        below.append(left)
    spread = max(fit.quality.residual_std for _, _, fit, _ in sides)
    points = sum(fit.quality.points for _, _, fit, _ in sides)
    least = [(s * THRUST_FROM_N, np.asarray(fit.coefficients)) for _, s, fit, _ in sides]
    asked = (f"{fixed(n, 1)} N takes code {code(round(float(polynomial(n, k))))}" for n, k in least)
    return zoomable_figure(
        "fig-inverse-rest",
        f"The cubics follow {plural(points, 'mooring point')} with a residual of "
        f"{fixed(spread, 2)} codes; {' and '.join(asked)}.",
        "Inverse mooring characteristic (fig. 9 of Kostenko 2023). Below: measured less fitted "
        "code.",
        (
            Panel("code N  [–]", above, height=2.0),
            Panel("residual  [–]", below, height=0.7, band=0.0),
        ),
        x_label="thrust T at rest  [N]",
    )


def _table3_sentence(sides: Sequence[Side]) -> str:
    parts = []
    for name, sign, fit, printed in sides:
        at = np.linspace(THRUST_FROM_N, max(map(abs, fit.quality.valid_range)), 400)
        found = printed and tables.largest(at, tables.fit_difference(fit, printed, sign * at))
        if found:
            codes, at_n = (fixed(found[0], 2), fixed(found[1], 1))
            parts.append(f"{codes} codes for {name} thrust (at {at_n} N)")
    return (
        f"Over {THRUST_FROM_N} N to the largest measured thrust our Table 3 differs from the "
        f"published one by at most {' and '.join(parts)}."
    )


def _table4(
    results: VehicleResults, inverse: fits.InverseCharacteristic, published: PublishedTable4 | None
) -> Blocks:
    rows = inverse.table4
    if not rows:
        reason = missing_reasons(results).get("static", "there is no static family.")
        yield Text(f"Table 4 was not computed: {reason}", tone="warning")
        return
    columns = [tables.Column(r.speed_mps, r, published) for r in rows]
    common = any(one.printed is not None for one in columns)
    names = [f"K_N{i}" for i in range(4)]
    printed_n = dict(zip(published.speed_mps, published.T_max_n, strict=True) if published else ())
    limits = (
        "T_max, N",
        [fixed(row.thrust_max_n, 2) for row in rows],
        [as_printed(printed_n[v]) if (v := r.speed_mps) in printed_n else "–" for r in rows],
    )
    note = "K_Ni in codes per N to the power i." + (
        " The paper prints the K_N2 row under the name of K_N3; it is read here by its unit."
        if common
        else ""
    )
    if results.static is not None:
        yield _under_way(rows, results.static, published)
    yield tables.paper_table(
        "Table 4. N = K_N0 sign T + K_N1 T + K_N2 T|T| + K_N3 T³",
        columns,
        [limits, *tables.paper_rows(names, columns)],
        note,
    )
    own = [coefficient for one in columns for coefficient in one.coefficients(names)]
    if published is not None:
        none = "The published Table 4 has no speed in common with ours."
        said = f"{_table4_sentence(rows, published)} {tables.share_inside(own)}"
        yield Text(said if common else none)
    points = "fig-inverse-family" if results.static is not None else ""
    table = tables.coefficient_table("Coefficients of Table 4", own, points=points)
    yield Details("Coefficients of Table 4 with intervals", (table,))


def _under_way(
    rows: Sequence[fits.SpeedInverse],
    static: fits.StaticCharacteristic,
    published: PublishedTable4 | None,
) -> Figure:
    shared = min(row.thrust_max_n for row in rows)
    probe = float(np.floor(shared)) if shared > 2 else shared
    first, last = (float(table4_code(row.coefficients, probe)) for row in (rows[0], rows[-1]))
    fastest = rows[-1].speed_mps
    index = speed_index(static.speed_mps, fastest)
    kept = ""
    if index is not None:
        thrust = float(static_thrust(static, index, first))
        kept = f"; the code found at rest gives {fixed(thrust, 1)} N at {speed(fastest)} m/s"
    above, below = list[Trace](), list[Trace]()
    for row, colour in zip(rows, plotting.ordered_colours(len(rows)), strict=True):
        own = np.linspace(min(THRUST_FROM_N, row.thrust_max_n), row.thrust_max_n, 150)
        cubic = table4_code(row.coefficients, own)
        above.append(Trace(f"{speed(row.speed_mps)} m/s", own, cubic, colour))
        family = family_code(static, row.speed_mps, own)
        if family is not None:
            above.append(Trace("family", own[::10], family[::10], colour, "points", mark="o"))
            below.append(Trace("", own, cubic - family, colour))
        printed = tables.printed_row(published, row.speed_mps)
        if printed is not None:
            other = table4_code(printed, own)
            above.append(Trace("published", own, other, plotting.INK, dash="dash"))
    return zoomable_figure(
        "fig-inverse-family",
        f"For {fixed(probe, 0)} N the code must rise from {fixed(first, 0)} to {fixed(last, 0)} "
        f"between {speed(rows[0].speed_mps)} and {speed(fastest)} m/s{kept}.",
        "Inverse family (fig. 10 of Kostenko 2023). Solid: cubic of Table 4; dots: the family "
        "itself; dashed: published Table 4. Below, in codes: how far the cubic is off the family.",
        (
            Panel("code N  [–]", above, height=2.0, from_zero=True),
            Panel("off the\nfamily  [–]", below, height=0.7, band=0.0),
        ),
        x_label="thrust T  [N]",
    )


def _table4_sentence(rows: Sequence[fits.SpeedInverse], published: PublishedTable4) -> str:
    found = []
    for row in rows:
        thrust = np.linspace(THRUST_FROM_N, row.thrust_max_n, 400)
        worst = tables.largest(thrust, tables.table4_difference(row, published, thrust))
        if worst is not None:
            found.append((*worst, row.speed_mps))
    if not found:
        return f"Our Table 4 and the published one have no thrust over {THRUST_FROM_N} N in common."
    codes, at_n, at_mps = max(found)
    return (
        f"Our Table 4 differs from the published one by at most {fixed(codes, 1)} codes "
        f"(at {fixed(at_n, 1)} N, {speed(at_mps)} m/s)."
    )


def _round_trip_table(results: VehicleResults, inverse: fits.InverseCharacteristic) -> Table:
    tabulated = results.vehicle.tables.speed_mps
    rows = [r for r in inverse.round_trip if speed_index(tabulated, r.speed_mps) is not None]
    others = [r for r in inverse.round_trip if r not in rows]
    printed = any(r.published_n is not None for r in rows)
    note = (
        f"Between the tabulated speeds ({len(others)} more) the firmware form is off by at "
        f"most {fixed(max(r.firmware_n for r in others), 4)} N before rounding and "
        f"{fixed(max(r.firmware_rounded_codes for r in others), 2)} codes after it."
        if others
        else ""
    )
    return Table.of(
        f"Largest error of T(N(T, V), V) over {THRUST_FROM_N} N < T ≤ T_max",
        rows,
        lambda row: {
            "Speed, m/s": speed(row.speed_mps),
            "Cubic, N": fixed(row.cubic_n, 3),
            "Firmware form, N": fixed(row.firmware_n, 4),
            "Firmware form after rounding, codes": fixed(row.firmware_rounded_codes, 2),
            **({"Published tables, N": fixed(row.published_n, 2)} if printed else {}),
        },
        note=note,
    )
