"""A vehicle for the tests of the effects: every slot filled with a number that is not neutral."""

import numpy as np

from pipeline.effects.effect import EffectContext
from pipeline.physics.parameters import LENGTH, SLOTS, neutral_vector, offset, read, write
from pipeline.types import FloatArray

GRAVITY_MPS2 = 9.81
NAMES = ("upper", "lower", "left", "right", "bow")
#: A nominal model that lacks every term that can be lacking, with everything known and measured.
#: Its thrusters have a lag; where the balance of the shafts is solved in time, `lagged` is False.
CONTEXT = EffectContext(
    thruster_names=NAMES,
    thrust_falls_with_speed=False,
    coriolis=False,
    strips=True,
    walls=True,
    gravity_mps2=GRAVITY_MPS2,
    measured=frozenset({"dvl", "imu", "depth"}),
    munk_held=(18.0, -7.0),
)


def sample_vector() -> FloatArray:
    """A 300 kg vehicle with 5 thrusters; off-diagonal terms, and a minus zero here and there."""
    rng = np.random.default_rng(3)
    vector = neutral_vector()
    write(vector, "mass", 300.0)
    write(vector, "weight", 300.0 * GRAVITY_MPS2)
    write(vector, "buoyancy", 2950.0)
    write(vector, "density", 1000.62)
    write(vector, "centre_of_mass", np.array([0.02, -0.0, 0.03]))
    write(vector, "centre_of_buoyancy", np.array([0.02, 0.01, -0.0]))
    write(vector, "inertia", np.diag([9.0, 80.0, 78.0]) - 0.3)
    for name, size in (("added_mass", 40.0), ("linear_damping", 12.0)):
        half = rng.normal(size=(6, 6))
        full = size * (np.eye(6) + 0.1 * half @ half.T)
        write(vector, name, (full + full.T) / 2.0)
    write(vector, "quadratic_damping", np.array([30.0, 200.0, 210.0, 5.0, 90.0, 95.0]))
    write(vector, "turnover_slope", np.array([18.0, -0.0]))
    write(vector, "thruster_count", len(NAMES))
    for name in ("thrust_gain", "reverse_gain"):
        read(vector, name)[: len(NAMES)] = rng.uniform(0.8, 1.1, len(NAMES))
    read(vector, "lag")[: len(NAMES)] = 0.1
    read(vector, "rotor_inertia")[: len(NAMES)] = 1.4e-4
    read(vector, "dead_zone")[1] = -0.0
    write(vector, "current", np.array([0.1, -0.0, 0.0]))
    write(vector, "dvl_scale", 1.01)
    return vector


def changed_slots(before: FloatArray, after: FloatArray) -> set[str]:
    """Slots in which any bit differs."""
    one, other = before.view(np.int64), after.view(np.int64)
    differs = one != other
    return {s.name for s in SLOTS if differs[offset(s.name) : offset(s.name) + s.size].any()}


def same_bits(one: FloatArray, other: FloatArray) -> bool:
    assert one.shape == other.shape == (LENGTH,)
    return one.tobytes() == other.tobytes()
