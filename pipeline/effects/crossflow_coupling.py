"""Cross-flow coupling: drifting and turning together drag more than each alone.

When the hull drifts and turns, bow and stern meet the water sideways at different speeds, v + x r
at a station x. Strip by strip the drag goes with the square of that local speed, and the square of
a sum is not the sum of the squares: drift makes a yaw moment when turning, and turning a side
force when drifting. Sway with yaw (heights of the strips) and, likewise, heave with pitch
(breadths). With the drag of each motion alone left to the damping of its axis, the coupling is

    Y = -1/2 rho C_d integral of h(x) [ |s| s - |v| v - |x r| x r ] dx,     s = v + x r
    N = the same with x h(x)

The effect is the fraction of this that is at work, 0 none and 1 all of it. A candidate where the
vehicle file gives the sections of the hull and the nominal model leaves the coupling out.

It shows in turns with drift (zig-zag, spiral, a turn in a current), in sway and yaw together.
Easily taken for the sway or yaw factor of `quadratic_damping` when a run always turns with the
same drift, for `added_mass` in sway and for `coriolis_omitted` (which is there at the smallest
turning rates in proportion to u r; the cross-flow is of second order in drift and turn).
"""

from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.effects.forms import adding


def _missing(context: EffectContext) -> str | None:
    if not context.strips:
        return "the vehicle file gives no hull sections (model.crossflow.sections)"
    if context.crossflow_in_nominal:
        return "the nominal model has the cross-flow already (model.crossflow.in_nominal)"
    return None


EFFECT = Effect(
    id="crossflow_coupling",
    title="drift and turning together drag more than each alone",
    source=(
        "Faltinsen 1990, Sea Loads on Ships and Offshore Structures, chapter 6 (cross-flow "
        "principle); Fossen 2021, chapter 6"
    ),
    parameters=(
        Parameter(
            "fraction",
            unit="1",
            neutral=0.0,
            plausible=(0.3, 1.2),
            meaning="share of the strips' coupling between sway and yaw, heave and pitch",
            possible=(0.0, 2.0),
        ),
    ),
    channels=("v", "w", "q", "r"),
    vector_slots=("crossflow_fraction",),
    apply=adding(crossflow_fraction="fraction"),
    missing=_missing,
)
