"""Tables 3 to 6 of Kostenko and Mokeeva 2009 beside what was computed."""

from collections.abc import Sequence

import numpy as np

from pipeline.design.printed import compare, rounding, unknown_quantities
from pipeline.design.tether_input import TetherInput
from pipeline.physics.tether_footprint import largest_pull
from pipeline.records.design import DriveNeed, FootprintVariant, Printed


def printed_tables(
    one: TetherInput, variants: Sequence[FootprintVariant], needs: Sequence[DriveNeed]
) -> tuple[tuple[Printed, ...], tuple[str, ...]]:
    """Put Tables 3 to 6 beside ours; Table 3 beside the chosen flow."""
    if one.published is None:
        return (), ()
    chosen = next(v for v in variants if v.variant == one.flow)
    by_angle = {row.angle_deg: row for row in chosen.rows}
    found: list[Printed] = []
    skipped = []
    for angle, *values in one.published.footprint:
        row = by_angle.get(angle)
        if row is None:
            skipped.append(f"{angle:g}")
            continue
        ours = [
            *row.on_garage_n,
            float(np.linalg.norm(row.on_garage_n)),
            *row.on_vehicle_n,
            float(np.linalg.norm(row.on_vehicle_n)),
        ]
        names = [f"{t} at {angle:g} deg" for t in _TABLE_3]
        found += [
            Printed(
                table=one.published.footprint_table,
                quantity=name,
                unit="N",
                printed=value,
                computed=our,
                rounding=rounding(value),
                reason=one.published.footprint_reason,
            )
            for name, value, our in zip(names, values, ours, strict=True)
        ]
    known = _known(variants, needs, one)
    rows, unknown = compare(one.published, known)
    warnings = unknown_quantities(unknown, known)
    if skipped:
        warnings += (f"published.footprint: no place is computed at {', '.join(skipped)} deg.",)
    return (*found, *rows), warnings


_TABLE_3 = ("T_nx", "T_ny", "T_nz", "|T_n|", "T_ax", "T_ay", "T_az", "|T_a|")


def _known(
    variants: Sequence[FootprintVariant], needs: Sequence[DriveNeed], one: TetherInput
) -> dict[str, tuple[float, str]]:
    """Name the quantities of Tables 4 to 6: from the printed pulls, and from ours by flow."""
    known: dict[str, tuple[float, str]] = {}
    stated = one.published.footprint if one.published is not None else ()
    if stated:  # Table 4 follows from the printed Table 3
        pulls = largest_pull(np.array([row[5:8] for row in stated]))
        whole = max(abs(row[8]) for row in stated)
        for axis, value in zip("xyz", pulls[:3], strict=True):
            known[f"largest_pull_{axis}_n"] = (value, "N")
        known["largest_pull_n"] = (whole, "N")
    for variant in variants:
        for axis, value in zip(("_x", "_y", "_z", ""), variant.largest_pull_n, strict=True):
            known[f"largest_pull{axis}_n_{variant.variant}"] = (value, "N")
    for need in needs:
        suffix = "" if need.basis == "printed pulls" else f"_{need.basis}"
        for k, axis in enumerate("xyz"):
            known[f"drag_{axis}_n{suffix}"] = (need.drag_n[k], "N")
            known[f"force_{axis}_n{suffix}"] = (need.force_n[k], "N")
            known[f"towing_{axis}_w{suffix}"] = (need.towing_power_w[k], "W")
            known[f"consumed_{axis}_w{suffix}"] = (need.consumed_power_w[k], "W")
        known[f"towing_w{suffix}"] = (sum(need.towing_power_w), "W")
        known[f"consumed_w{suffix}"] = (sum(need.consumed_power_w), "W")
    return known
