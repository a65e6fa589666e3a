"""Misaligned thruster: one thruster pushes in another direction than stated.

A bracket was bent by a knock, a thruster was fitted a hole further, or the drawing was not
followed. The thrust keeps its size and its place; its direction d is tilted by two angles, about
the two axes that stand across it. With s = z x d (level; to starboard of a thruster that pushes
ahead) and n = d x s, the azimuth a turns it towards s and the elevation e away from n:

    direction = d cos a cos e + s sin a cos e - n sin e

For a thruster that pushes ahead this is (cos a cos e, sin a cos e, -sin e) in x forward, y
starboard, z down: azimuth to starboard, elevation up. A thruster that pushes straight up or down
has no level axis of its own; there s is starboard, so the azimuth leans it to starboard, and the
elevation leans one that pushes up towards the stern, one that pushes down towards the bow.

So 5 degrees give 9 % of the thrust across, with its lever arm, and cost 0.4 % along. The inflow
along the thruster's axis turns with it.

It shows as a side or vertical force and a moment in proportion to that thruster's command, ahead
and astern with opposite sign. Easily taken for `thruster_degraded` of the same or the opposite
thruster (on a straight course both leave a steady moment; the side force tells them apart, best
from rest) and for `cg_shift` when the command never changes.
"""

from collections.abc import Mapping
from math import radians

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], target: int | None, _context: EffectContext
) -> None:
    if target is None:
        raise ValueError("thruster_misalignment needs the index of a thruster")
    this = slice(target, target + 1)
    add(vector, "misalignment_azimuth", radians(values["azimuth_deg"]), this)
    add(vector, "misalignment_elevation", radians(values["elevation_deg"]), this)


EFFECT = Effect(
    id="thruster_misalignment",
    title="one thruster pushes in another direction",
    source="Fossen 2021, chapter 9 (thrust configuration); Voitasyk 2018 (T_i = [F_i, r_i x F_i])",
    parameters=(
        Parameter(
            "azimuth_deg",
            unit="deg",
            neutral=0.0,
            plausible=(-15.0, 15.0),
            meaning="level tilt across the stated direction, to starboard of ahead positive",
            possible=(-180.0, 180.0),
        ),
        Parameter(
            "elevation_deg",
            unit="deg",
            neutral=0.0,
            plausible=(-15.0, 15.0),
            meaning="tilt across the level one, up positive for a thruster that pushes ahead",
            possible=(-180.0, 180.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "psi"),
    vector_slots=("misalignment_azimuth", "misalignment_elevation"),
    apply=_apply,
    scope="thruster",
)
