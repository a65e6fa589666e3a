"""Every printed number beside ours, with the difference and, beyond rounding, the reason."""

from collections.abc import Sequence

from pipeline.records.design import Printed
from pipeline.report.blocks import Details, Paragraph, Section, Table
from pipeline.report.numbers import as_printed, general, plural, signed

#: Tables longer than this are folded away.
LONG = 40


def printed_sections(printed: Sequence[Printed]) -> tuple[Section, ...]:
    """Return the section of the comparison, or none where nothing was printed."""
    if not printed:
        return ()
    inside = sum(row.within_rounding for row in printed)
    groups: dict[str, list[Printed]] = {}
    for row in printed:
        groups.setdefault(row.table or "printed", []).append(row)
    text = (
        f"{plural(len(printed), 'printed number')}, {inside} met within the rounding of what "
        "is printed. A suffix after the quantity tells what ours is computed from (exact: the "
        "exact form; from printed: from other printed numbers; the name of a flow: from our "
        "cable)."
    )
    blocks = [
        _table(name, rows)
        if len(rows) <= LONG
        else Details(f"{name}: all {len(rows)} numbers", (_table(name, rows),))
        for name, rows in groups.items()
    ]
    return (Section("printed", "Printed numbers beside ours", (Paragraph(text), *blocks)),)


def _table(name: str, rows: Sequence[Printed]) -> Table:
    return Table.of(
        f"{name}, printed and computed",
        [
            {
                "Quantity": _words(row.quantity),
                "unit": row.unit,
                "printed": as_printed(row.printed),
                "computed": general(row.computed, 4),
                "difference": _difference(row),
                "why beyond rounding": "" if row.within_rounding else row.reason or "not explained",
            }
            for row in rows
        ],
        row_classes=tuple("" if row.within_rounding else "warning" for row in rows),
    )


def _words(quantity: str) -> str:
    """Return a quantity without underscores and the unit, which has a column of its own."""
    if " at " in quantity:
        return quantity
    units = {"n", "w", "deg", "nm", "rpm", "m"}
    return " ".join(part for part in quantity.split("_") if part not in units)


def _difference(row: Printed) -> str:
    decimals = 0
    unit = 2 * row.rounding
    while unit < 0.999 and decimals < 9:
        unit *= 10
        decimals += 1
    text = signed(row.difference, decimals + 1)
    if row.printed and not row.within_rounding:
        text += f" ({signed(100 * row.difference / abs(row.printed), 1)} %)"
    return text
