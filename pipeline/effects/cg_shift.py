"""Shifted centre of gravity: the mass sits elsewhere than stated.

Batteries pushed in differently, lead moved from one rail to another, an instrument swapped: weight
and displacement are as before, but the weight hangs at another place. The mass as a whole, with
the payloads of the vehicle file, is taken to move by (dx, dy, dz) in body axes (x forward, y
starboard, z down), so its inertia about its own centre of mass stays, and that about the body
origin follows from the parallel-axis theorem:

    r_g -> r_g + d        I_o -> I_o + m [ S(r_g)S(r_g) - S(r_g + d)S(r_g + d) ]

with S(r) the matrix of the cross product with r. Weight, buoyancy and the centre of buoyancy stay.
Moving a lump of ballast inside the hull shifts the centre in this way; the inertia about it then
changes a little as well, in second order.

It shows as trim and list at rest (the vehicle turns until the centre of gravity is below that of
buoyancy), as a period and stiffness of pitch and roll that change with dz, and under way as pitch
that comes with braking. Easily taken for `payload` (which also weighs), for `residual_buoyancy`
with a centre of buoyancy off the origin (which has heave), and, in one steady state, for a
misaligned or degraded thruster (whose moment goes with its command). dz does not show on an even
keel: it needs motion in pitch or roll.
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.physics.parameters import read
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    shift = np.array([values["dx_m"], values["dy_m"], values["dz_m"]])
    mass = read(vector, "mass")
    centre = read(vector, "centre_of_mass")
    # m (r'.r' 1 - r'r'^T) less the same of r, with r' = r + d multiplied out: zero at d = 0
    across = np.outer(centre, shift)
    squared = 2.0 * (centre @ shift) + shift @ shift
    moved = mass * (squared * np.eye(3) - across - across.T - np.outer(shift, shift))
    add(vector, "inertia", moved)
    add(vector, "centre_of_mass", shift)


def _shift(name: str, direction: str) -> Parameter:
    return Parameter(
        name,
        unit="m",
        neutral=0.0,
        plausible=(-0.05, 0.05),
        grows=1,
        meaning=f"shift of the centre of mass, {direction}",
        possible=(-10.0, 10.0),
    )


EFFECT = Effect(
    id="cg_shift",
    title="the centre of gravity sits elsewhere",
    source="Fossen 2021, chapters 3 and 4 (parallel-axis theorem, metacentric stability)",
    parameters=(
        _shift("dx_m", "forward"),
        _shift("dy_m", "to starboard"),
        _shift("dz_m", "downward"),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "z"),
    vector_slots=("centre_of_mass", "inertia"),
    apply=_apply,
)
