"""Pages of the propeller calculation (Kostenko 2017, fig. 6)."""

import numpy as np

from pipeline.records.design import PropellerDesign, PropellerPoint
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Bullets, Figure, Gallery, Table, Text, chapter
from pipeline.report.numbers import fixed, general
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


def _points(found: PropellerDesign) -> tuple[PropellerPoint, ...]:
    return found.ranked if found.candidate is None else (*found.ranked, found.candidate)


@chapter("ranked", "Propellers, best first")
def ranked_section(found: PropellerDesign) -> Blocks:
    """Show what is required, the propellers that give it, and the best of them at work."""
    points, best = _points(found), found.ranked[0]
    yield Text(
        f"Required: {general(found.thrust_n)} N at an advance speed of "
        f"{general(found.advance_speed_mps)} m/s in water of {general(found.density_kgpm3, 4)} "
        f"kg/m^3. Drive: {found.drive}. For each number of blades the propeller of the series that "
        "needs least shaft power, by differential evolution and SLSQP."
    )
    yield Table.of(
        "Propellers ranked by shaft power",
        points,
        "Propeller: {label} | blades: {blades} | D, m: {diameter_m:.4f} | P/D: {pitch_ratio:.3f} | "
        "A_E/A_0: {area_ratio:.3f} | rpm: {shaft_speed_rpm:.0f} | J: {advance_ratio:.3f} | "
        "K_T: {thrust_coefficient:.4f} | 10 K_Q: {torque_coefficient:10*.4f} | "
        "thrust, N: {thrust_n:.4g} | torque, N m: {torque_nm:.4g} | power, W: {power_w:.4g} | "
        "efficiency: {efficiency:.3f}",
        lambda p: "chosen" if p is best else "published" if p is found.candidate else "",
        note="The last row in italics is the stated candidate." if found.candidate else "",
    )
    yield Gallery((_open_water_figure(found), _drive_figure(found)))
    notes = tuple(dict.fromkeys(note for point in points for note in point.notes))
    yield Bullets(notes) if notes else None
    if best.full_power_thrust_n is not None and best.full_power_shaft_speed_rpm is not None:
        yield Text(
            f"With all that the drive has, {best.label} turns at "
            f"{fixed(best.full_power_shaft_speed_rpm, 0)} rpm and gives "
            f"{fixed(best.full_power_thrust_n, 1)} N."
        )


@chapter("cavitation", "Cavitation and Reynolds number")
def cavitation_section(found: PropellerDesign) -> Blocks:
    """Show by two criteria which propellers cavitate."""
    yield Text(
        "Keller: the area ratio must be at least (1.3 + 0.3 Z) T / ((p_0 - p_v) D^2) + k. Burrill: "
        "the loading of the projected area must stay below the line of 5 % back cavitation."
    )
    yield Table.of(
        "Cavitation",
        _points(found),
        lambda p: {
            "Propeller": p.label,
            "A_E/A_0": fixed(p.area_ratio, 3),
            "least, Keller": fixed(p.keller_area_ratio, 3),
            "loading": fixed(p.burrill_loading, 3),
            "limit, Burrill": fixed(p.burrill_limit, 3),
            "Rn": general(p.reynolds, 2),
            "verdict": "cavitates" if p.cavitates else "free",
        },
        lambda p: p.cavitates,
    )


def _point(
    name: str, x: float | None, y: float | None, colour: str, mark: str = "o"
) -> tuple[Trace, ...]:
    if x is None or y is None:
        return ()
    return (Trace(name, np.array([x]), np.array([y]), colour, "points", mark=mark),)


def _open_water_figure(found: PropellerDesign) -> Figure:
    best, curves = found.ranked[0], found.curves
    j = np.array(curves.advance_ratio)
    lines = (
        ("K_T", curves.thrust_coefficient, best.thrust_coefficient, 1.0, plotting.BLUE),
        ("10 K_Q", curves.torque_coefficient, best.torque_coefficient, 10.0, plotting.ORANGE),
        ("efficiency", curves.efficiency, best.efficiency, 1.0, plotting.GREEN),
    )
    traces: list[Trace] = []
    for name, values, at, scale, colour in lines:
        traces.append(Trace(name, j, scale * np.array(values), colour))
        traces += _point("", best.advance_ratio, scale * at, colour)
    return zoomable_figure(
        "open-water",
        f"The best propeller works at J = {fixed(best.advance_ratio, 2)} with an efficiency of "
        f"{fixed(best.efficiency, 3)}.",
        f"B{best.blades}, P/D = {fixed(best.pitch_ratio, 3)}, A_E/A_0 = "
        f"{fixed(best.area_ratio, 3)}; dots: the operating point.",
        (Panel("coefficients  [–]", traces, height=2.2, from_zero=True),),
        x_label="advance ratio J  [–]",
    )


def _drive_figure(found: PropellerDesign) -> Figure:
    best, curves = found.ranked[0], found.curves
    rpm, need, pushes, have = (
        np.array(own, dtype=float)
        for own in (
            curves.shaft_speed_rpm, curves.propeller_torque_nm, curves.propeller_thrust_n,
            curves.drive_torque_nm,
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
        (Panel("torque  [N m]", above), Panel("thrust  [N]", below, limits=(found.thrust_n,))),
        x_label="shaft speed  [rpm]",
    )
