"""The page of one vehicle: warnings first, then every step from the raw files to the firmware."""

from pathlib import Path

from pipeline.control.inverse import firmware_grid
from pipeline.errors import CannotComputeError
from pipeline.language import as_it_is
from pipeline.records.base import PageFile
from pipeline.records.fits import DriveFit, FitQuality, PolynomialFit
from pipeline.report.bench_results import bench_line, thrust_figure, vehicle_glance
from pipeline.report.blocks import Blocks, Links, Table, Text, chapter, fold
from pipeline.report.html import address_from, safe_link
from pipeline.report.numbers import code, fixed, general, signed, speed
from pipeline.report.page import Page
from pipeline.report.results import VehicleResults, all_checks, all_problems, missing_reasons
from pipeline.report.sections.allocation import allocation_section, validation_section
from pipeline.report.sections.drive import drive_section
from pipeline.report.sections.gains import vehicle_gains_section
from pipeline.report.sections.inputs import inputs_section, warnings_section
from pipeline.report.sections.inverse import inverse_section
from pipeline.report.sections.propeller import propeller_section, working_points_section
from pipeline.report.sections.static import gap_section, static_section
from pipeline.report.sections.tables import data_section
from pipeline.report.sections.trials import day_line, has_trend, trials_section

#: Of a digest.
_DIGITS = 12

#: The page stands in a folder of its own beside the index.
INDEX_HREF = "../index.html"


@chapter("outliers", "Outliers")
def outliers_section(results: VehicleResults) -> Blocks:
    """Name every point that a robust fit left out, with its file, sheet and row."""
    fitted = _qualities(results)
    found = [(name, own, one) for name, own in fitted.items() for one in own.outliers]
    if not found:
        none = "No fit named an outlier."
        yield Text(none if fitted else "Nothing was fitted, so no outlier could be named.")
        return
    yield Table.of(
        "Outliers: points that were not fitted",
        [
            {
                "Where": "–" if outlier.source is None else str(outlier.source),
                "Fit": name,
                "At": outlier.label,
                "Measured less fitted": ("+" if outlier.residual > 0 else "")
                + general(outlier.residual, 3)
                + ("" if quality.unit == "1" else f" {quality.unit}"),
                "Robust sigmas": signed(outlier.robust_sigmas, 1),
            }
            for name, quality, outlier in found
        ],
    )


def _qualities(results: VehicleResults) -> dict[str, FitQuality]:
    propeller, inverse = results.propeller, results.inverse
    fits: dict[str, PolynomialFit | DriveFit | None] = {"M(n, N)": results.drive}
    if propeller is not None:
        fits |= {"K_T(J)": propeller.thrust, "K_M(J)": propeller.torque}
    if inverse is not None:
        fits["N(T), positive"] = inverse.table3_positive
        fits["N(T), negative"] = inverse.table3_negative
    return {name: fit.quality for name, fit in fits.items() if fit is not None}


@chapter("firmware", "Firmware files")
def firmware_section(results: VehicleResults) -> Blocks:
    """Link the firmware files and say what they are."""
    firmware = results.inverse.firmware if results.inverse is not None else None
    files = [(name.rpartition("firmware/")[2], safe_link(name)) for name in results.firmware_files]
    if files:
        yield Links(tuple(files))
    if results.inverse is not None and firmware is not None:
        limits = firmware_grid(results.inverse).limits(0.0)
        fastest = firmware.positive.speed_mps[-1]
        covered = (
            f"speeds to {speed(fastest)} m/s along the thrust"
            if fastest > 0
            else "rest only, at any speed the same"
        )
        yield Text(
            f"The tables cover codes {code(firmware.code_min)} to {code(firmware.code_max)} and "
            f"{covered}; thrust up to {fixed(limits.forward_n, 1)} N forward and "
            f"{fixed(limits.reverse_n, 1)} N in reverse at rest. Inputs beyond are clamped."
        )
    if not files:
        none = "no files were written beside this page; rig2sea export writes them."
        reason = results.missing.get(
            "firmware", "no firmware form was computed." if firmware is None else none
        )
        raise CannotComputeError(f"No firmware files: {reason}")


@chapter("changes", "Changes of the vehicle file")
def changes_section(results: VehicleResults) -> Blocks:
    """List the changes, the latest first; one that was taken back says so."""
    rows = []
    for entry in reversed(results.changes):
        state = f"undone {entry.undone_utc} UTC" if entry.undone_utc else "holds"
        digests = f"{entry.before_sha256[:_DIGITS]} → {entry.after_sha256[:_DIGITS]}"
        for one in entry.changes:
            interval = f" [{_value(one.ci95[0])}, {_value(one.ci95[1])}]" if one.ci95 else ""
            rows.append(
                {
                    "Key": as_it_is(one.path),
                    "Before": "–" if one.old is None else _value(one.old),
                    "After": f"{_value(one.value)}{interval}",
                    "From": as_it_is(entry.reason),
                    "When": f"{entry.date_utc} UTC, {state}",
                    "Vehicle file, SHA-256 before → after": digests,
                }
            )
    yield Table.of("Changes", rows)


def _value(value: float | bool | str) -> str:
    return general(value, 4) if isinstance(value, float) else str(value)


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


def vehicle_receipt(results: VehicleResults, files: dict[str, str]) -> PageFile:
    """Return what the index says of the page, which is one of the files."""
    problems, index = all_problems(results), Path("reports/index.html")
    name, href = results.page.parent.name, address_from(index, results.page)
    return PageFile(
        files=files,
        title=results.vehicle.title,
        name=name,
        href=href,
        data_note=results.vehicle.data_note,
        errors=sum(problem.severity == "error" for problem in problems),
        warnings=sum(problem.severity == "warning" for problem in problems),
        failed_checks=sum(not check.passed for _, check in all_checks(results)),
        not_computed=len(missing_reasons(results)),
        glance=vehicle_glance(results),
        bench=bench_line(name, results.inverse, results.mooring),
        days=tuple(day_line(one, index) for one in reversed(results.trials)),
        trend_href=f"{href}#trend" if has_trend(results) else "",
    )


def vehicle_page(results: VehicleResults, assets: str = "") -> str:
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
        crumbs=(("All vehicles", INDEX_HREF),),
        assets=assets,
    ).html()
