"""The compiled kernel against analytic limits: nothing here was computed by the kernel itself."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.physics.parameters import read, write
from pipeline.simulate.applied_wrench import actuator_states, thruster_wrench
from pipeline.simulate.kernel_hull import subtract_coriolis
from pipeline.simulate.pack import PackedVehicle, mass_of, pack_vehicle
from pipeline.simulate.run import Trajectory, initial_state, run
from pipeline.vehicle.load import load_vehicle
from tests.unit.simulate.conftest import full_symmetric

Make = Callable[..., PackedVehicle]
ZERO6 = np.zeros((6, 6))
nu_arrays = arrays(float, 6, elements=st.floats(-3, 3))


def idle(packed: PackedVehicle, seconds: float, dt: float, **options: object) -> Trajectory:
    commands = np.zeros((round(seconds / dt), 5))
    return run(packed, commands, dt_s=dt, **options)  # type: ignore[arg-type]


def skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def coriolis_force(packed: PackedVehicle, nu: np.ndarray) -> np.ndarray:
    force = np.zeros(6)
    subtract_coriolis.py_func(packed.vector, mass_of(packed.vector), nu, force)
    return -force


@given(nu=nu_arrays)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_coriolis_terms_do_no_work(make_packed: Make, nu: np.ndarray) -> None:
    packed = make_packed()
    force = coriolis_force(packed, nu)
    scale = np.abs(nu) @ np.abs(force) + 1e-30
    assert abs(nu @ force) <= 1e-13 * scale


@given(nu=nu_arrays)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_coriolis_is_the_papers_transport_matrix(make_packed: Make, nu: np.ndarray) -> None:
    """Voitasyk 2018: K (M + Lambda) V with K = [[S(w), 0], [S(v), S(w)]], full symmetric matrix."""
    packed = make_packed()
    v, w = nu[:3], nu[3:]
    transport = np.block([[skew(w), np.zeros((3, 3))], [skew(v), skew(w)]])
    expected = transport @ mass_of(packed.vector) @ nu
    np.testing.assert_allclose(coriolis_force(packed, nu), expected, atol=1e-10)


@given(nu=nu_arrays)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_rigid_body_part_is_newton_and_euler(make_packed: Make, nu: np.ndarray) -> None:
    """Without added mass: m (w x v + w x (w x r)) and w x I w + m r x (w x v) about the origin."""
    packed = make_packed(added_mass=ZERO6)
    m = float(read(packed.vector, "mass"))
    r, inertia = read(packed.vector, "centre_of_mass"), read(packed.vector, "inertia")
    v, w = nu[:3], nu[3:]
    force = m * (np.cross(w, v) + np.cross(w, np.cross(w, r)))
    moment = np.cross(w, inertia @ w) + m * np.cross(r, np.cross(w, v))
    np.testing.assert_allclose(
        coriolis_force(packed, nu), np.concatenate([force, moment]), atol=1e-9
    )


def test_mass_matrix_by_hand(make_packed: Make) -> None:
    packed = make_packed(added_mass=ZERO6)
    m, r = 60.0, np.array([0.03, -0.02, 0.05])
    expected = np.block(
        [[m * np.eye(3), -m * skew(r)], [m * skew(r), read(packed.vector, "inertia")]]
    )
    np.testing.assert_allclose(mass_of(packed.vector), expected, atol=1e-12)


def energy(packed: PackedVehicle, trajectory: Trajectory) -> np.ndarray:
    """Kinetic energy with added mass, and potential of weight and buoyancy at their centres."""
    matrix = mass_of(packed.vector)
    kinetic = 0.5 * np.einsum("ki,ij,kj->k", trajectory.nu, matrix, trajectory.nu)
    turn = Rotation.from_quat(trajectory.quaternion[:, [1, 2, 3, 0]])
    weight, buoyancy = (float(read(packed.vector, n)) for n in ("weight", "buoyancy"))
    down_g = (turn.apply(read(packed.vector, "centre_of_mass")) + trajectory.position_ned_m)[:, 2]
    down_b = (turn.apply(read(packed.vector, "centre_of_buoyancy")) + trajectory.position_ned_m)[
        :, 2
    ]
    return np.asarray(kinetic - weight * down_g + buoyancy * down_b)


START = initial_state(attitude_rad=(0.5, -0.4, 1.0), nu=(1.0, -0.5, 0.4, 0.6, -0.5, 0.7))


def test_energy_is_kept_without_damping(make_packed: Make) -> None:
    packed = make_packed(linear_damping=ZERO6, quadratic_damping=np.zeros(6))
    e = energy(packed, idle(packed, 20.0, 0.005, start=START))
    assert np.abs(e - e[0]).max() < 1e-7 * abs(e[0] - e.min() + 60.0)


def test_energy_never_grows_with_damping(make_packed: Make) -> None:
    """Crossflow coupling on, angle-of-attack terms off."""
    packed = make_packed(crossflow_fraction=1.0)
    e = energy(packed, idle(packed, 60.0, 0.01, start=START))
    assert np.diff(e).max() < 1e-9
    assert e[-1] < e[0] - 1.0


def test_a_current_carries_a_vehicle_at_rest_with_it(make_packed: Make) -> None:
    """Moving with the water is no motion at all: Galilean invariance."""
    still = make_packed()
    stream = make_packed(current=np.array([0.4, -0.3, 0.1]))
    turn = Rotation.from_quat(START[[4, 5, 6, 3]])
    moving = START.copy()
    moving[7:10] += turn.inv().apply([0.4, -0.3, 0.1])
    a, b = idle(still, 20.0, 0.01, start=START), idle(stream, 20.0, 0.01, start=moving)
    drift = a.time_s[:, None] * np.array([0.4, -0.3, 0.1])
    np.testing.assert_allclose(b.position_ned_m, a.position_ned_m + drift, atol=1e-6)
    np.testing.assert_allclose(b.quaternion, a.quaternion, atol=1e-7)


def test_terminal_speed_balances_thrust_and_drag(make_packed: Make) -> None:
    """4 T cos(delta) = X_u u + X_uu u^2, with T from the table at this speed."""
    packed = make_packed(
        centre_of_mass=np.array([0, 0, 0.05]),
        centre_of_buoyancy=np.zeros(3),
        buoyancy=60.0 * 9.81,
        added_mass=np.diag([5.0, 5, 5, 0.5, 9, 8]),  # no Munk moment: the course is stable
        inertia=np.diag([1.0, 9.0, 9.5]),
    )
    commands = np.tile([90.0, 90, 90, 90, 0], (6000, 1))
    u = run(packed, commands, dt_s=0.05).nu[-1, 0]
    cosine = np.cos(np.radians(22.5))
    share = 90 / 127
    # bilinear in speed: exact for this table, whose rows are linear in V
    thrust = 42 * share * (share - u * cosine / 5.0)
    assert 4 * thrust * cosine == pytest.approx(3 * u + 20 * u * u, rel=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_free_decay_has_the_analytic_period_and_damping(make_packed: Make, axis: int) -> None:
    """Small roll or pitch: (I + A) q'' + d q' + W h q = 0, log decrement pi d / (w_d (I + A))."""
    inertia, added, damping, arm = [1.0, 9.0][axis], [0.5, 8.0][axis], [0.4, 2.0][axis], 0.05
    packed = make_packed(
        centre_of_mass=np.zeros(3),
        inertia=np.diag([1.0, 9.0, 9.5]),
        added_mass=np.diag([5.0, 50, 55, 0.5, 8.0, 8.0]),
        centre_of_buoyancy=np.array([0, 0, -arm]),
        buoyancy=60 * 9.81,
        linear_damping=np.diag([3.0, 20, 20, 0.4, 2.0, 6.0]),
        quadratic_damping=np.zeros(6),
    )
    attitude = [0.0, 0.0, 0.0]
    attitude[axis] = 1e-3
    trajectory = idle(packed, 60.0, 0.01, start=initial_state(attitude_rad=attitude))
    angle = 2 * trajectory.quaternion[:, 1 + axis]
    total = inertia + added
    stiffness = 60 * 9.81 * arm
    decay = damping / (2 * total)
    frequency = np.sqrt(stiffness / total - decay**2)
    t = trajectory.time_s
    expected = (
        1e-3
        * np.exp(-decay * t)
        * (np.cos(frequency * t) + decay / frequency * np.sin(frequency * t))
    )
    np.testing.assert_allclose(angle, expected, atol=2e-8)


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi_implicit", 1)])
def test_error_falls_with_the_declared_order(make_packed: Make, method: str, order: int) -> None:
    """Halving the step divides the error by 2^order; with lag, current and all hull terms on."""
    packed = make_packed(
        crossflow_fraction=1.0,
        current=np.array([0.2, 0.1, 0.0]),
        lag=0.3,
        heave_lift_slope=30.0,
        pitch_lift_slope=-20.0,
    )
    command = np.array([60.0, 40.0, 55.0, 45.0, 10.0])
    # the table's kinks between speeds would hide the order
    read(packed.vector, "inflow_fraction")[:] = 0.0

    def end(dt: float, how: str) -> np.ndarray:
        steps = np.tile(command, (round(4.0 / dt), 1))
        return run(packed, steps, dt_s=dt, start=START, method=how).final_state  # type: ignore[arg-type]

    truth = end(0.00125, "rk4")
    errors = [np.abs(end(dt, method) - truth)[:13].max() for dt in (0.08, 0.04, 0.02)]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all(np.abs(rates - order) < 0.35), rates


def test_quaternion_stays_of_unit_length(make_packed: Make) -> None:
    trajectory = idle(make_packed(), 300.0, 0.05, start=START)
    np.testing.assert_allclose(np.linalg.norm(trajectory.quaternion, axis=1), 1.0, atol=1e-14)


@pytest.mark.parametrize(
    ("thruster", "signs"),
    [
        ("upper", {"X": 1, "Z": -1, "M": -1}),  # at the stern, pushes up: the bow goes down
        ("right", {"X": 1, "Y": 1, "N": -1}),  # at the stern, pushes to starboard: turns to port
        ("bow", {"Z": -1, "M": 1}),  # at the bow, pushes up: the bow rises
    ],
)
def test_frames_by_hand(make_packed: Make, thruster: str, signs: dict[str, int]) -> None:
    """Force and moment of a single thruster, in SNAME signs."""
    packed = make_packed(
        added_mass=ZERO6,
        centre_of_mass=np.zeros(3),
        inertia=np.eye(3) * 5,
        weight=0.0,
        buoyancy=0.0,
    )
    commands = np.zeros((1, 5))
    commands[0, packed.thruster_names.index(thruster)] = 127.0
    acceleration = run(packed, commands, dt_s=0.01).nu_dot[0]
    for axis, value in zip("XYZKMN", acceleration, strict=True):
        expected = signs.get(axis, 0)
        assert (np.sign(value) == expected) if expected else abs(value) < 1e-12, axis


def test_a_heavy_bow_sinks_and_pitches_down(make_packed: Make) -> None:
    packed = make_packed(centre_of_mass=np.array([0.05, 0, 0.02]), buoyancy=580.0)
    first = idle(packed, 0.02, 0.01).nu_dot[0]
    assert first[2] > 0  # heave down
    assert first[4] < 0  # pitch: bow down


def test_lift_signs_of_the_paper(make_packed: Make) -> None:
    """R_y = K alpha up and M_z = -K alpha righting: w > 0 is a positive angle of attack."""
    packed = make_packed(
        added_mass=np.diag([5.0] * 6),
        heave_lift_slope=30.0,
        pitch_lift_slope=-20.0,
        linear_damping=ZERO6,
        quadratic_damping=np.zeros(6),
        weight=0.0,
        buoyancy=0.0,
        centre_of_mass=np.zeros(3),
        inertia=np.eye(3),
    )
    start = initial_state(nu=(2.0, 0, 0.2, 0, 0, 0))
    a = idle(packed, 0.01, 0.01, start=start).nu_dot[0]
    assert a[2] == pytest.approx(-30.0 * 2.0 * 0.2 / 65.0)
    assert a[4] == pytest.approx(-20.0 * 2.0 * 0.2 / 6.0)


def test_runs_are_the_same_bit_for_bit(make_packed: Make) -> None:
    packed = make_packed()
    commands = np.random.default_rng(1).uniform(-127, 127, (500, 5))
    a = run(packed, commands, dt_s=0.02, start=START)
    b = run(packed, commands, dt_s=0.02, start=START)
    assert a.nu.tobytes() == b.nu.tobytes()


def test_wall_adds_mass_and_damping_and_far_away_nothing(make_packed: Make) -> None:
    walls = {
        "added_mass": np.diag([5.0, 50, 55, 0.5, 9, 8]),
        "centre_of_mass": np.zeros(3),
        "centre_of_buoyancy": np.zeros(3),
        "wall_count": 1.0,
        "wall_radius": 0.2,
        "wall_point": np.array([[0.0, 0, 5.0]] + [[0.0, 0, 0]] * 4),
        "wall_normal": np.array([[0.0, 0, -1.0]] + [[0.0, 0, 0]] * 4),
        "buoyancy": 60 * 9.81 - 10.0,
    }
    free = idle(make_packed(**walls), 0.01, 0.01).nu_dot[0]
    far = idle(make_packed(wall_strength=1.0, **walls), 0.01, 0.01).nu_dot[0]
    near_start = initial_state(position_ned_m=(0, 0, 4.7))
    near = idle(make_packed(wall_strength=1.0, **walls), 0.01, 0.01, start=near_start).nu_dot[0]
    assert far[2] == pytest.approx(free[2], rel=1e-2)
    assert near[2] < 0.95 * free[2]


def test_added_mass_of_the_fixture_is_positive_definite() -> None:
    assert np.linalg.eigvalsh(full_symmetric([5.0, 50, 55, 0.5, 9, 8], 1, 0.2)).min() > 0


def test_a_supply_above_that_of_the_bench_drives_beyond_the_largest_code() -> None:
    packed = pack_vehicle(load_vehicle(bundled_vehicle("rov8")))
    count = len(packed.thruster_names)
    largest = read(packed.vector, "code_max")[:count]
    thrusts = []
    for drop in (0.0, -0.05, -0.1):
        vector = packed.vector.copy()
        write(vector, "supply_drop", drop)
        codes = actuator_states(packed, np.tile(largest, (200, 1)), 0.02, vector=vector)[-1:]
        assert codes[0] == pytest.approx(largest * (1.0 - drop), rel=1e-6)
        thrusts.append(thruster_wrench(packed, codes, np.zeros((1, 6)), vector=vector)[1][0])
    first, second = thrusts[1] - thrusts[0], thrusts[2] - thrusts[1]
    # T ~ code^1.33: 5 % more code gives about 7 % more thrust, and 5 % more the same again
    assert first == pytest.approx(0.07 * thrusts[0], rel=0.1)
    assert second == pytest.approx(first, rel=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_supply_scales_what_lies_beyond_the_dead_zone_before_the_drive(
    make_packed: Make, share: float
) -> None:
    """A controller ignores the same codes at any voltage, a motor with friction more at a lower."""
    dead, left = 20.0, 0.8
    packed = make_packed(drive_dead=np.full(12, dead), lag_dead_share=share, supply_drop=1.0 - left)
    for code in (5.0, 30.0, 127.0):
        for sign in (1.0, -1.0):
            reached = actuator_states(packed, np.full((2, 5), sign * code), 0.02)[-1, 0]
            before = min(share * dead, code)
            assert reached == pytest.approx(sign * (before + left * (code - before)), rel=1e-12)
