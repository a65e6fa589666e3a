"""Figures of the tether calculation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.design import FootprintVariant, HeldFootprint, TetherDesign
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import fixed

if TYPE_CHECKING:
    import matplotlib.figure

_VARIANT_COLOURS = {
    "paper": plotting.BLUE,
    "uniform": plotting.VERMILLION,
    "vector": plotting.GREEN,
}


def _pull(variant: FootprintVariant) -> list[float]:
    return [float(np.linalg.norm(row.on_vehicle_n)) for row in variant.rows]


def pull_figure(found: TetherDesign) -> Figure:
    """Draw |T_a| around the footprint's edge for each flow, printed values as points."""
    chosen = next(v for v in found.variants if v.variant == found.variant)
    worst = max(chosen.rows, key=lambda row: float(np.linalg.norm(row.on_vehicle_n)))

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for variant in found.variants:
            angles = [row.angle_deg for row in variant.rows]
            axes.plot(
                [*angles, 360.0],
                [*_pull(variant), _pull(variant)[0]],
                color=_VARIANT_COLOURS[variant.variant],
                lw=2.0 if variant is chosen else 1.1,
                label=f"flow {variant.variant}",
            )
        printed = [row for row in found.printed if row.quantity.startswith("|T_a| at")]
        if printed:
            at = [float(row.quantity.split()[2]) for row in printed]
            axes.plot(at, [row.printed for row in printed], "k.", ms=6, label="printed")
        axes.set(xlabel="place on the edge, angle  [deg]", ylabel="pull on the vehicle  [N]")
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 60))
        axes.set_ylim(bottom=0)
        plotting.legend_above(figure, axes, columns=2)

    return Figure(
        "pull",
        f"The cable pulls hardest at {fixed(worst.angle_deg, 0)} deg: "
        f"{fixed(float(np.linalg.norm(worst.on_vehicle_n)), 1)} N with the flow '{found.variant}'.",
        plotting.draw("pull", "Pull of the cable on the vehicle around the footprint.", paint),
        "Angle from Z (starboard) towards X (ahead)."
        + (
            " One line for each reading of how the vehicle's own speed falls off along the cable."
            if len(found.variants) > 1
            else ""
        ),
    )


def shapes_figure(found: TetherDesign) -> Figure:
    """Draw the cable from above and from the side."""

    def paint(figure: matplotlib.figure.Figure) -> None:
        plan, side = figure.subplots(2, 1, sharex=True, height_ratios=(1.3, 1))
        colours = plotting.ordered_colours(len(found.shapes))
        for shape, colour in zip(found.shapes, colours, strict=True):
            label = f"{fixed(shape.angle_deg, 0)} deg"
            plan.plot(shape.x_m, shape.z_m, color=colour, label=label)
            side.plot(shape.x_m, shape.y_m, color=colour)
            plan.plot(shape.x_m[0], shape.z_m[0], "o", color=colour, ms=5)
            side.plot(shape.x_m[0], shape.y_m[0], "o", color=colour, ms=5)
        turn = np.linspace(0, 2 * np.pi, 100)
        plan.plot(
            found.radius_m * np.sin(turn),
            found.radius_m * np.cos(turn),
            "--",
            color=plotting.SOFT,
            lw=0.8,
        )
        for axes in (plan, side):
            axes.plot(0, 0, "s", color=plotting.INK, ms=5)
            axes.set_aspect("equal", adjustable="box")
        plan.set(ylabel="Z, starboard  [m]")
        side.set(xlabel="X, ahead  [m]", ylabel="Y, up  [m]")
        plotting.legend_above(figure, plan, columns=4)

    return Figure(
        "shapes",
        "The flow carries the slack of the cable away; the ends pull along the last metres of it.",
        plotting.draw("shapes", "Cable from above and from the side.", paint, height_in=5.6),
        "Square: garage. Ring: vehicle. Dashed: the footprint's edge. Above: from above; below: "
        f"from the side. Flow '{found.variant}'.",
    )


def held_figure(held: HeldFootprint) -> Figure:
    """Draw the map of the thrusters' use and the edge that is held."""
    low, high = min(held.held_radius_m), max(held.held_radius_m)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        angles = np.radians([*held.angle_deg, held.angle_deg[0] + 360.0])
        use = np.array([*held.use, held.use[0]])
        use = np.column_stack([use[:, :1], use])  # the centre as the first ring
        a, r = np.meshgrid(angles, (0.0, *held.radius_m), indexing="ij")
        filled = axes.contourf(
            r * np.sin(a),
            r * np.cos(a),
            np.clip(use, 0.0, 1.49),
            levels=np.linspace(0.0, 1.5, 16),
            cmap="viridis_r",
        )
        fine = np.linspace(angles[0], angles[-1], 181)
        edge = np.interp(fine, angles, [*held.held_radius_m, held.held_radius_m[0]])
        axes.plot(edge * np.sin(fine), edge * np.cos(fine), color=plotting.VERMILLION, lw=2)
        axes.plot(0, 0, "s", color=plotting.INK, ms=5)
        axes.set_aspect("equal")
        axes.set(xlabel="X, ahead  [m]", ylabel="Z, starboard  [m]")
        figure.colorbar(filled, ax=axes, label="use of the thrusters  [–]")

    return Figure(
        "held",
        f"{held.vehicle} holds {fixed(low, 1)} m in the worst direction and {fixed(high, 1)} m in "
        "the best.",
        plotting.draw(
            "held", "Map of the thrusters' use over the footprint.", paint, height_in=3.8
        ),
        "From above. Within the red line the thrusters hold cable, current and buoyancy; colour: "
        "the share of the most loaded thruster at its best allocation.",
    )
