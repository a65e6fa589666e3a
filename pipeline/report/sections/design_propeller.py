"""Pages of the propeller calculation (Kostenko 2017, fig. 6)."""

import numpy as np

from pipeline.records.design import PropellerDesign, PropellerPoint
from pipeline.report import plotting
from pipeline.report.blocks import Block, Bullets, Figure, Gallery, Paragraph, Section, Table
from pipeline.report.numbers import fixed, general
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


def propeller_sections(found: PropellerDesign) -> tuple[Section, ...]:
    """Return everything but the printed numbers."""
    points = found.ranked if found.candidate is None else (*found.ranked, found.candidate)
    best = found.ranked[0]
    text = (
        f"Required: {general(found.thrust_n)} N at an advance speed of "
        f"{general(found.advance_speed_mps)} m/s in water of "
        f"{general(found.density_kgpm3, 4)} kg/m^3. Drive: {found.drive}. For each number of "
        "blades the propeller of the series that needs least shaft power, by differential "
        "evolution and SLSQP."
    )
    figures = Gallery((open_water_figure(found), drive_figure(found)))
    blocks: list[Block] = [Paragraph(text), _table(found, points), figures]
    notes = tuple(dict.fromkeys(note for point in points for note in point.notes))
    blocks += [Bullets(notes)] if notes else []
    if best.full_power_thrust_n is not None and best.full_power_shaft_speed_rpm is not None:
        full = (
            f"With all that the drive has, {best.label} turns at "
            f"{fixed(best.full_power_shaft_speed_rpm, 0)} rpm and gives "
            f"{fixed(best.full_power_thrust_n, 1)} N."
        )
        blocks.append(Paragraph(full))
    return (Section("ranked", "Propellers, best first", tuple(blocks)), _cavitation(points))


def _table(found: PropellerDesign, points: tuple[PropellerPoint, ...]) -> Table:
    return Table.of(
        "Propellers ranked by shaft power",
        [
            {
                "Propeller": p.label,
                "blades": str(p.blades),
                "D, m": fixed(p.diameter_m, 4),
                "P/D": fixed(p.pitch_ratio, 3),
                "A_E/A_0": fixed(p.area_ratio, 3),
                "rpm": fixed(p.shaft_speed_rpm, 0),
                "J": fixed(p.advance_ratio, 3),
                "K_T": fixed(p.thrust_coefficient, 4),
                "10 K_Q": fixed(10 * p.torque_coefficient, 4),
                "thrust, N": general(p.thrust_n, 4),
                "torque, N m": general(p.torque_nm, 4),
                "power, W": general(p.power_w, 4),
                "efficiency": fixed(p.efficiency, 3),
            }
            for p in points
        ],
        row_classes=tuple(
            "chosen" if k == 0 else "published" if p is found.candidate else ""
            for k, p in enumerate(points)
        ),
        note="The last row in italics is the stated candidate." if found.candidate else "",
    )


def _cavitation(points: tuple[PropellerPoint, ...]) -> Section:
    text = (
        "Keller: the area ratio must be at least (1.3 + 0.3 Z) T / ((p_0 - p_v) D^2) + k. "
        "Burrill: the loading of the projected area must stay below the line of 5 % back "
        "cavitation."
    )
    table = Table.of(
        "Cavitation",
        [
            {
                "Propeller": p.label,
                "A_E/A_0": fixed(p.area_ratio, 3),
                "least, Keller": fixed(p.keller_area_ratio, 3),
                "loading": fixed(p.burrill_loading, 3),
                "limit, Burrill": fixed(p.burrill_limit, 3),
                "Rn": general(p.reynolds, 2),
                "verdict": "cavitates" if p.cavitates else "free",
            }
            for p in points
        ],
        row_classes=tuple("warning" if p.cavitates else "" for p in points),
    )
    return Section("cavitation", "Cavitation and Reynolds number", (Paragraph(text), table))


def _point(
    name: str, x: float | None, y: float | None, colour: str, mark: str = "o"
) -> tuple[Trace, ...]:
    if x is None or y is None:
        return ()
    return (Trace(name, np.array([x]), np.array([y]), colour, "points", mark=mark),)


def open_water_figure(found: PropellerDesign) -> Figure:
    """Draw K_T, 10 K_Q and efficiency of the best, with its operating point."""
    best, curves = found.ranked[0], found.curves
    j = np.array(curves.advance_ratio)
    lines = (
        ("K_T", curves.thrust_coefficient, best.thrust_coefficient, 1.0, plotting.BLUE),
        ("10 K_Q", curves.torque_coefficient, best.torque_coefficient, 10.0, plotting.ORANGE),
        ("efficiency", curves.efficiency, best.efficiency, 1.0, plotting.GREEN),
    )
    traces = [
        trace
        for name, values, at, scale, colour in lines
        for trace in (
            Trace(name, j, scale * np.array(values), colour),
            *_point("", best.advance_ratio, scale * at, colour),
        )
    ]
    return zoomable_figure(
        "open-water",
        f"The best propeller works at J = {fixed(best.advance_ratio, 2)} with an efficiency of "
        f"{fixed(best.efficiency, 3)}.",
        f"B{best.blades}, P/D = {fixed(best.pitch_ratio, 3)}, A_E/A_0 = "
        f"{fixed(best.area_ratio, 3)}; dots: the operating point.",
        (Panel("coefficients  [–]", tuple(traces), height=2.2, from_zero=True),),
        x_label="advance ratio J  [–]",
    )


def drive_figure(found: PropellerDesign) -> Figure:
    """Draw the torque of the best over shaft speed, with what the drive has."""
    best, curves = found.ranked[0], found.curves
    rpm, need, have, pushes = (
        np.array(getattr(curves, name), dtype=float)
        for name in (
            "shaft_speed_rpm", "propeller_torque_nm", "drive_torque_nm", "propeller_thrust_n",
        )
    )  # fmt: skip
    drive: tuple[Trace, ...] = (Trace("drive has", rpm, have, plotting.VERMILLION),)
    if not np.isfinite(have).any():
        at, torque = best.shaft_speed_rpm, found.drive_torque_at_point_nm
        drive = _point("drive's working point", at, torque, plotting.VERMILLION, "s")
    full = best.full_power_shaft_speed_rpm
    above = (
        Trace("propeller needs", rpm, need, plotting.BLUE),
        *drive,
        *_point("", best.shaft_speed_rpm, best.torque_nm, plotting.BLUE),
        *_point("full power", full, best.full_power_torque_nm, plotting.INK, "D"),
    )
    below = (
        Trace("", rpm, pushes, plotting.BLUE),
        *_point("", best.shaft_speed_rpm, best.thrust_n, plotting.BLUE),
        *_point("", full, best.full_power_thrust_n, plotting.INK, "D"),
    )
    return zoomable_figure(
        "drive",
        f"At {fixed(best.shaft_speed_rpm, 0)} rpm the best propeller needs "
        f"{fixed(best.torque_nm, 3)} N m of the drive's "
        f"{fixed(found.drive_torque_at_point_nm, 3)} N m.",
        f"At an advance speed of {fixed(found.advance_speed_mps, 2)} m/s; dotted: the required "
        f"{fixed(found.thrust_n, 1)} N. Drive: {found.drive}.",
        (
            Panel("torque  [N m]", above),
            Panel("thrust  [N]", below, limits=(found.thrust_n,)),
        ),
        x_label="shaft speed  [rpm]",
    )
