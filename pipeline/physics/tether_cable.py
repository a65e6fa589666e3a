r"""A tether cable: its properties, the load of water and weight on it, and its shape at rest.

.. math:: q = w\,e_z + \tfrac{1}{2} \rho d \left(C_n |V_n| V_n + C_t |V_t| V_t\right), \qquad
    V_t = (V \cdot t)\,t, \quad V_n = V - V_t

with V the velocity of the water past the cable and t its unit tangent. C_t is referred to the
diameter d, as in Kostenko and Mokeeva 2009, not to the girth: a coefficient on the girth pi d
(MoorPy, MoorDyn) is C_t / pi.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.types import FloatArray


@dataclass(frozen=True)
class Cable:
    """A uniform cable of unstretched length.

    C_n and C_t are both referred to the diameter; `wet_weight_npm` is weight less buoyancy of a
    metre, negative floats; `axial_stiffness_n` is EA [N], None a cable that does not stretch.
    """

    length_m: float
    diameter_m: float
    normal_drag: float
    tangential_drag: float
    wet_weight_npm: float = 0.0
    axial_stiffness_n: float | None = None


@dataclass(frozen=True)
class TetherSolution:
    """Shape and tension of a cable at rest, at n points, NED.

    `arc_length_m` (n,) unstretched distance from the start; `position_m` (n, 3); `tension_n` (n, 3)
    tension times the tangent from start to end; `residual` the largest relative error of the
    equations between the points.
    """

    arc_length_m: FloatArray
    position_m: FloatArray
    tension_n: FloatArray
    residual: float

    @property
    def force_on_start_n(self) -> FloatArray:
        """Force of the cable on the body at its start, NED, shape (3,). [N]."""
        return np.asarray(self.tension_n[0], dtype=float)

    @property
    def force_on_end_n(self) -> FloatArray:
        """Force of the cable on the body at its end, NED, shape (3,). [N]."""
        return np.asarray(-self.tension_n[-1], dtype=float)

    @property
    def tension_size_n(self) -> FloatArray:
        """Tension along the cable, shape (n,). [N]."""
        return np.asarray(np.linalg.norm(self.tension_n, axis=1), dtype=float)


def tether_load(
    cable: Cable, velocity_mps: FloatArray, tangent: FloatArray, density_kgpm3: float
) -> FloatArray:
    """Return the force of water and weight on a metre of cable, (n, 3), NED. [N/m].

    `velocity_mps` (n, 3) is that of the water past the cable, NED; `tangent` (n, 3) are unit
    vectors.

    Examples
    --------
    1 m/s across 10 mm of cable with C_n = 1.2, and along it with C_t = 0.02:

    >>> rope = Cable(1.0, 0.01, 1.2, 0.02)
    >>> north = np.array([[1.0, 0.0, 0.0]])
    >>> tether_load(rope, north, np.array([[0.0, 0.0, 1.0]]), 1000.0).tolist()
    [[6.0, 0.0, 0.0]]
    >>> tether_load(rope, north, north, 1000.0).round(3).tolist()
    [[0.1, 0.0, 0.0]]
    """
    along = np.sum(velocity_mps * tangent, axis=1, keepdims=True)
    across = velocity_mps - along * tangent
    half_rho_d = 0.5 * density_kgpm3 * cable.diameter_m
    load = half_rho_d * (
        cable.normal_drag * np.linalg.norm(across, axis=1, keepdims=True) * across
        + cable.tangential_drag * np.abs(along) * along * tangent
    )
    load[:, 2] += cable.wet_weight_npm
    return np.asarray(load, dtype=float)
