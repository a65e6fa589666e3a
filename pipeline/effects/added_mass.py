"""Added mass: the water that is set in motion with the hull weighs more, or less, than stated.

A body that accelerates must accelerate the water around it. Per axis that is a mass (surge, sway,
heave) or a moment of inertia (roll, pitch, yaw) on top of the vehicle's own. Shape formulas miss
it easily: an open frame, water inside the fairing, floats and grips, or a tank's walls. Potapov
and Galyaev computed 12.0 kg in surge and measured 18.9 kg. The effect is one factor f per axis on
the rows and columns of the added-mass matrix,

    A_ij -> sqrt(f_i f_j) A_ij

so the matrix stays symmetric and positive definite, as the kinetic energy of water demands. The
Coriolis and centripetal terms, and with them the Munk moment, follow by themselves.

It shows where the vehicle speeds up and slows down, with thrust and without; in steady straight
motion it vanishes, in a steady turn the Coriolis terms remain. Easily taken for `thruster_lag` and
`thrust_deduction` (the coast-down separates them), for `payload` (which has weight as well), for
`linear_damping` on runs that never reach a steady speed, and, close to a wall, for `wall_effect`
(which depends on the distance).
"""

from pipeline.effects.effect import AXES, Effect
from pipeline.effects.forms import factors_by_axis, scale_rows_and_columns

EFFECT = Effect(
    id="added_mass",
    title="the water moved with the hull is more or less than stated",
    source=(
        "Potapov and Galyaev (added masses from shapes against a measured one); Newman 1977, "
        "Marine Hydrodynamics, chapter 4; Fossen 2021, chapter 6"
    ),
    parameters=factors_by_axis(
        (
            f"factor on the added {'mass' if i < 3 else 'inertia'} in {axis}"
            for i, axis in enumerate(AXES)
        ),
        plausible=(0.5, 2.0),
        possible=(0.01, 100.0),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("added_mass",),
    apply=scale_rows_and_columns("added_mass"),
)
