"""Effects as a user switches them on: each once, and on a vehicle that can be.

The diagnosis calls `apply_effects` alone: on its way to an answer it passes points that no vehicle
has, where a refusal would stop it.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.effects.library import EffectSpec, apply_effects
from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import point_inertia
from pipeline.types import FloatArray
from pipeline.vehicle.model_checks import inertia_fault


def effects_on(
    packed: PackedVehicle, specs: Sequence[EffectSpec]
) -> Callable[[FloatArray], FloatArray]:
    """Return what turns a vector of the vehicle into the one with effects switched on.

    It takes a vector, which it does not change, and returns another one; raises
    `CannotComputeError` where `apply_effects` does, or where no body can be like what is left.

    Raises
    ------
    InputError
        When an effect is given twice for the same thruster, or for the vehicle: limits of its
        values hold for each alone.
    """
    seen: set[tuple[str, str | None]] = set()
    for spec in specs:
        if (spec.id, spec.target) in seen:
            raise InputError.at(
                Place(f'effect "{spec}"'),
                f"{spec.id} is given twice.",
                expected="each effect once, and for each thruster once.",
                remedy="Put its values together into one.",
            )
        seen.add((spec.id, spec.target))

    def switched(vector: FloatArray) -> FloatArray:
        changed = apply_effects(vector, specs, packed.context)
        fault = body_fault(changed) if specs else None
        if fault is not None:
            named = " ".join(str(spec) for spec in specs)
            raise CannotComputeError(f"{named}: {fault}")
        return changed

    return switched


def body_fault(vector: FloatArray) -> str | None:
    """Say in words why no body can have mass, inertia and buoyancy of a vector; None if one can.

    The inertia about the centre of mass is that about the origin less Steiner's part, and obeys
    `inertia_fault`.
    """
    mass, buoyancy = float(read(vector, "mass")), float(read(vector, "buoyancy"))
    if mass <= 0.0:
        return f"the vehicle has {mass:g} kg left. The total must stay positive."
    if buoyancy <= 0.0:
        return f"the vehicle has {buoyancy:g} N of buoyancy left. The total must stay positive."
    about = read(vector, "inertia") - point_inertia(mass, read(vector, "centre_of_mass"))
    entries = [about[0, 0], about[1, 1], about[2, 2], -about[0, 1], -about[0, 2], -about[1, 2]]
    if inertia_fault(entries) is None:
        return None
    principal = ", ".join(f"{moment:.3g}" for moment in np.linalg.eigvalsh(about))
    return (
        f"no body has the principal moments of inertia {principal} kg m^2 about its centre of "
        "mass: all are positive, and none exceeds the sum of the other two.\n"
        "What is taken off must have been part of the vehicle: give less mass, or a place nearer "
        "to the centre."
    )
