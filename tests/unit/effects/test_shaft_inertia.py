"""Shaft inertia: what the factor becomes, where it is a candidate, and what the shafts then do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled, mmt300_bench
from effect_cases import CONTEXT, changed_slots, same_bits, sample_vector

from pipeline.effects.library import EffectSpec, apply_effects, candidates, why_not
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read, write
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import initial_state, run
from pipeline.types import FloatArray

BALANCED = replace(CONTEXT, lagged=False)
CODES = np.array([30.0, 60.0, 90.0, 127.0, -60.0])


def with_factor(vector: FloatArray, factor: float) -> FloatArray:
    return apply_effects(vector, [EffectSpec("shaft_inertia", {"factor": factor})], BALANCED)


@pytest.fixture(scope="module")
def in_time(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> PackedVehicle:
    """mmt300 with the torque balance of its shafts solved in time."""
    vehicle = bundled(repository, "mmt300")
    assert vehicle.model is not None
    drive = vehicle.model.thrusters["at_drive"].model_copy(update={"balance_in_time": True})
    model = vehicle.model.model_copy(update={"thrusters": {"at_drive": drive}})
    bench = mmt300_bench(repository, tmp_path_factory)
    return pack_vehicle(vehicle.model_copy(update={"model": model}), bench)


@pytest.fixture(scope="module")
def held(in_time: PackedVehicle) -> PackedVehicle:
    """The same, so heavy that no thrust moves it: the shafts turn in water at rest."""
    vector = in_time.vector.copy()
    write(vector, "mass", 1e12)
    write(vector, "inertia", 1e12 * np.eye(3))
    write(vector, "weight", float(read(vector, "buoyancy")))
    return replace(in_time, vector=vector)


def shafts(packed: PackedVehicle, vector: FloatArray, dt_s: float) -> FloatArray:
    """Shaft speeds over 200 steps after a step of the codes, (201, 5)."""
    flown = run(packed, np.tile(CODES, (200, 1)), dt_s=dt_s, vector=vector, start=initial_state())
    return flown.actuator[:, : CODES.size]


def test_every_shaft_has_the_factor_and_nothing_else_changes() -> None:
    vector = sample_vector()
    changed = with_factor(vector, 2.5)
    assert changed_slots(vector, changed) == {"rotor_inertia"}
    assert read(changed, "rotor_inertia")[:6] == pytest.approx([3.5e-4] * 5 + [0.0], rel=1e-15)


def test_a_vehicle_has_this_or_the_lag() -> None:
    """Both are delays of the shaft: one model has the one, the other model the other."""
    assert "thruster_lag" in candidates(CONTEXT)
    assert "shaft_inertia" not in candidates(CONTEXT)
    assert "balance_in_time" in why_not(CONTEXT)["shaft_inertia"]
    assert "thruster_lag" not in candidates(BALANCED)
    assert "shaft_inertia" in candidates(BALANCED)
    with pytest.raises(CannotComputeError, match="shaft_inertia cannot be switched on here"):
        apply_effects(sample_vector(), [EffectSpec("shaft_inertia", {"factor": 2.0})], CONTEXT)


def test_neutral_flies_the_same_bit_for_bit(in_time: PackedVehicle) -> None:
    assert "shaft_inertia" in candidates(in_time.context)
    vector = with_factor(in_time.vector, 1.0)
    assert same_bits(vector, in_time.vector)
    one, other = (
        run(in_time, np.tile(CODES, (100, 1)), dt_s=0.005, vector=v, start=initial_state())
        for v in (vector, in_time.vector)
    )
    assert one.nu.tobytes() == other.nu.tobytes()
    assert one.actuator.tobytes() == other.actuator.tobytes()


def test_time_stretches_with_the_factor(held: PackedVehicle) -> None:
    """dn/dt goes with 1/J, so in water at rest n(t) of four times the inertia is n(t / 4)."""
    heavy = shafts(held, with_factor(held.vector, 4.0), 0.008)
    plain = shafts(held, held.vector, 0.002)
    assert np.abs(plain[-1]).min() > 1.0
    assert heavy == pytest.approx(plain, rel=1e-9, abs=1e-9)
