"""What a vehicle on a tether needs: Kostenko and Mokeeva 2009, eqs. (3) to (6), Tables 3 to 6."""

from collections.abc import Sequence

import numpy as np

from pipeline.design.printed import compare, rounding
from pipeline.design.tether_held import HeldVehicle
from pipeline.design.tether_input import TetherInput
from pipeline.errors import CannotComputeError
from pipeline.physics.tether_footprint import (
    hull_drag_n,
    largest_pull,
    ned_from_paper,
    paper_from_ned,
)
from pipeline.records.design import DriveNeed, FootprintVariant, Printed
from pipeline.types import FloatArray


def hull_drag_vector_n(one: TetherInput, held: HeldVehicle | None) -> FloatArray:
    """Force of the water on the hull in the file's flow, paper's axes. [N]."""
    through = np.array(one.vehicle_velocity_mps) - np.array(one.current_mps)
    return hull_force_n(one, held, through)


def hull_force_n(one: TetherInput, held: HeldVehicle | None, through_mps: FloatArray) -> FloatArray:
    """Force of the water on the hull: eq. (4), or at the heading of the vehicle that is held.

    Both `through_mps`, the velocity through the water, and the force are (3,) in the paper's axes.
    [m/s], [N]

    Raises
    ------
    CannotComputeError
        Without hull and vehicle.
    """
    if held is None:
        if one.hull is None:
            raise CannotComputeError("State hull: in the design file.")
        return -np.array(
            [
                hull_drag_n(v, one.hull.displacement_m3, one.density_kgpm3, c)
                for v, c in zip(through_mps, one.hull.drag_coefficients, strict=True)
            ]
        )
    body = held.drag_n(held.to_body(ned_from_paper(through_mps)))
    c, s = np.cos(held.heading_rad), np.sin(held.heading_rad)
    ned = np.array([c * body[0] - s * body[1], s * body[0] + c * body[1], body[2]])
    return paper_from_ned(ned)


def buoyancy_n(one: TetherInput, held: HeldVehicle | None) -> float:
    """Residual buoyancy of file or vehicle, up. [N]."""
    if one.hull is not None:
        return one.hull.residual_buoyancy_n
    return 0.0 if held is None else held.buoyancy_n


def needs_of(
    one: TetherInput, variants: Sequence[FootprintVariant], held: HeldVehicle | None
) -> tuple[DriveNeed, ...]:
    """Tables 5 and 6 from the printed pulls, where there are, and from each of ours."""
    pulls: list[tuple[str, tuple[float, ...]]] = []
    if one.published is not None and one.published.largest_pull_n is not None:
        pulls.append(("printed pulls", one.published.largest_pull_n[:3]))
    pulls += [(one_of.variant, one_of.largest_pull_n[:3]) for one_of in variants]
    return tuple(drive_need(one, basis, (p[0], p[1], p[2]), held) for basis, p in pulls)


def drive_need(
    one: TetherInput,
    basis: str,
    pull_n: tuple[float, float, float],
    held: HeldVehicle | None = None,
) -> DriveNeed:
    r"""Needed forces and powers, eqs. (3) to (6), from the largest pulls.

    .. math:: F_i = T_i + R_i + Q_i, \qquad N_i = F_i V_i, \qquad N_{cons} = N_i / (\eta_p \eta_d)

    Where the current may come from any side, the drag along each axis is that of its own largest
    speed alone.
    """
    own, current = np.abs(one.vehicle_velocity_mps), np.abs(one.current_mps)
    pull = np.array(pull_n)
    if one.current_from_any_side:
        level = float(np.hypot(current[0], current[2]))
        speed = own + np.array([level, current[1], level])
        pull[[0, 2]] = max(pull[0], pull[2])
        along = np.diag(speed)
        drag = np.abs([hull_force_n(one, held, along[k])[k] for k in range(3)])
    else:
        speed = np.abs(np.array(one.vehicle_velocity_mps) - np.array(one.current_mps))
        drag = np.abs(hull_drag_vector_n(one, held))
    force = pull + drag + np.array([0.0, abs(buoyancy_n(one, held)), 0.0])
    towing = force * speed
    return DriveNeed(
        basis=basis,
        pull_n=plain(pull),
        drag_n=plain(drag),
        force_n=plain(force),
        towing_power_w=plain(towing),
        consumed_power_w=plain(
            towing / (one.drive.propeller_efficiency * one.drive.drive_efficiency)
        ),
    )


def plain(values: FloatArray) -> tuple[float, ...]:
    """Return a vector as a record holds it."""
    return tuple(float(v) for v in values)


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
    rows, warnings = compare(one.published, _known(variants, needs, one))
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
