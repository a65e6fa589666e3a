r"""Added mass of simple bodies in unbounded water, at their centre, in SNAME axes.

Every value is that of an ideal fluid far from walls, bottom and surface. The added-mass matrix A is
positive: the water's force on the body is :math:`-A \dot\nu`, so A[0, 0] is Fossen's
:math:`-X_{\dot u}`. Plane sections are in `added_mass_sections`, slender hulls in `strip_theory`.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import elliprd

from pipeline.physics.carried_body import cross_matrix
from pipeline.types import FloatArray


def ellipsoid_added_mass(
    semi_axes_m: tuple[float, float, float], density_kgpm3: float
) -> FloatArray:
    r"""Return the added mass of an ellipsoid, exact (Lamb).

    With semi-axes a, b, c along x, y, z and

    .. math::

        \alpha_0 = abc \int_0^\infty \frac{d\lambda}{(a^2 + \lambda) \Delta}
                 = \tfrac{2}{3} abc\, R_D(b^2, c^2, a^2), \qquad
        \Delta^2 = (a^2 + \lambda)(b^2 + \lambda)(c^2 + \lambda),

    and beta_0, gamma_0 likewise for b and c, the surge mass and the roll inertia are

    .. math::

        A_{11} = \frac{\alpha_0}{2 - \alpha_0} m, \qquad
        A_{44} = \frac{m}{5} \frac{(b^2 - c^2)^2 (\gamma_0 - \beta_0)}
                 {2 (b^2 - c^2) - (b^2 + c^2)(\gamma_0 - \beta_0)}, \qquad
        m = \tfrac{4}{3} \pi \rho abc;

    the others follow by turning the axes round.

    Parameters
    ----------
    semi_axes_m : tuple of 3 floats
        a, b, c. [m]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    ndarray, shape (6, 6)
        Diagonal added-mass matrix at the centre. [kg, kg m^2]

    References
    ----------
    Lamb, Hydrodynamics, 6th ed. 1932, sections 114, 115 and 121a; Lamb 1918, ARC R&M 623 (table for
    the prolate spheroid). R_D is Carlson's integral, DLMF 19.16.5.

    Examples
    --------
    A sphere of 1 m radius carries half of the mass of its water; a 6 : 1 spheroid little along its
    axis and most of it across (R&M 623 prints 0.045, 0.918 and 0.764).

    >>> round(float(ellipsoid_added_mass((1.0, 1.0, 1.0), 3 / (4 * np.pi))[0, 0]), 6)
    0.5
    >>> spheroid = ellipsoid_added_mass((6.01, 1.0, 1.0), 3 / (4 * np.pi * 6.01))
    >>> inertia = (6.01**2 + 1) / 5
    >>> [round(float(v), 3) for v in (spheroid[0, 0], spheroid[1, 1], spheroid[5, 5] / inertia)]
    [0.045, 0.917, 0.763]
    """
    squares = np.square(np.asarray(semi_axes_m, float))
    product = float(np.prod(semi_axes_m))
    mass = 4.0 / 3.0 * np.pi * density_kgpm3 * product
    integrals = np.array(
        [
            2.0 / 3.0 * product * elliprd(squares[i - 2], squares[i - 1], squares[i])
            for i in range(3)
        ]
    )
    diagonal = np.empty(6)
    diagonal[:3] = integrals / (2.0 - integrals) * mass
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        difference, total = squares[j] - squares[k], squares[j] + squares[k]
        if abs(difference) < 1e-9 * total:
            diagonal[3 + i] = 0.0  # a round section carries no water as it turns; 0 / 0 above
            continue
        slope = (integrals[k] - integrals[j]) / difference
        diagonal[3 + i] = mass / 5.0 * difference**2 * slope / (2.0 - total * slope)
    return np.diag(diagonal)


def disc_added_mass(radius_m: float, density_kgpm3: float) -> tuple[float, float]:
    r"""Return mass [kg] across a thin disc and inertia [kg m^2] about a diameter.

    .. math:: m = \tfrac{8}{3} \rho r^3, \qquad J = \tfrac{16}{45} \rho r^5

    References
    ----------
    Lamb, Hydrodynamics, 1932, sections 102 and 108.

    >>> mass, inertia = disc_added_mass(1.0, 1.0)
    >>> round(mass, 4), round(inertia, 4)
    (2.6667, 0.3556)
    """
    return 8.0 / 3.0 * density_kgpm3 * radius_m**3, 16.0 / 45.0 * density_kgpm3 * radius_m**5


def moved_added_mass(
    added_mass: FloatArray, position_m: FloatArray, rotation: FloatArray | None = None
) -> FloatArray:
    r"""Return the added mass of a part as seen from the vehicle's reference point O, (6, 6).

    .. math::

        A_O = H^T A_P H, \qquad
        H = \begin{pmatrix} R^T & -R^T S(r) \\ 0 & R^T \end{pmatrix}, \qquad S(r)\,v = r \times v

    H turns the velocities of O into those of the part's point P. Sum the matrices of the parts;
    their interaction is left out, as in the papers. `added_mass` (6, 6) is about P, in the part's
    axes [kg, kg m, kg m^2], `position_m` r (3,) from O to P in vehicle axes [m], the columns of
    `rotation` R (3, 3) are the part's axes in vehicle axes; none if they are parallel.

    References
    ----------
    Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. 2021, section 3.3.

    Examples
    --------
    A sphere at the bow: turning to starboard (yaw) pushes its water to starboard (sway).

    >>> sphere = ellipsoid_added_mass((0.1, 0.1, 0.1), 1000.0)
    >>> at_bow = moved_added_mass(sphere, np.array([2.0, 0.0, 0.0]))
    >>> bool(np.isclose(at_bow[1, 5], 2.0 * sphere[1, 1])), bool(at_bow[2, 4] < 0)
    (True, True)
    """
    skew = cross_matrix(position_m)
    turn = np.eye(3) if rotation is None else np.asarray(rotation, float).T
    transform = np.block([[turn, -turn @ skew], [np.zeros((3, 3)), turn]])
    return np.asarray(transform.T @ added_mass @ transform, dtype=float)


@dataclass(frozen=True)
class PotapovGalyaev:
    """Added masses of a flat cylinder in a square frame, x and y in the plane of the frame.

    (M_a)_11, (M_a)_33 by the printed formula and with the coefficient that gives the printed
    figure, (J_a)_11.
    """

    surge_kg: float
    heave_formula_kg: float
    heave_figure_kg: float
    tilt_kgm2: float


def potapov_galyaev(
    *,
    radius_m: float = 0.15,
    height_m: float = 0.17,
    outer_side_m: float = 0.33,
    inner_side_m: float = 0.24,
    density_kgpm3: float = 1000.0,
) -> PotapovGalyaev:
    r"""Return the added masses of a cylinder in a frame; the defaults are the paper's sizes.

    .. math::

        (M_a)_{11} = \pi \rho r^2 h, \qquad
        (M_a)_{33} = \kappa \rho r^2 h + \tfrac{\pi}{8} \rho (a^3 - b^3), \qquad
        (J_a)_{11} = 0.725 \rho r^3 \tfrac{h^2}{4} + \tfrac{3.7 \pi}{32} \rho (a^5 - b^5)

    The frame is taken as the larger plate less the smaller. The paper's text has kappa = 2.377; its
    figure 26.86 kg follows with kappa = 4.754.

    References
    ----------
    Potapov and Galyaev, On one problem of identification of an unmanned underwater vehicle model.
    """
    r, h, a, b, rho = radius_m, height_m, outer_side_m, inner_side_m, density_kgpm3
    frame_mass = np.pi / 8 * rho * (a**3 - b**3)
    frame_inertia = 3.7 * np.pi / 32 * rho * (a**5 - b**5)
    return PotapovGalyaev(
        surge_kg=np.pi * rho * r**2 * h,
        heave_formula_kg=2.377 * rho * r**2 * h + frame_mass,
        heave_figure_kg=4.754 * rho * r**2 * h + frame_mass,
        tilt_kgm2=0.725 * rho * r**3 * h**2 / 4 + frame_inertia,
    )
