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

    Attributes
    ----------
    radius_m : float
        Largest radius of that spheroid. [m]
    surge_kg : float
        Its surge added mass. [kg]
    sway_factor, yaw_factor : float
        Exact sway mass and yaw inertia over those of strips, for the spheroid. [-]
    """

    radius_m: float
    surge_kg: float
    sway_factor: float
    yaw_factor: float


def strip_added_mass(
    station_m: ArrayLike,
    sway_kgpm: ArrayLike,
    heave_kgpm: ArrayLike,
    roll_kgm: ArrayLike = 0.0,
    *,
    reference_m: float = 0.0,
) -> FloatArray:
    """Sum sections, given at stations and taken as linear between them, to an added-mass matrix.

    Parameters
    ----------
    station_m : array_like, shape (n,)
        Positions along x, rising or falling; two stations bound one interval. [m]
    sway_kgpm, heave_kgpm : array_like, shape (n,) or scalar
        Added mass of the sections. [kg/m]
    roll_kgm : array_like, shape (n,) or scalar
        Added inertia of the sections about the axis. [kg m]
    reference_m : float
        Place of the reference point on the same x. [m]

    Returns
    -------
    ndarray, shape (6, 6)
        Symmetric; the surge row is zero. [kg, kg m, kg m^2]

    Raises
    ------
    CannotComputeError
        Fewer than two stations, stations out of order, negative or non-finite values.

    Examples
    --------
    >>> a = strip_added_mass([-1.0, 1.0], 3.0, 3.0)
    >>> float(round(a[1, 1], 9)), float(round(a[5, 5], 9))
    (6.0, 2.0)
    """
    x = _checked_stations(station_m)
    sections = [
        _checked_sections(name, values, x.size)
        for name, values in (("sway", sway_kgpm), ("heave", heave_kgpm), ("roll", roll_kgm))
    ]
    places, weights = _quadrature(x)
    order = np.argsort(x)
    at_places = [np.interp(places, x[order], s[order]) for s in sections]
    return _assemble(places - reference_m, weights, *at_places)


def slender_hull_added_mass(
    station_m: ArrayLike,
    radius_m: ArrayLike,
    density_kgpm3: float,
    *,
    reference_m: float = 0.0,
) -> FloatArray:
    r"""Return the added mass of a hull of circular sections, :math:`a_y = a_z = \rho \pi R(x)^2`.

    Parameters
    ----------
    station_m : array_like, shape (n,)
        Positions along x. [m]
    radius_m : array_like, shape (n,)
        Radius at each station, taken as linear between stations (cones). [m]
    density_kgpm3 : float
        Water density. [kg/m^3]
    reference_m : float
        Place of the reference point on the same x. [m]

    Returns
    -------
    ndarray, shape (6, 6)
        Symmetric; surge and roll are zero. [kg, kg m, kg m^2]

    Raises
    ------
    CannotComputeError
        As `strip_added_mass`.

    Notes
    -----
    The integral of the cones is exact whatever the number of stations: n stations are n - 1
    intervals, and a cylinder given by its two ends has exactly the mass of its water.

    Examples
    --------
    >>> a = slender_hull_added_mass([0.0, 2.0], [0.1, 0.1], 1000.0, reference_m=1.0)
    >>> float(round(a[1, 1] / (np.pi * 0.1**2 * 2 * 1000), 12))
    1.0
    """
    x = _checked_stations(station_m)
    radius = _checked_sections("radius", radius_m, x.size)
    if not (np.isfinite(density_kgpm3) and density_kgpm3 > 0):
        raise CannotComputeError(f"Water of {density_kgpm3} kg/m^3 cannot be; expected above zero.")
    places, weights = _quadrature(x)
    order = np.argsort(x)
    section = density_kgpm3 * np.pi * np.interp(places, x[order], radius[order]) ** 2
    return _assemble(places - reference_m, weights, section, section, np.zeros_like(section))


def equivalent_spheroid(
    length_m: float, volume_m3: float, density_kgpm3: float
) -> EquivalentSpheroid:
    """Return Lamb's spheroid of the same length and volume: surge mass and end factors.

    Parameters
    ----------
    length_m : float
        Length of the hull. [m]
    volume_m3 : float
        Displaced volume. [m^3]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    EquivalentSpheroid

    Raises
    ------
    CannotComputeError
        Sizes not above zero, or a spheroid that is not longer than wide.

    Examples
    --------
    >>> s = equivalent_spheroid(2.0, 4 / 3 * np.pi * (1 / 6) ** 2, 1000.0)
    >>> round(s.radius_m, 4), round(s.sway_factor, 3), round(s.yaw_factor, 3)
    (0.1667, 0.917, 0.783)
    """
    if not (np.isfinite([length_m, volume_m3]).all() and length_m > 0 and volume_m3 > 0):
        raise CannotComputeError(
            f"A hull of {length_m} m and {volume_m3} m^3 cannot be; expected both above zero."
        )
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


def _assemble(
    arm: FloatArray, weights: FloatArray, sway: FloatArray, heave: FloatArray, roll: FloatArray
) -> FloatArray:
    """Return the 6 x 6 matrix of the moments of the sections about the reference point."""
    a = np.zeros((6, 6))
    a[1, 1] = weights @ sway
    a[2, 2] = weights @ heave
    a[3, 3] = weights @ roll
    a[4, 4] = weights @ (heave * arm**2)
    a[5, 5] = weights @ (sway * arm**2)
    a[1, 5] = a[5, 1] = weights @ (sway * arm)
    a[2, 4] = a[4, 2] = -weights @ (heave * arm)
    return a


def _checked_stations(station_m: ArrayLike) -> FloatArray:
    """Return the stations, which must be two or more in strict order."""
    x = np.asarray(station_m, float)
    steps = np.diff(x)
    if x.ndim != 1 or x.size < 2 or not np.isfinite(x).all():
        raise CannotComputeError("Strips need two or more stations with finite positions.")
    if not ((steps > 0).all() or (steps < 0).all()):
        raise CannotComputeError(
            "The stations must rise or fall throughout; two of them coincide or turn back."
        )
    return x


def _checked_sections(name: str, values: ArrayLike, count: int) -> FloatArray:
    """Return one value a station, none negative."""
    v = np.asarray(values, float)
    if v.ndim > 1 or (v.ndim == 1 and v.size != count):
        raise CannotComputeError(f"{v.size} values of {name} for {count} stations.")
    v = np.broadcast_to(v, (count,))
    if not (np.isfinite(v).all() and (v >= 0).all()):
        raise CannotComputeError(f"The {name} of a section must be a finite number, not negative.")
    return v
