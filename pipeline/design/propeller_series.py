r"""Open-water polynomials of the Wageningen B-series.

.. math:: K_T = \sum_i C_i J^{s_i} (P/D)^{t_i} (A_E/A_0)^{u_i} Z^{v_i}

and K_Q (the papers' K_M) likewise, 39 and 47 terms: Oosterveld and van Oossanen 1975, International
Shipbuilding Progress 22 (251). They hold at a Reynolds number of 2e6, for P/D 0.5 to 1.4, A_E/A_0
0.30 to 1.05, 2 to 7 blades.
"""

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from pipeline.types import ArrayLike, FloatArray

PITCH_RATIOS = (0.5, 1.4)
AREA_RATIOS = (0.30, 1.05)
#: Smallest and largest area ratio of the models that were tested, by blades.
TESTED_AREA_RATIOS = {
    2: (0.30, 0.30),
    3: (0.35, 0.80),
    4: (0.40, 1.00),
    5: (0.45, 1.05),
    6: (0.50, 0.80),
    7: (0.55, 0.85),
}
#: Reynolds number of the polynomials, by the chord at 0.75 of the radius.
SERIES_REYNOLDS = 2e6
#: (C, powers of J, P/D, A_E/A_0 and Z); the thrust has 39 terms.
Term = tuple[float, int, int, int, int]


def _terms(of: str) -> tuple[Term, ...]:
    """Read the terms of a coefficient: powers of J, P/D, A_E/A_0 and Z."""
    with Path(__file__).with_name("b_series.csv").open(encoding="utf-8", newline="") as stream:
        return tuple(
            (float(c), int(s), int(t), int(u), int(v))
            for name, c, s, t, u, v in csv.reader(stream)
            if name == of
        )


THRUST_TERMS, TORQUE_TERMS = _terms("K_T"), _terms("K_Q")


@dataclass(frozen=True)
class Geometry:
    """Blades Z, diameter D [m], pitch ratio P/D, expanded area ratio A_E/A_0; arrays broadcast."""

    blades: int
    diameter_m: FloatArray | float
    pitch_ratio: FloatArray | float
    area_ratio: FloatArray | float


@cache
def _tensor(terms: tuple[Term, ...], blades: int) -> FloatArray:
    """Coefficients of a number of blades, shape (powers of J, of P/D, of A_E/A_0)."""
    tensor = np.zeros((4, 7, 3))
    for c, s, t, u, v in terms:
        tensor[s, t, u] += c * float(blades) ** v
    return tensor


def _sum(terms: tuple[Term, ...], advance_ratio: ArrayLike, one: Geometry) -> FloatArray:
    j, p, a = np.broadcast_arrays(
        np.asarray(advance_ratio, float),
        np.asarray(one.pitch_ratio, float),
        np.asarray(one.area_ratio, float),
    )
    tensor = _tensor(terms, one.blades)
    # Horner in A_E/A_0, then in P/D, then in J
    in_area = (tensor[..., 2, None] * a.ravel() + tensor[..., 1, None]) * a.ravel()
    in_area += tensor[..., 0, None]
    total = np.zeros(j.size)
    for by_pitch in in_area[::-1]:
        inner = np.zeros(j.size)
        for coefficient in by_pitch[::-1]:
            inner = inner * p.ravel() + coefficient
        total = total * j.ravel() + inner
    return total.reshape(j.shape)


def thrust_coefficient(advance_ratio: ArrayLike, one: Geometry) -> FloatArray:
    """K_T of the series at Rn = 2e6. [-].

    Examples
    --------
    The propeller of REMUS 100 in Fossen 2021 (MSS toolbox): 0.4566 and 0.1798 are printed.

    >>> remus = Geometry(3, 0.14, 1.0, 0.718)
    >>> thrust_coefficient([0.0, 0.6632], remus).round(4).tolist()
    [0.4566, 0.1798]
    """
    return _sum(THRUST_TERMS, advance_ratio, one)


def torque_coefficient(advance_ratio: ArrayLike, one: Geometry) -> FloatArray:
    """K_Q (K_M) of the series at Rn = 2e6. [-].

    >>> remus = Geometry(3, 0.14, 1.0, 0.718)
    >>> torque_coefficient([0.0, 0.6632], remus).round(4).tolist()
    [0.07, 0.0312]
    """
    return _sum(TORQUE_TERMS, advance_ratio, one)


def no_thrust_from(one: Geometry) -> float | None:
    """Return the least advance ratio at which a propeller gives no thrust; None: none up to 2.

    Far beyond it the polynomials turn positive again, so the sign there says nothing.

    >>> no_thrust_from(Geometry(3, 0.14, 1.0, 0.718))
    1.045
    """
    j = np.linspace(0.0, 2.0, 401)
    none = np.flatnonzero(thrust_coefficient(j, one) <= 0.0)
    return round(float(j[none[0]]), 3) if none.size else None


def reynolds(
    advance_speed_mps: float, shaft_speed_rps: ArrayLike, one: Geometry, viscosity_m2ps: float
) -> FloatArray:
    r"""Reynolds number by the chord at 0.75 R, c = 2.073 (A_E/A_0) D / Z. [-].

    >>> pilgrim = Geometry(3, 0.185, 1.3, 0.3)
    >>> f"{float(reynolds(3.0, 17.0, pilgrim, 1.0e-6)):.2e}"
    '3.07e+05'
    """
    chord = 2.073 * np.asarray(one.area_ratio) * one.diameter_m / one.blades
    tip = 0.75 * np.pi * np.asarray(shaft_speed_rps, float) * one.diameter_m
    return np.asarray(chord * np.sqrt(advance_speed_mps**2 + tip**2) / viscosity_m2ps)


def reynolds_correction(
    advance_ratio: ArrayLike, one: Geometry, reynolds_number: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    r"""Return what K_T and K_Q gain above Rn = 2e6; nothing below, where it was not derived.

    Oosterveld and van Oossanen 1975, Table 7, with x = log10(Rn) - 0.301.

    >>> dkt, dkq = reynolds_correction(0.8, Geometry(4, 5.0, 1.0, 0.7), 5e7)
    >>> float(dkt) > 0 and float(dkq) < 0
    True
    """
    number = np.asarray(reynolds_number, float)
    j, p, a = (np.asarray(v, float) for v in (advance_ratio, one.pitch_ratio, one.area_ratio))
    z = float(one.blades)
    x = np.log10(np.maximum(number, SERIES_REYNOLDS)) - 0.301
    thrust = (
        0.000353485
        - 0.00333758 * a * j**2
        - 0.00478125 * a * p * j
        + 0.000257792 * x**2 * a * j**2
        + 0.0000643192 * x * p**6 * j**2
        - 0.0000110636 * x**2 * p**6 * j**2
        - 0.0000276305 * x**2 * z * a * j**2
        + 0.0000954 * x * z * a * p * j
        + 0.0000032049 * x * z**2 * a * p**3 * j
    )
    torque = (
        -0.000591412
        + 0.00696898 * p
        - 0.0000666654 * z * p**6
        + 0.0160818 * a**2
        - 0.000938091 * x * p
        - 0.00059593 * x * p**2
        + 0.0000782099 * x**2 * p**2
        + 0.0000052199 * x * z * a * j**2
        - 0.00000088528 * x**2 * z * a * p * j
        + 0.0000230171 * x * z * p**6
        - 0.00000184341 * x**2 * z * p**6
        - 0.00400252 * x * a**2
        + 0.000220915 * x**2 * a**2
    )
    above = number > SERIES_REYNOLDS
    return np.where(above, thrust, 0.0), np.where(above, torque, 0.0)
