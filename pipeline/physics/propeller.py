"""Open-water propeller: thrust, torque, efficiency from the coefficients K_T(J) and K_M(J).

The papers' K_M is the K_Q of the English literature.
"""

import numpy as np

from pipeline.types import ArrayLike, FloatArray


def advance_ratio(
    speed_mps: ArrayLike, shaft_speed_rps: ArrayLike, diameter_m: float
) -> FloatArray:
    r"""Advance ratio :math:`J = V_a / (n D)`. [-].

    `speed_mps` of the inflow is positive from ahead, `shaft_speed_rps` n [rev/s] is not zero.

    References
    ----------
    Kostenko 2023, below eq. (1), where J is written lambda.

    >>> float(advance_ratio(1.0, 10.0, 0.2))
    0.5
    """
    return np.asarray(speed_mps, float) / (np.asarray(shaft_speed_rps, float) * diameter_m)


def polynomial(variable: ArrayLike, coefficients: ArrayLike) -> FloatArray:
    r"""Evaluate :math:`\sum_i a_i x^i`: K_T(J), K_M(J) of Kostenko 2023, eq. (2), shape (...). [-].

    `coefficients` (d + 1,) or (d + 1, ...), ascending powers, are the same for all J, or of each
    its own. Nothing is clipped: the measured range of J travels with the fit, and the caller
    decides.

    >>> polynomial(np.array([0.0, 0.5]), np.array([0.139, -0.155, -0.061])).round(4).tolist()
    [0.139, 0.0463]
    """
    return np.asarray(
        np.polynomial.polynomial.polyval(
            np.asarray(variable, float), np.asarray(coefficients), tensor=False
        ),
        dtype=float,
    )


def thrust(
    shaft_speed_rps: ArrayLike,
    speed_mps: ArrayLike,
    *,
    coefficients: ArrayLike,
    diameter_m: float,
    density_kgpm3: float,
) -> FloatArray:
    r"""Thrust :math:`T = K_T(J) \rho n^2 D^4` of Kostenko 2023, eq. (1), in SI units. [N].

    The paper's rho = 102 kg s^2/m^4 times g = 9.81 m/s^2 is the density 1000.62 kg/m^3.

    Parameters
    ----------
    shaft_speed_rps : array_like
        Shaft speed, positive. [rev/s]
    speed_mps : array_like
        Speed of the inflow, positive from ahead. [m/s]
    coefficients : array_like, shape (d + 1,)
        K_T polynomial, ascending. [-]

    >>> t = thrust(1692 / 60, 0.0, coefficients=[0.139, -0.155, -0.061],
    ...            diameter_m=0.14, density_kgpm3=1000.62)
    >>> round(float(t), 1)
    42.5
    """
    n = np.asarray(shaft_speed_rps, float)
    k_t = polynomial(advance_ratio(speed_mps, n, diameter_m), coefficients)
    return np.asarray(k_t * density_kgpm3 * n**2 * diameter_m**4)


def torque(
    shaft_speed_rps: ArrayLike,
    speed_mps: ArrayLike,
    *,
    coefficients: ArrayLike,
    diameter_m: float,
    density_kgpm3: float,
) -> FloatArray:
    r"""Torque :math:`M = K_M(J) \rho n^2 D^5` that the shaft must supply, eq. (1). [N m].

    As `thrust`, with the K_M polynomial.

    >>> m = torque(1692 / 60, 0.0, coefficients=[0.0171, -0.0164, -0.0055],
    ...            diameter_m=0.14, density_kgpm3=1000.62)
    >>> round(float(m), 3)
    0.732
    """
    n = np.asarray(shaft_speed_rps, float)
    k_m = polynomial(advance_ratio(speed_mps, n, diameter_m), coefficients)
    return np.asarray(k_m * density_kgpm3 * n**2 * diameter_m**5)


def efficiency(
    advance_ratio: ArrayLike, thrust_coefficient: ArrayLike, torque_coefficient: ArrayLike
) -> FloatArray:
    r"""Open-water efficiency :math:`\eta = J K_T / (2 \pi K_M)`. [-].

    References
    ----------
    Carlton, Marine Propellers and Propulsion, 4th ed. 2019, ch. 6.

    Examples
    --------
    The Pilgrim's propeller (Kostenko 2017, table 3) at 3 m/s: 64.8 N, 2.43 N m, 17 rev/s, 0.185 m.

    >>> j = 3 / (17 * 0.185)
    >>> k_t, k_m = 64.8 / 0.185**4, 2.43 / 0.185**5
    >>> round(float(efficiency(j, k_t, k_m)), 2)
    0.75
    """
    j, k_t, k_m = (
        np.asarray(a, float) for a in (advance_ratio, thrust_coefficient, torque_coefficient)
    )
    return np.asarray(j * k_t / (2.0 * np.pi * k_m))
