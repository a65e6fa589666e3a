"""Coriolis terms omitted: the nominal model leaves out what turning does to momentum.

Seen from a body that turns, momentum changes direction even at constant speed. Ahead at u and
turning at r, the vehicle is thrown outward with (m + A_11) u r; where the added masses of two axes
differ, an oblique course makes a turning moment (Munk). Models that are fitted axis by axis drop
these products of velocities, as (4) of Potapov and Galyaev does, who name it first among the
reasons for their gap between computed and measured added mass. The effect adds the fraction k of

    -C(nu) nu,    C from the rigid body and the full added-mass matrix

0 none, 1 all of it. A candidate only where the vehicle file says that the nominal model lacks the
terms. A moment slope of the file that holds the Munk moment keeps it once: what comes in with
C(nu) nu leaves the slope.

It shows in every turn under way, in sway and yaw first, and as a loss of speed in the turn; on a
straight course it vanishes. The terms do no work. Easily taken for `lift` and `crossflow_coupling`
(both also need drift in a turn) and for the sway and yaw factors of `added_mass`.
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, context: EffectContext
) -> None:
    add(vector, "coriolis_fraction", values["fraction"])
    leaving = -values["fraction"] * np.array(context.munk_held)
    add(vector, "pitch_lift_slope", leaving[0])
    add(vector, "yaw_lift_slope", leaving[1])
    add(vector, "turnover_slope", leaving)


def _missing(context: EffectContext) -> str | None:
    if context.coriolis:
        return "the nominal model has the Coriolis terms already (model.terms.coriolis)"
    return None


EFFECT = Effect(
    id="coriolis_omitted",
    title="the nominal model lacks the Coriolis and centripetal terms",
    source=(
        "Potapov and Galyaev, section 4.1, first reason; Voitasyk 2018 (the matrix K); Fossen "
        "2021, chapters 3 and 6"
    ),
    parameters=(
        Parameter(
            "fraction",
            unit="1",
            neutral=0.0,
            plausible=(0.5, 1.1),
            meaning="share of C(nu) nu that is at work; 1 is the full term",
            possible=(0.0, 2.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("coriolis_fraction", "pitch_lift_slope", "yaw_lift_slope", "turnover_slope"),
    apply=_apply,
    missing=_missing,
    scales_with=("added_mass",),
)
