"""The page of a design calculation: one self-contained file, made from its record alone."""

from pipeline.records.design import BalanceDesign, Design, PropellerDesign
from pipeline.report.blocks import Section
from pipeline.report.html import render
from pipeline.report.sections.design_balance import balance_sections
from pipeline.report.sections.design_printed import printed_sections
from pipeline.report.sections.design_propeller import propeller_sections
from pipeline.report.sections.design_tether import tether_sections


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
    return render(
        "design.html.j2",
        still_only=True,
        title=found.title,
        crumbs=crumbs,
        kind=kind,
        calculator=calculator,
        source=found.source,
        published_source=found.published_source,
        warnings=found.warnings,
        sections=(*sections, *printed_sections(found.printed)),
    )
