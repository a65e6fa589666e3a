r"""Cavitation of a screw: Keller's least area and Burrill's limit of the blade loading.

Keller 1966: :math:`(A_E/A_0)_{min} = (1.3 + 0.3 Z) T / ((p_0 - p_v) D^2) + k`.

Burrill and Emerson 1963, 5 % back cavitation, as fitted in Molland, Turnock and Hudson 2011,
ch. 12:

.. math::

    \tau_c = \frac{T}{\frac12 \rho A_P V_R^2} \le 0.28 (\sigma - 0.03)^{0.57}, \qquad
    \sigma = \frac{p_0 - p_v}{\frac12 \rho V_R^2}, \qquad V_R^2 = V_a^2 + (0.7 \pi n D)^2

with the projected area :math:`A_P = A_E (1.067 - 0.229 P/D)`.
"""

import numpy as np

from pipeline.design.propeller_input import WaterInput
from pipeline.design.propeller_series import Geometry
from pipeline.types import ArrayLike, FloatArray

ATMOSPHERE_PA = 101325.0
#: Burrill's chart ends here; a larger cavitation number counts as this one.
LARGEST_SIGMA = 2.0


def pressure_over_vapour_pa(water: WaterInput) -> float:
    """p_0 - p_v at the shaft. [Pa]."""
    head = water.density_kgpm3 * water.gravity_mps2 * water.shaft_depth_m
    return ATMOSPHERE_PA + head - water.vapour_pressure_pa


def keller_area_ratio(
    thrust_n: ArrayLike, one: Geometry, water: WaterInput, margin: float = 0.2
) -> FloatArray:
    """Least expanded area ratio by Keller's formula. [-].

    >>> sea = WaterInput(density_kgpm3=1025.0, shaft_depth_m=3.0, vapour_pressure_pa=1700.0)
    >>> round(float(keller_area_ratio(150e3, Geometry(4, 3.0, 1.0, 0.5), sea)), 3)
    0.521
    """
    thrust = np.asarray(thrust_n, float)
    per = pressure_over_vapour_pa(water) * np.asarray(one.diameter_m) ** 2
    return np.asarray((1.3 + 0.3 * one.blades) * thrust / per + margin)


def burrill(
    thrust_n: ArrayLike,
    advance_speed_mps: float,
    shaft_speed_rps: ArrayLike,
    one: Geometry,
    water: WaterInput,
) -> tuple[FloatArray, FloatArray]:
    """Blade loading tau_c and Burrill's limit for 5 % back cavitation. [-]."""
    diameter = np.asarray(one.diameter_m, float)
    turning = 0.7 * np.pi * np.asarray(shaft_speed_rps, float) * diameter
    pressure = 0.5 * water.density_kgpm3 * (advance_speed_mps**2 + turning**2)
    expanded = np.asarray(one.area_ratio) * np.pi / 4.0 * diameter**2
    projected = expanded * (1.067 - 0.229 * np.asarray(one.pitch_ratio))
    sigma = np.clip(pressure_over_vapour_pa(water) / pressure, 0.031, LARGEST_SIGMA)
    limit = 0.28 * (sigma - 0.03) ** 0.57
    return np.asarray(np.asarray(thrust_n, float) / (pressure * projected)), np.asarray(limit)
