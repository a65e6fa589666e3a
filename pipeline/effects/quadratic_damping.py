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

from pipeline.effects.effect import AXES, Effect
from pipeline.effects.forms import factors_by_axis, scale_axes

EFFECT = Effect(
    id="quadratic_damping",
    title="drag of the hull differs",
    source="Hoerner 1965, Fluid-Dynamic Drag; Voitasyk 2018 (T_H, with the sign of speed kept)",
    parameters=factors_by_axis(
        (f"factor on the quadratic damping in {axis}" for axis in AXES),
        plausible=(0.5, 2.0),
        possible=(0.0, 100.0),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("quadratic_damping",),
    apply=scale_axes("quadratic_damping"),
)
