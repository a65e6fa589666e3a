"""Every bundled vehicle flies every manoeuvre, and each does what its name says."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvres import MANOEUVRES, OPEN_WATER_DEPTH_M, POOL_DEPTH_M
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.types import FloatArray

VEHICLES = ("mmt300", "rov8", "cargo_carrier")
each_vehicle = pytest.mark.parametrize("name", VEHICLES)


_FLOWN: dict[tuple[str, str], Trajectory] = {}


def flown(packed: PackedVehicle, manoeuvre: str) -> Trajectory:
    """Fly it, once for all tests."""
    key = (packed.name, manoeuvre)
    if key not in _FLOWN:
        one = MANOEUVRES[manoeuvre]
        _FLOWN[key] = fly(packed, one.plan(packed, 1.0, one.duration_s))
    return _FLOWN[key]


def angles(run: Trajectory) -> FloatArray:
    """Heading, pitch, roll [deg], without jumps."""
    turn = Rotation.from_quat(run.quaternion[:, [1, 2, 3, 0]])
    return np.degrees(np.unwrap(turn.as_euler("ZYX"), axis=0))


# the third has open water, as the first, and moves in six axes, as the second
@pytest.mark.parametrize(
    "name", ["mmt300", "rov8", pytest.param("cargo_carrier", marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("manoeuvre", list(MANOEUVRES))
def test_flies_without_leaving_its_water(
    packed_vehicles: dict[str, PackedVehicle], name: str, manoeuvre: str
) -> None:
    packed = packed_vehicles[name]
    run = flown(packed, manoeuvre)
    depth, tilt = run.position_ned_m[:, 2], angles(run)[:, 1:]
    assert run.time_s[-1] == pytest.approx(MANOEUVRES[manoeuvre].duration_s)
    assert np.abs(tilt).max() < 40.0
    assert np.abs(run.nu[:, :3]).max() < 2.5
    assert np.abs(run.nu[:, 3:]).max() < 2.0
    assert depth.min() > 0.0
    assert np.all(run.command <= packed.code_limits[:, 1])
    assert np.all(run.command >= packed.code_limits[:, 0])
    if name == "rov8":
        assert depth.max() < 3.0
        assert np.abs(run.position_ned_m[:, 0]).max() < 5.0
    elif manoeuvre not in ("free_decay", "pitch_steps"):
        assert np.abs(depth - OPEN_WATER_DEPTH_M).max() < 3.0


@each_vehicle
def test_excites_what_can_be_excited(packed_vehicles: dict[str, PackedVehicle], name: str) -> None:
    """A multisine moves every axis that a wrench alone can reach."""
    run = flown(packed_vehicles[name], "multisine")
    moved = run.nu.std(axis=0) > [0.03, 0.03, 0.02, 0.02, 0.02, 0.02]
    reachable = [True, False, True, False, True, False] if name == "mmt300" else [True] * 6
    assert moved[np.array(reachable)].all()


@each_vehicle
def test_hover_keeps_its_place(packed_vehicles: dict[str, PackedVehicle], name: str) -> None:
    packed = packed_vehicles[name]
    run = flown(packed, "hover")
    wanted = POOL_DEPTH_M if packed.context.walls else OPEN_WATER_DEPTH_M
    assert abs(run.position_ned_m[-1, 2] - wanted) < 0.05
    assert np.abs(run.position_ned_m[:, :2]).max() < 0.2
    assert np.abs(angles(run)[-1]).max() < 1.0


@pytest.mark.parametrize("name", ["mmt300", "cargo_carrier"])
def test_straight_settles_at_the_speed_that_was_asked(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    packed = packed_vehicles[name]
    plan = MANOEUVRES["straight"].plan(packed, 1.0, 60.0)
    assert plan.reference is not None
    wanted = plan.reference(30.0).surge_mps
    assert wanted is not None
    run = fly(packed, plan)
    assert run.nu[-1, 0] == pytest.approx(wanted, rel=0.01)
    assert abs(angles(run)[-1, 0]) < 0.5


def test_amplitude_and_duration_are_taken(packed_vehicles: dict[str, PackedVehicle]) -> None:
    packed = packed_vehicles["mmt300"]
    whole = MANOEUVRES["straight"].plan(packed, 1.0, 20.0)
    half = MANOEUVRES["straight"].plan(packed, 0.5, 20.0)
    assert whole.reference is not None
    assert half.reference is not None
    full_speed = whole.reference(0.0).surge_mps
    assert full_speed is not None
    assert half.reference(0.0).surge_mps == pytest.approx(0.5 * full_speed)
    assert fly(packed, half).time_s[-1] == pytest.approx(20.0)


def test_zig_zag_of_the_auv_turns_to_both_sides(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    run = flown(packed_vehicles["mmt300"], "zig_zag")
    heading = angles(run)[:, 0]
    at = {t: heading[round(t / 0.02)] for t in (19.9, 39.9, 59.9, 79.9, 99.9)}
    assert list(at.values()) == pytest.approx([20, -20, 20, -20, 20], abs=4.0)


def test_circle_turns_at_its_rate(packed_vehicles: dict[str, PackedVehicle]) -> None:
    run = flown(packed_vehicles["mmt300"], "circle")
    assert np.degrees(run.nu[run.time_s > 60.0, 5]) == pytest.approx(9.0, abs=0.7)


def test_free_decay_has_no_command(packed_vehicles: dict[str, PackedVehicle]) -> None:
    run = flown(packed_vehicles["rov8"], "free_decay")
    assert (run.command == 0.0).all()
    late = np.abs(angles(run)[run.time_s > 50.0, 1:])
    assert late.max() < 2.0


def test_runs_to_and_fro_in_a_pool(packed_vehicles: dict[str, PackedVehicle]) -> None:
    run = flown(packed_vehicles["rov8"], "straight")
    assert run.nu[:, 0].max() > 0.4
    assert run.nu[:, 0].min() < -0.4
    assert np.abs(run.position_ned_m[:, 0]).max() < 2.0
