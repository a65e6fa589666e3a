"""Wall effect: walls and bottom near by make the water heavier and the drag larger.

Between hull and wall the water must squeeze through a narrower path: it moves faster, so more of
it is set in motion (added mass) and drag grows. Potapov and Galyaev name the walls of their pool
as the second reason for a measured added mass half as large again as computed. For a sphere of
radius R at the distance h from a plane wall the image method gives a factor 1 + (3/8) (R/h)^3 on
the added mass for motion towards the wall and half of that along it. The effect takes this form
with one number c,

    1 + c sum over walls of (R / h)^3

on added mass and damping of all axes, R the vehicle's half width and h never below R. c = 0 is
open water; 0.2 to 0.4 is a sphere, and bluff or flat hulls go well above 1. A candidate where the
vehicle file states the walls.

It shows within two or three half widths of a wall or the bottom, and nowhere else: distance to the
wall is the regressor to look at. Easily taken for `added_mass` and `quadratic_damping` in runs
that never leave the wall; one run in the middle of the pool separates them. The suction towards a
wall of a vehicle that moves along it is not in the term.
"""

from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.effects.forms import adding


def _missing(context: EffectContext) -> str | None:
    if not context.walls:
        return "the vehicle file states no walls or bottom (model.pool.walls)"
    return None


EFFECT = Effect(
    id="wall_effect",
    title="walls and bottom near by add mass and drag",
    source=(
        "Lamb 1932, Hydrodynamics (sphere near a plane wall); Newman 1977, Marine Hydrodynamics; "
        "Potapov and Galyaev, section 4.1, second reason"
    ),
    parameters=(
        Parameter(
            "strength",
            unit="1",
            neutral=0.0,
            plausible=(0.1, 3.0),
            meaning="c in the factor 1 + c (R / h)^3 on added mass and damping",
            possible=(0.0, 20.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("wall_strength",),
    apply=adding(wall_strength="strength"),
    missing=_missing,
)
