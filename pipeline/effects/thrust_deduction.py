"""Thrust deduction: the hull takes back a share of the thrust.

A propeller measured alone in a tank pulls water from all around. Behind a hull it pulls that water
off the stern, lowers the pressure there, and so draws the hull back: of the thrust T only (1 - t)
T drives the vehicle. Frames, floats and nozzle struts in the jet or the inflow do the same. The
effect is one factor for all thrusters and both signs:

    T_i = (1 - t) T(N_i, V_i)

The neutral value is the t that the vehicle file states ("thrust_deduction" of its model, mean over
the thrusters; 0 where it says nothing); the thrusters are scaled alike from there. The width stated
beside it is ordinary, or the uncertainty of the thrust where none is.

A naval architect would object to one t for both signs, and rightly: ahead, t comes from suction on
the stern and is 0.05 to 0.25; astern, the jet itself strikes the hull and the loss is usually
larger. The library keeps one number so that what is special to astern stays a matter of
`reverse_thrust`; a vehicle with both is named as the pair. Also, t of ships is defined at the
self-propulsion point and changes towards bollard pull.

It shows at every speed and code level alike, in the static pull too. Easily taken for a high drag
or a high added mass: with all forces a tenth too small the vehicle accelerates and settles as if
it were heavier and fuller, and only what does not come from the thrusters (coast-down, free decay,
weight and buoyancy, a bollard pull) fixes the scale.
"""

from collections.abc import Mapping
from dataclasses import replace

from pipeline.effects.effect import Effect, EffectContext, Parameter, scale
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, context: EffectContext
) -> None:
    fitted = slice(len(context.thruster_names))
    # at the stated value exactly 1, whatever rounding leaves of 1 - t
    stated = 1.0 - (1.0 - context.thrust_share)
    scale(vector, "thrust_gain", (1.0 - values["t"]) / stated, fitted)


def _stated(parameters: tuple[Parameter, ...], context: EffectContext) -> tuple[Parameter, ...]:
    (fraction,) = parameters
    neutral, (low, high) = 1.0 - context.thrust_share, fraction.plausible
    if neutral != 0.0:
        # there is less of it on another hull, or none
        low, high = min(0.0, neutral - low), max(high, neutral + low)
    ordinary = context.deduction_std or 0.0
    return (replace(fraction, neutral=neutral, plausible=(low, high), ordinary=ordinary),)


EFFECT = Effect(
    id="thrust_deduction",
    title="the hull takes back a share of all thrust",
    source=(
        "Harvald 1983, Resistance and Propulsion of Ships; Carlton, Marine Propellers and "
        "Propulsion; Fossen 2021, chapter 9"
    ),
    parameters=(
        Parameter(
            "t",
            unit="1",
            neutral=0.0,
            plausible=(0.03, 0.3),
            meaning="thrust deduction fraction, for thrust ahead and astern",
            possible=(-0.5, 1.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("thrust_gain",),
    apply=_apply,
    of_thrusters=True,
    stated=_stated,
)
