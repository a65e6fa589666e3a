"""Mass and volume lead the place of a payload, against each other."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.linear.coordinates import (
    Coordinate,
    coordinates,
    counted_by_size,
    recounted,
    vector_at,
)
from pipeline.diagnose.linear.linear_model import plain
from pipeline.diagnose.linear.places import leads, pulls
from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import candidates
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle


@pytest.fixture(scope="module")
def packed() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


@pytest.fixture(scope="module")
def payload(packed: PackedVehicle) -> Effect:
    return candidates(packed.context)["payload"]


@pytest.fixture(scope="module")
def every(packed: PackedVehicle, payload: Effect) -> tuple[Coordinate, ...]:
    """Departures of a payload: mass (0), volume (1), then its place."""
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    assert vehicle.model is not None
    return coordinates(packed, {"payload": payload}, vehicle.model.uncertainty)


@pytest.fixture(scope="module")
def place(every: tuple[Coordinate, ...]) -> Coordinate:
    """Where it sits athwart."""
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
    # 20 kg, and the 20 litres that weigh as much in the vehicle's water
    density = float(read(packed.vector, "density"))
    found = pulls(packed, payload, None, placed, needed)
    assert found == pytest.approx((1.0, -density / 1000.0))


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
        # what weighs in water, and a hundredth of the squares of both
        (0.4, 0.3, np.sqrt(0.99 * 0.1**2 + 0.01 * 0.5**2)),
        (0.3, 0.4, -np.sqrt(0.99 * 0.1**2 + 0.01 * 0.5**2)),
        # neither sinks nor floats
        (0.3, 0.3, 0.03 * np.sqrt(2.0)),
    ],
)
def test_how_much_there_is_has_the_sign_of_what_weighs_more(
    place: Coordinate, mass: float, volume: float, size: float
) -> None:
    departures = np.array([mass, volume, 0.0, 0.0, 0.0])
    assert place.lead_size(departures) == pytest.approx(size)


def test_a_place_counted_by_another_size_is_the_same_place(every: tuple[Coordinate, ...]) -> None:
    by_size = counted_by_size(every)
    departures = np.array([0.15, 0.10, 0.01, -0.02, 0.005])
    there = recounted(every, by_size, departures)
    np.testing.assert_allclose(plain(by_size, there), plain(every, departures), rtol=1e-12)
    np.testing.assert_allclose(recounted(by_size, every, there), departures, rtol=1e-12)
    assert there[2] == pytest.approx(0.01 * np.hypot(0.15, 0.10) / every[2].lead_size(departures))
    assert not recounted(every, by_size, np.zeros(5)).any()


def test_the_slope_of_the_size_is_its_derivative(place: Coordinate) -> None:
    there = np.array([0.4, 0.3, 0.0, 0.0, 0.0])
    for k, slope in enumerate(place.lead_slope(there)):
        step = np.zeros(5)
        step[k] = 1e-6
        by = place.lead_size(there + step) - place.lead_size(there - step)
        assert by / 2e-6 == pytest.approx(slope, rel=1e-6)
    assert not place.lead_slope(np.zeros(5)).any()


def test_the_trim_of_a_payload_is_one_straight_departure_whatever_its_mass(
    packed: PackedVehicle, every: tuple[Coordinate, ...]
) -> None:
    """Two modules of the same weight in water and the same product have nearly the same trim."""
    moments = []
    for mass in (0.10, 0.15):
        vector = vector_at(packed, every, plain(every, np.array([mass, mass - 0.05, 0, 0.01, 0])))
        weight, buoyancy = read(vector, "weight"), read(vector, "buoyancy")
        centre = read(vector, "centre_of_mass")
        moments.append(weight * centre - buoyancy * read(vector, "centre_of_buoyancy"))
    empty = read(packed.vector, "weight") * read(packed.vector, "centre_of_mass")
    empty = empty - read(packed.vector, "buoyancy") * read(packed.vector, "centre_of_buoyancy")
    trims = [float(moment[1] - empty[1]) for moment in moments]
    # 0.5 kg that weigh in water at 0.0125 / 0.05 m; counted by mass it would be a third off
    assert trims[0] == pytest.approx(trims[1], rel=0.05)
    assert trims[0] == pytest.approx(0.5 * packed.context.gravity_mps2 * 0.05, rel=0.06)
