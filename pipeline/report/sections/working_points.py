"""Where drive and propeller meet (Kostenko 2023, figs. 3, 5 and 6)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import DriveFit, StaticCharacteristic
from pipeline.report import plotting
from pipeline.report.blocks import (
    Block,
    Figure,
    Gallery,
    Paragraph,
    Section,
    not_computed,
)
from pipeline.report.curves import drive_torque, speed_index
from pipeline.report.figures.propeller_demand import demand_figures, rpm_without_drive
from pipeline.report.numbers import code, fixed, speed
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.types import FloatArray

if TYPE_CHECKING:
    import matplotlib.figure
    from matplotlib.axes import Axes

ANCHOR, TITLE = "working-points", "Working points: where drive and propeller meet"


def working_points_section(results: VehicleResults) -> Section:
    """Draw the propeller's demand and the drive's supply over shaft speed."""
    propeller, drive, static = results.propeller, results.drive, results.static
    if propeller is None:
        return not_computed(ANCHOR, TITLE, missing_reasons(results)["propeller"])
    model = OpenWaterPropeller(
        np.asarray(propeller.thrust.coefficients),
        np.asarray(propeller.torque.coefficients),
        propeller.diameter_m,
        results.vehicle.water.density_kgpm3,
    )
    speeds = results.vehicle.tables.speed_mps
    ranges = (propeller.thrust.quality.valid_range, propeller.torque.quality.valid_range)
    covered = (max(low for low, _ in ranges), min(high for _, high in ranges))
    if drive is None or static is None:
        reason = missing_reasons(results).get(
            "drive" if drive is None else "static", "the stage has not run"
        )
        return Section(
            ANCHOR,
            TITLE,
            (
                Gallery(
                    demand_figures(
                        model, speeds, rpm_without_drive(model, speeds, covered), covered
                    )
                ),
                Paragraph(f"The working points were not computed: {reason}", tone="warning"),
            ),
        )
    fastest = max(
        *(spread.shaft_speed_rpm[1] for spread in drive.codes),
        *(point[1] for spread in drive.codes for point in _points_at(static, spread.code, speeds)),
    )
    rpm = np.linspace(fastest / 200, 1.05 * fastest, 300)
    blocks: list[Block] = [
        Gallery(demand_figures(model, speeds, rpm, covered)),
        Gallery(
            (
                _meeting_figure(model, drive, static, speeds, rpm),
                _thrust_figure(model, drive, static, speeds, rpm),
            )
        ),
    ]
    return Section(ANCHOR, TITLE, tuple(blocks))


def _shown_codes(drive: DriveFit) -> list[float]:
    codes = [spread.code for spread in drive.codes]
    picked = np.unique(np.linspace(0, len(codes) - 1, min(6, len(codes))).round().astype(int))
    return [codes[index] for index in picked]


def _meeting_figure(
    model: OpenWaterPropeller,
    drive: DriveFit,
    static: StaticCharacteristic,
    speeds: Sequence[float],
    rpm: FloatArray,
) -> Figure:
    codes = _shown_codes(drive)
    top = codes[-1]
    ends = _points_at(static, top, speeds)
    lead = f"At code {code(top)} drive and propeller do not meet at any tabulated speed."
    if len(ends) == 1:  # tables may be of rest alone
        lead = (
            f"At code {code(top)} the shaft settles at {fixed(ends[0][1], 0)} rpm and "
            f"{fixed(ends[0][2], 3)} N m at {speed(ends[0][0])} m/s."
        )
    elif ends:
        lead = (
            f"At code {code(top)} the shaft settles at {fixed(ends[0][1], 0)} rpm and "
            f"{fixed(ends[0][2], 3)} N m at rest, and at {fixed(ends[-1][1], 0)} rpm and "
            f"{fixed(ends[-1][2], 3)} N m at {speed(ends[-1][0])} m/s: the faster the inflow, the "
            "less torque the propeller asks for."
        )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        colours = plotting.ordered_colours(len(speeds))
        for speed_mps, colour in zip(speeds, colours, strict=True):
            torque = model.torque_nm(rpm / 60.0, speed_mps)
            shown = torque > 0
            axes.plot(
                rpm[shown], torque[shown], color=colour, lw=1.1, label=f"{speed(speed_mps)} m/s"
            )
        for spread in drive.codes:
            if spread.code not in codes:
                continue
            n = np.linspace(*spread.shaft_speed_rpm, 60)
            torque = drive_torque(drive, n, spread.code)[0]
            axes.plot(n, torque, color=plotting.SOFT, lw=1.3)
            axes.annotate(
                code(spread.code),
                (float(n[-1]), float(torque[-1])),
                xytext=(3, -2),
                textcoords="offset points",
                va="bottom" if torque[-1] < 0.02 else "center",
                fontsize=8,
            )
        _mark(axes, static, codes, speeds, 2)
        highest = max(
            *(spread.torque_nm[1] for spread in drive.codes),
            *(point[2] for value in codes for point in _points_at(static, value, speeds)),
        )
        axes.set(xlabel="shaft speed n  [rpm]", ylabel="torque M  [N m]", ylim=(0, 1.08 * highest))
        plotting.legend_above(figure, axes, columns=5)

    alt = (
        "The drive's falling torque lines for several codes and the propeller's rising torque "
        "curves for each speed; circles where they meet."
    )
    return Figure(
        "fig-working-points",
        lead,
        plotting.draw("fig-working-points", alt, paint, height_in=3.9),
        "Torque balance (figs. 5, a and 6, a of Kostenko 2023). Grey: drive at the code written "
        "beside it, over the shaft speeds of the bench; coloured: propeller at each speed; "
        "circles: working points (open where extrapolated).",
    )


def _thrust_figure(
    model: OpenWaterPropeller,
    drive: DriveFit,
    static: StaticCharacteristic,
    speeds: Sequence[float],
    rpm: FloatArray,
) -> Figure:
    codes = _shown_codes(drive)
    middle = codes[len(codes) // 2]
    points = _points_at(static, middle, speeds)
    lead = f"Code {code(middle)} gives no thrust at any tabulated speed."
    if len(points) == 1:
        lead = (
            f"At code {code(middle)} the shaft turns at {fixed(points[0][1], 0)} rpm and the "
            f"thrust is {fixed(points[0][3], 1)} N at {speed(points[0][0])} m/s."
        )
    elif points:
        lead = (
            f"At code {code(middle)} the shaft speeds up from {fixed(points[0][1], 0)} to "
            f"{fixed(points[-1][1], 0)} rpm between {speed(points[0][0])} and "
            f"{speed(points[-1][0])} m/s, yet the thrust falls from {fixed(points[0][3], 1)} to "
            f"{fixed(points[-1][3], 1)} N."
        )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        colours = plotting.ordered_colours(len(speeds))
        for speed_mps, colour in zip(speeds, colours, strict=True):
            thrust = model.thrust_n(rpm / 60.0, speed_mps)
            shown = thrust > 0
            axes.plot(
                rpm[shown], thrust[shown], color=colour, lw=1.1, label=f"{speed(speed_mps)} m/s"
            )
        _mark(axes, static, codes, speeds, 3)
        for value in codes:
            line = _points_at(static, value, speeds)
            if len(line) > 1:
                axes.plot([p[1] for p in line], [p[3] for p in line], color=plotting.SOFT, lw=1.0)
            if line:
                axes.annotate(
                    code(value),
                    (line[0][1], line[0][3]),
                    xytext=(-4, 2),
                    textcoords="offset points",
                    ha="right",
                    fontsize=8,
                )
        highest = max(
            (point[3] for value in codes for point in _points_at(static, value, speeds)),
            default=1.0,
        )
        axes.set(xlabel="shaft speed n  [rpm]", ylabel="thrust T  [N]", ylim=(0, 1.1 * highest))
        plotting.legend_above(figure, axes, columns=5)

    alt = (
        "Thrust against shaft speed for each speed of the vehicle, with the working points marked."
    )
    return Figure(
        "fig-working-thrust",
        lead,
        plotting.draw("fig-working-thrust", alt, paint, height_in=3.9),
        "Thrust at the working points (figs. 5, b and 6, b of Kostenko 2023). Grey lines join the "
        "working points of one code (written beside it).",
    )


def _points_at(
    static: StaticCharacteristic, at_code: float, speeds: Sequence[float]
) -> list[tuple[float, float, float, float, str]]:
    """Working points of one code: (speed, rpm, torque, thrust, status)."""
    column = speed_index(static.code, at_code)
    points: list[tuple[float, float, float, float, str]] = []
    for speed_mps in speeds:
        row = speed_index(static.speed_mps, speed_mps)
        if row is None or column is None:
            continue
        status = static.status[row][column]
        if status in {"live", "extrapolated"}:
            points.append(
                (
                    speed_mps,
                    static.shaft_speed_rpm[row][column],
                    static.torque_nm[row][column],
                    static.thrust_n[row][column],
                    status,
                )
            )
    return points


def _mark(
    axes: Axes,
    static: StaticCharacteristic,
    codes: Sequence[float],
    speeds: Sequence[float],
    field: int,
) -> None:
    colours = dict(zip(speeds, plotting.ordered_colours(len(speeds)), strict=True))
    for at_code in codes:
        for point in _points_at(static, at_code, speeds):
            axes.plot(
                point[1],
                (point[0], point[1], point[2], point[3])[field],
                "o",
                ms=5,
                mfc=colours[point[0]] if point[4] == "live" else "white",
                mec=colours[point[0]],
                zorder=4,
            )
