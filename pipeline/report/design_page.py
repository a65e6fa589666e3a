"""The page of a design calculation: one self-contained file, made from its record alone."""

from pipeline.language import as_it_is, translate
from pipeline.records.design import BalanceDesign, Design, PropellerDesign
from pipeline.report.blocks import Paragraph, Section
from pipeline.report.page import Page
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
        sections=(*sections, *printed_sections(found.printed)),
    ).html()
