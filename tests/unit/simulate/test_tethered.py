"""Vehicle and tether together: action and reaction, energy, frames, winch, and what is refused."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.physics.winch import Winch
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.run import initial_state, run
from pipeline.simulate.tether import LumpedMassTether, TetherState
from pipeline.simulate.tethered import fly_tethered
from pipeline.vehicle.attachment_schema import Tether

Make = Callable[..., PackedVehicle]
POINT = (0.4, -0.1, -0.2)
SECTION = Tether(
    attachment_m=POINT,
    anchor_ned_m=(0.0, 0.0, 0.0),
    length_m=30.0,
    diameter_m=0.01,
    mass_kgpm=0.12,
    axial_stiffness_n=2e4,
    segments=12,
)
START = initial_state(position_ned_m=(18.0, 4.0, 12.0), attitude_rad=(0.1, -0.2, 0.7))
NO_DAMPING = {"linear_damping": np.zeros((6, 6)), "quadratic_damping": np.zeros(6)}


@pytest.fixture
def packed(make_packed: Make) -> PackedVehicle:
    return make_packed(tether_point=POINT)


def codes(steps: int, *values: float) -> np.ndarray:
    return np.tile(np.array([*values, *[0.0] * (5 - len(values))]), (steps, 1))


def lumped(**numbers: float) -> LumpedMassTether:
    values: dict[str, float] = {
        "diameter_m": 0.01,
        "mass_kgpm": 0.12,
        "normal_drag": 1.2,
        "tangential_drag": 0.01,
        "axial_stiffness_n": 2e4,
        "density_kgpm3": 1000.0,
        "gravity_mps2": 9.81,
    }
    return LumpedMassTether(30.0, 12, **(values | numbers))


def test_the_wrench_that_is_reported_is_what_moves_the_vehicle(packed: PackedVehicle) -> None:
    """The vehicle alone, with that wrench from outside, accelerates in the same way."""
    flown, tether = fly_tethered(packed, codes(100, 40.0, 60.0, 80.0), SECTION, dt_s=0.02)
    for k in (0, 40, 99):
        start = np.zeros_like(flown.final_state)
        start[:3], start[3:7] = flown.position_ned_m[k], flown.quaternion[k]
        start[7:13] = flown.nu[k]
        alone = run(
            packed,
            codes(1, 40.0, 60.0, 80.0),
            dt_s=0.02,
            start=start,
            external=tether.wrench_on_vehicle[k : k + 1],
        )
        np.testing.assert_allclose(alone.nu_dot[0], flown.nu_dot[k], atol=1e-9)


def test_the_wrench_is_the_half_nodes_force_less_its_inertia(packed: PackedVehicle) -> None:
    """By hand: acceleration of the attachment from differences of its velocity."""
    cable = lumped(added_mass=0.0)
    flown, tether = fly_tethered(packed, codes(400, 100.0), cable, dt_s=0.002, start=START)
    turn = Rotation.from_quat(flown.quaternion[:, [1, 2, 3, 0]])
    arm = np.cross(flown.nu[:, 3:], POINT)
    speed = turn.apply(flown.nu[:, :3] + arm)
    acceleration = (speed[2:] - speed[:-2]) / 0.004
    force = tether.force_below_ned_n[1:-1] - 0.5 * 0.12 * cable.segment_m * acceleration
    body = turn[1:-1].apply(force, inverse=True)
    np.testing.assert_allclose(tether.wrench_on_vehicle[1:-1, :3], body, atol=2e-3)
    np.testing.assert_allclose(
        tether.wrench_on_vehicle[:, 3:],
        np.cross(POINT, tether.wrench_on_vehicle[:, :3]),
        atol=1e-12,
    )


def whole_momentum(
    packed: PackedVehicle, state: np.ndarray, cable: LumpedMassTether, tether: TetherState
) -> np.ndarray:
    """Momentum of a dry vehicle and of the cable below the anchor, NED."""
    matrix = mass_of(packed.vector)
    turn = Rotation.from_quat(state[[4, 5, 6, 3]])
    lump = np.zeros(len(tether.position_ned_m))
    lump[:-1] += tether.rest_length_m / 2
    lump[1:] += tether.rest_length_m / 2
    cable_part = cable.mass_kgpm * lump[:, None] * tether.velocity_ned_mps
    return np.asarray(turn.apply((matrix @ state[7:13])[:3]) + cable_part[1:].sum(axis=0))


def test_momentum_changes_by_what_the_anchor_takes(make_packed: Make) -> None:
    """In a vacuum, without weight: the anchor's force is the only one from outside."""
    packed = make_packed(
        tether_point=POINT, added_mass=np.zeros((6, 6)), weight=0.0, buoyancy=0.0, **NO_DAMPING
    )
    cable = lumped(density_kgpm3=0.0, gravity_mps2=0.0)
    start = START.copy()
    start[7:13] = [1.0, -0.5, 0.8, 0.2, -0.3, 0.4]
    _, first = fly_tethered(packed, codes(1), cable, dt_s=0.001, start=start)
    begin = first.final
    state = fly_tethered(packed, codes(1), cable, dt_s=0.001, start=start)[0].final_state
    before = whole_momentum(packed, state, cable, begin)
    flown, tether = fly_tethered(
        packed, codes(6000), cable, dt_s=0.001, start=state, tether_start=begin
    )
    after = whole_momentum(packed, flown.final_state, cable, tether.final)
    taken = -np.trapezoid(tether.force_on_top_ned_n, tether.time_s, axis=0)
    assert np.abs(taken).max() > 5.0  # it went taut
    np.testing.assert_allclose(after - before, taken, atol=0.01 * np.abs(taken).max())


def vehicle_energy(packed: PackedVehicle, state: np.ndarray) -> float:
    matrix = mass_of(packed.vector)
    turn = Rotation.from_quat(state[[4, 5, 6, 3]])
    place = [
        state[2] + turn.apply(read(packed.vector, name))[2]
        for name in ("centre_of_mass", "centre_of_buoyancy")
    ]
    weights = [float(read(packed.vector, "weight")), -float(read(packed.vector, "buoyancy"))]
    potential = -sum(w * z for w, z in zip(weights, place, strict=True))
    return float(0.5 * state[7:13] @ matrix @ state[7:13] + potential)


def test_energy_of_vehicle_and_tether_never_grows_without_thrust_and_current(
    make_packed: Make,
) -> None:
    """No damping of the hull, no drag, no damping in the cable: what is lost are short waves."""
    from tests.unit.simulate.test_tether_dynamics import energy

    packed = make_packed(tether_point=POINT, **NO_DAMPING)
    cable = lumped(normal_drag=0.0, tangential_drag=0.0, axial_damping=0.0, density_kgpm3=1000.0)
    state, tether = START.copy(), None
    state[7:13] = [1.0, -0.5, 0.4, 0.3, -0.2, 0.4]
    totals, largest, tightest = [], 0.0, 0.0
    for _ in range(60):
        flown, swung = fly_tethered(
            packed, codes(10), cable, dt_s=0.02, start=state, tether_start=tether
        )
        state, tether = flown.final_state, swung.final
        kinetic, whole = energy(cable, tether)
        # the lower half node's velocity is the vehicle's, so the sum counts each part once
        totals.append(vehicle_energy(packed, state) + whole)
        largest = max(largest, kinetic + 0.5 * 60.0 * float(state[7:10] @ state[7:10]))
        tightest = max(tightest, float(swung.lower_tension_n.max()))
    assert tightest > 50.0  # the cable stopped it
    assert np.max(np.diff(totals)) < 1e-6 * largest
    assert totals[0] - totals[-1] < 0.05 * largest


def test_a_heavy_vehicle_comes_to_hang_on_its_tether(make_packed: Make) -> None:
    """At rest the cable carries the net weight, straight below the anchor, at its full length."""
    packed = make_packed(tether_point=(0.0, 0.0, -0.2), buoyancy=60.0 * 9.81 - 40.0)
    flown, tether = fly_tethered(
        packed,
        codes(4000),
        lumped(),
        dt_s=0.05,
        start=initial_state(position_ned_m=(3.0, 0.0, 29.0)),
    )
    half = 0.5 * lumped().wet_weight_npm * lumped().segment_m
    assert tether.lower_tension_n[-1] == pytest.approx(40.0 + half, rel=1e-3)
    turn = Rotation.from_quat(flown.quaternion[-1, [1, 2, 3, 0]])
    pull = turn.apply(tether.wrench_on_vehicle[-1, :3])
    np.testing.assert_allclose(pull, [0.0, 0.0, -40.0], atol=0.1)
    stretched = 30.0 * (1 + 42.0 / 2e4)
    place = flown.position_ned_m[-1] + turn.apply([0.0, 0.0, -0.2])
    np.testing.assert_allclose(place, [0.0, 0.0, stretched], atol=0.05)


def test_a_vehicle_cannot_leave_the_reach_of_its_tether(packed: PackedVehicle) -> None:
    flown, tether = fly_tethered(
        packed, codes(3000, 0.0, 0.0, 120.0, 120.0), SECTION, dt_s=0.02, start=START
    )
    turn = Rotation.from_quat(flown.quaternion[:, [1, 2, 3, 0]])
    reach = np.linalg.norm(flown.position_ned_m + turn.apply(POINT), axis=1)
    free = run(packed, codes(3000, 0.0, 0.0, 120.0, 120.0), dt_s=0.02, start=START)
    assert np.linalg.norm(free.position_ned_m[-1]) > 35.0
    assert reach.max() < 30.0 * 1.01
    np.testing.assert_allclose(
        tether.position_ned_m[:, 12], flown.position_ned_m + turn.apply(POINT)
    )


def test_cutting_a_run_into_pieces_changes_no_bit(make_packed: Make) -> None:
    packed = make_packed(tether_point=POINT, lag=np.full(12, 0.15))
    winch = Winch(0.2, 3.0, 60.0, 6.0, dry_friction_nm=2.0, brake_nm=50.0, shortest_m=8.0)
    commands, haul = codes(200, 50.0, 70.0, 30.0), np.where(np.arange(200) < 120, -0.8, 0.4)
    whole, line = fly_tethered(
        packed, commands, SECTION, dt_s=0.02, start=START, winch=winch, winch_command=haul
    )
    state, tether, rows, tensions = START, None, [], []
    for first in range(0, 200, 50):
        piece, swung = fly_tethered(
            packed,
            commands[first : first + 50],
            SECTION,
            dt_s=0.02,
            start=state,
            tether_start=tether,
            winch=winch,
            winch_command=haul[first : first + 50],
            start_time_s=first * 0.02,
        )
        state, tether = piece.final_state, swung.final
        rows.append(piece.nu[:-1])
        tensions.append(swung.top_tension_n[:-1])
    assert line.segments.min() < 12
    np.testing.assert_array_equal(np.concatenate(rows), whole.nu[:-1])
    np.testing.assert_array_equal(np.concatenate(tensions), line.top_tension_n[:-1])
    np.testing.assert_array_equal(state, whole.final_state)
    np.testing.assert_array_equal(tether.position_ned_m, line.final.position_ned_m)


def test_halving_the_step_is_of_fourth_order_until_a_segment_slackens(make_packed: Make) -> None:
    packed = make_packed(tether_point=POINT)
    cable = lumped(axial_stiffness_n=300.0)
    moving = START.copy()
    moving[7:13] = [0.6, -0.3, 0.4, 0.3, -0.2, 0.4]  # thrust tables have kinks: none is asked for
    _, first = fly_tethered(packed, codes(1), cable, dt_s=0.01, start=moving)
    ends = []
    for halvings in range(4):
        dt = 0.01 / 2**halvings
        flown, tether = fly_tethered(
            packed,
            codes(round(1.0 / dt)),
            cable,
            dt_s=dt,
            start=moving,
            tether_start=first.final,
        )
        assert tether.substeps.max() == 1
        ends.append(np.concatenate([flown.position_ned_m[-1], flown.nu[-1]]))
    errors = [np.abs(a - ends[-1]).max() for a in ends[:-1]]
    # against the finest: (16^3 - 1) / (16^2 - 1), (16^2 - 1) / (16 - 1)
    assert errors[0] / errors[1] == pytest.approx(16.06, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(17.0, rel=0.35)


def test_walls_make_the_vehicle_heavier_for_the_tether_too(make_packed: Make) -> None:
    """Near a wall the wrench still accounts for the acceleration, with the larger mass."""
    walls: dict[str, object] = {
        "wall_strength": 0.4,
        "wall_radius": 0.5,
        "wall_count": 1.0,
        "wall_point": np.array([[0.0, 0.0, 13.0]] + [[0.0] * 3] * 4),
        "wall_normal": np.array([[0.0, 0.0, -1.0]] + [[0.0] * 3] * 4),
    }
    packed = make_packed(tether_point=POINT, **walls)
    flown, tether = fly_tethered(packed, codes(50, 90.0), SECTION, dt_s=0.02, start=START)
    open_water, _ = fly_tethered(
        make_packed(tether_point=POINT), codes(50, 90.0), SECTION, dt_s=0.02, start=START
    )
    assert np.abs(flown.nu - open_water.nu).max() > 1e-3
    alone = run(
        packed,
        codes(1, 90.0),
        dt_s=0.02,
        start=START,
        external=tether.wrench_on_vehicle[:1],
    )
    np.testing.assert_allclose(alone.nu_dot[0], flown.nu_dot[0], atol=1e-9)


def refused(packed: PackedVehicle, **change: object) -> str:
    options: dict[str, object] = {
        "commands": codes(5),
        "tether": SECTION,
        "dt_s": 0.02,
        "start": START,
    }
    with pytest.raises(CannotComputeError) as caught:
        fly_tethered(packed, **(options | change))  # type: ignore[arg-type]
    return str(caught.value)


def test_bad_input_has_one_clear_message_each(packed: PackedVehicle) -> None:
    nan = codes(5)
    nan[2, 1] = np.nan
    assert "lower at 0.040 s is not a number" in refused(packed, commands=nan)
    assert "(5, 3) were given" in refused(packed, commands=np.zeros((5, 3)))
    assert "too large" in refused(packed, dt_s=1e4)
    assert "cannot be" in refused(packed, dt_s=np.nan)
    away = initial_state(position_ned_m=(0.0, 0.0, 50.0))
    text = refused(packed, start=away)
    assert "30 m long" in text
    assert "49.8" in text
    broken = START.copy()
    broken[0] = np.nan
    assert "finite numbers" in refused(packed, start=broken)


def test_a_motion_that_runs_away_ends_in_a_message(make_packed: Make) -> None:
    """A hull whose damping is too stiff for the step."""
    stiff = make_packed(tether_point=POINT, linear_damping=np.diag([1e7] * 6))
    moving = START.copy()
    moving[7] = 1.0
    text = refused(stiff, commands=codes(400), start=moving)
    assert "left the finite numbers" in text or "too large" in text
