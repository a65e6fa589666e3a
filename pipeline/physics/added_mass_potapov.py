r"""The added masses of Potapov and Galyaev, number by number, beside what the formulas give.

The vehicle is a cylinder of radius 15 cm and height 17 cm in a square frame of 33 cm outside and
24 cm inside; x_1 and y_1 lie in the plane of the frame, z_1 is the cylinder's axis.

.. math::

    (M_a)_{11} = \pi \rho r^2 h, \qquad
    (M_a)_{33} = \kappa \rho r^2 h + \tfrac{\pi}{8} \rho (a^3 - b^3), \qquad
    (J_a)_{11} = 0.725 \rho r^3 \tfrac{h^2}{4} + \tfrac{3.7 \pi}{32} \rho (a^5 - b^5)

The paper's text has kappa = 2.377; its figure 26.86 kg follows with kappa = 4.754.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.physics.added_mass_sections import rectangle_section


@dataclass(frozen=True)
class ComparedValue:
    """A printed number, None where the paper prints nothing, and what was computed for it.

    `note` names the formula: which reading, and what to think of it.
    """

    name: str
    unit: str
    printed: float | None
    computed: float
    note: str


@dataclass(frozen=True)
class PotapovGalyaev:
    """Every added mass of the paper.

    `surge` (M_a)_11, `heave_formula` (M_a)_33 as printed, `heave_figure` with the coefficient that
    gives the printed figure, `tilt_inertia` (J_a)_11; `section_mass`, `section_inertia` the two
    coefficients that the paper quotes for a square of side 2a; `surge_measured_kg` (M_a)_11 from
    the slope of acceleration against thrust in the pool, `surge_in_conclusion_kg` what section 4.1
    prints for the computed one.
    """

    surge: ComparedValue
    heave_formula: ComparedValue
    heave_figure: ComparedValue
    tilt_inertia: ComparedValue
    section_mass: ComparedValue
    section_inertia: ComparedValue
    surge_measured_kg: float
    surge_in_conclusion_kg: float


def potapov_galyaev(
    *,
    radius_m: float = 0.15,
    height_m: float = 0.17,
    outer_side_m: float = 0.33,
    inner_side_m: float = 0.24,
    density_kgpm3: float = 1000.0,
) -> PotapovGalyaev:
    """Return the paper's added masses, printed and computed; the defaults are the paper's sizes.

    Cylinder of `radius_m` and `height_m`; frame, taken as the larger plate less the smaller, of
    `outer_side_m` and `inner_side_m` [m]; water of `density_kgpm3`.

    References
    ----------
    Potapov and Galyaev, On one problem of identification of an unmanned underwater vehicle model.

    >>> p = potapov_galyaev()
    >>> round(p.surge.computed, 2), round(p.tilt_inertia.computed, 2)
    (12.02, 1.15)
    >>> round(p.heave_formula.computed, 2), round(p.heave_figure.computed, 2)
    (17.78, 26.87)
    """
    r, h, a, b, rho = radius_m, height_m, outer_side_m, inner_side_m, density_kgpm3
    frame_mass = np.pi / 8 * rho * (a**3 - b**3)
    frame_inertia = 3.7 * np.pi / 32 * rho * (a**5 - b**5)
    square = rectangle_section(2.0, 2.0, 1.0)
    return PotapovGalyaev(
        surge=ComparedValue(
            "(M_a)_11 = (M_a)_22", "kg", 12.02, np.pi * rho * r**2 * h, "strip of a long cylinder"
        ),
        heave_formula=ComparedValue(
            "(M_a)_33",
            "kg",
            26.86,
            2.377 * rho * r**2 * h + frame_mass,
            "formula as printed, coefficient 2.377",
        ),
        heave_figure=ComparedValue(
            "(M_a)_33",
            "kg",
            26.86,
            4.754 * rho * r**2 * h + frame_mass,
            "coefficient 4.754, which gives the printed figure (26.868, cut to 26.86)",
        ),
        tilt_inertia=ComparedValue(
            "(J_a)_11 = (J_a)_22",
            "kg m^2",
            1.15,
            0.725 * rho * r**3 * h**2 / 4 + frame_inertia,
            "as printed; 98 % of it is the frame's 3.7 pi / 32",
        ),
        section_mass=ComparedValue(
            "(M'_a)_11 / (rho a^2)",
            "-",
            4.754,
            square.sway_kgpm,
            "exact for a long square bar of side 2a, per metre: a plane section, not a plate",
        ),
        section_inertia=ComparedValue(
            "(J'_a)_33 / (rho a^4)",
            "-",
            0.725,
            square.roll_kgm,
            "the same section turning about its axis, per metre",
        ),
        surge_measured_kg=18.92,
        surge_in_conclusion_kg=12.05,
    )
