"""A manoeuvre that the thrusters cannot fly is refused; a passive axis is no obstacle to one."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvre_reach import ANY_AXIS, out_of_reach, reach_alone, why_not_flown
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

#: A vehicle whose pitch no thruster holds, given as it was by one who has it.
PASSIVE_PITCH = Path(__file__).parents[2] / "cases" / "folders" / "bluerov2_surge" / "vehicle.yaml"


def with_thrusters(vehicles: dict[str, Vehicle], count: int) -> PackedVehicle:
    """rov8 with its first oblique thrusters only."""
    vehicle = vehicles["rov8"]
    return pack_vehicle(vehicle.model_copy(update={"thrusters": vehicle.thrusters[:count]}))


def why_not(packed: PackedVehicle, name: str) -> str:
    return why_not_flown(packed, name, MANOEUVRES[name].axes)


@pytest.mark.parametrize("name", sorted(MANOEUVRES))
def test_the_bundled_vehicles_fly_every_manoeuvre(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    for packed in packed_vehicles.values():
        assert out_of_reach(packed, MANOEUVRES[name].axes) == ()


def test_one_oblique_thruster_drives_nothing_straight(vehicles: dict[str, Vehicle]) -> None:
    packed = with_thrusters(vehicles, 1)
    assert out_of_reach(packed, ("surge", "yaw", "heave")) == ("surge", "heave")
    assert why_not(packed, "straight") == (
        "straight cannot be flown: its thrusters cannot push along surge without a push along "
        "sway and roll and pitch and yaw that none can balance."
    )
    assert out_of_reach(packed, ANY_AXIS) == ANY_AXIS


def test_without_thrusters_nothing_is_flown_but_a_decay(vehicles: dict[str, Vehicle]) -> None:
    packed = with_thrusters(vehicles, 0)
    assert "along which the thrusters can push alone" in why_not(packed, "multisine")
    assert why_not(packed, "zig_zag").count("no thruster pushes along") == 2
    assert why_not(packed, "free_decay") == ""


def test_a_passive_axis_is_no_obstacle() -> None:
    packed = pack_vehicle(load_vehicle(PASSIVE_PITCH))
    reach = reach_alone(packed)
    assert reach[4] == 0.0
    assert reach[:3].min() > 5.0
    flown = fly(packed, MANOEUVRES["surge_steps"].plan(packed, 1.0, 60.0))
    # an arm of 85 mm below the drag, 4 N at 0.15 rad of tilt: 0.37 m/s by the file's drag
    assert flown.nu[:, 0].max() == pytest.approx(0.37, abs=0.05)
    assert 2.0 * np.abs(flown.quaternion[:, 2]).max() < 0.45


def test_a_torpedo_without_fins_runs_ahead_and_says_why_it_does_not_turn() -> None:
    packed = pack_vehicle(load_vehicle(bundled_vehicle("remus100")))
    assert why_not(packed, "zig_zag") == "zig_zag cannot be flown: no thruster pushes along yaw."
    flown = fly(packed, MANOEUVRES["straight"].plan(packed, 1.0, 30.0))
    assert flown.nu[-1, 0] == pytest.approx(2.1, abs=0.2)
