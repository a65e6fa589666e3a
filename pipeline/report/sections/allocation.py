"""The allocator's wrench error with and without speed compensation: the thesis of the paper."""

from pipeline.records.allocation import AllocationMap, SpeedError
from pipeline.report.blocks import (
    Block,
    Details,
    Gallery,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.figures.allocation import error_by_speed_figure, error_map_figure
from pipeline.report.numbers import fixed, percent, speed
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import explained

ANCHOR, TITLE = "allocation", "Allocator: what the vehicle gets of what it asks for"

_FORMS = {
    "limit": "the portion is only the limit of a channel (clip at Π T_max); a demand within reach "
    "is realised. This is the default: the printed form would scale down demands that nothing "
    "prevents",
    "scaled": "eq. (6) as printed: every demand is multiplied by its portion, even when nothing "
    "saturates",
}


def allocation_section(results: VehicleResults) -> Section:
    """Show the error map, one number for each speed and variant, and the frames."""
    allocation = results.allocation
    if allocation is None:
        reason = missing_reasons(results).get("allocation") or results.missing.get(
            "allocation", "vehicle.yaml describes no allocator."
        )
        return not_computed(ANCHOR, TITLE, reason)
    surge, heading, pitch = (*allocation.portions, 0.0, 0.0, 0.0)[:3]
    last_m, last_c = allocation.mooring[-1], allocation.compensated[-1]
    blocks: list[Block] = [
        Gallery((error_map_figure(allocation), error_by_speed_figure(allocation))),
        Paragraph(
            f"At {speed(last_m.speed_mps)} m/s the worst wrench error is "
            f"{percent(last_m.worst)} of the available range without compensation and "
            f"{percent(last_c.worst)} with it, over the demands that are within reach and need no "
            "thrust against the motion."
        ),
        _error_table(allocation),
        Paragraph(
            f"Form: {_FORMS.get(allocation.form, allocation.form)}. Portions: surge (Π_x) "
            f"{fixed(surge, 2)}, heading (Π_φ) {fixed(heading, 2)}, pitch (Π_ψ) {fixed(pitch, 2)}. "
            "Errors are measured against the wrench that this form asks for."
            + _inverses(allocation)
        ),
        Details("Worst demands, opposed thrust and dead band", (_worst_table(allocation),)),
    ]
    if allocation.explanations:
        blocks += explained(allocation.explanations)
    blocks.append(Details("Frames: the paper's and SNAME", (_frame_table(),)))
    return Section(ANCHOR, TITLE, tuple(blocks))


def _inverses(allocation: AllocationMap) -> str:
    if not allocation.mooring_inverse or not allocation.compensated_inverse:
        return ""
    return (
        f" Inverse without compensation: {allocation.mooring_inverse}; "
        f"with it: {allocation.compensated_inverse}."
    )


def _error_table(allocation: AllocationMap) -> Table:
    rows = []
    for moored, compensated in zip(allocation.mooring, allocation.compensated, strict=True):
        rows.append(
            (
                speed(moored.speed_mps),
                percent(moored.worst),
                percent(compensated.worst),
                percent(moored.rms),
                percent(compensated.rms),
                percent(compensated.reachable_share),
                percent(compensated.opposed_share),
            )
        )
    return Table(
        "Wrench error in percent of the available range",
        (
            "Speed, m/s",
            "Worst, mooring inverse",
            "Worst, compensated",
            "Rms, mooring inverse",
            "Rms, compensated",
            "Demands within reach",
            "Within reach, opposed to motion",
        ),
        tuple(rows),
        note="One-sided range: the largest surge force, pitch and yaw moment that the thrusters "
        "can make at that speed. Opposed demands need thrust against the motion and are scored "
        "apart. Both shares are of all demands.",
    )


def _worst_table(allocation: AllocationMap) -> Table:
    rows = [
        _worst_row(name, error)
        for name, errors in (
            ("mooring inverse", allocation.mooring),
            ("compensated", allocation.compensated),
        )
        for error in errors
    ]
    return Table(
        "Where the worst errors are (SNAME: X surge, M pitch, N yaw)",
        (
            "Variant",
            "Speed, m/s",
            "Component",
            "Demand X, M, N",
            "Asked X, M, N",
            "Achieved X, M, N",
            "Worst with dead band",
            "Worst opposed",
        ),
        tuple(rows),
        text_columns=frozenset({2}),
        note="X in N, M and N in N m. Dead band: demands that leave a thruster at or below the "
        "thrust for which code 0 is sent.",
    )


def _worst_row(name: str, error: SpeedError) -> tuple[str, ...]:
    def triple(values: tuple[float, ...]) -> str:
        return ", ".join(fixed(value, 1) for value in values) or "–"

    return (
        name,
        speed(error.speed_mps),
        error.worst_component or "–",
        triple(error.worst_demand),
        triple(error.worst_asked),
        triple(error.worst_achieved),
        percent(error.worst_with_dead_band),
        percent(error.worst_opposed),
    )


def _frame_table() -> Table:
    return Table(
        "Frames",
        (
            "Paper (x forward, y up, z starboard)",
            "SNAME (x forward, y starboard, z down)",
            "Meaning",
        ),
        (
            ("F_x, F_y, F_z", "X, −Z, Y", "surge, heave, sway force"),
            ("M_y", "−N", "yaw moment (heading)"),
            ("M_z", "M", "pitch moment"),
            ("M_x", "K", "roll moment"),
            ("φ, ψ, θ", "ψ, θ, φ", "heading, pitch, roll; signs as the moments"),
            ("Π_x, Π_φ, Π_ψ", "portions surge, heading, pitch", "share of T_max of a channel"),
        ),
        text_columns=frozenset({1, 2}),
        note="This report uses SNAME except in the tables that reproduce the paper's.",
    )
