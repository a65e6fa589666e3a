"""The plain methods name a large fault where nothing else is wrong, and refuse without a DVL."""

import dataclasses

import numpy as np
import pytest

from evaluation.baselines import bic_baseline, sparse_baseline
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def rov8() -> tuple[Vehicle, PackedVehicle]:
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    return vehicle, pack_vehicle(vehicle)


def flown(vehicle: Vehicle, packed: PackedVehicle, *specs: EffectSpec) -> RunTable:
    assert vehicle.sensors is not None
    vector = apply_effects(packed.vector, specs, packed.context)
    plan = MANOEUVRES["multisine"].plan(packed, 1.0, 45.0)
    trajectory = fly(packed, plan, vector=vector)
    log = measure(trajectory, packed, vehicle.sensors, vector=vector, seed=1)
    return table_of_log(log, vehicle.sensors)


def test_a_large_fault_is_named(rov8: tuple[Vehicle, PackedVehicle]) -> None:
    vehicle, packed = rov8
    run = flown(vehicle, packed, EffectSpec("residual_buoyancy", {"force_n": 8.0}))
    assert bic_baseline(vehicle, packed, (run,)) in {"residual_buoyancy", "payload", "tether"}
    assert sparse_baseline(vehicle, packed, (run,)) in {"residual_buoyancy", "payload"}


def test_without_a_velocity_or_a_whole_window_they_refuse(
    rov8: tuple[Vehicle, PackedVehicle],
) -> None:
    vehicle, packed = rov8
    run = flown(vehicle, packed)
    values = {name: part for name, part in run.values.items() if name != "velocity"}
    blind = dataclasses.replace(run, values=values)
    assert bic_baseline(vehicle, packed, (blind,)) == "refused"
    assert sparse_baseline(vehicle, packed, (blind,)) == "refused"
    assert (
        bic_baseline(vehicle, packed, (run.rows(0, int(np.searchsorted(run.time_s, 8.0))),))
        == "refused"
    )
