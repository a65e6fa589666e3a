"""The page of a design calculation, made from its record alone."""

from collections.abc import Sequence

from pipeline.language import as_it_is, translate
from pipeline.records.design import BalanceDesign, Design, Printed, PropellerDesign
from pipeline.report.blocks import Blocks, Details, Section, Table, Text, chapter, fold
from pipeline.report.numbers import as_printed, general, plural, signed
from pipeline.report.page import Labels, Page
from pipeline.report.sections import design_balance, design_propeller, design_tether

#: Tables longer than this are folded away.
LONG = 40


def design_page(found: Design, crumbs: Labels = (), assets: str = "") -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    if isinstance(found, BalanceDesign):
        calculator, kind = "balance", "Steady motion with residual buoyancy: thruster loads"
        sections: tuple[Section, ...] = (
            design_balance.state_section(found),
            design_balance.readings_section(found),
            design_balance.envelope_section(found),
        )
    elif isinstance(found, PropellerDesign):
        calculator, kind = "propeller", "Propeller of the Wageningen B-series for a drive"
        ranked, cavitates = design_propeller.ranked_section, design_propeller.cavitation_section
        sections = ranked(found), cavitates(found)
    else:
        calculator, kind = "tether", "Tether around a footprint: pull, forces, power"
        held = () if found.held is None else (design_tether.held_section(found.held),)
        sections = design_tether.pull_section(found), design_tether.needs_section(found), *held
    under = [f"rig2sea design {calculator}", kind]
    under += [f"Input: {as_it_is(found.source)}"] if found.source else []
    if found.published_source:
        under.append(f"Compared with: {as_it_is(found.published_source)}")
    return Page(
        title=as_it_is(found.title),
        tab=as_it_is(f"{found.title}: {translate(kind)}"),
        under=tuple(under),
        notes=tuple(Text(text, tone="warning") for text in found.warnings),
        crumbs=crumbs,
        sections=(*sections, *([fold(_printed_section(found.printed))] if found.printed else [])),
        assets=assets,
    ).html()


@chapter("printed", "Printed numbers beside ours")
def _printed_section(printed: Sequence[Printed]) -> Blocks:
    inside = sum(row.within_rounding for row in printed)
    yield Text(
        f"{plural(len(printed), 'printed number')}, {inside} met within the rounding of what is "
        "printed. A suffix after the quantity tells what ours is computed from (exact: the exact "
        "form; from printed: from other printed numbers; the name of a flow: from our cable)."
    )
    groups: dict[str, list[Printed]] = {}
    for row in printed:
        groups.setdefault(row.table or "printed", []).append(row)
    for name, rows in groups.items():
        table = Table.of(
            f"{name}, printed and computed",
            rows,
            lambda row: {
                "Quantity": _words(row.quantity),
                "unit": row.unit,
                "printed": as_printed(row.printed),
                "computed": general(row.computed, 4),
                "difference": _difference(row),
                "why beyond rounding": "" if row.within_rounding else row.reason or "not explained",
            },
            lambda row: not row.within_rounding,
        )
        long = len(rows) > LONG
        yield Details(f"{name}: all {len(rows)} numbers", (table,)) if long else table


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
