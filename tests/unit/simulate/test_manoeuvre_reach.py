"""A manoeuvre that the thrusters cannot fly is told."""

import numpy as np
import pytest

from pipeline.simulate.manoeuvre_reach import ANY_AXIS, out_of_reach
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import run
from pipeline.stages.run_summary import summarise
from pipeline.vehicle.schema import Vehicle


def with_thrusters(vehicles: dict[str, Vehicle], count: int) -> PackedVehicle:
    """rov8 with its first oblique thrusters only."""
    vehicle = vehicles["rov8"]
    return pack_vehicle(vehicle.model_copy(update={"thrusters": vehicle.thrusters[:count]}))


def doubts(packed: PackedVehicle, name: str) -> tuple[str, ...]:
    flown = run(packed, np.zeros((5, len(packed.thruster_names))), dt_s=0.02)
    return summarise(flown, {}, packed, packed.vector, MANOEUVRES[name]).doubts


@pytest.mark.parametrize("name", sorted(MANOEUVRES))
def test_the_bundled_vehicles_fly_every_manoeuvre(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    for packed in packed_vehicles.values():
        assert out_of_reach(packed, MANOEUVRES[name].axes) == ()


def test_one_oblique_thruster_drives_nothing_straight(vehicles: dict[str, Vehicle]) -> None:
    packed = with_thrusters(vehicles, 1)
    assert out_of_reach(packed, ("surge", "yaw", "heave")) == ("surge", "heave")
    (doubt,) = doubts(packed, "straight")
    assert doubt == (
        "straight was not flown as it is meant: the thrusters cannot push along surge alone."
    )
    assert out_of_reach(packed, ANY_AXIS) == ANY_AXIS


def test_without_thrusters_nothing_is_flown_but_a_decay(vehicles: dict[str, Vehicle]) -> None:
    packed = with_thrusters(vehicles, 0)
    assert "gave no command" in doubts(packed, "multisine")[0]
    assert len(doubts(packed, "zig_zag")) == 2
    assert doubts(packed, "free_decay") == ()


def test_commands_of_a_log_are_no_manoeuvre(packed_vehicles: dict[str, PackedVehicle]) -> None:
    packed = packed_vehicles["rov8"]
    flown = run(packed, np.zeros((5, 8)), dt_s=0.02)
    assert summarise(flown, {}, packed, packed.vector).doubts == ()
