"""The allocator's error map and its worst error by speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.allocation import AllocationMap
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import fixed, general, percent, speed
from pipeline.types import BoolArray

if TYPE_CHECKING:
    import matplotlib.figure


BEYOND_REACH = "0.82"
"""Grey of the demands that the thrusters cannot meet even with compensation."""


def within_reach(allocation: AllocationMap) -> tuple[BoolArray, BoolArray]:
    """Tell which demands of the slices no limit cuts, surge and yaw, each [speed][demand].

    A demand beyond it is clipped, and an error against the clipped demand says nothing about what
    was asked. Reverse surge needs thrust against the motion, whose limit is that at rest.
    """
    surge, yaw = np.asarray(allocation.surge_demand_n), np.asarray(allocation.yaw_demand_nm)
    speeds = len(allocation.speed_mps)
    shares = allocation.portions[:2] if allocation.form == "scaled" else (1.0, 1.0)
    # a demand exactly at the limit is within reach in spite of rounding
    most, turn = (
        np.asarray(reach or (np.inf,) * speeds)[:, None] / max(share, 1e-9) * (1.0 + 1e-9)
        for reach, share in zip(
            (allocation.surge_reach_n, allocation.yaw_reach_nm), shares, strict=True
        )
    )
    return surge[None, :] <= most, np.abs(yaw)[None, :] <= turn


def error_map_figure(allocation: AllocationMap) -> Figure:
    """Error of surge force and yaw moment over demand and speed, both variants, one scale."""
    speeds = np.asarray(allocation.speed_mps)
    surge_within, yaw_within = within_reach(allocation)
    moored = np.ma.masked_where(~surge_within, np.asarray(allocation.surge_error_mooring))
    compensated = np.ma.masked_where(~surge_within, np.asarray(allocation.surge_error_compensated))
    size = np.abs(moored).filled(0.0)
    row, column = (int(at) for at in np.unravel_index(int(np.argmax(size)), size.shape))
    lead = (
        f"Asked for {fixed(allocation.surge_demand_n[column], 0)} N of surge at "
        f"{speed(float(speeds[row]))} m/s, which is within reach, the mooring inverse misses by "
        f"{fixed(float(size[row, column]), 1)} N; with compensation the largest miss within reach "
        f"is {general(float(np.abs(compensated).max()), 2)} N."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots(2, 2, sharey=True)
        rows = (
            (
                allocation.surge_demand_n,
                moored,
                compensated,
                "surge demand X  [N]",
                "error of X  [N]",
            ),
            (
                allocation.yaw_demand_nm,
                np.ma.masked_where(~yaw_within, np.asarray(allocation.yaw_error_mooring)),
                np.ma.masked_where(~yaw_within, np.asarray(allocation.yaw_error_compensated)),
                "yaw demand N  [N m]",
                "error of N  [N m]",
            ),
        )
        for line, (demand, left, right, xlabel, label) in zip(axes, rows, strict=True):
            limit = max(float(np.abs(left).max()), float(np.abs(right).max()), 1e-9)
            for one, values in zip(line, (left, right), strict=True):
                one.pcolormesh(
                    np.asarray(demand),
                    speeds,
                    values,
                    cmap="RdBu_r",
                    vmin=-limit,
                    vmax=limit,
                    shading="nearest",
                    rasterized=True,
                )
                one.set_facecolor(BEYOND_REACH)
                one.grid(visible=False)
                one.set_xlabel(xlabel)
                one.locator_params(axis="x", nbins=4)
            line[0].set_ylabel("speed V  [m/s]")
            figure.colorbar(line[1].collections[0], ax=line, label=label, pad=0.02, aspect=14)
        axes[0][0].set_title("mooring inverse")
        axes[0][1].set_title("compensated")

    alt = (
        "Four maps of the wrench error over demand and speed: surge above, yaw below; mooring "
        "inverse on the left, compensated on the right, each pair on one colour scale."
    )
    return Figure(
        "fig-error-map",
        lead,
        plotting.draw("fig-error-map", alt, paint, height_in=4.4),
        "Achieved less asked, against the demand (before limits) and the speed. Above: surge force "
        "with no moment asked; below: yaw moment at a surge demand of "
        f"{fixed(allocation.yaw_slice_surge_n, 0)} N. White: no error; grey: beyond what the "
        "thrusters can give at that speed, with compensation or without.",
    )


def error_by_speed_figure(allocation: AllocationMap) -> Figure:
    """Worst error at each speed for both variants, logarithmic."""
    first, last = allocation.mooring[0], allocation.mooring[-1]
    lead = (
        f"Without compensation the worst wrench error grows from {percent(first.worst)} of the "
        f"available range at {speed(first.speed_mps)} m/s to {percent(last.worst)} at "
        f"{speed(last.speed_mps)} m/s; with it, it stays at or below "
        f"{percent(max(error.worst for error in allocation.compensated))}."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for errors, label, colour, marker in (
            (allocation.mooring, "mooring inverse", plotting.VERMILLION, "s"),
            (allocation.compensated, "compensated", plotting.BLUE, "o"),
        ):
            at = [error.speed_mps for error in errors]
            axes.plot(
                at,
                [100 * max(error.worst, 1e-6) for error in errors],
                marker=marker,
                color=colour,
                label=f"{label}, worst",
            )
            axes.plot(
                at,
                [100 * max(error.rms, 1e-6) for error in errors],
                "--",
                marker=marker,
                mfc="none",
                lw=0.9,
                color=colour,
                label=f"{label}, rms",
            )
        plotting.plain_log_axis(axes)
        axes.set(xlabel="speed V  [m/s]", ylabel="wrench error  [% of available range]")
        plotting.legend_above(figure, axes, columns=2)

    alt = "Worst and rms wrench error against speed with and without speed compensation."
    return Figure(
        "fig-error-speed",
        lead,
        plotting.draw("fig-error-speed", alt, paint, height_in=4.4),
        "One number for each speed, over surge, pitch and yaw demands within reach that need no "
        "thrust against the motion.",
    )
