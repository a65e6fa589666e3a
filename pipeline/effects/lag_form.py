"""Form of the lag: of what in a thruster the stated lag is one, and at which codes.

A vehicle file states a time constant, not what lags by it. Where a motor controller ignores small
codes the dead zone comes before the lag of the shaft; where a drive ramps its code it comes after.
And it may be the code that lags, or the shaft speed, or the thrust (first order in shaft speed:
Yoerger, Cooke and Slotine 1990; in thrust: the actuator models of many simulators). Of a
characteristic T = T_max s^e the shaft speed goes as the code to the power e / 2, the thrust as that
to the power e. With d the share of the dead zone N_dead that comes before, and m the power,

    s = (|N| - d N_dead) / (N_max - d N_dead),    q = sign(N) s^m,    tau dq_act/dt + q_act = q

and the characteristic takes the code that belongs to q_act. Nor need the lag be the same at all
codes. A shaft is braked by the square of its speed: J dn/dt = Q - k n|n| answers in J / (2 k n),
the faster the faster it turns (Yoerger, Cooke and Slotine 1990); that of a drive that holds a
torque, whose speed goes with the root of the code, falls with the root of the code. With h the
power, the stated lag that of half the largest code, and s half way between what acts and what is
commanded,

    tau = tau_stated (2 s)^-h

That share is out of reach of the
supply as well: a controller ignores the same codes at any voltage, where a motor that does not
overcome its friction needs more code at a lower one. A sagging supply that took it for the other
looked like thrust deduction, surely. At the stated supply and at rest all forms are the same. They
differ for about tau after steps, most where thrust changes its sign, and by far more than an
accelerometer's noise: a vehicle that is exactly as its file states had a supply voltage 30 % too
high and a thrust deduction of 0.4, surely, for want of this. It is no fault, so it is ordinary on
every vehicle, and no answer.
"""

from collections.abc import Mapping

from pipeline.effects.effect import Effect, EffectContext, Parameter, add, scale
from pipeline.effects.thruster_lag import EFFECT as THRUSTER_LAG
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    add(vector, "lag_dead_share", values["dead_share"])
    scale(vector, "lag_power", values["power"])
    add(vector, "lag_fall", values["fall"])


EFFECT = Effect(
    id="lag_form",
    title="what in a thruster lags",
    source="Yoerger, Cooke and Slotine 1990, IEEE J. Oceanic Eng. 15(3), 167-178",
    parameters=(
        Parameter(
            "dead_share",
            unit="1",
            neutral=0.0,
            plausible=(0.0, 1.0),
            meaning="share of the dead zone that comes before lag and supply",
            possible=(0.0, 1.0),
            ordinary=0.7,
        ),
        Parameter(
            "power",
            unit="1",
            neutral=1.0,
            plausible=(0.5, 2.0),
            meaning="power of the code that lags: 1 the code; half the characteristic's exponent "
            "the shaft speed, all of it the thrust",
            possible=(0.4, 3.0),
            ordinary=0.5,
        ),
        Parameter(
            "fall",
            unit="1",
            neutral=0.0,
            plausible=(0.0, 1.0),
            meaning="power by which the lag falls with the code; a half of a drive that holds a "
            "torque",
            possible=(-1.0, 2.0),
            ordinary=0.5,
        ),
    ),
    channels=THRUSTER_LAG.channels,
    vector_slots=("lag_dead_share", "lag_power", "lag_fall"),
    apply=_apply,
    of_thrusters=True,
    missing=THRUSTER_LAG.missing,
    unstated=True,
)
