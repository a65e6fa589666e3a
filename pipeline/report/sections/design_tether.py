"""Sections of the tether calculation (Kostenko and Mokeeva 2009)."""

from collections.abc import Sequence

import numpy as np

from pipeline.records.design import FootprintVariant, HeldFootprint, TetherDesign
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Details, Figure, Table, Text, chapter
from pipeline.report.numbers import fixed, general, use_of_limit
from pipeline.report.zoomable import Panel, Trace, zoomable_figure

_FLOWS = (
    "How the vehicle's own speed falls off along the cable is an assumption. paper: eq. (1) as it "
    "reads, one direction of flow whose size falls by the vehicle's speed; vector: the velocity "
    "itself falls, the current is left at the garage; uniform: the flow at the vehicle everywhere, "
    "the safe one."
)
_COLOURS = {"paper": plotting.BLUE, "uniform": plotting.VERMILLION, "vector": plotting.GREEN}


@chapter("pull", "Pull of the cable along the footprint's edge")
def pull_section(found: TetherDesign) -> Blocks:
    """Show the cable, what it pulls with and what shape it takes."""
    own, current = (
        f"({', '.join(general(v) for v in values)})"
        for values in (found.vehicle_velocity_mps, found.current_mps)
    )
    yield Text(
        f"{general(found.length_m)} m of cable, vehicle {general(found.radius_m)} m from the "
        f"garage's vertical and {general(abs(found.height_m))} m "
        f"{'below' if found.height_m < 0 else 'above'} it, own velocity {own} m/s, current "
        f"{current} m/s, {general(found.density_kgpm3, 4)} kg/m^3. Axes of the paper: X ahead, Y "
        "up, Z to starboard."
    )
    yield _pull_figure(found)
    yield Text(_FLOWS) if len(found.variants) > 1 else None
    for one in found.variants:
        chosen, name = one.variant == found.variant, f"The same with the flow '{one.variant}'"
        yield _edge(one) if chosen else Details(name, (_edge(one),))
    if found.equivalent is not None:
        yield Text(f"In simulation: {found.equivalent.text}")
    yield _shapes_figure(found)


def _edge(variant: FootprintVariant) -> Table:
    judged = any(row.use is not None for row in variant.rows)
    return Table.of(
        f"Flow '{variant.variant}': forces of the cable on garage (n) and vehicle (a), thrust "
        "needed there (F), N",
        variant.rows,
        lambda row: {
            "angle, deg": fixed(row.angle_deg, 0),
            **_parts("T_n", row.on_garage_n, whole=True),
            **_parts("T_a", row.on_vehicle_n, whole=True),
            **_parts("F_", row.required_n),
            **({"use": use_of_limit(row.use)} if judged else {}),
        },
        note="F holds cable, drag of the hull and buoyancy at that place.",
    )


def _parts(
    name: str, force_n: Sequence[float], decimals: int = 0, *, whole: bool = False
) -> dict[str, str]:
    """Write a force by its parts, and its size where that is wanted."""
    cells = {f"{name}{axis}": fixed(v, decimals) for axis, v in zip("xyz", force_n, strict=True)}
    size = {f"|{name}|": fixed(float(np.linalg.norm(force_n)), decimals)}
    return cells | (size if whole else {})


@chapter("drive", "Control forces and power")
def needs_section(found: TetherDesign) -> Blocks:
    """Show the forces and the power that the cable asks for."""

    def of(basis: str) -> dict[str, str]:
        return {"From": basis if basis == "printed pulls" else f"flow {basis}"}

    def watts(what: str, power_w: Sequence[float]) -> dict[str, str]:
        cells = {f"{what} {axis}": fixed(v, 0) for axis, v in zip("XYZ", power_w, strict=True)}
        return {**cells, f"{what}, sum": fixed(sum(power_w), 0)}

    yield Table.of(
        "Largest pull, drag of the hull, needed force, eqs. (3) and (4), N",
        found.needs,
        lambda n: of(n.basis) | _parts("T_", n.pull_n, 1) | _parts("R_", n.drag_n, 1)
        | _parts("F_", n.force_n, 1),
    )  # fmt: skip
    yield Table.of(
        "Towing and consumed power, eqs. (5) and (6), W",
        found.needs,
        lambda n: (
            of(n.basis) | watts("towing", n.towing_power_w) | watts("consumed", n.consumed_power_w)
        ),
    )


@chapter("held", lambda held: f"Footprint that {held.vehicle} can hold")
def held_section(held: HeldFootprint) -> Blocks:
    """Show how far from the garage a vehicle holds its place."""
    ahead, astern, up, down, starboard, port = (fixed(n, 0) for n in held.largest_force_n)
    yield Text(
        f"Largest thrust at rest without turning: {ahead} N ahead, {astern} N astern, {up} N up, "
        f"{down} N down, {starboard} N to starboard and {port} N to port. Roll and pitch are left "
        "to weight and buoyancy."
    )
    angle = np.array([*held.angle_deg, held.angle_deg[0] + 360.0])
    radius = np.array([*held.held_radius_m, held.held_radius_m[0]])
    trace = Trace("", angle, radius, plotting.VERMILLION, "both", mark="o")
    yield zoomable_figure(
        "held",
        f"{held.vehicle} holds {fixed(float(radius.min()), 1)} m in the worst direction and "
        f"{fixed(float(radius.max()), 1)} m in the best.",
        "Within this radius the thrusters hold cable, current and buoyancy. Angle from Z "
        "(starboard) towards X (ahead).",
        (Panel("radius  [m]", (trace,), height=1.7, from_zero=True),),
        x_label="angle  [deg]",
    )
    table = Table.of(
        "Radius that is held",
        zip(held.angle_deg, held.held_radius_m, held.limit, strict=True),
        "Angle, deg: {0:.0f} | radius, m: {1:.1f} | ends with: {2}",
    )
    yield Details("Radius that is held", (table,))


def _pull_figure(found: TetherDesign) -> Figure:
    traces, worst = [], (0.0, 0.0)
    for variant in found.variants:
        angles = np.array([row.angle_deg for row in variant.rows])
        pull = np.array([float(np.linalg.norm(row.on_vehicle_n)) for row in variant.rows])
        chosen = variant.variant == found.variant
        if chosen:
            worst = (float(angles[pull.argmax()]), float(pull.max()))
        x, y = np.append(angles, 360.0), np.append(pull, pull[0])
        colour, width = _COLOURS[variant.variant], 2.0 if chosen else 1.1
        traces.append(Trace(f"flow {variant.variant}", x, y, colour, width=width))
    printed = [row for row in found.printed if row.quantity.startswith("|T_a| at")]
    if printed:
        at = np.array([float(row.quantity.split()[2]) for row in printed])
        values = np.array([row.printed for row in printed])
        traces.append(Trace("printed", at, values, plotting.INK, "points"))
    more = (
        " One line for each reading of how the vehicle's own speed falls off along the cable."
        if len(found.variants) > 1
        else ""
    )
    return zoomable_figure(
        "pull",
        f"The cable pulls hardest at {fixed(worst[0], 0)} deg: {fixed(worst[1], 1)} N with the "
        f"flow '{found.variant}'.",
        f"Angle from Z (starboard) towards X (ahead).{more}",
        (Panel("pull on the\nvehicle  [N]", traces, height=1.9, from_zero=True),),
        x_label="place on the edge, angle  [deg]",
    )


def _shapes_figure(found: TetherDesign) -> Figure:
    plan, side = [], []
    colours = plotting.ordered_colours(len(found.shapes))
    for shape, colour in zip(found.shapes, colours, strict=True):
        x, y, z = (np.array(values) for values in (shape.x_m, shape.y_m, shape.z_m))
        plan.append(Trace(f"{fixed(shape.angle_deg, 0)} deg", x, z, colour))
        plan.append(Trace("", x[:1], z[:1], colour, "points", mark="o"))
        side.append(Trace("", x, y, colour))
    turn = np.linspace(0, 2 * np.pi, 100)
    edge = (found.radius_m * np.sin(turn), found.radius_m * np.cos(turn))
    plan.append(Trace("edge", *edge, plotting.SOFT, dash="dash"))
    return zoomable_figure(
        "shapes",
        "The flow carries the slack of the cable away; the ends pull along the last metres of it.",
        "The garage is at zero; dots: the vehicle. Dashed: the footprint's edge. Above: from "
        f"above; below: from the side. Flow '{found.variant}'.",
        (Panel("Z, starboard  [m]", plan, height=1.9), Panel("Y, up  [m]", side, height=1.3)),
        x_label="X, ahead  [m]",
    )
