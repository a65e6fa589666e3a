"""The whole tether calculation: Kostenko and Mokeeva 2009, Tables 2 to 6, and what can be held."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from pipeline.design.tether_held import HeldVehicle, held_footprint
from pipeline.design.tether_input import TetherInput
from pipeline.design.tether_needs import (
    buoyancy_n,
    hull_drag_vector_n,
    needs_of,
    plain,
    printed_tables,
)
from pipeline.errors import CannotComputeError
from pipeline.physics.tether_cable import Cable, TetherSolution
from pipeline.physics.tether_footprint import (
    VARIANTS,
    Footprint,
    Variant,
    footprint_cable,
    hull_drag_n,
    largest_pull,
    ned_from_paper,
    paper_from_ned,
)
from pipeline.records.design import (
    CableShape,
    EquivalentEffect,
    FootprintRow,
    FootprintVariant,
    TetherDesign,
)
from pipeline.types import FloatArray

SHAPES_AT_DEG = (0.0, 90.0, 180.0, 270.0)
#: An equivalent effect that leaves more than this share of the pull stands for nothing.
LARGEST_SHARE_LEFT = 0.1


def make_footprint(one: TetherInput) -> Footprint:
    """Turn the input into the physics' terms.

    Raises
    ------
    CannotComputeError
        When the cable is shorter than the distance; the text has the largest radius.
    """
    cable = one.cable
    distance = float(np.hypot(one.footprint.radius_m, one.footprint.height_m))
    if cable.length_m <= distance * (1 + 1e-7):
        depth = abs(one.footprint.height_m)
        reach = float(np.sqrt(max(cable.length_m**2 - depth**2, 0.0)))
        text = (
            f"at this height the radius can be at most {reach:.4g} m"
            if reach > 0
            else f"it does not even reach {depth:g} m straight"
        )
        raise CannotComputeError(
            f"The cable is {cable.length_m:g} m long and the footprint's edge is {distance:.4g} m "
            f"from the garage: {text}.\nPay out more cable or take a smaller footprint."
        )
    return Footprint(
        Cable(
            cable.length_m,
            cable.diameter_m,
            cable.normal_drag,
            cable.tangential_drag,
            cable.wet_weight_npm,
        ),
        one.footprint.radius_m,
        one.footprint.height_m,
        one.vehicle_velocity_mps,
        one.current_mps,
        one.density_kgpm3,
    )


def design_tether(one: TetherInput, held: HeldVehicle | None = None) -> TetherDesign:
    """Compute what ``rig2sea design tether`` shows, of a file and the vehicle that it names.

    Raises
    ------
    CannotComputeError
        For a cable that does not reach, a current stronger than the thrusters, a cable without an
        equilibrium in the chosen flow; the text gives the limiting figure.
    """
    footprint = make_footprint(one)
    angles = [float(a) for a in range(0, 360, one.footprint.step_deg)]
    if held is not None and one.hull is not None:  # what the file states goes before the vehicle's
        held = _with_stated_hull(one, held)
    drag, lift = hull_drag_vector_n(one, held), buoyancy_n(one, held)
    held_map = None if held is None else held_footprint(one, footprint, held, angles)
    moves = any(one.vehicle_velocity_mps)
    looked_at = VARIANTS if moves else (one.flow,)  # at rest all three flows are the same
    solutions, left_out = _solve(one, footprint, looked_at, angles)
    through = ned_from_paper(np.array(one.vehicle_velocity_mps) - np.array(one.current_mps))
    variants = tuple(
        _variant(variant, angles, solutions[variant], drag, lift, held, through)
        for variant in solutions
    )
    needs = needs_of(one, variants, held)
    printed, unknown = printed_tables(one, variants, needs)
    chosen = next(variant for variant in variants if variant.variant == one.flow)
    equivalent, far = _equivalent(one, footprint, chosen)
    return TetherDesign(
        name=one.name,
        title=one.title,
        source=one.source,
        variant=one.flow,
        length_m=one.cable.length_m,
        radius_m=one.footprint.radius_m,
        height_m=one.footprint.height_m,
        vehicle_velocity_mps=one.vehicle_velocity_mps,
        current_mps=one.current_mps,
        density_kgpm3=one.density_kgpm3,
        variants=variants,
        needs=needs,
        shapes=_shapes(footprint, one, angles, solutions[one.flow]),
        held=held_map,
        equivalent=equivalent,
        printed=printed,
        published_source=one.published.source if one.published else "",
        warnings=(*left_out, *far, *unknown),
    )


def _solve(
    one: TetherInput, footprint: Footprint, looked_at: Sequence[Variant], angles: Sequence[float]
) -> tuple[dict[Variant, list[TetherSolution]], tuple[str, ...]]:
    """Solve every place in every flow; one that was not chosen may fail, with a warning."""
    solutions: dict[Variant, list[TetherSolution]] = {}
    warnings = []
    for variant in looked_at:
        try:
            solutions[variant] = [footprint_cable(footprint, variant, angle) for angle in angles]
        except CannotComputeError as error:
            if variant == one.flow:
                raise
            left_out = f"The flow '{variant}' is left out; '{one.flow}' was chosen."
            warnings.append(" ".join([left_out, str(error).splitlines()[0]]))
    return solutions, tuple(warnings)


def _with_stated_hull(one: TetherInput, held: HeldVehicle) -> HeldVehicle:
    assert one.hull is not None  # noqa: S101 - the caller asked
    x, y, z = (
        hull_drag_n(1.0, one.hull.displacement_m3, one.density_kgpm3, c)
        for c in one.hull.drag_coefficients
    )
    return replace(
        held,
        linear=np.zeros(3),
        quadratic=np.array([x, z, y]),
        buoyancy_n=one.hull.residual_buoyancy_n,
    )


def _variant(  # noqa: PLR0917
    variant: str,
    angles: Sequence[float],
    solutions: Sequence[TetherSolution],
    drag: FloatArray,
    lift: float,
    held: HeldVehicle | None,
    through_ned: FloatArray,
) -> FootprintVariant:
    rows = []
    pulls = []
    for angle, solution in zip(angles, solutions, strict=True):
        pull = paper_from_ned(solution.force_on_start_n)
        pulls.append(pull)
        use = None
        if held is not None:
            use = held.use(*held.required(solution.force_on_start_n, through_ned))
        rows.append(
            FootprintRow(
                angle_deg=angle,
                on_vehicle_n=plain(pull),
                on_garage_n=plain(paper_from_ned(solution.force_on_end_n)),
                required_n=plain(-pull - drag - np.array([0.0, lift, 0.0])),
                use=use,
            )
        )
    return FootprintVariant(
        variant=variant, rows=tuple(rows), largest_pull_n=largest_pull(np.array(pulls))
    )


def _shapes(
    footprint: Footprint,
    one: TetherInput,
    angles: Sequence[float],
    solutions: Sequence[TetherSolution],
) -> tuple[CableShape, ...]:
    shapes = []
    for angle in SHAPES_AT_DEG:
        at = [k for k, a in enumerate(angles) if a == angle]
        solution = solutions[at[0]] if at else footprint_cable(footprint, one.flow, angle)
        place = paper_from_ned(solution.position_m)[::2]
        shapes.append(
            CableShape(
                angle_deg=angle,
                x_m=plain(place[:, 0]),
                y_m=plain(place[:, 1]),
                z_m=plain(place[:, 2]),
                tension_n=plain(solution.tension_size_n[::2]),
            )
        )
    return tuple(shapes)


def _equivalent(
    one: TetherInput, footprint: Footprint, variant: FootprintVariant
) -> tuple[EquivalentEffect | None, tuple[str, ...]]:
    """Return drag area and pull of the effect `tether` that come nearest at the worst place.

    None, with a warning, where what is nearest is still far: the effect knows no hanging weight.
    """
    row = max(variant.rows, key=lambda r: float(np.linalg.norm(r.on_vehicle_n)))
    through = np.array(one.vehicle_velocity_mps) - np.array(one.current_mps)
    size = float(np.linalg.norm(through))
    place = footprint.position_m(row.angle_deg)
    columns = np.column_stack(
        [-0.5 * one.density_kgpm3 * size * through, -place / np.linalg.norm(place)]
    )
    pull = np.array(row.on_vehicle_n)
    (area, towards), left = nnls(columns, pull)
    whole = float(np.linalg.norm(pull))
    if left > LARGEST_SHARE_LEFT * whole:
        text = (
            f"The effect `tether` cannot stand for this cable in simulation: of its {whole:.4g} N "
            f"on the vehicle at {row.angle_deg:.0f} deg, drag against the flow and a pull towards "
            f"the garage leave {left:.3g} N over."
        )
        return None, (text,)
    effect = EquivalentEffect(
        angle_deg=row.angle_deg,
        drag_area_m2=float(area),
        pull_n=float(towards),
        text=(
            f"--effect tether:drag_area_m2={area:.3g},pull_n={towards:.3g} meets the cable's force "
            f"on the vehicle at {row.angle_deg:.0f} deg within {max(left, 0.01):.2g} N of "
            f"{whole:.4g} N."
        ),
    )
    return effect, ()
