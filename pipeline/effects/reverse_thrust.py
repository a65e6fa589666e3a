"""Reverse thrust: astern the thrusters give another share of their thrust than stated.

Blades are cut for one direction. Turning astern the trailing edge leads, the camber is on the
wrong side, and a nozzle works with its diffuser in front: 60 to 90 % of the thrust ahead is usual
for an asymmetric propeller. A vehicle file that takes both directions alike, or whose negative
branch was measured with another propeller, is wrong for all thrusters by the same factor:

    T_i = f T(N_i, V_i)     for N_i < 0 only

It shows when braking and going astern, in turns made with one thruster ahead and one astern (less
moment, and a surge force left over that should have cancelled), and in descent where the vertical
thrusters push down by turning astern. On runs with positive codes alone it cannot be seen. Easily
taken for `thrust_deduction` when most codes are negative; a few runs ahead separate them.
"""

from pipeline.effects.effect import Effect, Parameter, scale
from pipeline.effects.forms import of_all_thrusters

EFFECT = Effect(
    id="reverse_thrust",
    title="thrust astern differs from the stated one",
    source=(
        "van Lammeren, van Manen and Oosterveld 1969, SNAME Trans. 77 (four-quadrant B-series: "
        "78 % at rest for B4-70, pitch ratio 1)"
    ),
    parameters=(
        Parameter(
            "fraction",
            unit="1",
            neutral=1.0,
            plausible=(0.5, 1.2),
            meaning="negative thrust over the stated negative thrust",
            possible=(0.0, 2.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("reverse_gain",),
    apply=of_all_thrusters(scale, "reverse_gain", "fraction"),
    of_thrusters=True,
)
