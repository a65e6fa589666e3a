"""What of a departure the drives' state depends on."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.diagnose.linear.predictions import other_drives
from pipeline.effects.library import EffectSpec, apply_effects, candidates, unstated
from pipeline.physics.parameters import write
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.pack import pack_vehicle


@pytest.mark.parametrize("vehicle", ["cargo_carrier", "rov8"])
def test_other_drives_are_those_whose_state_differs(vehicle: str, repository: Path) -> None:
    """A piece of a simulation that begins with another vehicle's drives has wrong derivatives."""
    packed = pack_vehicle(bundled(repository, vehicle))
    write(packed.vector, "lag", 0.15)
    names = packed.thruster_names
    wave = np.sin(0.3 * np.arange(200))[:, None] * np.linspace(20.0, 90.0, len(names))
    stated = actuator_states(packed, wave, 0.02)
    for effect in (candidates(packed.context) | unstated(packed.context)).values():
        values = {one.name: sum(one.plausible) / 2.0 for one in effect.parameters}
        target = names[0] if effect.scope == "thruster" else None
        vector = apply_effects(
            packed.vector, [EffectSpec(effect.id, values, target)], packed.context
        )
        moved = not np.array_equal(stated, actuator_states(packed, wave, 0.02, vector=vector))
        assert other_drives(vector, packed.vector) == moved, effect.id
