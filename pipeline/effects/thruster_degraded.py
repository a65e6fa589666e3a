"""Degraded thruster: one thruster gives less than its characteristic says.

Weed or line around the shaft, a chipped or bent blade, a worn bearing, a lost magnet or a dead
phase take thrust from one thruster while the others are sound. The effect is a factor on that
thruster's thrust, for both directions of rotation:

    T_i = f T(N_i, V_i),     f = 1 sound, f = 0 dead

It shows as a steady turn or trim that comes with the thruster's command and changes sign with it,
and as a controller that holds a heading or pitch with a lasting moment. Which thruster it is
follows from the pattern over the six axes, so the runs must use the thrusters in more than one
combination: on a straight course a weak thruster on port cannot be told from a misaligned one or
from a current that veers. Easily taken for `thruster_misalignment` of the same thruster and, with
stern thrusters only, for `cg_shift` across. A shaft speed below that of its neighbours at the same
code names it at once.
"""

from collections.abc import Mapping

from pipeline.effects.effect import Effect, EffectContext, Parameter, scale
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], target: int | None, _context: EffectContext
) -> None:
    if target is None:
        raise ValueError("thruster_degraded needs the index of a thruster")
    scale(vector, "thrust_gain", values["thrust_fraction"], slice(target, target + 1))


EFFECT = Effect(
    id="thruster_degraded",
    title="one thruster gives less thrust",
    source="Alessandri, Caccia and Veruggio 1999, Control Engineering Practice 7(3), 357-368",
    parameters=(
        Parameter(
            "thrust_fraction",
            unit="1",
            neutral=1.0,
            plausible=(0.0, 0.95),
            meaning="thrust over that of the characteristic; 0 is a dead thruster",
            possible=(0.0, 2.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "psi"),
    vector_slots=("thrust_gain",),
    apply=_apply,
    scope="thruster",
)
