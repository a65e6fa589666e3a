"""The parameter vector of a vehicle under the conditions of a run.

Applied last, on whatever vector is asked for: effects switched on, free parameters moved. Buoyancy,
added mass, quadratic damping and lift are in proportion to the density of the water; linear damping
and the thrust at a code stay, because viscosity and the drive decide them.
"""

import numpy as np

from pipeline.physics.carried_body import carry
from pipeline.physics.parameters import read
from pipeline.records.run_table import Conditions
from pipeline.types import FloatArray

_WITH_DENSITY = (
    "density",
    "buoyancy",
    "added_mass",
    "quadratic_damping",
    "heave_lift_slope",
    "sway_lift_slope",
    "pitch_lift_slope",
    "yaw_lift_slope",
    "turnover_slope",
)


def vector_under(known: Conditions, vector: FloatArray) -> FloatArray:
    """Return the parameter vector of a run for one of the vehicle; that one is not changed.

    Parameters
    ----------
    known : Conditions
        How the vehicle differed from its file.
    vector : ndarray
        Parameter vector of the vehicle.

    Raises
    ------
    CannotComputeError
        When nothing of the vehicle's mass or buoyancy would be left.
    """
    if known.as_stated:
        return vector
    found = vector.copy()
    if known.density_kgpm3 is not None:
        share = known.density_kgpm3 / float(read(found, "density"))
        for name in _WITH_DENSITY:
            read(found, name)[...] *= share
    for body in known.bodies:
        carry(
            found,
            body.mass_kg,
            body.volume_m3,
            np.array(body.position_m),
            gravity_mps2=known.gravity_mps2,
            inertia_kgm2=np.array(body.inertia_kgm2),
            name=body.name,
        )
    return found
