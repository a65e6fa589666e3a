"""The directions in which a vehicle may differ, and how far."""

from dataclasses import replace

import numpy as np
from diagnosis_cases import index_of, small_case, small_coordinates

from pipeline.diagnose.coordinates import coordinates, specs_at
from pipeline.effects.library import apply_effects, candidates
from pipeline.physics.parameters import read
from pipeline.vehicle.model_schema import Uncertainty


def test_nothing_is_taken_off_that_is_heavier_than_the_vehicle() -> None:
    packed = small_case(seconds=4.0, manoeuvres=("prbs",)).packed
    mass = small_coordinates(("payload",))
    heavy = mass[index_of(mass, "payload:mass_kg")]
    light = packed.vector.copy()
    read(light, "mass")[...] = 4.0
    every = coordinates(
        replace(packed, vector=light),
        {"payload": candidates(packed.context)["payload"]},
        Uncertainty(),
    )
    own = every[index_of(every, "payload:mass_kg")]
    low, high = (own.value(end) for end in own.bounds)
    assert -4.0 < low < -3.9
    assert high == heavy.value(heavy.bounds[1])
    for end in own.bounds:
        apply_effects(light, specs_at([own], np.array([end])), packed.context)
