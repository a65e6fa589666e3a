r"""Added mass of a slender hull from its sections, about any point of the axis.

.. math::

    A_{22} = \int a_y\,dx, \quad A_{26} = \int x\,a_y\,dx, \quad A_{66} = \int x^2 a_y\,dx, \quad
    A_{33} = \int a_z\,dx, \quad A_{35} = -\int x\,a_z\,dx, \quad A_{55} = \int x^2 a_z\,dx

with a_y, a_z the added mass of a section in sway and heave (`added_mass_sections`), x forward from
the reference point (Newman 1977, section 7.2; Fossen 2021, section 5.4). A strip meets the water at
v + x r in sway and w - x q in heave, hence the minus of A_35.

Strips know nothing of the ends: they give no surge mass and too much of the rest (a spheroid of
6 diameters: 9 % in sway, 28 % in yaw; see docs/methods/added_mass.md). `equivalent_spheroid`
supplies the surge mass and the factors that correct the rest.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.added_mass_shapes import ellipsoid_added_mass
from pipeline.types import ArrayLike, FloatArray

#: Three Gauss points an interval integrate polynomials up to degree 5 exactly.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class EquivalentSpheroid:
    """What Lamb's spheroid of the hull's length and volume says about the ends.

    Largest radius [m] and surge added mass [kg] of it; `sway_factor`, `yaw_factor` its exact sway
    mass and yaw inertia over those of strips [-].
    """

    radius_m: float
    surge_kg: float
    sway_factor: float
    yaw_factor: float


def slender_hull_added_mass(
    station_m: ArrayLike, radius_m: ArrayLike, density_kgpm3: float
) -> FloatArray:
    r"""Return the added mass of a hull of circular sections, :math:`a_y = a_z = \rho \pi R(x)^2`.

    `radius_m` (n,) at the stations along x is taken as linear between them (cones), whose integral
    is exact whatever their number: a cylinder given by its two ends has exactly the mass of its
    water. (6, 6), symmetric; surge and roll are zero. [kg, kg m, kg m^2]

    >>> a = slender_hull_added_mass([-1.0, 1.0], [0.1, 0.1], 1000.0)
    >>> float(round(a[1, 1] / (np.pi * 0.1**2 * 2 * 1000), 12))
    1.0
    """
    x, radius = np.asarray(station_m, float), np.asarray(radius_m, float)
    places, weights = _quadrature(x)
    order = np.argsort(x)
    section = density_kgpm3 * np.pi * np.interp(places, x[order], radius[order]) ** 2
    a = np.zeros((6, 6))
    a[1, 1] = a[2, 2] = weights @ section
    a[4, 4] = a[5, 5] = weights @ (section * places**2)
    a[1, 5] = a[5, 1] = weights @ (section * places)
    a[2, 4] = a[4, 2] = -a[1, 5]
    return a


def equivalent_spheroid(
    length_m: float, volume_m3: float, density_kgpm3: float
) -> EquivalentSpheroid:
    """Return Lamb's spheroid of the same length and displaced volume: surge mass and end factors.

    Raises
    ------
    CannotComputeError
        A spheroid that is not longer than wide, or without a volume.

    >>> s = equivalent_spheroid(2.0, 4 / 3 * np.pi * (1 / 6) ** 2, 1000.0)
    >>> round(s.radius_m, 4), round(s.sway_factor, 3), round(s.yaw_factor, 3)
    (0.1667, 0.917, 0.783)
    """
    if volume_m3 <= 0.0:
        raise CannotComputeError(f"A hull of {length_m:g} m cannot have {volume_m3:g} m^3.")
    half = length_m / 2
    radius = float(np.sqrt(3 * volume_m3 / (4 * np.pi * half)))
    if radius >= half:
        raise CannotComputeError(
            f"A hull of {length_m:g} m and {volume_m3:g} m^3 is wider ({2 * radius:.3g} m as a "
            "spheroid) than long: strips do not apply.\nTake ellipsoid_added_mass."
        )
    exact = ellipsoid_added_mass((half, radius, radius), density_kgpm3)
    mass = density_kgpm3 * volume_m3
    return EquivalentSpheroid(
        radius_m=radius,
        surge_kg=float(exact[0, 0]),
        sway_factor=float(exact[1, 1] / mass),
        yaw_factor=float(exact[5, 5] / (mass * half**2 / 5)),
    )


def _quadrature(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Gauss places and weights of all intervals between neighbouring stations."""
    middle, half = (x[1:] + x[:-1]) / 2, np.abs(np.diff(x)) / 2
    places = middle[:, None] + half[:, None] * _POINTS * np.sign(x[-1] - x[0])
    return places.ravel(), (half[:, None] * _WEIGHTS).ravel()
