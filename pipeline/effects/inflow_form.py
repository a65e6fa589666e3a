"""Form of the inflow: what water from behind does to a thruster.

Where thrust falls with speed a vehicle file states by how much along the motion. It says nothing of
thrust against it: a propeller that brakes a turn, or a thruster on the inner side of one. Here the
curve at rest holds there (decision 0011); the straight line that many simulators use,
T = a |n| n - b |n| V, goes on rising, by as much as it fell on the other side. With o the share of
that rise and k that of the inflow that reaches the blades (`advance_speed_loss`),

    T(N, V) = T_static(N, k V)                               V >= 0
    T(N, V) = T(N, 0) + o (T(N, 0) - T_static(N, k |V|))     V < 0

Measured four-quadrant curves of one propeller give 0.93 to 1.0 of the thrust at rest at J = -0.5
and equal shaft speed, so o about 0, and up to 1.2 at equal torque (docs/methods/allocator.md). It
acts most on a vehicle that turns or brakes by opposed thrusters, as a damping in yaw. It is no
fault, so it is ordinary on every vehicle whose thrust falls with speed, and no answer.
"""

from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.effects.forms import adding


def _missing(context: EffectContext) -> str | None:
    if not context.thrust_falls_with_speed:
        return (
            "the nominal model has the thrust at rest at any speed "
            "(model.terms.thrust_falls_with_speed)"
        )
    return None


EFFECT = Effect(
    id="inflow_form",
    title="how inflow from behind acts on the thrust",
    source=(
        "Carlton, Marine Propellers and Propulsion, chapter on propeller characteristics; Fossen "
        "1994, Guidance and Control of Ocean Vehicles, chapter 4 "
        "(bilinear thruster model)"
    ),
    parameters=(
        Parameter(
            "opposed_share",
            unit="1",
            neutral=0.0,
            plausible=(0.0, 1.0),
            meaning="rise of thrust against the motion over its fall along it: 0 the curve at rest",
            possible=(-0.5, 1.5),
            ordinary=0.5,
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("opposed_share",),
    apply=adding(opposed_share="opposed_share"),
    of_thrusters=True,
    missing=_missing,
    unstated=True,
)
