"""Misaligned thruster: one thruster pushes in another direction than stated.

A bracket was bent by a knock, a thruster was fitted a hole further, or the drawing was not
followed. The thrust keeps its size and its place; its direction is turned first by an azimuth
about the body's z axis (positive turns a thruster that pushes ahead towards starboard) and then
raised by an elevation out of the horizontal plane of the vehicle (positive is up). For a thruster
that pushes ahead

    direction = (cos a cos e, sin a cos e, -sin e)     in x forward, y starboard, z down

so 5 degrees give 9 % of the thrust across, with its lever arm, and cost 0.4 % ahead. The inflow
along the thruster's axis turns with it.

For a thruster that is mounted vertically the azimuth has nothing to turn, and only the elevation
tilts it: positive leans one that pushes up towards the stern, one that pushes down towards the
bow. A vertical thruster that leans sideways is not covered.

It shows as a side or vertical force and a moment in proportion to that thruster's command, ahead
and astern with opposite sign. Easily taken for `thruster_degraded` of the same or the opposite
thruster (on a straight course both leave a steady moment; the side force tells them apart, best
from rest) and for `cg_shift` when the command never changes.
"""

from collections.abc import Mapping
from math import radians

from pipeline.effects.change import add
from pipeline.effects.effect import Effect, EffectContext, Parameter
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
            meaning="turn about the body z axis, from ahead to starboard positive",
            possible=(-180.0, 180.0),
        ),
        Parameter(
            "elevation_deg",
            unit="deg",
            neutral=0.0,
            plausible=(-15.0, 15.0),
            meaning="tilt out of the body's horizontal plane, up positive",
            possible=(-180.0, 180.0),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "psi"),
    vector_slots=("misalignment_azimuth", "misalignment_elevation"),
    apply=_apply,
    scope="thruster",
)
