"""Linear damping: resistance in proportion to speed differs from the stated one.

At small speeds the skin friction of laminar flow, openings, brushes and cables give a force that
goes with the first power of speed; a quadratic drag alone lets a slow vehicle glide for ever. The
effect is one factor f per axis on the linear damping matrix,

    D_ij -> sqrt(f_i f_j) D_ij

so a matrix that takes energy out goes on doing so. An axis whose stated linear damping is zero
stays without.

It shows at hover, in slow drift, at the end of a coast-down and in the decay of roll and pitch
once the swing is small; at full speed the quadratic part hides it. Easily taken for
`quadratic_damping` when a run has one speed only (a wide range of speeds separates them), for
`dead_zone` (which acts on thrust, not on the coast-down), for `tether` and for `current` (which
pushes also a vehicle at rest).
"""

from pipeline.effects.effect import AXES, Effect
from pipeline.effects.forms import factors_by_axis, scale_rows_and_columns

EFFECT = Effect(
    id="linear_damping",
    title="resistance in proportion to speed differs",
    source="Fossen 2021, chapter 6 (linear damping of underwater vehicles)",
    parameters=factors_by_axis(
        (f"factor on the linear damping in {axis}" for axis in AXES),
        plausible=(0.3, 3.0),
        possible=(0.0, 100.0),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("linear_damping",),
    apply=scale_rows_and_columns("linear_damping"),
)
