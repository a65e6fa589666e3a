"""The drive's mechanical characteristic M(n, N) (Kostenko 2023, fig. 4)."""

from dataclasses import replace

import numpy as np

from pipeline.records.fits import DriveFit
from pipeline.records.intervals import SWEEPS_PER_TERM, drive_factor
from pipeline.report.blocks import (
    Block,
    Details,
    Gallery,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.figures.drive import (
    family_figure,
    fitted_points,
    raw_figure,
    residual_figure,
)
from pipeline.report.numbers import (
    code,
    fixed,
    percent,
    signed,
    with_interval,
)
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import order_table, quality_line

ANCHOR, TITLE = "drive", "Drive: torque against shaft speed and code"


def drive_section(results: VehicleResults) -> Section:
    """Show the surface over the bench's points, its residuals and its spread by code."""
    fit = results.drive
    if fit is None:
        missing = not_computed(ANCHOR, TITLE, missing_reasons(results)["drive"])
        raw = raw_figure(results.load_test)
        return missing if raw is None else replace(missing, blocks=(*missing.blocks, raw))
    points, outliers = fitted_points(results.load_test, fit)
    blocks: list[Block] = [
        Gallery((family_figure(fit, points, outliers), residual_figure(fit, points))),
        Paragraph(quality_line("M(n, N)", fit.quality, "codes")),
        _intervals(fit),
    ]
    blocks += _scales(fit)
    blocks.append(_spread_table(fit))
    if fit.quality.orders:
        blocks.append(Paragraph(fit.quality.order_reason or "The order was given."))
        blocks.append(
            Details(
                f"The {len(fit.quality.orders)} orders that were compared",
                (order_table("Choice of order for M(n, N)", fit.quality),),
            )
        )
    blocks.append(Details("Coefficients of the surface", (_coefficients(fit),)))
    return Section(ANCHOR, TITLE, tuple(blocks))


def _intervals(fit: DriveFit) -> Paragraph:
    """Say what the intervals count as independent."""
    if fit.clustered and fit.clusters < SWEEPS_PER_TERM * len(fit.coefficients):
        return Paragraph(
            f"The covariance is clustered by sweep, but the {fit.clusters} sweeps are fewer than "
            f"two for each of the {len(fit.coefficients)} terms of the surface: the 95 % intervals "
            "that rest on it hold the truth less often than that. Measure more codes, both "
            "branches, or a second drive.",
            tone="warning",
        )
    if fit.clustered:
        return Paragraph(
            f"The covariance is clustered by sweep ({fit.clusters} sweeps): the errors of one "
            "sweep go together, and counting its points as independent would make the intervals "
            "too narrow."
        )
    return Paragraph(
        f"The {fit.clusters} sweeps are too few for the {len(fit.coefficients)} terms of the "
        "surface, so the covariance could not be clustered by sweep: it counts the points of a "
        "sweep as independent, and all intervals that rest on it are too narrow.",
        tone="warning",
    )


def _scales(fit: DriveFit) -> list[Block]:
    if len(fit.torque_scale_by_file) < 2:
        return []
    rows = tuple(
        (file, fixed(scale, 4), f"{signed(100 * (scale - 1), 2)} %")
        for file, scale in fit.torque_scale_by_file.items()
    )
    return [
        Table(
            "Torque of each file against the common surface",
            ("File", "Scale", "Difference"),
            rows,
            note=f"Standard deviation {percent(fit.torque_scale_std)}: the spread from "
            "drive to drive, which the intervals carry.",
        )
    ]


def _spread_table(fit: DriveFit) -> Table:
    return Table(
        "Scatter about the surface, by code",
        (
            "Code",
            "Points",
            "Shaft speed, rpm",
            "Torque, N m",
            "Residual std, mN m",
            "Rising less falling load, mN m",
        ),
        tuple(
            (
                code(spread.code),
                str(spread.points),
                f"{fixed(spread.shaft_speed_rpm[0], 0)} to {fixed(spread.shaft_speed_rpm[1], 0)}",
                f"{fixed(spread.torque_nm[0], 3)} to {fixed(spread.torque_nm[1], 3)}",
                fixed(1000 * spread.residual_std_nm, 2),
                "–"
                if spread.loading_minus_unloading_nm is None
                else signed(1000 * spread.loading_minus_unloading_nm, 2),
            )
            for spread in fit.codes
        ),
    )


def _coefficients(fit: DriveFit) -> Table:
    rows = []
    factor = drive_factor(fit)
    for (i, j), value, variance in zip(
        fit.exponents, fit.coefficients, np.diag(np.asarray(fit.covariance)), strict=True
    ):
        half = factor * float(np.sqrt(max(variance, 0.0)))
        text, interval = with_interval(value, (value - half, value + half))
        rows.append((f"x^{i} y^{j}", text, interval))
    return Table(
        "M = Σ c x^i y^j, N m",
        ("Term", "c, N m", "95 % interval"),
        tuple(rows),
        note="x: shaft speed less the middle of the speeds measured at the code, scaled; y: |N| / "
        f"{code(fit.code_scale)}. Beyond the speeds of the bench M goes on along its tangent. "
        "Single coefficients lean on each other; read the band of the curve, not these.",
    )
