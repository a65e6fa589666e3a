"""Sections of the tether calculation (Kostenko and Mokeeva 2009)."""

import numpy as np

from pipeline.records.design import FootprintVariant, HeldFootprint, TetherDesign
from pipeline.report.blocks import Block, Details, Gallery, Paragraph, Section, Table
from pipeline.report.figures.design_tether import held_figure, pull_figure, shapes_figure
from pipeline.report.numbers import fixed, general, use_of_limit

_FLOWS = (
    "How the vehicle's own speed falls off along the cable is an assumption. paper: eq. (1) as it "
    "reads, one direction of flow whose size falls by the vehicle's speed; vector: the velocity "
    "itself falls, the current is left at the garage; uniform: the flow at the vehicle everywhere, "
    "the safe one."
)


def tether_sections(found: TetherDesign) -> tuple[Section, ...]:
    """Return everything but the printed numbers."""
    sections = [_pull(found), _drive(found)]
    if found.held is not None:
        sections.append(_held(found.held))
    return tuple(sections)


def _vector(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(general(v) for v in values) + ")"


def _pull(found: TetherDesign) -> Section:
    blocks: list[Block] = [
        Paragraph(
            f"{general(found.length_m)} m of cable, vehicle {general(found.radius_m)} m from the "
            f"garage's vertical and {general(abs(found.height_m))} m "
            f"{'below' if found.height_m < 0 else 'above'} it, own velocity "
            f"{_vector(found.vehicle_velocity_mps)} m/s, current {_vector(found.current_mps)} m/s, "
            f"{general(found.density_kgpm3, 4)} kg/m^3. Axes of the paper: X ahead, Y up, Z to "
            "starboard."
        ),
        Gallery((pull_figure(found),)),
    ]
    if len(found.variants) > 1:
        blocks.append(Paragraph(_FLOWS))
    for variant in found.variants:
        table = _edge(variant)
        blocks.append(
            table
            if variant.variant == found.variant
            else Details(f"The same with the flow '{variant.variant}'", (table,))
        )
    if found.equivalent is not None:
        blocks.append(Paragraph(f"In simulation: {found.equivalent.text}"))
    blocks.append(Gallery((shapes_figure(found),)))
    return Section("pull", "Pull of the cable along the footprint's edge", tuple(blocks))


def _edge(variant: FootprintVariant) -> Table:
    judged = any(row.use is not None for row in variant.rows)
    rows = []
    for row in variant.rows:
        cells = (
            fixed(row.angle_deg, 0),
            *(fixed(v, 0) for v in row.on_garage_n),
            fixed(float(np.linalg.norm(row.on_garage_n)), 0),
            *(fixed(v, 0) for v in row.on_vehicle_n),
            fixed(float(np.linalg.norm(row.on_vehicle_n)), 0),
            *(fixed(v, 0) for v in row.required_n),
        )
        rows.append((*cells, use_of_limit(row.use)) if judged else cells)
    header = (
        "angle, deg",
        "T_nx",
        "T_ny",
        "T_nz",
        "|T_n|",
        "T_ax",
        "T_ay",
        "T_az",
        "|T_a|",
        "F_x",
        "F_y",
        "F_z",
    )
    return Table(
        f"Flow '{variant.variant}': forces of the cable on garage (n) and vehicle (a), thrust "
        "needed there (F), N",
        (*header, "use") if judged else header,
        tuple(rows),
        note="F holds cable, drag of the hull and buoyancy at that place.",
    )


def _drive(found: TetherDesign) -> Section:
    rows = tuple(
        (
            need.basis if need.basis == "printed pulls" else f"flow {need.basis}",
            *(fixed(v, 1) for v in need.pull_n),
            *(fixed(v, 1) for v in need.drag_n),
            *(fixed(v, 1) for v in need.force_n),
        )
        for need in found.needs
    )
    power = tuple(
        (
            need.basis if need.basis == "printed pulls" else f"flow {need.basis}",
            *(fixed(v, 0) for v in need.towing_power_w),
            fixed(sum(need.towing_power_w), 0),
            *(fixed(v, 0) for v in need.consumed_power_w),
            fixed(sum(need.consumed_power_w), 0),
        )
        for need in found.needs
    )
    return Section(
        "drive",
        "Control forces and power",
        (
            Table(
                "Largest pull, drag of the hull, needed force, eqs. (3) and (4), N",
                (
                    "From",
                    "T_x",
                    "T_y",
                    "T_z",
                    "R_x",
                    "R_y",
                    "R_z",
                    "F_x",
                    "F_y",
                    "F_z",
                ),
                rows,
            ),
            Table(
                "Towing and consumed power, eqs. (5) and (6), W",
                (
                    "From",
                    "towing X",
                    "Y",
                    "Z",
                    "sum",
                    "consumed X",
                    "Y",
                    "Z",
                    "sum",
                ),
                power,
            ),
        ),
    )


def _held(held: HeldFootprint) -> Section:
    ahead, astern, up, down, starboard, port = held.largest_force_n
    return Section(
        "held",
        f"Footprint that {held.vehicle} can hold",
        (
            Paragraph(
                "Largest thrust at rest without turning: "
                f"{fixed(ahead, 0)} N ahead, {fixed(astern, 0)} N astern, {fixed(up, 0)} N up, "
                f"{fixed(down, 0)} N down, {fixed(starboard, 0)} N to starboard and "
                f"{fixed(port, 0)} N to port. Roll and pitch are left to weight and buoyancy."
            ),
            Gallery((held_figure(held),)),
            Table(
                "Radius that is held",
                ("Angle, deg", "radius, m", "ends with"),
                tuple(
                    (fixed(angle, 0), fixed(radius, 1), what)
                    for angle, radius, what in zip(
                        held.angle_deg, held.held_radius_m, held.limit, strict=True
                    )
                ),
                text_columns=frozenset({2}),
            ),
        ),
    )
