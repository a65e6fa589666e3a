"""Dead zone: small codes give no thrust.

A drive needs a least voltage or current before friction in bearings and seals, or the start-up of
a brushless motor without a rotor sensor, lets the shaft turn. Codes below that threshold do
nothing. The effect is a dead zone wider than the one in the measured characteristic, the same for
all thrusters. With d the lost codes and N_max the largest code, the drive sees

    N_eff = 0                                         for |N| <= d
    N_eff = sign(N) (|N| - d) N_max / (N_max - d)     beyond

so that full code still gives full thrust. A dead zone narrower than the stated one is not covered:
that is a wrong characteristic, to be measured again.

It shows at hover, at slow speed and wherever a controller crosses zero: limit cycles in heading,
depth or pitch, and a vehicle that does not answer small codes. At high codes it vanishes. Easily
taken for linear damping (both weaken slow motion; damping acts also with stopped thrusters) and
for thrust deduction or voltage sag when a run uses one code level only (several levels separate
them).
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, context: EffectContext
) -> None:
    fitted = slice(len(context.thruster_names))
    add(vector, "dead_zone", values["codes"], fitted)
    if values["codes"] == 0.0:
        return
    whole = read(vector, "dead_zone")[fitted] >= read(vector, "code_max")[fitted]
    if whole.any():
        worst = int(np.flatnonzero(whole)[0])
        raise CannotComputeError(
            f"dead_zone: {values['codes']:g} lost codes leave nothing of the "
            f"{read(vector, 'code_max')[worst]:g} codes of thruster "
            f'"{context.thruster_names[worst]}". Give fewer codes.'
        )


EFFECT = Effect(
    id="dead_zone",
    title="small codes give no thrust",
    source="Kostenko 2023, eq. (4) and Table 2 (dead zone of a drive); Fossen 2021, chapter 9",
    parameters=(
        Parameter(
            "codes",
            unit="code",
            neutral=0.0,
            plausible=(2.0, 60.0),
            meaning="codes lost at either side of zero, on top of the stated dead zone",
            possible=(0.0, np.inf),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z"),
    vector_slots=("dead_zone",),
    apply=_apply,
    of_thrusters=True,
)
