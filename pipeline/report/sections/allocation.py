"""The allocator's wrench error with and without speed compensation: the thesis of the paper."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.allocation import AllocationMap
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Figure, Paragraph, Table, chapter
from pipeline.report.numbers import fixed, percent, speed
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import explained
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


@chapter("allocation", "Allocator: what the vehicle gets of what it asks for")
def allocation_section(results: VehicleResults) -> Blocks:
    """Show one number for each speed and variant."""
    allocation = results.allocation
    if allocation is None:
        stated = results.missing.get("allocation", "vehicle.yaml describes no allocator.")
        raise CannotComputeError(missing_reasons(results).get("allocation") or stated)
    surge, heading, pitch = (fixed(own, 2) for own in (*allocation.portions, 0.0, 0.0, 0.0)[:3])
    inverses = (
        f" Inverse without compensation: {allocation.mooring_inverse}; "
        f"with it: {allocation.compensated_inverse}."
        if allocation.mooring_inverse and allocation.compensated_inverse
        else ""
    )
    form = (
        "a portion is only the limit of a channel, so a demand within reach is realised"
        if allocation.form == "limit"
        else "eq. (6) as printed: every demand is multiplied by its portion"
    )
    yield _figure(allocation)
    yield Table.of(
        "Wrench error in percent of the available range",
        zip(allocation.mooring, allocation.compensated, strict=True),
        "Speed, m/s: {0.speed_mps:speed} | Worst, mooring inverse: {0.worst:percent} | "
        "Worst, compensated: {1.worst:percent} | Rms, mooring inverse: {0.rms:percent} | "
        "Rms, compensated: {1.rms:percent} | Demands within reach: {1.reachable_share:percent} | "
        "Within reach, opposed to motion: {1.opposed_share:percent}",
        note="One-sided range: the largest surge force, pitch and yaw moment that the thrusters "
        "can make at that speed. Opposed demands need thrust against the motion and are scored "
        "apart. Both shares are of all demands. The worst demands themselves are in "
        "allocation.json.",
    )
    yield Paragraph(
        f"Form: {form}. Portions: surge (Π_x) {surge}, heading (Π_φ) {heading}, pitch (Π_ψ) "
        f"{pitch}.{inverses}"
    )
    yield explained(allocation.explanations)


def _figure(allocation: AllocationMap) -> Figure:
    """Draw the worst error at each speed for both variants, logarithmic."""
    first, last = allocation.mooring[0], allocation.mooring[-1]
    traces = []
    for name, errors, colour, mark in (
        ("mooring inverse", allocation.mooring, plotting.VERMILLION, "s"),
        ("compensated", allocation.compensated, plotting.BLUE, "o"),
    ):
        at, worst, rms = np.array([(one.speed_mps, one.worst, one.rms) for one in errors]).T
        worst, rms = (100 * np.maximum(own, 1e-6) for own in (worst, rms))
        traces += [
            Trace(f"{name}, worst", at, worst, colour, "both", mark=mark),
            Trace(f"{name}, rms", at, rms, colour, "both", mark=mark, dash="dash", hollow=True),
        ]
    return zoomable_figure(
        "fig-error-speed",
        f"Without compensation the worst wrench error grows from {percent(first.worst)} of the "
        f"available range at {speed(first.speed_mps)} m/s to {percent(last.worst)} at "
        f"{speed(last.speed_mps)} m/s; with it, it stays at or below "
        f"{percent(max(error.worst for error in allocation.compensated))}.",
        "One number for each speed, over surge, pitch and yaw demands within reach that need no "
        "thrust against the motion.",
        (Panel("wrench error\n[% of range]", tuple(traces), height=1.9, log=True),),
        x_label="speed V  [m/s]",
    )
