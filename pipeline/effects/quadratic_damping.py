"""Quadratic damping: the drag of the hull differs from the stated one.

The drag of a hull under way goes with the square of speed: friction of the turbulent boundary
layer and, on bluff and open bodies, the pressure behind edges. What is bolted on after the drag
was measured (a lamp, a sonar head, a hose) adds to it. The effect is one factor per axis,

    force_i = -f_i d_i |nu_i| nu_i

with nu the velocity relative to the water and the sign of the square kept, so it opposes motion in
both directions (Voitasyk 2018 prints it without the sign).

It shows as another steady speed at the same code, most at full speed, and in the early part of a
coast-down. Easily taken for `advance_speed_loss` and `thrust_deduction` (the coast-down separates
them), for `tether` (whose drag acts at its point of attachment and in every direction alike, not
along one axis) and for `linear_damping` on runs of one speed.
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.change import scale
from pipeline.effects.effect import AXES, Effect, EffectContext, Parameter
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    scale(vector, "quadratic_damping", np.array([values[axis] for axis in AXES]))


EFFECT = Effect(
    id="quadratic_damping",
    title="drag of the hull differs",
    source="Hoerner 1965, Fluid-Dynamic Drag; Voitasyk 2018 (T_H, with the sign of speed kept)",
    parameters=tuple(
        Parameter(
            axis,
            unit="1",
            neutral=1.0,
            plausible=(0.5, 2.0),
            meaning=f"factor on the quadratic damping in {axis}",
            possible=(0.0, 100.0),
        )
        for axis in AXES
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("quadratic_damping",),
    apply=_apply,
)
