"""Tether: a cable drags and pulls at the vehicle.

The communication cable of an ROV, or the safety line of an AUV on trial, is towed through the
water and hangs on to something. On a working vehicle its pull reaches that of the hull's drag
(Kostenko and Mokeeva 2009: 54 to 213 N at the vehicle with 200 m of 14 mm cable). The effect lumps
the cable at its point of attachment. With v_t the velocity of that point relative to the water,

    F = -1/2 rho (C_d A) |v_t| v_t  +  T (direction to the anchor)

C_d A is the drag area of what is towed, the same in every direction, and T a constant pull towards
the upper end of the cable. Both turn the vehicle through the lever arm of the point. Drag area and
pull come on top of what the nominal model holds of a tether. Point and anchor are those of the
vehicle file's tether; a vehicle without one is pulled at its body origin, towards where the
manoeuvres start at the surface (0, 0, 0 in NED). Shape, weight and slack of the cable are not in
it: a cable that goes taut at some distance, or snags, is another matter (`unknown`).

It shows as a drag that always opposes the motion of the attachment, in sway and heave as well as
ahead, as a pull whose direction in the body turns with heading and place, and as a moment when the
attachment is off centre. Easily taken for `quadratic_damping` (which has one number per axis and
no lever arm), for `current` (no dependence on place), for `linear_damping` and `added_mass`. Legs
at different distances and headings, and with the cable at rest, separate them.
"""

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.forms import adding

EFFECT = Effect(
    id="tether",
    title="a cable drags and pulls at the vehicle",
    source="Kostenko and Mokeeva 2009, eq. (1), Tables 2 and 3; Hoerner 1965, Fluid-Dynamic Drag",
    parameters=(
        Parameter(
            "drag_area_m2",
            unit="m^2",
            neutral=0.0,
            plausible=(0.005, 2.0),
            grows=2,
            meaning="drag coefficient times area of the cable that is towed",
            possible=(0.0, 100.0),
        ),
        Parameter(
            "pull_n",
            unit="N",
            neutral=0.0,
            plausible=(1.0, 100.0),
            grows=2,
            meaning="constant pull towards the upper end of the cable",
            possible=(0.0, 10000.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "x", "y", "z"),
    vector_slots=("tether_drag_area", "tether_pull"),
    apply=adding(tether_drag_area="drag_area_m2", tether_pull="pull_n"),
)
