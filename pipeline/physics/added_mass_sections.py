r"""Added mass of plane sections in an unbounded fluid, per metre of length.

A section lies in the y, z plane of the body. Its exterior is mapped onto that of the unit circle,

.. math:: y + i z = c \zeta + a_1 / \zeta + \dots, \qquad \zeta = e^{i \theta} \text{ on the body},

and for a section with two planes of symmetry the coefficients of the map are the added masses:

.. math::

    m_{yy} = \rho (2 \pi c (c - a_1) - S), \qquad
    m_{zz} = \rho (2 \pi c (c + a_1) - S), \qquad
    J = \pi \rho \sum_n n\, p_n^2,

with S the area and p_n the Fourier coefficients of |y + i z|^2 / 2 over theta (Sedov 1950, ch. 5;
Newman 1977, sections 4.14 to 4.16).
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray


@dataclass(frozen=True)
class SectionAddedMass:
    """Added mass of a section, per metre along x.

    `sway_kgpm`, `heave_kgpm` for motion along y and z [kg/m], `roll_kgm` the moment of inertia for
    rotation about the section's centre [kg m].
    """

    sway_kgpm: float
    heave_kgpm: float
    roll_kgm: float


def rectangle_section(width_m: float, height_m: float, density_kgpm3: float) -> SectionAddedMass:
    r"""Return the added mass of a rectangular section of full sides along y and z, exact.

    Schwarz-Christoffel: with the corners at :math:`\theta = \pm\beta, \pi \pm \beta`, k = sin(beta)
    and k' = cos(beta), the half-height and half-width are

    .. math:: h = 2 c\,[E(k) - k'^2 K(k)], \quad w = 2 c\,[E(k') - k^2 K(k')], \quad
        a_1 = c \cos 2\beta.

    The square of side 2a has m = (Gamma(1/4)^4 / (2 pi^2) - 4) rho a^2 = 4.754 rho a^2 and
    J = 0.725 rho a^4: the two numbers of Newman's table 4.3. They are per metre of a long square
    bar, not those of a square plate.

    Raises
    ------
    CannotComputeError
        Sides or density not above zero, or sides in a ratio beyond 1 : 1000.

    >>> square = rectangle_section(2.0, 2.0, 1.0)
    >>> round(square.sway_kgpm, 3), round(square.heave_kgpm, 3), round(square.roll_kgm, 3)
    (4.754, 4.754, 0.725)
    """
    w, h, rho = width_m / 2, height_m / 2, density_kgpm3
    if not (np.isfinite([w, h, rho]).all() and min(w, h, rho) > 0 and 1e-3 < h / w < 1e3):
        raise CannotComputeError(
            f"A rectangular section of {width_m} m by {height_m} m in water of {rho} kg/m^3 has no "
            "added mass that this formula gives.\nExpected sides and density above zero, and sides "
            "in a ratio of less than 1000. Take a flat plate for thinner ones."
        )
    # the ratio h / w rises from 0 to infinity with beta; m = k^2 is scipy's parameter
    beta = float(
        brentq(
            lambda b: h * _side(np.pi / 2 - b) - w * _side(b),
            1e-4,
            np.pi / 2 - 1e-4,
            xtol=1e-15,
            rtol=1e-14,
        )
    )
    c = (w + h) / (2 * (_side(beta) + _side(np.pi / 2 - beta)))
    a_1 = c * np.cos(2 * beta)
    area = 4 * w * h
    return SectionAddedMass(
        sway_kgpm=float(rho * (2 * np.pi * c * (c - a_1) - area)),
        heave_kgpm=float(rho * (2 * np.pi * c * (c + a_1) - area)),
        roll_kgm=float(rho * _rectangle_roll(w, h, c, beta)),
    )


def _side(beta: float) -> float:
    """Return half of the side that spans -beta to beta, for c = 1/2: E(k) - k'^2 K(k)."""
    m = np.sin(beta) ** 2
    return float(ellipe(m) - (1 - m) * ellipk(m))


def _rectangle_roll(w: float, h: float, c: float, beta: float) -> float:
    """Return J / rho from the Fourier series of |y + i z|^2 / 2 on the unit circle.

    By the two symmetries one quadrant is enough, and only even harmonics are there.
    """
    n = 2048
    theta = (np.arange(n) + 0.5) * (np.pi / 2) / n
    # position along the upright side, from its middle, for theta < beta: z = int 2 c sqrt(...)
    z = np.where(theta < beta, 2 * c * _partial_side(np.minimum(theta, beta), beta), h)
    y = np.where(
        theta > beta,
        2 * c * _partial_side(np.minimum(np.pi / 2 - theta, np.pi / 2 - beta), np.pi / 2 - beta),
        w,
    )
    p = dct((y**2 + z**2) / 2)[1 : n // 4] / n  # coefficients of cos(2 m theta), m = 1, 2, ...
    return float(np.pi * np.sum(2 * np.arange(1, n // 4) * p**2))


def _partial_side(theta: FloatArray, beta: float) -> FloatArray:
    """Return the integral of sqrt(sin^2 beta - sin^2 t) from 0 to theta, in closed form."""
    m = np.sin(beta) ** 2
    # sin t = k sin u turns it into E(u, k) - k'^2 F(u, k)
    u = np.arcsin(np.clip(np.sin(theta) / np.sin(beta), -1.0, 1.0))
    return np.asarray(ellipeinc(u, m) - (1 - m) * ellipkinc(u, m), dtype=float)
