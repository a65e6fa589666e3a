"""DVL scale: the measured velocity is the true one times a constant.

A Doppler log turns a frequency shift into a speed through the speed of sound at the transducer.
Set for sea water and used in a fresh-water pool, or with a wrong temperature, it is off by the
same share on all axes: 1435 against 1500 m/s is 4 %. Beam angles that are off do the same. (A
phased array has no such error along its face.) The effect is one factor,

    v_measured = s v_true

on all three components. The motion itself is untouched.

It shows in the measured velocity alone, in proportion to speed and at every heading alike, while
position, depth rate and specific force disagree with it. This is settled by comparing the
instruments with each other, before any force is blamed. Easily taken for thrust or drag that is
off when no position, depth or acceleration is logged, and for `current` on one heading.
"""

from collections.abc import Mapping

from pipeline.effects.effect import Effect, EffectContext, Parameter, scale
from pipeline.effects.forms import without_dvl
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    scale(vector, "dvl_scale", values["scale"])


EFFECT = Effect(
    id="dvl_scale",
    title="the DVL reads too fast or too slow",
    source="RD Instruments, ADCP Principles of Operation: A Practical Primer (speed of sound)",
    parameters=(
        Parameter(
            "scale",
            unit="1",
            neutral=1.0,
            plausible=(0.9, 1.1),
            meaning="measured over true speed",
            possible=(0.1, 10.0),
        ),
    ),
    channels=("u", "v", "w"),
    vector_slots=("dvl_scale",),
    apply=_apply,
    missing=without_dvl,
)
