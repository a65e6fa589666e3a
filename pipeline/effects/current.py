"""Current: the water itself moves over the ground.

Hull and thrusters feel the velocity relative to the water; DVL (on the bottom) and position show
the velocity over ground. In a steady, uniform current of velocity V_c the forces are those of

    nu_r = nu - R^T V_c

with R from body to north-east-down. The effect adds to the stated current (usually zero), in
north, east and down components.

It shows as drift at rest that carries the vehicle along until it moves with the water, as a ground
speed that differs between opposite headings by twice the component along them, and as a crab angle
across. The same leg on reversed headings is the test: what changes sign in body axes with heading
is current; what stays is in the vehicle. Easily taken for `dvl_scale` and `dvl_misalignment` on
one heading, for `linear_damping` and `quadratic_damping` on one leg, and for the pull of a
`tether` (which depends on place).
"""

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.forms import adding


def _component(name: str, half_width_mps: float, direction: str) -> Parameter:
    return Parameter(
        name,
        unit="m/s",
        neutral=0.0,
        plausible=(-half_width_mps, half_width_mps),
        meaning=f"velocity of the water towards {direction}, on top of the stated current",
        possible=(-10.0, 10.0),
    )


EFFECT = Effect(
    id="current",
    title="the water moves over the ground",
    source="Fossen 2021, chapter 10 (ocean currents); Voitasyk 2018 (V_s)",
    parameters=(
        _component("north_mps", 0.5, "north"),
        _component("east_mps", 0.5, "east"),
        _component("down_mps", 0.1, "the bottom"),
    ),
    channels=("u", "v", "w", "r", "x", "y", "z"),
    vector_slots=("current",),
    apply=adding(current=("north_mps", "east_mps", "down_mps")),
    scales_with=("linear_damping", "quadratic_damping"),
)
