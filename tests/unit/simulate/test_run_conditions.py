"""What the notes of a run say, as fits and flights take it."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.records.pool_run import (
    BallastItem,
    RunEvent,
    RunNotes,
    TetherNotes,
    WaterNotes,
)
from pipeline.simulate.events import PayloadSchedule, vector_with_modules
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.pack_hull import vector_under
from pipeline.simulate.run_conditions import RunSetup, run_setup
from pipeline.vehicle.attachment_schema import Ballast
from pipeline.vehicle.schema import Vehicle

LEAD = BallastItem(what="lead", mass_kg=4.0, displaced_kg=0.35, position_m=(0.3, 0.0, 0.1))


@pytest.fixture(scope="module")
def vehicle(repository: Path) -> Vehicle:
    return bundled(repository, "cargo_carrier")


@pytest.fixture(scope="module")
def carrier(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


def setup(vehicle: Vehicle, notes: RunNotes) -> RunSetup:
    assert vehicle.model is not None
    return run_setup(vehicle, vehicle.model, notes)


def test_a_module_let_go_is_gone_from_the_vector_of_then(
    carrier: PackedVehicle, vehicle: Vehicle
) -> None:
    notes = RunNotes(events=(RunEvent(at_s=20.0, release="module_1"),))
    known = setup(vehicle, notes)
    assert known.times_s == (0.0, 20.0)
    assert vector_under(known.conditions(19.9), carrier.vector) is carrier.vector
    after = vector_under(known.conditions(20.0), carrier.vector)
    assert vehicle.model is not None
    expected = vector_with_modules(carrier, vehicle.model, frozenset({"module_2"}))
    np.testing.assert_allclose(after, expected, rtol=1e-12, atol=1e-12)


def test_ballast_of_the_notes_is_that_of_the_vehicle_file(
    carrier: PackedVehicle, vehicle: Vehicle
) -> None:
    """Of a run or for good: the same parameter vector."""
    model = vehicle.model
    assert model is not None
    volume = 0.35 / vehicle.water.density_kgpm3
    stays = Ballast(what="lead", mass_kg=4.0, volume_m3=volume, position_m=(0.3, 0.0, 0.1))
    heavier = vehicle.model_copy(update={"model": model.model_copy(update={"ballast": (stays,)})})
    known = setup(vehicle, RunNotes(ballast=(LEAD,))).conditions(0.0)
    found = vector_under(known, carrier.vector)
    np.testing.assert_allclose(found, pack_vehicle(heavier).vector, rtol=1e-12, atol=1e-12)
    assert read(found, "mass") == pytest.approx(246.9)


def test_density_moves_buoyancy_and_what_water_makes(
    carrier: PackedVehicle, vehicle: Vehicle
) -> None:
    water = WaterNotes(density_kgpm3=1000.0)
    found = vector_under(setup(vehicle, RunNotes(water=water)).conditions(0.0), carrier.vector)
    share = 1000.0 / 1025.0
    for name in ("density", "buoyancy", "added_mass", "quadratic_damping"):
        np.testing.assert_allclose(read(found, name), share * read(carrier.vector, name))
    for name in ("mass", "weight", "linear_damping", "thrust_gain"):
        np.testing.assert_array_equal(read(found, name), read(carrier.vector, name))


def test_a_flight_carries_what_a_fit_takes(carrier: PackedVehicle, vehicle: Vehicle) -> None:
    """Modules come and go by the schedule, ballast beside them; a fit takes both as bodies."""
    notes = RunNotes(
        payloads=("module_1",),
        ballast=(LEAD,),
        events=(
            RunEvent(at_s=5.0, attach="module_2"),
            RunEvent(at_s=8.0, ballast=LEAD.model_copy(update={"mass_kg": -4.0})),
        ),
    )
    known = setup(vehicle, notes)
    schedule = PayloadSchedule(
        carrier,
        known.model,
        known.events,
        carried=known.carried,
        carried_from_s=[from_s for from_s, _ in known.ballast],
    )
    assert schedule.times_s == (5.0, 8.0)
    state = np.zeros(64)
    state[3] = 1.0
    for time_s in (0.0, 5.0, 8.0):
        _, vector = schedule.change(time_s, state)
        expected = vector_under(known.conditions(time_s), carrier.vector)
        np.testing.assert_allclose(vector, expected, rtol=1e-12, atol=1e-12)
    shifted = known.later(-6.0)
    assert shifted.times_s == (0.0, 2.0)


@pytest.mark.parametrize(
    ("notes", "told"),
    [
        (RunNotes(payloads=("module_7",)), "has no module module_7"),
        (RunNotes(events=(RunEvent(at_s=1.0, attach="module_1"),)), "is already on board then"),
    ],
)
def test_notes_that_do_not_fit_the_vehicle_are_refused(
    vehicle: Vehicle, notes: RunNotes, told: str
) -> None:
    with pytest.raises(CannotComputeError, match=told):
        setup(vehicle, notes)


def test_what_cannot_be_taken_is_told(vehicle: Vehicle) -> None:
    light = BallastItem(what="foam", mass_kg=0.2)
    known = setup(vehicle, RunNotes(ballast=(light,)))
    assert known.conditions(0.0).as_stated
    assert "displaced_kg" in known.notes[0]


def test_the_tether_of_the_day(vehicle: Vehicle) -> None:
    off = setup(vehicle, RunNotes(tether=TetherNotes(attached=False)))
    assert off.model.tether is None
    long = setup(vehicle, RunNotes(tether=TetherNotes(attached=True, paid_out_m=150.0)))
    tether = long.model.tether
    assert tether is not None
    assert tether.length_m == 150.0
    assert tether.winch is not None
    assert 2.0 * tether.length_m / tether.segments <= tether.winch.shortest_m
