"""Lift: the hull, its fins and its frame give a force across an oblique flow.

A hull that is held at an angle of attack or drift carries a force across the flow and a moment,
like a short wing. Kostenko 2017, eq. (4), has R_y = K_y alpha and M_z = -K_z alpha per radian at 3
m/s; both go with speed squared, and for small angles alpha = w / u, so in SNAME axes (z down)

    Z = -k_w |u| w      M = k_q u w      Y = -k_v |u| v      N = k_r u v

The effect adds to these four slopes (heave, pitch, sway, yaw) of the nominal model. A positive
heave or sway slope opposes the drift, ahead and astern: a force with u in place of |u| would push
astern with the drift and give a passive hull energy. The moment slopes are net of the Munk moment,
which the added masses already make, and turn over with u as that does: what a hull's moment differs
by is mostly what its lee end takes off Munk's (Hoerner and Borst 1985, ch. 19). On measured runs of
a small ROV to and fro a moment with |u| explained less. The pitch slope is negative where a nose
that is too high is pushed down. K_y = 1375 N/rad at
3 m/s is a slope of 1375 / 9 = 153 N s^2/m^2.

It shows with speed and an angle of attack or drift together: trim at speed, depth keeping with a
residual buoyancy, drift in a turn. At rest and on a straight level course it vanishes. Easily taken
for `added_mass` in heave and sway (the Munk moment has the same u w ahead), for `linear_damping` in
heave and sway on runs of one speed, and for `cg_shift` in pitch (which is there at rest as well).
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.types import FloatArray

_SLOTS = {
    "heave_slope": "heave_lift_slope",
    "pitch_slope": "pitch_lift_slope",
    "sway_slope": "sway_lift_slope",
    "yaw_slope": "yaw_lift_slope",
}


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    for name, slot in _SLOTS.items():
        add(vector, slot, values[name])
    # the slots hold what goes with |u|; this makes u of it
    add(vector, "turnover_slope", np.array([values["pitch_slope"], values["yaw_slope"]]))


EFFECT = Effect(
    id="lift",
    title="force and moment across an oblique flow differ",
    source=(
        "Kostenko 2017, eq. (4) and Table 1; Hoerner and Borst 1985, Fluid-Dynamic Lift, ch. 19"
    ),
    parameters=(
        Parameter(
            "heave_slope",
            unit="N s^2/m^2",
            neutral=0.0,
            plausible=(-150.0, 150.0),
            grows=2,
            meaning="added to k in Z = -k abs(u) w",
        ),
        Parameter(
            "pitch_slope",
            unit="N s^2/m",
            neutral=0.0,
            plausible=(-80.0, 80.0),
            grows=3,
            meaning="added to k in M = k u w",
        ),
        Parameter(
            "sway_slope",
            unit="N s^2/m^2",
            neutral=0.0,
            plausible=(-150.0, 150.0),
            grows=2,
            meaning="added to k in Y = -k abs(u) v",
        ),
        Parameter(
            "yaw_slope",
            unit="N s^2/m",
            neutral=0.0,
            plausible=(-80.0, 80.0),
            grows=3,
            meaning="added to k in N = k u v",
        ),
    ),
    channels=("v", "w", "q", "r", "theta"),
    vector_slots=(*_SLOTS.values(), "turnover_slope"),
    apply=_apply,
)
