"""The page of one vehicle: warnings first, then every step from the raw files to the firmware."""

from pipeline.language import as_it_is
from pipeline.report.bench_results import thrust_figure, vehicle_glance
from pipeline.report.blocks import fold
from pipeline.report.page import Page
from pipeline.report.results import VehicleResults
from pipeline.report.sections.allocation import allocation_section, validation_section
from pipeline.report.sections.closing import changes_section, firmware_section, outliers_section
from pipeline.report.sections.drive import drive_section
from pipeline.report.sections.gains import vehicle_gains_section
from pipeline.report.sections.gap import gap_section
from pipeline.report.sections.inputs import inputs_section, warnings_section
from pipeline.report.sections.inverse import inverse_section
from pipeline.report.sections.propeller import propeller_section, working_points_section
from pipeline.report.sections.static import static_section
from pipeline.report.sections.tables import data_section
from pipeline.report.sections.trials import trials_section

__all__ = ["VehicleResults", "vehicle_page"]

#: The page stands in a folder of its own beside the index.
INDEX_HREF = "../index.html"

#: What a reader comes for, in the open.
RESULTS = (trials_section, firmware_section)
#: How it was found and what came in, behind summaries.
BEHIND = (
    warnings_section,
    vehicle_gains_section,
    inverse_section,
    static_section,
    propeller_section,
    drive_section,
    working_points_section,
    gap_section,
    allocation_section,
    validation_section,
    outliers_section,
    inputs_section,
    changes_section,
    data_section,
)


def vehicle_page(results: VehicleResults, index_href: str = INDEX_HREF, assets: str = "") -> str:
    """Return the page as HTML text; `assets` as of `Page`."""
    sections = (
        *(build(results) for build in RESULTS),
        *(
            fold(build(results))
            for build in BEHIND
            if build is not changes_section or results.changes
        ),
    )
    vehicle = results.vehicle
    return Page(
        title=as_it_is(vehicle.title),
        tab=f"{as_it_is(vehicle.title)}: thruster tables",
        under=(f"Thruster tables from rig data: {as_it_is(vehicle.name)}",),
        sections=sections,
        glance=vehicle_glance(results),
        picture=thrust_figure(results),
        data_note=vehicle.data_note,
        crumbs=(("All vehicles", index_href),),
        assets=assets,
    ).html()
