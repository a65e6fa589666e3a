"""Modules that come and go in flight: bookkeeping by hand, momentum, the trim afterwards."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.simulate.events import (
    PayloadEvent,
    PayloadSchedule,
    held_payload,
    vector_with_modules,
)
from pipeline.simulate.fly import FlightPlan, fly, run_changing
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.run import initial_state
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

RELEASE = PayloadEvent(2.0, "release", "module_1")
BOTH = frozenset({"module_1", "module_2"})


@pytest.fixture
def carrier(packed_vehicles: dict[str, PackedVehicle]) -> PackedVehicle:
    return packed_vehicles["cargo_carrier"]


@pytest.fixture
def model(vehicles: dict[str, Vehicle]) -> Model:
    found = vehicles["cargo_carrier"].model
    assert found is not None
    return found


def idle(carrier: PackedVehicle, seconds: float) -> FloatArray:
    return np.zeros((round(seconds / 0.02), len(carrier.thruster_names)))


def test_the_books_after_a_release_by_hand(carrier: PackedVehicle, model: Model) -> None:
    """Module 1 gone: 30 kg and 22 l less; the carrier and the 20 kg of module 2 are left."""
    vector = vector_with_modules(carrier, model, frozenset({"module_2"}))
    assert read(vector, "mass") == pytest.approx(212.9)
    assert read(vector, "weight") == pytest.approx(212.9 * 9.81)
    assert read(vector, "buoyancy") == pytest.approx(1025 * 9.81 * 0.216)
    centre = np.array([20 * -0.5, 0.0, 192.9 * 0.04 + 20 * 0.13]) / 212.9
    assert read(vector, "centre_of_mass") == pytest.approx(centre)
    zz = 33.4 + 0.16 + 20 * 0.5**2
    assert read(vector, "inertia")[2, 2] == pytest.approx(zz)
    lift = np.array([0.016 * -0.5, 0.0, 0.2 * -0.04 + 0.016 * 0.13]) / 0.216
    assert read(vector, "centre_of_buoyancy") == pytest.approx(lift)


def test_all_on_board_is_the_vehicle_of_the_file(carrier: PackedVehicle, model: Model) -> None:
    assert vector_with_modules(carrier, model, BOTH).tobytes() == carrier.vector.tobytes()


def test_packed_inertia_is_that_of_the_gripper(carrier: PackedVehicle, model: Model) -> None:
    """Two codes, one body: the mass matrix changes by what the gripper says a module has."""
    without = mass_of(vector_with_modules(carrier, model, frozenset({"module_2"})))
    held = held_payload(model.payloads[0]).mass_matrix()
    np.testing.assert_allclose(mass_of(carrier.vector) - without, held, atol=1e-9)


def test_release_leaves_position_attitude_and_velocity(
    carrier: PackedVehicle, model: Model
) -> None:
    schedule = PayloadSchedule(carrier, model, [RELEASE])
    start = initial_state(attitude_rad=(0.1, -0.1, 0.5), nu=(0.4, 0.1, -0.1, 0.1, 0.05, -0.1))
    run = run_changing(carrier, idle(carrier, 4.0), schedule.change, [2.0], dt_s=0.02, start=start)
    (outcome,) = schedule.outcomes
    assert (outcome.impulse == 0.0).all()
    assert np.abs(np.diff(run.nu, axis=0)).max() < 0.02
    assert np.abs(np.diff(run.position_ned_m, axis=0)).max() < 0.02
    # the acceleration jumps: 79 N of wet weight less on 213 kg and 628 kg of added mass
    jump = run.nu_dot[100, 2] - run.nu_dot[99, 2]
    assert -0.14 < jump < -0.07


def test_momentum_of_both_stays_at_a_release(carrier: PackedVehicle, model: Model) -> None:
    before = mass_of(carrier.vector)
    after = mass_of(vector_with_modules(carrier, model, frozenset({"module_2"})))
    module = held_payload(model.payloads[0]).mass_matrix()
    nu = np.array([0.4, 0.1, -0.1, 0.1, 0.05, -0.1])
    np.testing.assert_allclose(before @ nu, after @ nu + module @ nu, atol=1e-9)


@pytest.mark.parametrize("current", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.0)])
def test_attachment_keeps_the_momentum_of_both(
    carrier: PackedVehicle, model: Model, current: tuple[float, float, float]
) -> None:
    """Relative to the water, added mass of the carrier included; the module lies on the ground."""

    def flowing(vector: FloatArray) -> FloatArray:
        read(vector, "current")[:] = current
        return vector

    events = [RELEASE, PayloadEvent(3.0, "attach", "module_1")]
    schedule = PayloadSchedule(carrier, model, events, flowing)
    nu = np.array([0.4, 0.1, -0.1, 0.1, 0.05, -0.1])
    state, alone = schedule.change(2.0, initial_state(attitude_rad=(0.1, 0.2, 0.9), nu=nu))
    assert state[7:13].tolist() == nu.tolist()
    state, joined = schedule.change(3.0, state)
    water = Rotation.from_euler("ZYX", (0.9, 0.2, 0.1)).inv().apply(current)
    relative = np.concatenate([water, np.zeros(3)])
    module = held_payload(model.payloads[0]).mass_matrix()
    expected = mass_of(alone) @ (nu - relative) + module @ -relative
    np.testing.assert_allclose(mass_of(joined) @ (state[7:13] - relative), expected, atol=1e-9)
    impulse = mass_of(alone) @ (state[7:13] - nu)
    np.testing.assert_allclose(schedule.outcomes[-1].impulse, impulse, atol=1e-9)
    # inelastic: some of the energy is gone
    assert np.abs(state[7:13]).sum() < np.abs(nu).sum()


def test_trim_after_a_release_is_the_static_one(carrier: PackedVehicle, model: Model) -> None:
    """Left alone, pitch ends where the moments of weight and buoyancy about the origin balance."""
    schedule = PayloadSchedule(carrier, model, [PayloadEvent(1.0, "release", "module_1")])
    start = initial_state(position_ned_m=(0.0, 0.0, 500.0))
    run = run_changing(
        carrier, idle(carrier, 300.0), schedule.change, [1.0], dt_s=0.02, start=start
    )
    vector = schedule.vector()
    weight, lift = float(read(vector, "weight")), float(read(vector, "buoyancy"))
    moment = weight * read(vector, "centre_of_mass") - lift * read(vector, "centre_of_buoyancy")
    # M = -z sin(theta) - x cos(theta) = 0
    trim = -np.arctan2(moment[0], moment[2])
    turn = Rotation.from_quat(run.quaternion[-1, [1, 2, 3, 0]])
    pitch = turn.as_euler("ZYX")[1]
    # it rises at a constant speed; what the drag's moment adds is a part of a degree
    # 98.1 - 80.4 N m about y against 101.2 + 59.5 N m/rad
    assert np.degrees(trim) == pytest.approx(6.27, abs=0.02)
    assert run.nu_dot[-1] == pytest.approx(np.zeros(6), abs=1e-4)
    flow = run.nu[-1]
    added = read(vector, "added_mass")
    munk = (added[2, 2] - added[0, 0]) * flow[0] * flow[2]
    held = moment[2] * np.sin(pitch) + moment[0] * np.cos(pitch)
    assert held == pytest.approx(munk, abs=0.02)
    # and the net force drives the rise
    net = lift - weight
    d, q = read(vector, "linear_damping"), read(vector, "quadratic_damping")
    drag = -d[2, 2] * flow[2] - q[2] * abs(flow[2]) * flow[2]
    assert drag == pytest.approx(net * np.cos(pitch), rel=1e-3)


def test_autopilot_takes_the_depth_back(carrier: PackedVehicle, model: Model) -> None:
    """It is not told of the release; its integral finds the 73 N that are missing."""
    schedule = PayloadSchedule(carrier, model, [PayloadEvent(10.0, "release", "module_1")])
    plan = MANOEUVRES["hover"].plan(carrier, 1.0, 120.0)
    run = fly(carrier, plan, change=schedule.change)
    depth = run.position_ned_m[:, 2]
    assert 9.0 < depth.min() < 9.8
    assert depth[-1] == pytest.approx(10.0, abs=0.05)


def test_events_of_the_schedule_and_effects_go_together(
    carrier: PackedVehicle, model: Model
) -> None:
    def weaker(vector: FloatArray) -> FloatArray:
        read(vector, "thrust_gain")[:] = 0.5
        return vector

    schedule = PayloadSchedule(carrier, model, [RELEASE], weaker)
    _, vector = schedule.change(2.0, initial_state())
    assert (read(vector, "thrust_gain") == 0.5).all()
    assert read(vector, "mass") == pytest.approx(212.9)
    assert (read(carrier.vector, "thrust_gain") == 1.0).all()


def test_without_events_the_run_is_the_same(carrier: PackedVehicle, model: Model) -> None:
    schedule = PayloadSchedule(carrier, model, [])
    plan = FlightPlan(3.0, wrench=lambda _t: np.array([20.0, 0, 0, 0, 0, 5.0]))
    assert (
        fly(carrier, plan, change=schedule.change).nu.tobytes() == fly(carrier, plan).nu.tobytes()
    )


@pytest.mark.parametrize(
    ("events", "message"),
    [
        ([PayloadEvent(1.0, "release", "modul_1")], 'Did you mean "module_1"'),
        ([PayloadEvent(1.0, "attach", "module_1")], "is already on board then"),
        (
            [PayloadEvent(5.0, "release", "module_2"), PayloadEvent(1.0, "release", "module_2")],
            "module_2 at 5 s: it is not on board then",
        ),
        ([PayloadEvent(-1.0, "release", "module_1")], "a time from 0 on"),
        ([PayloadEvent(float("nan"), "release", "module_1")], "a time from 0 on"),
    ],
)
def test_what_cannot_happen_is_refused_before_the_run(
    carrier: PackedVehicle, model: Model, events: list[PayloadEvent], message: str
) -> None:
    with pytest.raises(CannotComputeError, match=message):
        PayloadSchedule(carrier, model, events)
