"""Which errors of the DVL are sure: known errors, none, errors that are no candidates."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from reckoned_runs import lively, reckoned_run

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.kinematics.instruments import InstrumentErrors, instrument_errors
from pipeline.effects.library import candidates
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

NOISE = (0.01, 0.03)


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    """rov8, its DVL at the origin: the runs are of a motion, not of a vehicle."""
    found = load_vehicle(bundled_vehicle("rov8"))
    assert found.sensors is not None
    assert found.sensors.dvl is not None
    dvl = found.sensors.dvl.model_copy(
        update={"position_m": (0.0, 0.0, 0.0), "rotation_deg": (0.0, 0.0, 0.0)}
    )
    return found.model_copy(update={"sensors": found.sensors.model_copy(update={"dvl": dvl})})


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


def flown(seed: int = 0, wrong: Mapping[str, Any] | None = None) -> tuple[RunTable, ...]:
    return tuple(
        reckoned_run(lively(20.0 * k), **(wrong or {}), noise=NOISE, seed=10 * seed + k)
        for k in range(2)
    )


def found_in(
    vehicle: Vehicle,
    packed: PackedVehicle,
    runs: tuple[RunTable, ...],
    healthy: tuple[RunTable, ...] = (),
    without: tuple[str, ...] = (),
) -> InstrumentErrors | None:
    library = {k: one for k, one in candidates(packed.context).items() if k not in without}
    return instrument_errors(vehicle, packed, library, runs, healthy)


@pytest.mark.parametrize(
    ("wrong", "effect", "values"),
    [
        ({"scale": 1.1}, "dvl_scale", {"scale": 1.1}),
        ({"delay_s": 0.3}, "dvl_delay", {"delay_s": 0.3}),
        ({"arm_m": (0.0, 0.5, 0.0)}, "dvl_lever_arm", {"y_m": 0.5}),
        ({"turn_deg": (0.0, 0.0, 6.0)}, "dvl_misalignment", {"yaw_deg": 6.0}),
    ],
)
def test_an_error_is_named_with_its_value(
    vehicle: Vehicle,
    packed: PackedVehicle,
    wrong: dict[str, Any],
    effect: str,
    values: dict[str, float],
) -> None:
    found = found_in(vehicle, packed, flown(0, wrong))
    assert found is not None
    assert found.effects == (effect,)
    assert found.alike == ()
    assert set(found.parameters[effect]) == set(values)
    for name, value in values.items():
        low, high = found.parameters[effect][name].ci95
        assert low < value < high
        assert found.specs[0].values[name] == found.parameters[effect][name].value


def test_two_errors_are_named_together(vehicle: Vehicle, packed: PackedVehicle) -> None:
    found = found_in(vehicle, packed, flown(0, {"scale": 1.1, "delay_s": 0.4}))
    assert found is not None
    assert found.effects == ("dvl_delay", "dvl_scale")


@pytest.mark.parametrize("seed", range(4))
def test_a_dvl_that_is_well_has_none(vehicle: Vehicle, packed: PackedVehicle, seed: int) -> None:
    assert found_in(vehicle, packed, flown(seed)) is None


def test_what_is_within_its_tolerance_is_none(vehicle: Vehicle, packed: PackedVehicle) -> None:
    assert found_in(vehicle, packed, flown(0, {"scale": 1.01, "delay_s": 0.02})) is None


def test_what_it_was_off_by_when_the_vehicle_was_well_is_none(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    wrong = {"scale": 1.08}
    assert found_in(vehicle, packed, flown(0, wrong)) is not None
    assert found_in(vehicle, packed, flown(0, wrong), healthy=flown(5, wrong)) is None


@pytest.mark.parametrize(
    ("wrong", "effect"),
    [({"delay_s": 0.4}, "dvl_delay"), ({"turn_deg": (0.0, 5.0, 5.0)}, "dvl_misalignment")],
)
def test_an_error_that_is_no_candidate_is_not_taken_for_another(
    vehicle: Vehicle, packed: PackedVehicle, wrong: dict[str, Any], effect: str
) -> None:
    assert found_in(vehicle, packed, flown(0, wrong), without=(effect,)) is None


def test_a_dvl_that_tracks_the_water_is_held_against_nothing(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    assert vehicle.sensors is not None
    assert vehicle.sensors.dvl is not None
    dvl = vehicle.sensors.dvl.model_copy(update={"water_track": True})
    through = vehicle.model_copy(
        update={"sensors": vehicle.sensors.model_copy(update={"dvl": dvl})}
    )
    assert found_in(through, packed, flown(0, {"scale": 1.1})) is None


def test_the_order_of_runs_does_not_matter(vehicle: Vehicle, packed: PackedVehicle) -> None:
    runs = flown(0, {"scale": 1.1})
    one, other = found_in(vehicle, packed, runs), found_in(vehicle, packed, runs[::-1])
    assert one is not None
    assert other is not None
    value, again = (found.parameters["dvl_scale"]["scale"].value for found in (one, other))
    assert value == pytest.approx(again, abs=1e-9)


def test_frozen_readings_of_the_position_make_no_error(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    """Marked as not valid they take no part; there is nothing left to compare."""
    runs = tuple(
        replace(run, valid=run.valid | {"position": np.zeros(run.time_s.size, bool)})
        for run in flown(0, {"scale": 1.1})
    )
    assert found_in(vehicle, packed, runs) is None
