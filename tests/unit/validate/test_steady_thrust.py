"""The settled thrust over arrays is the kernel's, and the ranges follow from it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from flight_cases import Bench

from pipeline.control.inverse import firmware_grid, thrust_grid
from pipeline.control.paper_allocator import PaperAllocator
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read, write
from pipeline.physics.thrust_grid import thrust_from_code
from pipeline.records.fits import InverseCharacteristic
from pipeline.simulate.applied_wrench import inflow_speed, levers, settled_thrust
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import initial_state, run
from pipeline.validate.closed_loop import ClosedLoop
from pipeline.validate.controllers import general_controllers, paper_shares
from pipeline.validate.plan import axis_range, calm_vehicle, thrust_limits
from pipeline.validate.power import Grid
from pipeline.vehicle.schema import Vehicle


def test_settled_thrust_is_the_kernels_without_lag(mmt300: Bench) -> None:
    packed = calm_vehicle(mmt300.packed)
    vector = packed.vector.copy()
    write(vector, "lag", np.zeros_like(read(vector, "lag")))
    generator = np.random.default_rng(3)
    for _ in range(40):
        codes = generator.uniform(-127, 127, (1, 5))
        nu = generator.uniform([-1, -1, -1, -1, -1, -1], [2.6, 1, 1, 1, 1, 1])
        state = initial_state(position_ned_m=(0, 0, 10), nu=nu.tolist())
        kernel = run(packed, codes, dt_s=0.02, vector=vector, start=state).thrust_n[0]
        ours = settled_thrust(packed, codes, inflow_speed(packed, nu[None, :]))[0]
        assert ours == pytest.approx(kernel, abs=1e-9)


@pytest.mark.parametrize("speed_mps", [-2.0, 1.0, 2.0])
def test_a_propeller_that_is_not_driven_drags_as_in_the_firmware(
    mmt300: Bench, speed_mps: float
) -> None:
    """Thrust at codes about the dead zone; freely turning -3.4 N at 2 m/s, weak or not."""
    assert mmt300.inverse.firmware is not None
    branches = mmt300.inverse.firmware.positive, mmt300.inverse.firmware.negative
    positive, negative = (thrust_grid(one) for one in branches)
    packed = calm_vehicle(mmt300.packed)
    codes = np.arange(-30.0, 31.0, 5.0)
    flow = np.full(codes.shape, speed_mps)
    firmware = thrust_from_code(codes, flow, positive=positive, negative=negative)
    ours = settled_thrust(packed, codes[:, None].repeat(5, 1), flow[:, None].repeat(5, 1))
    assert ours[:, 0] == pytest.approx(firmware, abs=0.06)
    free = -np.sign(speed_mps) * 3.37 * (speed_mps / 2.0) ** 2
    weak = packed.vector.copy()
    write(weak, "thrust_gain", np.full_like(read(weak, "thrust_gain"), 0.5))
    for vector in (packed.vector, weak):
        at_zero = settled_thrust(replace(packed, vector=vector), np.zeros((1, 5)), flow[:1, None])
        assert at_zero[0] == pytest.approx(free, abs=0.02)


def test_a_shaft_that_the_water_turns_drags_as_a_free_propeller(mmt300: Bench) -> None:
    """With the balance solved in time a vehicle that coasts meets the same drag."""
    vehicle = mmt300.vehicle
    assert vehicle.model is not None
    drive = vehicle.model.thrusters["at_drive"].model_copy(update={"balance_in_time": True})
    model = vehicle.model.model_copy(update={"thrusters": {"at_drive": drive}})
    packed = pack_vehicle(vehicle.model_copy(update={"model": model}), mmt300.model)
    start = initial_state(position_ned_m=(0, 0, 10), nu=[2.0, 0, 0, 0, 0, 0])
    flown = run(packed, np.zeros((400, 5)), dt_s=0.005, start=start)
    speed = flown.nu[:, 0] * 0.92388
    free = -0.8436 * speed[300] ** 2
    assert free < flown.thrust_n[300, 0] < 0.75 * free  # the rotor slows a little later


def test_a_grid_goes_on_along_its_last_slope_in_rows_only() -> None:
    grid = Grid(np.array([[0.0, 1.0], [2.0, 4.0]]), 0.5, 1.0)
    row, column = np.array([0.25, 1.0, 0.0, -1.0]), np.array([0.5, 1.0, 9.0, 1.0])
    assert grid.at(row, column) == pytest.approx([1.75, 7.0, 1.0, 1.0])


def test_limits_promise_no_more_against_the_motion(mmt300: Bench) -> None:
    packed = calm_vehicle(mmt300.packed)
    rest, fast = thrust_limits(packed, 0.0), thrust_limits(packed, 2.0)
    largest = packed.thrust_tables[0, 0, 0, -1]
    assert rest == pytest.approx(np.full((2, 5), largest))
    along = packed.thrust_tables[0, 0, :, -1]
    expected = np.interp(2.0 * 0.92388, 0.1 * np.arange(len(along)), along)
    assert fast == pytest.approx(np.array(2 * [[*[expected] * 4, largest]]), abs=1e-4)


def test_limits_have_a_value_for_each_sign_and_surge_takes_the_one_ahead(repository: Path) -> None:
    """rov8: 51.4 N ahead, 39.9 N in reverse; two of its verticals push down in a surge."""
    vehicle = bundled(repository, "rov8")
    packed = calm_vehicle(pack_vehicle(vehicle))
    assert thrust_limits(packed, 0.0) == pytest.approx(np.array([8 * [51.4], 8 * [39.9]]))
    shares = general_controllers(packed).thrust_of_wrench
    got = axis_range(packed, shares, 0.0)
    assert got[0] == pytest.approx(4 * 51.4 * np.sqrt(0.5), rel=1e-4)
    assert got[2] == pytest.approx(4 * 39.9)
    assert got[5] == pytest.approx(39.9 / np.abs(shares[:, 5]).max())


def test_shares_of_the_paper_give_each_axis_alone(field: ClosedLoop) -> None:
    axes = (0, 2, 4, 5)
    wrench = levers(field.packed) @ field.controllers.thrust_of_wrench[:, axes]
    assert wrench[list(axes)] == pytest.approx(np.eye(4), abs=1e-5)


def test_shares_of_a_bow_thruster_without_a_stated_arm_are_those_it_is_flown_with(
    mmt300: Bench,
) -> None:
    assert mmt300.vehicle.allocator is not None
    geometry = mmt300.vehicle.allocator.model_copy(update={"bow_arm_m": None})
    names = mmt300.packed.thruster_names
    shares = paper_shares(geometry, names)
    assert shares[names.index("bow"), 2] == pytest.approx(-1.0)
    one = PaperAllocator(geometry, firmware_grid(mmt300.inverse), names)
    for axis in (2, 4):
        _, thrust, _ = one.decide(2.0 * np.eye(6)[axis], np.zeros(6))
        assert thrust == pytest.approx(2.0 * shares[:, axis])


def one_way(bench: Bench) -> tuple[Vehicle, PackedVehicle, InverseCharacteristic]:
    """mmt300 with drives that take no negative codes."""
    drives = {
        name: drive.model_copy(update={"code_min": 0})
        for name, drive in bench.vehicle.drives.items()
    }
    vehicle = bench.vehicle.model_copy(update={"drives": drives})
    firmware = bench.inverse.firmware
    assert firmware is not None
    inverse = bench.inverse.model_copy(
        update={"firmware": firmware.model_copy(update={"code_min": 0})}
    )
    return vehicle, pack_vehicle(vehicle, bench.model), inverse


def test_a_drive_without_reverse_keeps_a_speed_ahead_and_cannot_turn(
    mmt300: Bench, field: ClosedLoop
) -> None:
    vehicle, packed, inverse = one_way(mmt300)
    got = ClosedLoop.of(vehicle, packed, inverse, None)
    for speed in (0.0, 1.0):
        assert got.ranges[speed][0] == pytest.approx(field.ranges[speed][0])
        assert got.ranges[speed][1:] == pytest.approx(np.zeros(3))
    assert got.amplitude == pytest.approx(np.zeros(4))
    assert any("No thruster gives reverse thrust" in text for text in got.explanations)
    assert not any("No thruster gives reverse thrust" in text for text in field.explanations)


def test_who_needs_reverse_thrust_and_has_none_is_said(repository: Path) -> None:
    """The verticals of rov8 hold its pitch when it surges: two of them push down."""
    vehicle = bundled(repository, "rov8")
    drives = {
        name: drive.model_copy(update={"code_min": 0}) for name, drive in vehicle.drives.items()
    }
    vehicle = vehicle.model_copy(update={"drives": drives})
    with pytest.raises(CannotComputeError, match="vertical_front_right, vertical_front_left, but"):
        ClosedLoop.of(vehicle, pack_vehicle(vehicle), None, None)


def test_range_is_that_of_the_tables(field: ClosedLoop) -> None:
    limit = thrust_limits(field.packed, 1.0)[0, 0]
    got = axis_range(field.packed, field.controllers.thrust_of_wrench, 1.0)
    delta = np.radians(22.5)
    assert got[0] == pytest.approx(4 * limit * np.cos(delta))
    assert got[5] == pytest.approx(2 * limit * np.sin(delta) * 0.9)
    assert got[1] == got[3] == 0.0
