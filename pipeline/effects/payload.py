"""Payload: a module is on board, or missing, that the vehicle file does not know.

A sampler, a sonar, a lump of lead or a flooded tube brings mass, displaces water and sits
somewhere. Voitasyk 2018 has the module's weight m g and its moment r x m g; buoyancy and the
change of inertia and centre of mass are needed with it. A point payload of mass m_p and volume V_p
at r_p gives

    m    -> m + m_p                    W -> W + m_p g
    r_g  -> r_g + m_p (r_p - r_g) / (m + m_p)
    I_o  -> I_o + m_p [ (r_p . r_p) 1 - r_p r_p^T ]       about the body origin
    B    -> B + rho g V_p
    r_b  -> r_b + rho g V_p (r_p - r_b) / (B + rho g V_p)

Mass without volume is water or lead inside the hull; negative values are a module that was taken
off. The module's inertia about its own centre, its drag and its added mass are left out: a bulky
module needs its entry in the vehicle file.

It shows as heave force (weight less buoyancy), as trim from its place, and as slower answers in
every axis. Easily taken for `residual_buoyancy` (no mass, no place), for `cg_shift` (no weight)
and for `added_mass` (no weight); heave acceleration and static trim together separate them. While
mass and volume are zero the place has no meaning, and while m_p = rho V_p the place hardly shows
in trim.
"""

from collections.abc import Mapping

import numpy as np

from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.physics.carried_body import carry
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, context: EffectContext
) -> None:
    carry(
        vector,
        values["mass_kg"],
        values["volume_m3"],
        np.array([values["x_m"], values["y_m"], values["z_m"]]),
        gravity_mps2=context.gravity_mps2,
        name="payload",
    )


def _coordinate(name: str, half_width_m: float, direction: str) -> Parameter:
    return Parameter(
        name,
        unit="m",
        neutral=0.0,
        plausible=(-half_width_m, half_width_m),
        grows=1,
        meaning=f"place in the body, {direction}",
        possible=(-50.0, 50.0),
    )


EFFECT = Effect(
    id="payload",
    title="a module on board, or missing, that is not in the vehicle file",
    source="Voitasyk 2018 (T_UC, with buoyancy and inertia added); Fossen 2021, chapters 3 and 4",
    parameters=(
        Parameter(
            "mass_kg",
            unit="kg",
            neutral=0.0,
            plausible=(-5.0, 20.0),
            grows=2,
            meaning="mass of the module; negative where one is missing",
        ),
        Parameter(
            "volume_m3",
            unit="m^3",
            neutral=0.0,
            plausible=(-0.005, 0.02),
            grows=2,
            together_with="mass_kg",
            meaning="water that it displaces; 0 inside the hull",
        ),
        _coordinate("x_m", 1.0, "forward"),
        _coordinate("y_m", 0.5, "to starboard"),
        _coordinate("z_m", 0.5, "downward"),
    ),
    channels=("u", "v", "w", "p", "q", "r", "phi", "theta", "z"),
    vector_slots=(
        "mass",
        "weight",
        "inertia",
        "centre_of_mass",
        "buoyancy",
        "centre_of_buoyancy",
    ),
    apply=_apply,
)
