"""Residual buoyancy: the vehicle is lighter or heavier in water than its trim sheet says.

Ballasting is done to a few newtons; then the water is warmer or fresher, the hull is squeezed at
depth, foam soaks, or a bubble stays in the fairing. What is left over pulls up or down constantly.
Kostenko 2017 designs the drive for up to 75 N of it on a vehicle at 3 m/s, carried by an angle of
attack. The effect adds a force to the buoyancy, upward positive, at the centre of buoyancy:

    B -> B + P

It shows in depth and heave from the first second, at rest too: drift up or down without thrust, a
vertical thruster that never stops, a nose held down at speed. If the centre of buoyancy lies off
the origin, trim moves with it. Easily taken for `payload` (which also has mass, hence slower
heave, and a place of its own, hence trim), for the vertical part of `current` (a drift that dies
out relative to the water, not a force), and for `tether` (whose pull changes with place). The
static heave force at hover names its size; an acceleration in heave separates it from payload.
"""

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.forms import adding

EFFECT = Effect(
    id="residual_buoyancy",
    title="lighter or heavier in water than stated",
    source="Kostenko 2017, eqs. (1) to (7) (P between -75 and 75 N)",
    parameters=(
        Parameter(
            "force_n",
            unit="N",
            neutral=0.0,
            plausible=(-75.0, 75.0),
            grows=2,
            meaning="buoyancy in excess of the stated one, upward positive",
        ),
    ),
    channels=("w", "p", "q", "phi", "theta", "z"),
    vector_slots=("buoyancy",),
    apply=adding(buoyancy="force_n"),
)
