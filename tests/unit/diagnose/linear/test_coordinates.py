"""Departures and the parameter vectors that they stand for."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.linear.coordinates import Coordinate, coordinates, specs_at, vector_at
from pipeline.diagnose.linear.linear_model import plain, realisable
from pipeline.effects.library import candidates, unstated
from pipeline.physics.parameters import read
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import run
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle

Rov8 = tuple[PackedVehicle, tuple[Coordinate, ...], dict[str, int]]


@pytest.fixture(scope="module")
def rov8() -> Rov8:
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    packed = pack_vehicle(vehicle)
    assert vehicle.model is not None
    effects = {**candidates(packed.context), **unstated(packed.context)}
    every = coordinates(packed, effects, vehicle.model.uncertainty)
    return packed, every, {one.name: k for k, one in enumerate(every)}


def test_no_departure_is_the_nominal_vehicle_bit_for_bit(rov8: Rov8) -> None:
    packed, every, _ = rov8
    assert np.array_equal(vector_at(packed, every, np.zeros(len(every))), packed.vector)


def test_what_the_file_states_is_the_ordinary_width(rov8: Rov8) -> None:
    _, every, place = rov8
    weak = every[place["thruster_degraded:thrust_fraction@rear_left"]]
    assert weak.ordinary * weak.unit_size == pytest.approx(0.03)
    assert every[place["current:north_mps"]].ordinary == 0.0


def test_a_factor_on_nothing_is_no_coordinate(rov8: Rov8) -> None:
    # the file has no linear damping in sway
    _, _, place = rov8
    assert "linear_damping:sway" not in place
    assert "linear_damping:surge" in place


def test_the_place_of_a_payload_needs_its_mass(rov8: Rov8) -> None:
    _, every, place = rov8
    leads = (place["payload:mass_kg"], place["payload:volume_m3"])
    assert every[place["payload:x_m"]].leads == leads
    x = np.zeros(len(every))
    x[place["payload:x_m"]] = 0.5
    assert not plain(every, x).any()
    x[place["payload:mass_kg"]] = 0.25
    spec = specs_at(every, plain(every, realisable(every, x)))[0]
    assert spec.values["x_m"] == pytest.approx(0.5 / 0.25 * every[place["payload:x_m"]].unit_size)


def test_beyond_what_is_possible_the_vector_goes_on_as_it_came(rov8: Rov8) -> None:
    packed, every, place = rov8
    index = place["dead_zone:codes"]
    ways = []
    for value in (0.1, -0.1):
        x = np.zeros(len(every))
        x[index] = value
        ways.append(vector_at(packed, every, x) - packed.vector)
    np.testing.assert_allclose(ways[0], -ways[1])
    assert read(ways[1], "dead_zone")[0] == pytest.approx(-0.1 * every[index].unit_size)


def test_the_form_of_the_lag_stays_where_it_is_one(rov8: Rov8) -> None:
    """A motor that adds a dead zone to its code jumps at every zero: no derivative means that."""
    _, every, place = rov8
    form, zone = place["lag_form:dead_share"], place["dead_zone:codes"]
    x = np.zeros(len(every))
    x[[form, zone]] = -1.0
    kept = realisable(every, x)
    assert kept[form] == 0.0
    assert -1.0 < kept[zone] < 0.0
    x[form] = 9.0
    assert realisable(every, x)[form] * every[form].unit_size == pytest.approx(1.0)


def test_no_departure_has_a_kink_at_neutral(rov8: Rov8) -> None:
    """A step to one side moves the vehicle as far as one to the other, the other way."""
    packed, every, _ = rov8
    flown = fly(packed, MANOEUVRES["multisine"].plan(packed, 1.0, 8.0))

    def velocity(departures: FloatArray) -> FloatArray:
        vector = vector_at(packed, every, departures)
        return run(packed, flown.command[:400], dt_s=0.02, vector=vector).nu

    nominal = velocity(np.zeros(len(every)))
    for index, one in enumerate(every):
        if one.leads:
            continue
        step = np.zeros(len(every))
        step[index] = 3e-4
        forward, back = velocity(step) - nominal, velocity(-step) - nominal
        uneven = np.linalg.norm(forward + back) / max(float(np.linalg.norm(forward)), 1e-9)
        assert uneven < 0.1, one.name
