"""Sections of the propeller calculation (Kostenko 2017, fig. 6)."""

from pipeline.records.design import PropellerDesign, PropellerPoint
from pipeline.report.blocks import Block, Bullets, Gallery, Paragraph, Section, Table
from pipeline.report.figures.design_propeller import drive_figure, open_water_figure
from pipeline.report.numbers import fixed, general


def propeller_sections(found: PropellerDesign) -> tuple[Section, ...]:
    """Return everything but the printed numbers."""
    points = found.ranked if found.candidate is None else (*found.ranked, found.candidate)
    best = found.ranked[0]
    blocks: list[Block] = [
        Paragraph(
            f"Required: {general(found.thrust_n)} N at an advance speed of "
            f"{general(found.advance_speed_mps)} m/s in water of "
            f"{general(found.density_kgpm3, 4)} kg/m^3. Drive: {found.drive}. For each number of "
            "blades the propeller of the series that needs least shaft power, by differential "
            "evolution and SLSQP."
        ),
        _table(found, points),
        Gallery((open_water_figure(found), drive_figure(found))),
    ]
    notes = tuple(dict.fromkeys(note for point in points for note in point.notes))
    if notes:
        blocks.append(Bullets(notes))
    if best.full_power_thrust_n is not None and best.full_power_shaft_speed_rpm is not None:
        blocks.append(
            Paragraph(
                f"With all that the drive has, {best.label} turns at "
                f"{fixed(best.full_power_shaft_speed_rpm, 0)} rpm and gives "
                f"{fixed(best.full_power_thrust_n, 1)} N."
            )
        )
    return (
        Section("ranked", "Propellers, best first", tuple(blocks)),
        _cavitation(points),
    )


def _table(found: PropellerDesign, points: tuple[PropellerPoint, ...]) -> Table:
    return Table(
        "Propellers ranked by shaft power",
        (
            "Propeller",
            "blades",
            "D, m",
            "P/D",
            "A_E/A_0",
            "rpm",
            "J",
            "K_T",
            "10 K_Q",
            "thrust, N",
            "torque, N m",
            "power, W",
            "efficiency",
        ),
        tuple(
            (
                p.label,
                str(p.blades),
                fixed(p.diameter_m, 4),
                fixed(p.pitch_ratio, 3),
                fixed(p.area_ratio, 3),
                fixed(p.shaft_speed_rpm, 0),
                fixed(p.advance_ratio, 3),
                fixed(p.thrust_coefficient, 4),
                fixed(10 * p.torque_coefficient, 4),
                general(p.thrust_n, 4),
                general(p.torque_nm, 4),
                general(p.power_w, 4),
                fixed(p.efficiency, 3),
            )
            for p in points
        ),
        row_classes=tuple(
            "chosen" if k == 0 else "published" if p is found.candidate else ""
            for k, p in enumerate(points)
        ),
        note="The last row in italics is the stated candidate." if found.candidate else "",
    )


def _cavitation(points: tuple[PropellerPoint, ...]) -> Section:
    return Section(
        "cavitation",
        "Cavitation and Reynolds number",
        (
            Paragraph(
                "Keller: the area ratio must be at least (1.3 + 0.3 Z) T / ((p_0 - p_v) D^2) + k. "
                "Burrill: the loading of the projected area must stay below the line of 5 % back "
                "cavitation."
            ),
            Table(
                "Cavitation",
                (
                    "Propeller",
                    "A_E/A_0",
                    "least, Keller",
                    "loading",
                    "limit, Burrill",
                    "Rn",
                    "verdict",
                ),
                tuple(
                    (
                        p.label,
                        fixed(p.area_ratio, 3),
                        fixed(p.keller_area_ratio, 3),
                        fixed(p.burrill_loading, 3),
                        fixed(p.burrill_limit, 3),
                        general(p.reynolds, 2),
                        "cavitates" if p.cavitates else "free",
                    )
                    for p in points
                ),
                text_columns=frozenset({6}),
                row_classes=tuple("warning" if p.cavitates else "" for p in points),
            ),
        ),
    )
