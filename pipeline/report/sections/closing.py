"""Outliers by name, firmware files, and where everything came from."""

from pipeline.control.inverse import firmware_grid
from pipeline.records.fits import FitQuality, PolynomialFit
from pipeline.report.blocks import Block, Links, Paragraph, Section, Table
from pipeline.report.links import safe_link
from pipeline.report.numbers import fixed, general, plural, signed, speed
from pipeline.report.results import VehicleResults


def outliers_section(results: VehicleResults) -> Section:
    """Name every point that a robust fit left out, with its file, sheet and row."""
    rows = [
        (
            str(outlier.source) if outlier.source is not None else "–",
            name,
            outlier.label,
            _residual(outlier.residual, quality.unit),
            signed(outlier.robust_sigmas, 1),
        )
        for name, quality in _qualities(results)
        for outlier in quality.outliers
    ]
    if not rows:
        fitted = _qualities(results)
        text = (
            "No fit named an outlier."
            if fitted
            else "Nothing was fitted, so no outlier could be named."
        )
        return Section("outliers", "Outliers", (Paragraph(text),))
    return Section(
        "outliers",
        "Outliers",
        (
            Paragraph(
                f"{plural(len(rows), 'point')} did not belong to its curve and was not fitted. "
                "Nothing is dropped silently: each is named here and drawn as a cross where its "
                "fit is shown."
                if len(rows) == 1
                else f"{plural(len(rows), 'point')} did not belong to their curves and were not "
                "fitted. Nothing is dropped silently: each is named here."
            ),
            Table(
                "Outliers",
                ("Where", "Fit", "At", "Measured less fitted", "Robust sigmas"),
                tuple(rows),
            ),
        ),
    )


def _qualities(results: VehicleResults) -> list[tuple[str, FitQuality]]:
    fits: list[tuple[str, FitQuality]] = []

    def add(name: str, fit: PolynomialFit | None) -> None:
        if fit is not None:
            fits.append((name, fit.quality))

    if results.propeller is not None:
        add("K_T(J)", results.propeller.thrust)
        add("K_M(J)", results.propeller.torque)
    if results.drive is not None:
        fits.append(("M(n, N)", results.drive.quality))
    if results.inverse is not None:
        add("N(T), positive", results.inverse.table3_positive)
        add("N(T), negative", results.inverse.table3_negative)
    return fits


def _residual(value: float, unit: str) -> str:
    sign = "+" if value > 0 else ""
    return f"{sign}{general(value, 3)}" + ("" if unit == "1" else f" {unit}")


def firmware_section(results: VehicleResults) -> Section:
    """Link the firmware files and say what they are."""
    blocks: list[Block] = []
    firmware = results.inverse.firmware if results.inverse is not None else None
    if results.firmware_files:
        blocks.append(
            Links(
                tuple(
                    (name.rpartition("firmware/")[2], safe_link(name))
                    for name in results.firmware_files
                )
            )
        )
    else:
        reason = results.missing.get(
            "firmware",
            "no firmware form was computed."
            if firmware is None
            else "no files were written beside this page; rig2sea export writes them.",
        )
        blocks.append(Paragraph(f"No firmware files: {reason}", tone="warning"))
    if results.inverse is not None and firmware is not None:
        limits = firmware_grid(results.inverse).limits(0.0)
        blocks.append(
            Paragraph(
                f"The tables cover codes {firmware.code_min} to {firmware.code_max} and "
                + (
                    f"speeds to {speed(firmware.positive.speed_mps[-1])} m/s along the thrust"
                    if firmware.positive.speed_mps[-1] > 0
                    else "rest only, at any speed the same"
                )
                + f"; thrust up to "
                f"{fixed(limits.forward_n, 1)} N forward and {fixed(limits.reverse_n, 1)} N in "
                "reverse at rest. Inputs beyond are clamped."
            )
        )
    return Section(
        "firmware", "Firmware files", tuple(blocks), available=bool(results.firmware_files)
    )
