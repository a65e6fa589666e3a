r"""Something that a vehicle carries: its mass, the water it displaces and where it sits.

A body of mass :math:`m_p` and volume :math:`V_p` at :math:`r_p` gives

.. math::

    m &\to m + m_p, \qquad W \to W + m_p g \\
    r_g &\to r_g + m_p (r_p - r_g) / (m + m_p) \\
    I_o &\to I_o + J + m_p [ (r_p \cdot r_p) 1 - r_p r_p^T ] \quad \text{about the body origin} \\
    B &\to B + \rho g V_p \\
    r_b &\to r_b + \rho g V_p (r_p - r_b) / (B + \rho g V_p)

with J its inertia about its own centre. Mass without volume is water or lead inside the hull;
negative values are what was taken off. Drag and added mass of the body are left out.
"""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.types import FloatArray


def cross_matrix(a: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) of a x, of a vector (3,): S(a) of Fossen 2021, definition 2.2.

    Turning rates (k, 3) times the matrix of a place are the velocities there, in a quarter of the
    time of `numpy.cross`.

    >>> forward, right = np.eye(3)[:2]
    >>> (cross_matrix(forward) @ right).tolist(), (forward @ cross_matrix(right)).tolist()
    ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0])
    """
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def carry(
    vector: FloatArray,
    mass_kg: float,
    volume_m3: float,
    position_m: FloatArray,
    *,
    gravity_mps2: float,
    inertia_kgm2: FloatArray | None = None,
    name: str,
) -> None:
    """Add a body to a parameter vector, in place; what is zero leaves its numbers untouched.

    `mass_kg` in air and `volume_m3` are negative for what was taken off; `position_m` (3,) is the
    centre of both, body axes; `inertia_kgm2` (3,) I_xx, I_yy, I_zz about it, of the sign of the
    mass, a point otherwise; `name` is for messages. The density is that of the vector.

    Raises
    ------
    CannotComputeError
        When nothing of the vehicle's mass or buoyancy would be left.

    >>> from pipeline.physics.parameters import neutral_vector, write
    >>> vector = neutral_vector()
    >>> write(vector, "mass", 10.0)
    >>> carry(vector, 2.0, 0.0, np.array([0.6, 0.0, 0.0]), gravity_mps2=9.81, name="lead")
    >>> round(float(read(vector, "centre_of_mass")[0]), 6)
    0.1
    """
    place = np.asarray(position_m, float)
    if mass_kg != 0.0:
        total = float(read(vector, "mass")) + mass_kg
        if total <= 0.0:
            raise CannotComputeError(
                f"{name}: with mass_kg={mass_kg:g} the vehicle has {total:g} kg left. "
                "The total must stay positive."
            )
        more = mass_kg * (place @ place * np.eye(3) - np.outer(place, place))
        if inertia_kgm2 is not None:
            more += np.diag(inertia_kgm2)
        _add(vector, "mass", np.array(mass_kg))
        _add(vector, "weight", np.array(mass_kg * gravity_mps2))
        _add(vector, "inertia", more)
        _add(vector, "centre_of_mass", mass_kg / total * (place - read(vector, "centre_of_mass")))
    lift = float(read(vector, "density")) * gravity_mps2 * volume_m3
    if lift != 0.0:
        total = float(read(vector, "buoyancy")) + lift
        if total <= 0.0:
            raise CannotComputeError(
                f"{name}: with volume_m3={volume_m3:g} the vehicle has {total:g} N of buoyancy "
                "left. The total must stay positive."
            )
        _add(vector, "buoyancy", np.array(lift))
        centre = read(vector, "centre_of_buoyancy")
        _add(vector, "centre_of_buoyancy", lift / total * (place - centre))


def _add(vector: FloatArray, name: str, departure: FloatArray) -> None:
    """Add to a slot in place; adding 0.0 would turn a -0.0 into 0.0."""
    target = read(vector, name)
    np.add(target, departure, out=target, where=departure != 0.0)
