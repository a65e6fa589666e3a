"""The propeller: its open-water curves (Table 1), and where the drive meets it (Kostenko 2023)."""

from collections.abc import Sequence

import numpy as np

from pipeline.physics.propeller import efficiency, polynomial
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records import fit_values as values
from pipeline.records.fits import DriveFit, PropellerFit, StaticCharacteristic
from pipeline.records.measurements import OpenWaterRecord
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Figure, Text, chapter
from pipeline.report.numbers import code, fixed, general, percent, speed
from pipeline.report.panels import fit_panels
from pipeline.report.results import VehicleResults, missing_reasons, needed
from pipeline.report.sections import tables
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.vehicle.bench_schema import PublishedTable1

#: The published comparison is scored up to this advance ratio.
COMPARED_TO_J = 0.6


@chapter("propeller", "Propeller: K_T(J) and K_M(J), Table 1")
def propeller_section(results: VehicleResults) -> Blocks:
    """Show the fit with its data, residuals, Table 1 and the published curves."""
    fit = needed(results, "propeller", results.propeller)
    published = results.vehicle.published.table1 if results.vehicle.published else None
    yield _curves_figure(fit, results.open_water, published)
    curves = {
        "K_T": (fit.thrust, published.KT if published else None),
        "K_M": (fit.torque, published.KM if published else None),
    }
    rows: list[tables.Coefficient] = []
    off = []
    for name, (curve, printed) in curves.items():
        names = [f"{name}{i}" for i in range(4)]
        rows += tables.coefficients(names, curve.coefficients, curve.ci95, printed)
        if printed is not None:
            share = percent(tables.largest_relative_difference(curve, printed, COMPARED_TO_J))
            off.append(f"{name} differs by at most {share} of {name}0")
    yield tables.coefficient_table(
        "Table 1. Propeller coefficients",
        rows,
        note=f"Diameter {fixed(fit.diameter_m, 3)} m. K_M is the English K_Q.",
        points="fig-propeller",
    )
    if off:
        over = f"Against the published curves over J = 0 to {COMPARED_TO_J}"
        yield Text(f"{over}: {', '.join(off)}. {tables.share_inside(rows)}")
    for name, (curve, _) in curves.items():
        yield Text(tables.quality_line(name, curve.quality, "J"))
        if curve.quality.order_reason:
            yield Text(curve.quality.order_reason)


def _curves_figure(
    fit: PropellerFit, record: OpenWaterRecord | None, published: PublishedTable1 | None
) -> Figure:
    lows, highs = zip(*(own.quality.valid_range for own in (fit.thrust, fit.torque)), strict=True)
    j = np.linspace(min(lows), max(highs), 200)
    eta = values.efficiency_curve(fit, j)
    best = int(np.nanargmax(eta)) if np.isfinite(eta).any() else None
    k_t = polynomial(j, np.asarray(fit.thrust.coefficients))
    best_text = (
        f"; efficiency is largest, {fixed(float(eta[best]), 2)}, at J = {fixed(float(j[best]), 2)}"
        if best is not None
        else ""
    )
    k_t_printed, k_m_printed = (published.KT, published.KM) if published else (None, None)
    thrust, left_t = fit_panels(fit.thrust, "K_T", plotting.BLUE, k_t_printed)
    torque, left_m = fit_panels(fit.torque, "10 K_M", plotting.VERMILLION, k_m_printed, scale=10.0)
    # of the single points
    useful = np.array(
        [
            (p.advance_ratio, p.thrust_coefficient, p.torque_coefficient)
            for p in (record.points if record is not None else ())
            if not p.marks and min(p.thrust_coefficient or 0.0, p.torque_coefficient or 0.0) > 0.0
        ]
    ).reshape(-1, 3)
    measured = Trace("", useful[:, 0], efficiency(*useful.T), plotting.GREEN, "points")
    curves = (*thrust, *torque, Trace("efficiency", j, eta, plotting.GREEN))
    curves = (*curves, measured) if len(useful) else curves
    return zoomable_figure(
        "fig-propeller",
        f"K_T falls from {fixed(float(k_t[0]), 3)} to {fixed(float(k_t[-1]), 3)} between "
        f"J = {fixed(float(j[0]), 2)} and {fixed(float(j[-1]), 2)}{best_text}.",
        "Open-water curves (fig. 2 of Kostenko 2023). Points: data; lines: fits; bands: 95 % of "
        "the fit; dashed: published; crosses: outliers. Below: residuals on the same axis.",
        (
            Panel("K_T, 10 K_M,\nefficiency  [–]", curves, height=2.0, from_zero=True),
            Panel("K_T\nresidual", (left_t,), height=0.6, band=0.0),
            Panel("10 K_M\nresidual", (left_m,), height=0.6, band=0.0),
        ),
        x_label="advance ratio J  [–]",
    )


#: Working point of one code: speed, rpm, torque, thrust, status.
Point = tuple[float, float, float, float, str]


@chapter("working-points", "Working points: where drive and propeller meet")
def working_points_section(results: VehicleResults) -> Blocks:
    """Draw the propeller's demand and the drive's supply over shaft speed."""
    propeller = needed(results, "propeller", results.propeller)
    drive, static = results.drive, results.static
    model = OpenWaterPropeller(
        np.asarray(propeller.thrust.coefficients),
        np.asarray(propeller.torque.coefficients),
        propeller.diameter_m,
        results.vehicle.water.density_kgpm3,
    )
    speeds = results.vehicle.tables.speed_mps
    if drive is not None and static is not None:
        yield _meeting_figure(model, speeds, drive, static)
        return
    yield _meeting_figure(model, speeds)
    stage = "drive" if drive is None else "static"
    reason = missing_reasons(results).get(stage, "the stage has not run")
    yield Text(f"The working points were not computed: {reason}", tone="warning")


def _meeting_figure(
    model: OpenWaterPropeller,
    speeds: Sequence[float],
    drive: DriveFit | None = None,
    static: StaticCharacteristic | None = None,
) -> Figure:
    every = [spread.code for spread in drive.codes] if drive else []
    picked = np.unique(np.linspace(0, len(every) - 1, min(6, len(every))).round().astype(int))
    codes = [every[index] for index in picked]
    points = {own: _points_at(static, own, speeds) if static else [] for own in codes}
    # without a drive down to J = 0.3 at the fastest speed
    fastest = 60.0 * max(*speeds, 0.5) / (0.3 * model.diameter_m)
    if drive:
        measured = [spread.shaft_speed_rpm[1] for spread in drive.codes]
        fastest = 1.05 * max(*measured, *(point[1] for own in points.values() for point in own))
    rpm = np.linspace(fastest / 200, fastest, 300)
    torque, thrust = list[Trace](), list[Trace]()
    colours = dict(zip(speeds, plotting.ordered_colours(len(speeds)), strict=True))
    for speed_mps, colour in colours.items():
        for of, traces in ((model.torque_nm, torque), (model.thrust_n, thrust)):
            own = of(rpm / 60.0, speed_mps)
            shown = np.where(own > 0, own, np.nan)
            traces.append(Trace(f"{speed(speed_mps)} m/s", rpm, shown, colour))
    for spread in drive.codes if drive else ():
        if drive and spread.code in codes:
            n = np.linspace(*spread.shaft_speed_rpm, 60)
            own = values.drive_torque(drive, n, spread.code)[0]
            torque.append(Trace("drive", n, own, plotting.SOFT, width=1.6, end=code(spread.code)))
    for found in points.values():
        for column, traces in ((2, torque), (3, thrust)):
            for point in found:
                at, own = np.array([point[1]]), np.array([point[column]])
                colour, open_one = colours[point[0]], point[4] != "live"
                traces.append(Trace("", at, own, colour, "points", mark="o", hollow=open_one))
    top = points.get(codes[-1], []) if codes else []
    highest = [1.3 * max((float(p[k]) for p in top), default=0.0) or None for k in (2, 3)]
    return zoomable_figure(
        "fig-working-points",
        _meeting_lead(model, speeds, codes[-1] if codes else None, top, float(rpm[-1])),
        "Torque balance (figs. 3, 5 and 6 of Kostenko 2023). Grey: drive at the code written "
        "beside it, over the shaft speeds of the bench; coloured: propeller at each speed; "
        "circles: working points (open where extrapolated).",
        tuple(
            Panel(label, traces, height=1.7, y_range=None if end is None else (0.0, end))
            for label, traces, end in zip(
                ("torque M  [N m]", "thrust T  [N]"), (torque, thrust), highest, strict=True
            )
        ),
        x_label="shaft speed n  [rpm]",
    )


def _meeting_lead(
    model: OpenWaterPropeller,
    speeds: Sequence[float],
    at_code: float | None,
    points: Sequence[Point],
    last_rpm: float,
) -> str:
    if at_code is None:
        first, last = (float(model.torque_nm(last_rpm / 60, v)) for v in (speeds[0], speeds[-1]))
        return (
            f"At {general(last_rpm, 4)} rpm the propeller's torque falls from {general(first)} to "
            f"{general(last)} N m between {speed(speeds[0])} and {speed(speeds[-1])} m/s."
        )
    if not points:
        return f"At code {code(at_code)} drive and propeller do not meet at any tabulated speed."
    first_point, last_point = points[0], points[-1]
    said = (
        f"At code {code(at_code)} the shaft turns at {fixed(first_point[1], 0)} rpm and gives "
        f"{fixed(first_point[3], 1)} N at {speed(first_point[0])} m/s"
    )
    if len(points) == 1:  # tables may be of rest alone
        return f"{said}."
    return (
        f"{said}, and at {fixed(last_point[1], 0)} rpm {fixed(last_point[3], 1)} N at "
        f"{speed(last_point[0])} m/s: the faster the inflow, the less torque the propeller asks "
        "for and the less it pushes."
    )


def _points_at(
    static: StaticCharacteristic, at_code: float, speeds: Sequence[float]
) -> list[Point]:
    column = values.speed_index(static.code, at_code)
    points: list[Point] = []
    if column is None:
        return points
    for speed_mps, row in values.shown_speeds(static, speeds):
        status = static.status[row][column]
        if status in {"live", "extrapolated"}:
            found = (static.shaft_speed_rpm, static.torque_nm, static.thrust_n)
            rpm, torque, thrust = (table[row][column] for table in found)
            points.append((speed_mps, rpm, torque, thrust, status))
    return points
