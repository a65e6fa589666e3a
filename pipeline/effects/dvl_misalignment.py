"""DVL misalignment: the log is mounted turned against the angles that are stated.

A velocity log that is turned in its mount splits the true velocity over the wrong axes. With the
angles (roll, pitch, yaw) of the true mount against the stated one and R their rotation,

    v_measured = R^T v_true

Turned by a yaw of +2 degrees (to starboard), a vehicle that goes straight ahead at u seems to
drift to port with 0.035 u. The motion itself is untouched.

It shows as a side or vertical speed in proportion to forward speed, astern with opposite sign, at
every heading alike, and against gyro, depth rate and position. One degree already matters to dead
reckoning. Easily taken for `current` on one heading, for `thruster_misalignment` (which bends the
real course, so position bends as well) and for `dvl_lever_arm` in steady turns (which vanishes on
straight legs). Roll of the mount shows only with side or vertical speed.
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.effects.forms import without_dvl
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    turned = np.radians([values["roll_deg"], values["pitch_deg"], values["yaw_deg"]])
    add(vector, "dvl_rotation", turned)


def _angle(name: str, direction: str) -> Parameter:
    return Parameter(
        name,
        unit="deg",
        neutral=0.0,
        plausible=(-5.0, 5.0),
        meaning=f"turn of the mount against the stated one, {direction} positive",
        possible=(-180.0, 180.0),
    )


EFFECT = Effect(
    id="dvl_misalignment",
    title="the DVL is mounted turned",
    source=(
        "Kinsey and Whitcomb 2007, IEEE J. Oceanic Eng. 32(2), 286-299 (in-situ alignment of "
        "Doppler sensors)"
    ),
    parameters=(
        _angle("roll_deg", "starboard side down"),
        _angle("pitch_deg", "front up"),
        _angle("yaw_deg", "front to starboard"),
    ),
    channels=("u", "v", "w"),
    vector_slots=("dvl_rotation",),
    apply=_apply,
    missing=without_dvl,
)
