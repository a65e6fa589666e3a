"""Added mass of plates, boxes and cylinders from the tables of DNV-RP-H103 (2011), now DNV-RP-N103.

Unbounded water, at right angles to the sides or along the axis; SI units.
"""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.added_mass_shapes import disc_added_mass, require_positive

#: DNV-RP-H103 (2011) table A-2, rectangular plate moving at right angles to itself: longer side
#: over shorter side, coefficient on the reference volume pi/4 a^2 b (a the shorter side).
PLATE_ASPECT = (1.0, 1.25, 1.5, 1.59, 2.0, 2.5, 3.0, 3.17, 4.0, 5.0, 6.25, 8.0, 10.0)
PLATE_COEFFICIENT = (
    0.579, 0.642, 0.690, 0.704, 0.757, 0.801, 0.830, 0.840, 0.872, 0.897, 0.917, 0.934, 0.947,
)  # fmt: skip
#: The same table, square prism moving along its length: length over side, coefficient on a^2 b.
PRISM_ASPECT = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 10.0)
PRISM_COEFFICIENT = (0.68, 0.36, 0.24, 0.19, 0.15, 0.13, 0.11, 0.08)
#: The same table, circular cylinder moving across its axis: length over diameter.
CYLINDER_ASPECT = (1.2, 2.5, 5.0, 9.0)
CYLINDER_COEFFICIENT = (0.62, 0.78, 0.90, 0.96)


def rectangular_plate_added_mass(side_1_m: float, side_2_m: float, density_kgpm3: float) -> float:
    r"""Return the added mass of a thin rectangular plate that moves at right angles to itself.

    .. math:: m = C_A(b / a)\, \rho \tfrac{\pi}{4} a^2 b, \qquad a \le b

    C_A is 1 for a long plate (strip theory) and 0.579 for the square.

    Parameters
    ----------
    side_1_m, side_2_m : float
        Full sides, in either order. [m]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    float
        Added mass. [kg]

    Notes
    -----
    The table is interpolated in a / b, with C_A = 1 at a / b = 0.

    References
    ----------
    DNV-RP-H103 (2011), table A-2.

    Examples
    --------
    >>> round(rectangular_plate_added_mass(1.0, 1.0, 1000.0), 1)
    454.7
    """
    require_positive("plate", (side_1_m, side_2_m), density_kgpm3)
    a, b = sorted((side_1_m, side_2_m))
    coefficient = _interpolate_to_infinity(b / a, PLATE_ASPECT, PLATE_COEFFICIENT)
    return coefficient * density_kgpm3 * np.pi / 4.0 * a**2 * b


def square_prism_axial_added_mass(side_m: float, length_m: float, density_kgpm3: float) -> float:
    r"""Return the added mass of a square prism that moves along its length, :math:`C_A \rho a^2 b`.

    Parameters
    ----------
    side_m : float
        Side a of the square. [m]
    length_m : float
        Length b, along the motion, 1 to 10 sides. [m]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    float
        Added mass. [kg]

    Raises
    ------
    CannotComputeError
        The table holds no such prism.

    References
    ----------
    DNV-RP-H103 (2011), table A-2.

    Examples
    --------
    >>> round(square_prism_axial_added_mass(1.0, 1.0, 1000.0), 1)  # a cube
    680.0
    """
    require_positive("prism", (side_m, length_m), density_kgpm3)
    aspect = length_m / side_m
    if not PRISM_ASPECT[0] <= aspect <= PRISM_ASPECT[-1]:
        raise CannotComputeError(
            f"A square prism of {side_m} m by {length_m} m is {aspect:.3g} sides long; "
            "the table of DNV-RP-H103 holds 1 to 10.\nTake box_added_mass for other boxes."
        )
    # added mass over a^3 changes little along the table (0.68 ... 0.80): interpolate that
    per_cube = np.interp(aspect, PRISM_ASPECT, np.multiply(PRISM_COEFFICIENT, PRISM_ASPECT))
    return float(per_cube) * density_kgpm3 * side_m**3


def thickened_added_mass(
    plate_added_mass_kg: float, projected_area_m2: float, thickness_m: float
) -> float:
    r"""Return the added mass of a straight-sided body from that of the plate of its outline.

    .. math::

        m = \left[1 + \sqrt{\frac{1 - \lambda^2}{2 (1 + \lambda^2)}}\right] m_\text{plate}, \qquad
        \lambda = \frac{\sqrt{A_p}}{t + \sqrt{A_p}}

    Parameters
    ----------
    plate_added_mass_kg : float
        Of the thin plate. [kg]
    projected_area_m2 : float
        Area A_p that the body shows to the flow. [m^2]
    thickness_m : float
        Length t of the body along the motion. [m]

    Returns
    -------
    float
        Added mass. [kg]

    References
    ----------
    DNV-RP-H103 (2011), section 4.6.3.3.

    Examples
    --------
    A cube: 0.704, where the table for prisms has 0.68.

    >>> round(thickened_added_mass(rectangular_plate_added_mass(1.0, 1.0, 1.0), 1.0, 1.0), 3)
    0.704
    """
    require_positive("body", (projected_area_m2, plate_added_mass_kg), 1.0)
    if not (np.isfinite(thickness_m) and thickness_m >= 0):
        raise CannotComputeError(f"A thickness of {thickness_m} m cannot be; expected 0 or more.")
    width = np.sqrt(projected_area_m2)
    ratio = width / (thickness_m + width)
    return float(plate_added_mass_kg * (1 + np.sqrt((1 - ratio**2) / (2 * (1 + ratio**2)))))


def box_added_mass(
    length_m: float, width_m: float, height_m: float, density_kgpm3: float
) -> tuple[float, float, float]:
    """Return the added mass of a rectangular box in surge, sway and heave.

    Each is a plate with `thickened_added_mass`.

    Parameters
    ----------
    length_m, width_m, height_m : float
        Full sides along x, y, z. [m]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    tuple of float
        Surge, sway, heave added mass. [kg]

    Notes
    -----
    Against the table for square prisms (lengths of 1 to 10 sides) the formula is -3 to +5 % off.
    It gives no rotation; take strips of `added_mass_sections.rectangle_section` for a long box.

    Examples
    --------
    >>> [round(m, 1) for m in box_added_mass(0.5, 0.4, 0.3, 1000.0)]
    [29.8, 39.3, 59.9]
    """
    require_positive("box", (length_m, width_m, height_m), density_kgpm3)
    sides = (length_m, width_m, height_m)
    surge, sway, heave = (
        thickened_added_mass(
            rectangular_plate_added_mass(sides[i - 2], sides[i - 1], density_kgpm3),
            sides[i - 2] * sides[i - 1],
            sides[i],
        )
        for i in range(3)
    )
    return surge, sway, heave


def cylinder_added_mass(
    radius_m: float, length_m: float, density_kgpm3: float
) -> tuple[float, float]:
    r"""Return the added mass of a circular cylinder with flat ends: along its axis and across it.

    Across: :math:`C_A(L / 2r)\, \rho \pi r^2 L` (table; 1 for a long one, which is strip theory).
    Along: a disc, 8/3 rho r^3, with `thickened_added_mass`.

    Parameters
    ----------
    radius_m, length_m : float
        Radius r and length L, L at least 1.2 diameters. [m]
    density_kgpm3 : float
        Water density. [kg/m^3]

    Returns
    -------
    tuple of float
        Added mass along the axis and across it. [kg]

    Raises
    ------
    CannotComputeError
        The cylinder is shorter than the table.

    References
    ----------
    DNV-RP-H103 (2011), table A-2 and section 4.6.3.3.

    Examples
    --------
    >>> along, across = cylinder_added_mass(0.1, 1.0, 1000.0)
    >>> round(along, 2), round(across, 2)
    (4.51, 28.27)
    """
    require_positive("cylinder", (radius_m, length_m), density_kgpm3)
    aspect = length_m / (2 * radius_m)
    if aspect < CYLINDER_ASPECT[0]:
        raise CannotComputeError(
            f"A cylinder of {aspect:.3g} diameters in length is too short for the table of "
            f"DNV-RP-H103, which starts at {CYLINDER_ASPECT[0]}.\nTake an ellipsoid of the same "
            "length and volume instead."
        )
    coefficient = _interpolate_to_infinity(aspect, CYLINDER_ASPECT, CYLINDER_COEFFICIENT)
    across = coefficient * density_kgpm3 * np.pi * radius_m**2 * length_m
    disc, _ = disc_added_mass(radius_m, density_kgpm3)
    return thickened_added_mass(disc, np.pi * radius_m**2, length_m), across


def _interpolate_to_infinity(
    aspect: float, aspects: tuple[float, ...], coefficients: tuple[float, ...]
) -> float:
    """Interpolate over 1 / aspect, with the coefficient 1 of an endless body at 0."""
    inverse = [0.0, *(1.0 / a for a in reversed(aspects))]
    return float(np.interp(1.0 / aspect, inverse, [1.0, *reversed(coefficients)]))
