"""Tether of Kostenko and Mokeeva 2009: Tables 3 to 6, what a vehicle holds, what cannot be."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from design_cases import tether

from pipeline.actions.design import held_vehicle
from pipeline.bundled.design import design_example
from pipeline.design.tether_design import design_tether, make_footprint
from pipeline.design.tether_held import MOST_USE, held_footprint
from pipeline.design.tether_input import TetherInput
from pipeline.design.tether_needs import drive_need, hull_drag_vector_n
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import write
from pipeline.physics.tether_footprint import footprint_cable, ned_from_paper
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_checked


def read(name: str, **changes: object) -> TetherInput:
    one = load_checked(design_example("tether", name), TetherInput, expected="", remedy="")
    return TetherInput.model_validate(one.model_dump() | changes)


def with_inflow(packed: PackedVehicle) -> PackedVehicle:
    """The vehicle with thrusters that feel the flow, which rov8's file leaves out."""
    vector = packed.vector.copy()
    write(vector, "inflow_fraction", 1.0)
    return replace(packed, vector=vector)


def test_tables_4_to_6_follow_from_the_printed_pulls() -> None:
    found = tether("mokeeva")
    by = {row.quantity: row for row in found.printed}
    for axis, pull in (("_x", 166), ("_y", 132), ("_z", 107), ("", 213)):
        assert by[f"largest_pull{axis}_n"].computed == pull
    for quantity in ("drag_x_n", "drag_z_n", "force_x_n", "force_z_n", "towing_x_w", "towing_y_w"):
        assert by[quantity].within_rounding
    # the rest within what the paper rounds on the way: 0.6 N, 3 W in the sum
    assert by["force_y_n"].computed == pytest.approx(159.4, abs=0.05)
    assert by["towing_w"].computed == pytest.approx(550.8, abs=0.05)
    assert by["consumed_w"].computed == pytest.approx(1335.3, abs=0.05)


def test_every_printed_number_is_there_and_explained() -> None:
    found = tether("mokeeva")
    table3 = [row for row in found.printed if row.table == "Table 3"]
    assert len(table3) == 8 * 12
    assert all(row.within_rounding or len(row.reason) > 5 for row in found.printed)


def test_our_pulls_are_those_of_the_method_page() -> None:
    pulls = {
        variant.variant: [round(float(np.linalg.norm(r.on_vehicle_n))) for r in variant.rows]
        for variant in tether("mokeeva").variants
    }
    assert pulls["paper"] == [110, 78, 57, 72, 104, 128, 135, 128, 122, 126, 134, 132]
    assert pulls["uniform"] == [210, 138, 91, 123, 195, 251, 268, 254, 241, 250, 267, 259]


def test_the_needed_thrust_balances_cable_drag_and_buoyancy() -> None:
    found = tether("mokeeva")
    area = 0.5 * 1025 * 0.05 ** (2 / 3)
    drag = np.array([-area * 1.0, area * 0.25, -area * 0.25])  # against (1, -0.5, 0.5) m/s
    for row in found.variants[0].rows:
        total = np.array(row.required_n) + row.on_vehicle_n + drag + [0.0, 10.0, 0.0]
        np.testing.assert_allclose(total, 0.0, atol=1e-9)


def test_the_equivalent_effect_makes_the_same_force() -> None:
    found = tether("mokeeva")
    effect = found.equivalent
    assert effect is not None
    row = next(
        r
        for v in found.variants
        if v.variant == found.variant
        for r in v.rows
        if r.angle_deg == effect.angle_deg
    )
    flow = np.array([1.0, -0.5, 0.5])
    angle = np.radians(effect.angle_deg)
    place = np.array([50 * np.sin(angle), -50.0, 50 * np.cos(angle)])
    force = -0.5 * 1025 * effect.drag_area_m2 * np.linalg.norm(
        flow
    ) * flow - effect.pull_n * place / np.linalg.norm(place)
    np.testing.assert_allclose(force, row.on_vehicle_n, atol=0.1)


def test_a_cable_shorter_than_the_distance_is_told_the_largest_radius() -> None:
    one = read("mokeeva")
    short = one.model_copy(update={"cable": one.cable.model_copy(update={"length_m": 60.0})})
    with pytest.raises(CannotComputeError, match=r"can be at most 33.17 m"):
        make_footprint(short)
    shorter = one.model_copy(update={"cable": one.cable.model_copy(update={"length_m": 40.0})})
    with pytest.raises(CannotComputeError, match=r"does not even reach 50 m"):
        make_footprint(shorter)


def test_the_rov_uses_all_of_a_thruster_at_the_edge_that_it_holds(repository: Path) -> None:
    one = read("rov8")
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, pack_vehicle(rov), attachment_m=np.array([-0.2, 0.0, -0.1]))
    footprint = make_footprint(one)
    found = held_footprint(one, footprint, held, [0.0, 90.0])
    assert found.limit[0] == "thrusters"
    at = replace(footprint, radius_m=found.held_radius_m[0])
    pull = footprint_cable(at, one.flow, 0.0).force_on_start_n
    through = ned_from_paper(np.array([0.7, 0.0, 0.0]))
    assert held.use(*held.required(pull, through)) == pytest.approx(1.0, abs=0.02)


def test_a_small_footprint_is_found_within_the_first_radius_of_the_map(repository: Path) -> None:
    """At 0.91 m/s a few metres are held on a cable of 100 m, and the map begins at 14 m."""
    one = read("rov8", current_mps=(-0.91, 0.0, 0.0))
    one = one.model_copy(update={"cable": one.cable.model_copy(update={"length_m": 100.0})})
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, pack_vehicle(rov))
    footprint = make_footprint(one)
    found = held_footprint(one, footprint, held, [0.0])
    radius = found.held_radius_m[0]
    assert found.use[0][0] > 1.0
    assert found.radius_m[0] > radius > 0.0
    pull = footprint_cable(replace(footprint, radius_m=radius), one.flow, 0.0).force_on_start_n
    through = ned_from_paper(np.array([0.91, 0.0, 0.0]))
    assert held.use(*held.required(pull, through)) == pytest.approx(1.0, abs=0.02)


def test_beyond_its_table_a_thruster_gives_less_and_less_as_it_does_in_simulation(
    repository: Path,
) -> None:
    """The bollard law is linear in the speed: half of its table continued is the whole one."""
    rov = bundled(repository, "rov8")
    packed = with_inflow(pack_vehicle(rov))
    rows = packed.thrust_tables.shape[2] // 2
    half = replace(packed, thrust_tables=packed.thrust_tables[:, :, :rows])
    known_mps = (rows - 1) * float(packed.steps[0, 0])
    for share, least_n in ((1.3, 10.0), (1.9, 1.0), (4.0, 0.0)):
        velocity = np.array([share * known_mps / np.sqrt(0.5), 0.0, 0.0])
        whole, part = (held_vehicle(rov, p).limits_n(velocity) for p in (packed, half))
        assert np.array(part) == pytest.approx(np.array(whole), abs=1e-9)
        assert least_n <= np.min(whole) < 39.9


def test_the_largest_forces_are_those_of_the_arrangement(repository: Path) -> None:
    """Four thrusters at 45 degrees: two may only push backwards at 39.9 N when going sideways."""
    rov = bundled(repository, "rov8")
    ahead, astern, up, down, starboard, port = held_vehicle(
        rov, pack_vehicle(rov)
    ).largest_forces_n()
    root = np.sqrt(0.5)
    assert ahead == pytest.approx(4 * 51.4 * root, rel=1e-4)
    assert astern == pytest.approx(4 * 39.9 * root, rel=1e-4)
    assert (up, down) == pytest.approx((4 * 51.4, 4 * 39.9), rel=1e-4)
    assert starboard == pytest.approx(port, rel=1e-6)
    assert starboard == pytest.approx(4 * 39.9 * root, rel=1e-4)


def test_a_current_stronger_than_the_thrusters_is_told_what_they_hold(repository: Path) -> None:
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, pack_vehicle(rov))
    with pytest.raises(CannotComputeError, match=r"thrusters of rov8 hold 0\.9\d+ m/s") as error:
        design_tether(read("rov8", current_mps=(-1.5, 0.0, 0.0)), held)
    speed = float(str(error.value).split("hold ")[1].split()[0])
    # 13.7 v + 141 v^2 = 145.4 N; the weight of 1 N is held by other thrusters
    assert 13.7 * speed + 141 * speed**2 == pytest.approx(4 * 51.4 * np.sqrt(0.5), rel=0.01)


def test_a_flow_in_which_no_thruster_gives_anything_is_no_flow_from_the_side(
    repository: Path,
) -> None:
    """Past 3.8 m/s along a thruster it gives nothing; headed into it the vehicle holds 0.88 m/s."""
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, with_inflow(pack_vehicle(rov)))
    ahead = np.array([100.0, 0.0, 0.0])
    assert held.use(ahead, 0.0, np.array([7.0, 0.0, 0.0])) == MOST_USE
    with pytest.raises(CannotComputeError, match=r"thrusters of rov8 hold 0\.88\d* m/s"):
        design_tether(read("rov8", current_mps=(-7.0, 0.0, 0.0)), held)


def test_a_flow_that_was_not_chosen_may_have_no_equilibrium() -> None:
    place = {"radius_m": 50.0, "height_m": -20.0, "step_deg": 90}
    found = design_tether(read("mokeeva", footprint=place, flow="uniform"))
    assert [variant.variant for variant in found.variants] == ["paper", "uniform"]
    assert {need.basis for need in found.needs} == {"printed pulls", "paper", "uniform"}
    assert any("flow 'vector' is left out" in text for text in found.warnings)
    with pytest.raises(CannotComputeError, match="No equilibrium was found"):
        design_tether(read("mokeeva", footprint=place, flow="vector"))


@pytest.mark.parametrize("heading_deg", [0.0, 45.0, 90.0])
def test_the_needed_force_holds_the_drag_at_the_vehicles_heading(
    repository: Path, heading_deg: float
) -> None:
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, pack_vehicle(rov), heading_rad=float(np.radians(heading_deg)))
    one = read("rov8", current_mps=(-0.4, 0.0, 0.0), current_from_any_side=False)
    needed = drive_need(one, "uniform", (0.0, 0.0, 0.0), held)
    np.testing.assert_allclose(needed.drag_n, np.abs(hull_drag_vector_n(one, held)), atol=1e-9)
    # abeam the ROV is wider than ahead
    assert (needed.drag_n[0] > 34.0) == (heading_deg == 90.0)
    any_side = drive_need(
        read("rov8", current_mps=(-0.4, 0.0, 0.0)), "uniform", (0.0, 0.0, 0.0), held
    )
    assert any_side.drag_n[0] == pytest.approx(needed.drag_n[0])


def test_a_stated_hull_turns_with_the_vehicle_that_is_held(repository: Path) -> None:
    """Abeam to the current a hull that is wide from the side is pushed by its side's drag."""
    rov = bundled(repository, "rov8")
    held = held_vehicle(rov, pack_vehicle(rov), heading_rad=np.pi / 2)
    hull = {
        "displacement_m3": 0.0115,
        "drag_coefficients": (0.5, 1.0, 2.5),
        "residual_buoyancy_n": 0.0,
    }
    place = {"radius_m": 20.0, "height_m": -20.0, "step_deg": 90}
    one = read("rov8", hull=hull, current_mps=(-0.5, 0.0, 0.0), footprint=place)
    found = design_tether(one, held)
    abeam = 0.5 * one.density_kgpm3 * 2.5 * 0.0115 ** (2 / 3) * 0.5**2
    row = found.variants[0].rows[0]
    np.testing.assert_allclose(row.required_n[0], abeam - row.on_vehicle_n[0], rtol=1e-9)
    assert found.needs[0].drag_n[0] == pytest.approx(abeam)


def test_no_effect_is_named_that_leaves_most_of_the_pull() -> None:
    """A heavy cable at rest hangs on the vehicle: neither drag nor a pull to the garage."""
    one = read("mokeeva", vehicle_velocity_mps=(0.0, 0.0, 0.0), current_mps=(0.0, 0.0, 0.0))
    heavy = one.model_copy(update={"cable": one.cable.model_copy(update={"wet_weight_npm": 0.5})})
    found = design_tether(heavy)
    assert found.equivalent is None
    assert any("cannot stand for this cable" in text for text in found.warnings)
