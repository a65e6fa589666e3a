"""Advance-speed loss: the inflow reduces a propeller's thrust.

The mooring characteristic holds at rest only. Under way the water already moves through the
propeller disc, the angle of attack of the blades falls, and so does the thrust at the same code
(Kostenko 2023, sections 3 to 5: 42 N at rest, 25 N at 2 m/s for the code 127). The thrust is

    T = T(N, k V)

with N the code, V the speed of the water along the thruster's axis (the vehicle's own motion at
the thruster's place included) and k the fraction of that inflow which reaches the blades. At 0 the
thrust is as moored, at 1 the full open-water inflow counts. In the wake of the hull k is below 1
(the wake fraction of a naval architect is w = 1 - k); between 0.6 and 1 is usual.

Where the vehicle file holds the mooring curve alone, the neutral value is 0. Where its model lets
the thrust fall with speed, it is the stated 1 - w ("wake_fraction", mean over the thrusters,
whose inflows are scaled alike); a departure within the width stated there is ordinary, one beyond
it is this effect.

It shows as a speed that stays behind at high codes and not at low ones, and as turning moments
that weaken under way. Easily taken for quadratic damping in surge (both grow with speed; a
coast-down with stopped thrusters separates them, since the damping stays) and for thrust deduction
(which is there at rest as well: a static pull separates them).
"""

from collections.abc import Mapping
from dataclasses import replace

from pipeline.effects.effect import Effect, EffectContext, Parameter, add, scale
from pipeline.types import FloatArray

#: Standard uncertainty of the share of the inflow where the vehicle file states none.
USUAL_WIDTH = 0.1
#: What is plausible reaches at least so far on either side of the stated share.
BESIDE = 0.1


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, context: EffectContext
) -> None:
    fitted, fraction = slice(len(context.thruster_names)), values["inflow_fraction"]
    if context.thrust_falls_with_speed:
        scale(vector, "inflow_fraction", fraction / context.inflow_share, fitted)
    else:
        add(vector, "inflow_fraction", fraction, fitted)


def _stated(parameters: tuple[Parameter, ...], context: EffectContext) -> tuple[Parameter, ...]:
    if not context.thrust_falls_with_speed:
        return parameters
    (fraction,) = parameters
    share, width = context.inflow_share, context.wake_std
    low, high = fraction.plausible
    return (
        replace(
            fraction,
            neutral=share,
            plausible=(min(low, share - BESIDE), max(high, share + BESIDE)),
            ordinary=USUAL_WIDTH if width is None else width,
        ),
    )


EFFECT = Effect(
    id="advance_speed_loss",
    title="thrust falls with speed through the water",
    source=(
        "Kostenko 2023, sections 1, 3 and 5; wake fraction: Carlton, Marine Propellers and "
        "Propulsion, chapter on the wake field"
    ),
    parameters=(
        Parameter(
            "inflow_fraction",
            unit="1",
            neutral=0.0,
            plausible=(0.2, 1.1),
            meaning="share of the inflow that reaches the blades; 1 is open water",
            possible=(0.0, 2.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("inflow_fraction",),
    apply=_apply,
    of_thrusters=True,
    stated=_stated,
)
