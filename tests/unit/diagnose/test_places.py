"""Mass and volume lead the place of a payload, against each other."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.coordinates import Coordinate, coordinates
from pipeline.diagnose.places import leads, lifting
from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import candidates
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle


@pytest.fixture(scope="module")
def packed() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


@pytest.fixture(scope="module")
def payload(packed: PackedVehicle) -> Effect:
    return candidates(packed.context)["payload"]


@pytest.fixture(scope="module")
def place(packed: PackedVehicle, payload: Effect) -> Coordinate:
    """Where it sits athwart, of mass (0) and volume (1)."""
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    assert vehicle.model is not None
    every = coordinates(packed, {"payload": payload}, vehicle.model.uncertainty)
    assert [one.parameter.name for one in every[:2]] == ["mass_kg", "volume_m3"]
    return next(one for one in every if one.parameter.name == "y_m")


def parameter(effect: Effect, name: str) -> Parameter:
    return next(one for one in effect.parameters if one.name == name)


@pytest.mark.parametrize("name", ["x_m", "y_m", "z_m"])
def test_a_place_needs_mass_or_volume_and_the_water_lifts(
    packed: PackedVehicle, payload: Effect, name: str
) -> None:
    placed = parameter(payload, name)
    needed = leads(packed, payload, None, placed)
    assert needed is not None
    assert [one.name for one in needed] == ["mass_kg", "volume_m3"]
    assert [one.name for one in lifting(packed, payload, None, placed, needed)] == ["volume_m3"]


@pytest.mark.parametrize("name", ["mass_kg", "volume_m3"])
def test_mass_and_volume_act_by_themselves(
    packed: PackedVehicle, payload: Effect, name: str
) -> None:
    assert leads(packed, payload, None, parameter(payload, name)) == ()


@pytest.mark.parametrize(
    ("mass", "volume", "size"),
    [
        (0.3, 0.0, 0.3),
        (-0.3, 0.0, -0.3),
        (0.0, 0.3, -0.3),
        (0.0, -0.3, 0.3),
        (0.4, 0.3, 0.5),
        (0.3, 0.4, -0.5),
    ],
)
def test_how_much_there_is_has_the_sign_of_what_weighs_more(
    place: Coordinate, mass: float, volume: float, size: float
) -> None:
    departures = np.array([mass, volume, 0.0, 0.0, 0.0])
    assert place.lead_size(departures) == pytest.approx(size)
