"""Shaft inertia: the shafts take longer to change speed than the stated inertia says.

A motor must turn rotor, gear, propeller and the water that goes round with the blades. That water
is never measured and may be half of the sum (Schwanecke 1963); a propeller of another maker, weed
on the blades or a guard that traps water add to it. A controller that ramps the code to spare the
gearbox acts like inertia many times over. Where the torque balance of the shafts is solved in time,

    2 pi J dn/dt = M_drive(n, N) - M_propeller(n, V)

the effect is one factor f on the stated inertia of all thrusters, J -> f J: the shafts do what they
did, f times as slowly. A candidate only where the vehicle file has this balance (balance_in_time);
elsewhere the delay is `thruster_lag`, so a vehicle never has both.

It shows right after steps and reversals of the code. In steady motion it vanishes; and where the
drive is stiff (8 ms for mmt300) the inertia must be tens of times as large before the motion of
the vehicle shows it. Easily taken for `added_mass` (both slow the start of a motion; added mass
also slows the coast-down with stopped thrusters) and for `dvl_delay` (which delays the measured
velocity but neither gyro nor depth). Where shaft speed is logged, it settles the matter without the
hull.
"""

from pipeline.effects.effect import Effect, EffectContext, Parameter, scale
from pipeline.effects.forms import of_all_thrusters


def _missing(context: EffectContext) -> str | None:
    if context.lagged:
        return (
            "the torque balance of the shafts is not solved in time "
            "(model.thrusters.<drive>.balance_in_time), so no inertia delays them"
        )
    return None


EFFECT = Effect(
    id="shaft_inertia",
    title="the shafts take longer to change speed",
    source=(
        "Healey and others 1995, IEEE J. Oceanic Eng. 20(4), 354-361 (motor and propeller in "
        "time); Schwanecke 1963 (water that turns with the blades)"
    ),
    parameters=(
        Parameter(
            "factor",
            unit="1",
            neutral=1.0,
            plausible=(1.5, 20.0),
            meaning="inertia over the stated one, of all shafts",
            possible=(1.0, 1000.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("rotor_inertia",),
    apply=of_all_thrusters(scale, "rotor_inertia", "factor"),
    of_thrusters=True,
    missing=_missing,
)
