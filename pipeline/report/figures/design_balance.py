"""Figures of the balance calculation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.design import BalanceDesign
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import fixed, general

if TYPE_CHECKING:
    import matplotlib.figure


def loads_figure(found: BalanceDesign) -> Figure:
    """Draw the load of each thruster with its limit, exact and, if there is one, small-angle."""
    exact, small = found.exact, found.small_angle
    most = max(exact.loads, key=lambda load: abs(load.thrust_n))

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        at = np.arange(len(exact.loads))
        axes.bar(
            at - (0.0 if small is None else 0.18),
            [one.thrust_n for one in exact.loads],
            0.34,
            color=plotting.BLUE,
            label="exact",
        )
        if small is not None:
            axes.bar(
                at + 0.18,
                [one.thrust_n for one in small.loads],
                0.34,
                color=plotting.ORANGE,
                label="small angle",
            )
        label = "limit"
        for k, one in enumerate(exact.loads):
            if one.limit_n is not None:
                sign = -1.0 if one.thrust_n < 0 else 1.0
                axes.hlines(
                    sign * one.limit_n, k - 0.4, k + 0.4, colors=plotting.INK, lw=1.5, label=label
                )
                label = "_"
        axes.axhline(0.0, color=plotting.SOFT, lw=0.8)
        axes.set_xticks(at, [one.thruster for one in exact.loads])
        axes.set(ylabel="thrust  [N]")
        axes.grid(visible=False, axis="x")
        plotting.legend_above(figure, axes)

    text = "The buoyancy is carried by an angle of attack; making it loads the thrusters unevenly."
    return Figure(
        "loads",
        f"The {most.thruster} thruster carries most, {fixed(most.thrust_n, 1)} N.",
        plotting.draw(
            "loads",
            "Bars: thrust of each stern thruster, exact."
            if small is None
            else "Bars: thrust of each stern thruster, exact and small angle.",
            paint,
        ),
        text,
    )


def use_figure(found: BalanceDesign) -> Figure:
    """Map the largest use (or load) over speed and buoyancy at the design's thruster angle."""
    envelope = found.envelope
    k = int(np.argmin(np.abs(np.array(envelope.angle_deg) - found.angle_deg)))
    judged = bool(found.limit_kind)
    values = np.array(envelope.use if judged else envelope.largest_load_n)[:, :, k]
    shown = np.where(np.array(envelope.largest_load_n)[:, :, k] > 0, values, np.nan)
    name = "use of the most loaded thruster  [–]" if judged else "largest load  [N]"
    there = shown[np.isfinite(shown)]
    least, top = (float(there.min()), float(there.max())) if there.size else (0.0, 0.0)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        levels = np.arange(0.0, min(2.0, max(1.2, top)) + 0.1, 0.1) if judged else 12
        filled = axes.contourf(
            envelope.residual_buoyancy_n,
            envelope.speed_mps,
            np.ma.masked_invalid(np.clip(shown, None, 2.0) if judged else shown),
            levels=levels,
            cmap="viridis_r",
            extend="max" if judged else "neither",
        )
        if judged and least < 1.0 < top:
            axes.contour(
                envelope.residual_buoyancy_n,
                envelope.speed_mps,
                np.ma.masked_invalid(shown),
                levels=[1.0],
                colors=plotting.VERMILLION,
                linewidths=2.0,
            )
        axes.plot(
            found.residual_buoyancy_n, found.speed_mps, "o", ms=7, mfc="white", mec=plotting.INK
        )
        axes.set(xlabel="residual buoyancy, up  [N]", ylabel="speed  [m/s]")
        axes.grid(visible=False)
        figure.colorbar(filled, ax=axes, label=name)

    return Figure(
        "use-map",
        _of_the_map(least, top, judged=judged, empty=not there.size),
        plotting.draw("use-map", "Map of the thrusters' use over buoyancy and speed.", paint),
        f"Thrusters at {general(envelope.angle_deg[k])} deg, the nearest of the envelope to the "
        f"design's {general(found.angle_deg)} deg. The ring is the design point."
        + (f" Limit: {found.limit_kind}." if judged else ""),
    )


def _of_the_map(least: float, top: float, *, judged: bool, empty: bool) -> str:
    """Say what the map shows; the red line is there only where the use passes 1."""
    if empty:
        return "Nowhere on the map does an angle of attack balance force and moment."
    if not judged:
        return "The load of the most loaded thruster over speed and buoyancy."
    if top <= 1.0:
        return "No thruster comes to its limit anywhere on the map."
    if least >= 1.0:
        return "The most loaded thruster is beyond its limit everywhere on the map."
    return "Beyond the red line the most loaded thruster has nothing left."


def angle_figure(found: BalanceDesign) -> Figure:
    """Draw the largest load over the thrusters' angle for several buoyancies."""
    envelope = found.envelope
    i = int(np.argmin(np.abs(np.array(envelope.speed_mps) - found.speed_mps)))
    load = np.array(envelope.largest_load_n)[i]
    last = len(envelope.residual_buoyancy_n) - 1
    chosen = sorted({last // 2, last * 3 // 4, last})

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for j, colour in zip(chosen, plotting.ordered_colours(len(chosen)), strict=True):
            shown = np.where(load[j] > 0, load[j], np.nan)
            label = f"{general(envelope.residual_buoyancy_n[j])} N"
            axes.plot(envelope.angle_deg, shown, "o-", color=colour, label=label)
        axes.axvline(found.angle_deg, color=plotting.SOFT, lw=0.8, ls="--")
        axes.set(xlabel="angle of the thrusters to the axis  [deg]", ylabel="largest load  [N]")
        plotting.legend_above(figure, axes, columns=4)

    return Figure(
        "angle",
        "A larger angle gives more vertical force for the same thrust and costs thrust ahead.",
        plotting.draw("angle", "Largest load over the thrusters' angle, by buoyancy.", paint),
        f"At {general(envelope.speed_mps[i])} m/s; one line for each residual buoyancy, dashed the "
        "design's angle.",
    )
