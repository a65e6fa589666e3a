"""The inverse characteristics N(T) and N(T, V): Tables 3 and 4 (Kostenko 2023, figs. 9 and 10)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.records.fits import InverseCharacteristic, PolynomialFit, SpeedInverse
from pipeline.report.blocks import (
    Block,
    Bullets,
    Details,
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
from pipeline.report.curves import speed_index
from pipeline.report.figures.inverse import family_figure, mooring_figure, round_trip_figure
from pipeline.report.numbers import as_printed, code, fixed, plural, signed, speed, with_interval
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import (
    coefficient_table,
    explained,
    order_table,
    quality_line,
    share_inside,
)
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import Published, PublishedTable3, PublishedTable4

ANCHOR, TITLE = "inverse", "Inverse characteristic: code from thrust, Tables 3 and 4"


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
        blocks.append(Heading("Round trip", "round-trip"))
        blocks += [round_trip_figure(inverse), _round_trip_table(results, inverse)]
    if inverse.firmware is not None:
        firmware = inverse.firmware
        blocks.append(Heading("The firmware form", "firmware-form"))
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
        if firmware.positive.against_motion == firmware.negative.against_motion:
            blocks.append(Paragraph(firmware.positive.against_motion))
        else:
            blocks.append(
                Bullets(tuple(f"{sign} thrust: {b.against_motion}" for sign, b in texts.items()))
            )
    if inverse.explanations:
        blocks += explained(inverse.explanations)
    return Section(ANCHOR, TITLE, tuple(blocks))


def _table3(
    results: VehicleResults, inverse: InverseCharacteristic, published: PublishedTable3 | None
) -> list[Block]:
    positive, negative = inverse.table3_positive, inverse.table3_negative
    if positive is None and negative is None:
        reason = missing_reasons(results).get("mooring", "the mooring data do not support it.")
        return [Paragraph(f"Table 3 was not computed: {reason}", tone="warning")]
    sides = [
        (sign, fit, printed)
        for sign, fit, printed in (
            (1, positive, published.positive if published else None),
            (-1, negative, published.negative if published else None),
        )
        if fit is not None
    ]
    rows: list[Coefficient] = []
    for sign, fit, printed in sides:
        names = [f"K_N{0 if sign > 0 else 1}{i}" for i in range(len(fit.coefficients))]
        rows += coefficients(names, fit.coefficients, fit.ci95, printed)
    blocks: list[Block] = [
        mooring_figure(results, inverse),
        coefficient_table(
            "Table 3. N = K_0 + K_1 T + K_2 T² + K_3 T³ at rest, each sign apart",
            rows,
            note="K_N0i: positive thrust; K_N1i: negative thrust, with its sign, as printed.",
            points="fig-inverse-rest",
        ),
    ]
    if published is not None:
        blocks += [
            _table3_differences([(s, f, p) for s, f, p in sides if p is not None]),
            Paragraph(_table3_sentence(sides) + " " + share_inside(rows)),
        ]
    for _, fit, _ in sides:
        side = "positive" if fit is positive else "negative"
        blocks.append(Paragraph(quality_line(f"N(T), {side} thrust", fit.quality, "T, N,")))
    orders = tuple(
        order_table(f"Order for {'positive' if sign > 0 else 'negative'} thrust", fit.quality)
        for sign, fit, _ in sides
        if fit.quality.orders
    )
    if orders:
        blocks.append(Details("Why this order", orders))
    for side, side_fit in (("positive", positive), ("negative", negative)):
        if side_fit is None:
            blocks.append(
                Paragraph(f"No fit for {side} thrust: the test has no such points.", tone="warning")
            )
    return blocks


Side = tuple[int, PolynomialFit, Sequence[float] | None]


def _thrust_of_comparison(fit: PolynomialFit) -> FloatArray:
    largest = max(abs(end) for end in fit.quality.valid_range)
    nice = np.array([1, 2, 5, 10, 15, 20, 25, 30, 35, 40, 50, 60, 80, 100, 150, 200.0])
    return np.asarray(nice[nice <= largest])


def _table3_differences(sides: Sequence[Side]) -> Table:
    thrust = np.array(
        sorted({value for _, fit, _ in sides for value in _thrust_of_comparison(fit).tolist()})
    )
    columns = []
    for sign, fit, printed in sides:
        difference = table3_difference(fit, printed or (), sign * thrust)
        inside = thrust <= max(abs(end) for end in fit.quality.valid_range)
        columns.append(
            [
                signed(sign * value, 2) if ok else "–"
                for value, ok in zip(difference.tolist(), inside.tolist(), strict=True)
            ]
        )
    return Table(
        "Table 3: our code less the published one, in codes (magnitudes)",
        ("|T|, N", *(f"{'positive' if s > 0 else 'negative'} thrust" for s, _, _ in sides)),
        tuple(
            (code(value), *(column[index] for column in columns))
            for index, value in enumerate(thrust.tolist())
        ),
    )


def _table3_sentence(sides: Sequence[Side]) -> str:
    parts = []
    for sign, fit, printed in sides:
        if printed is None:
            continue
        largest = max(abs(end) for end in fit.quality.valid_range)
        thrust = np.linspace(THRUST_FROM_N, largest, 400)
        difference = np.abs(table3_difference(fit, printed, sign * thrust))
        worst = int(np.argmax(difference))
        parts.append(
            f"{fixed(float(difference[worst]), 2)} codes for "
            f"{'positive' if sign > 0 else 'negative'} thrust (at {fixed(float(thrust[worst]), 1)} "
            "N)"
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
        blocks.append(family_figure(results, inverse, results.static))
    blocks.append(_table4_layout(inverse.table4, table4))
    rows: list[Coefficient] = []
    for row in inverse.table4:
        names = [f"K_N{i} at {speed(row.speed_mps)} m/s" for i in range(len(row.coefficients))]
        printed = table4_row(table4, row.speed_mps) if table4 else None
        rows += coefficients(names, row.coefficients, row.ci95, printed)
    if table4 is not None:
        blocks += _table4_compared(inverse, table4, rows)
    blocks.append(
        Details(
            "Coefficients of Table 4 with intervals",
            (
                coefficient_table(
                    "Coefficients of Table 4",
                    rows,
                    points="fig-inverse-family" if results.static is not None else "",
                ),
            ),
        )
    )
    return blocks


def _table4_compared(
    inverse: InverseCharacteristic, published: PublishedTable4, rows: Sequence[Coefficient]
) -> list[Block]:
    common = [r for r in inverse.table4 if table4_row(published, r.speed_mps) is not None]
    if not common:
        return [Paragraph("The published Table 4 has no speed in common with ours.")]
    said = f"{_table4_sentence(common, published)} {share_inside(rows, _why_outside(inverse))}"
    return [_table4_differences(common, published), Paragraph(said)]


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
    body: list[tuple[str, ...]] = [("T_max, N", *(fixed(row.thrust_max_n, 2) for row in rows))]
    classes = [""]

    def add_published(values: Sequence[float]) -> None:
        assert published is not None  # noqa: S101 - narrows the type, callers checked
        cells = []
        for row in rows:
            index = speed_index(published.speed_mps, row.speed_mps)
            cells.append("–" if index is None else as_printed(values[index]))
        body.append(("published", *cells))
        classes.append("published")

    if published is not None:
        add_published(published.T_max_n)
    for index in range(4):
        body.append(
            (
                f"K_N{index}",
                *(with_interval(row.coefficients[index], row.ci95[index])[0] for row in rows),
            )
        )
        classes.append("")
        if published is not None:
            add_published((published.KN0, published.KN1, published.KN2, published.KN3)[index])
    return Table(
        "Table 4. N = K_N0 sign T + K_N1 T + K_N2 T|T| + K_N3 T³",
        ("Coefficient", *(f"{speed(row.speed_mps)} m/s" for row in rows)),
        tuple(body),
        row_classes=tuple(classes),
        note="K_Ni in codes per N to the power i. The paper prints the K_N2 row under the name of "
        "K_N3; it is read here by its unit."
        if published is not None
        else "K_Ni in codes per N to the power i.",
    )


def _table4_differences(rows: Sequence[SpeedInverse], published: PublishedTable4) -> Table:
    largest = max(row.thrust_max_n for row in rows)
    thrust = np.array([1, 2, 5, 10, 15, 20, 25, 30, 35, 40, 50, 60, 80, 100, 150, 200.0])
    thrust = thrust[thrust <= largest]
    columns = {}
    for row in rows:
        difference = table4_difference(row, published, thrust.tolist())
        if difference is not None:
            columns[row.speed_mps] = difference
    return Table(
        "Table 4: our code less the published one, in codes",
        ("T, N", *(f"{speed(v)} m/s" for v in columns)),
        tuple(
            (
                code(value),
                *(
                    "–" if np.isnan(column[index]) else signed(float(column[index]), 2)
                    for column in columns.values()
                ),
            )
            for index, value in enumerate(thrust.tolist())
        ),
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
    header: tuple[str, ...] = (
        "Speed, m/s",
        "Cubic, N",
        "Firmware form, N",
        "Firmware form after rounding, codes",
    )
    if printed:
        header += ("Published tables, N",)
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
        header,
        tuple(body),
        note=note,
    )
