"""Thruster lag: thrust follows the code late.

The motor must bring rotor, propeller and the water that turns with it to speed, a controller may
ramp the code to spare the gearbox, and the jet behind the propeller takes time to build up.
Together this is close to a first-order lag of the shaft speed (Yoerger and others 1990; Healey
and others 1995). The effect adds a time constant to the one in the vehicle file, the same for all
thrusters:

    tau dN_act/dt + N_act = N_eff

Where the vehicle file has the torque balance of the shafts solved in time (balance_in_time), rotor
inertia and drive make the delay themselves and the nominal model has no lag to be added to: there
the effect is no candidate.

It shows right after steps and reversals of the code and in fast manoeuvres (zig-zag, multisine):
the simulated vehicle leads the measured one by about tau. In steady motion it vanishes. Easily
taken for added mass (both slow the start of a motion; added mass also slows the coast-down with
stopped thrusters) and for `dvl_delay` (which delays the measured velocity but neither gyro nor
depth). Where shaft speed is logged, it settles the matter without the hull.
"""

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.effects.forms import of_all_thrusters


def _missing(context: EffectContext) -> str | None:
    if not context.lagged:
        return (
            "the torque balance of the shafts is solved in time, and the rotor's inertia takes "
            "the place of a lag (model.thrusters.<drive>.balance_in_time)"
        )
    return None


EFFECT = Effect(
    id="thruster_lag",
    title="thrust follows the code late",
    source=(
        "Yoerger, Cooke and Slotine 1990, IEEE J. Oceanic Eng. 15(3), 167-178; Healey and others "
        "1995, IEEE J. Oceanic Eng. 20(4), 354-361"
    ),
    parameters=(
        Parameter(
            "lag_s",
            unit="s",
            neutral=0.0,
            plausible=(0.05, 1.0),
            meaning="time constant on top of the stated one",
            possible=(0.0, 60.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("lag",),
    apply=of_all_thrusters(add, "lag", "lag_s"),
    of_thrusters=True,
    missing=_missing,
)
