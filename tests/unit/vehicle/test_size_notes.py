"""Slips of a unit in an otherwise valid vehicle file are mentioned."""

from typing import Any

import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.notes import size_notes, vehicle_notes
from pipeline.vehicle.schema import Vehicle


def rov(**body: Any) -> Vehicle:  # noqa: ANN401 (fields of any type)
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    assert vehicle.model is not None
    changed = vehicle.model.rigid_body.model_copy(update=body)
    model = vehicle.model.model_copy(update={"rigid_body": changed})
    return vehicle.model_copy(update={"model": model})


@pytest.mark.parametrize("name", ["rov8", "cargo_carrier"])
def test_the_bundled_vehicles_are_of_one_size(name: str) -> None:
    assert size_notes(load_vehicle(bundled_vehicle(name))) == ()


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"displaced_volume_m3": 13.4}, "displace 1.3"),
        ({"displaced_volume_m3": 13.4e-6}, "so the vehicle goes down. Check mass_kg"),
        ({"mass_kg": 13500.0}, "a litre is 0.001 m^3"),
        ({"inertia_kgm2": (2.1e6, 2.5e6, 2.5e6, 0, 0, 0)}, "the radius of gyration is"),
        ({"inertia_kgm2": (2.1e3, 2.5e3, 2.5e3, 0, 0, 0)}, "Check the unit, kg m^2"),
        ({"centre_of_mass_m": (0.0, 0.0, 20.0)}, "centre_of_mass_m is 20 m from the origin"),
        ({"centre_of_buoyancy_m": (0.0, 0.0, -15.0)}, "centre_of_buoyancy_m is 15 m"),
    ],
)
def test_a_slip_of_a_unit_is_mentioned(body: dict[str, object], said: str) -> None:
    (note,) = size_notes(rov(**body))
    assert said in note
    assert note in vehicle_notes(rov(**body))


def test_thruster_places_in_millimetres() -> None:
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    far = tuple(
        one.model_copy(update={"position_m": tuple(1e3 * x for x in one.position_m)})
        for one in vehicle.thrusters
    )
    for changed in (
        vehicle.model_copy(update={"thrusters": far}),
        vehicle.model_copy(update={"thrusters": far, "model": None}),
    ):
        found = size_notes(changed)
        assert len(found) == len(far)
        assert found[0].startswith(f"thruster {far[0].name}: position_m is")
