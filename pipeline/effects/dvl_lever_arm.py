"""DVL lever arm: the log sits elsewhere in the vehicle than stated.

A velocity log measures the velocity of its own place. When the vehicle turns, that differs from
the velocity of the body origin by omega x r; whoever corrects it with the wrong place r is left
with

    v_measured = v_true + omega x (r_true - r_stated)

The effect is that difference of places, in body axes. The motion itself is untouched.

It shows in turns and in pitch and roll, in proportion to the rate: an error of 0.3 m at 20 deg/s
reads as 0.1 m/s. On straight legs it vanishes. Easily taken for `dvl_misalignment` where turning
and speed go together and for a sway force in turns (`crossflow_coupling`, `coriolis_omitted`); a
turn on the spot separates them.
"""

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.forms import adding, without_dvl


def _coordinate(name: str, direction: str) -> Parameter:
    return Parameter(
        name,
        unit="m",
        neutral=0.0,
        plausible=(-0.5, 0.5),
        grows=1,
        meaning=f"true minus stated place of the DVL, {direction}",
        possible=(-50.0, 50.0),
    )


EFFECT = Effect(
    id="dvl_lever_arm",
    title="the DVL sits elsewhere",
    source="Fossen 2021, chapter 2 (velocity of a point of the body); Kinsey and Whitcomb 2007",
    parameters=(
        _coordinate("x_m", "forward"),
        _coordinate("y_m", "to starboard"),
        _coordinate("z_m", "downward"),
    ),
    channels=("u", "v", "w"),
    vector_slots=("dvl_lever_arm",),
    apply=adding(dvl_lever_arm=("x_m", "y_m", "z_m")),
    missing=without_dvl,
)
