"""The page of a design calculation: one self-contained file, made from its record alone."""

from collections.abc import Sequence

from pipeline.language import as_it_is, translate
from pipeline.records.design import BalanceDesign, Design, Printed, PropellerDesign
from pipeline.report.blocks import Details, Paragraph, Section, Table
from pipeline.report.numbers import as_printed, general, plural, signed
from pipeline.report.page import Page
from pipeline.report.sections.design_balance import balance_sections
from pipeline.report.sections.design_propeller import propeller_sections
from pipeline.report.sections.design_tether import tether_sections

#: Tables longer than this are folded away.
LONG = 40


def design_page(found: Design, crumbs: tuple[tuple[str, str], ...] = ()) -> str:
    """Return the page as HTML; no scripts, nothing from a network; `crumbs` are the way back."""
    if isinstance(found, BalanceDesign):
        calculator, kind = "balance", "Steady motion with residual buoyancy: thruster loads"
        sections: tuple[Section, ...] = balance_sections(found)
    elif isinstance(found, PropellerDesign):
        calculator, kind = "propeller", "Propeller of the Wageningen B-series for a drive"
        sections = propeller_sections(found)
    else:
        calculator, kind = "tether", "Tether around a footprint: pull, forces, power"
        sections = tether_sections(found)
    under = [f"rig2sea design {calculator}", kind]
    under += [f"Input: {as_it_is(found.source)}"] if found.source else []
    if found.published_source:
        under.append(f"Compared with: {as_it_is(found.published_source)}")
    return Page(
        title=as_it_is(found.title),
        tab=as_it_is(f"{found.title}: {translate(kind)}"),
        under=tuple(under),
        notes=tuple(Paragraph(text, tone="warning") for text in found.warnings),
        crumbs=crumbs,
        sections=(*sections, *_printed(found.printed)),
    ).html()


def _printed(printed: Sequence[Printed]) -> tuple[Section, ...]:
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
