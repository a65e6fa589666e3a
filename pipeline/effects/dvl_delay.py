"""DVL delay: the readings are older than their time stamps say.

A velocity log needs the travel time of its ping, averages several, and sends the result over a
serial line; if the log's stamp is the time of arrival, the reading tells the past. The effect adds
to the stated age of a reading:

    v_measured(t) = v_true(t - tau)

A negative tau is a stated delay that is too long. The motion itself is untouched.

It shows only where velocity changes, and by tau times the acceleration: after steps of thrust, in
turns. Against the gyro and the specific force, which carry their own clock, the delay is seen
without any model of the vehicle. Easily taken for `thruster_lag` and for `added_mass` (which delay
the real motion, so depth and position as well).
"""

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.forms import adding, without_dvl

EFFECT = Effect(
    id="dvl_delay",
    title="DVL readings are older than stamped",
    source="RD Instruments, ADCP Principles of Operation: A Practical Primer (averaging of pings)",
    parameters=(
        Parameter(
            "delay_s",
            unit="s",
            neutral=0.0,
            plausible=(0.02, 1.0),
            meaning="age of a reading beyond the stated one",
            possible=(-10.0, 10.0),
        ),
    ),
    channels=("u", "v", "w"),
    vector_slots=("dvl_delay",),
    apply=adding(dvl_delay="delay_s"),
    missing=without_dvl,
)
