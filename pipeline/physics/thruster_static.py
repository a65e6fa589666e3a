"""Static characteristic T(N, V) as polynomials in the code: Kostenko 2023, eq. (4), Table 2.

Sign conventions. Code and thrust have one sign; the thruster is taken as symmetric, so a negative
code mirrors the positive one. Speed is that of the vehicle along the thruster's positive
direction. With thrust and speed along the same direction the row of that speed holds; against the
motion the row at rest holds (see `pipeline.physics.opposed_thrust` for how well).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.types import ArrayLike, FloatArray


def dead_zone_code(coefficients: ArrayLike) -> float:
    r"""Code up to which the thrust is zero: the root of K_F0 + K_F1 N + K_F2 N^2.

    The paper prints "T = 0 for |N| <= K_F0", but K_F0 is a (negative) thrust. The thrust is zero
    where the polynomial is not positive, that is up to its first positive root.

    Parameters
    ----------
    coefficients : array_like, shape (3,)
        K_F0, K_F1, K_F2. [N]

    Returns
    -------
    float
        Edge of the dead zone; 0 if the polynomial does not start below zero, inf if it never
        becomes positive.

    References
    ----------
    Kostenko 2023, eq. (4).

    Examples
    --------
    >>> round(dead_zone_code([-4.0, 0.254, 8.82e-4]), 2)
    14.97
    """
    k0, k1, k2 = (float(k) for k in np.asarray(coefficients, float))
    if k0 >= 0.0:
        return 0.0
    discriminant = k1**2 - 4.0 * k2 * k0
    if discriminant < 0.0:
        return np.inf
    # the first root: the polynomial starts negative at N = 0 and rises through zero there
    denominator = k1 + np.sqrt(discriminant)
    return float(-2.0 * k0 / denominator) if denominator > 0.0 else np.inf


def thrust_from_code(code: ArrayLike, coefficients: ArrayLike) -> FloatArray:
    r"""Thrust at one speed, :math:`T = K_{F0}\,\mathrm{sign} N + K_{F1} N + K_{F2} N |N|`.

    Parameters
    ----------
    code : array_like, shape (...)
        Signed control code.
    coefficients : array_like, shape (3,) or (..., 3)
        K_F0, K_F1, K_F2. [N]

    Returns
    -------
    ndarray, shape (...)
        Thrust, zero where the polynomial is not positive. [N]

    References
    ----------
    Kostenko 2023, eq. (4).

    Examples
    --------
    >>> thrust_from_code(np.array([-127, -10, 0, 10, 127]), [-4.0, 0.254, 8.82e-4]).round(2)
    array([-42.48,   0.  ,   0.  ,   0.  ,  42.48])
    """
    n = np.asarray(code, float)
    k = np.asarray(coefficients, float)
    size = np.abs(n)
    polynomial = k[..., 0] + k[..., 1] * size + k[..., 2] * size**2
    # adding zero turns the -0.0 of a negative code in the dead zone into 0.0
    return np.asarray(np.sign(n) * np.maximum(polynomial, 0.0) + 0.0)


def code_from_thrust(thrust_n: ArrayLike, coefficients: ArrayLike) -> FloatArray:
    r"""Exact inverse of `thrust_from_code` for coefficients with K_F1 > 0 and K_F2 >= 0.

    .. math:: |N| = \frac{2 (|T| - K_{F0})}{K_{F1} + \sqrt{K_{F1}^2 + 4 K_{F2} (|T| - K_{F0})}}

    the root that keeps its digits when K_F2 is small.

    Parameters
    ----------
    thrust_n : array_like, shape (...)
        Signed thrust. [N]
    coefficients : array_like, shape (3,) or (..., 3)
        K_F0, K_F1, K_F2. [N]

    Returns
    -------
    ndarray, shape (...)
        Signed code, not clamped; 0 for no thrust.

    Examples
    --------
    >>> round(float(code_from_thrust(20.0, [-15.0, 0.208, 8.67e-4])), 1)
    114.1
    """
    t = np.asarray(thrust_n, float)
    k = np.asarray(coefficients, float)
    rise = np.abs(t) - k[..., 0]
    size = 2.0 * rise / (k[..., 1] + np.sqrt(k[..., 1] ** 2 + 4.0 * k[..., 2] * rise))
    return np.asarray(np.sign(t) * size)


@dataclass(frozen=True)
class StaticTable:
    """Table 2: `speed_mps` shape (v,), rising from 0; `coefficients` shape (v, 3). [m/s], [N]."""

    speed_mps: FloatArray
    coefficients: FloatArray

    def at_speed(self, speed_mps: ArrayLike) -> FloatArray:
        """Coefficients at speeds along the thrust, shape (..., 3), clamped to the table.

        Linear in speed, which is the same as interpolating the polynomials at a fixed code.
        """
        speed = np.clip(np.asarray(speed_mps, float), self.speed_mps[0], self.speed_mps[-1])
        columns = [np.interp(speed, self.speed_mps, column) for column in self.coefficients.T]
        return np.stack(columns, axis=-1)

    def thrust_n(self, code: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Thrust for signed codes and speed along the thruster's positive direction. [N].

        Examples
        --------
        >>> table = StaticTable(np.array([0.0, 2.0]),
        ...                     np.array([[-4.0, 0.254, 8.82e-4], [-15.0, 0.208, 8.67e-4]]))
        >>> table.thrust_n(np.array([127.0, -127.0]), 2.0).round(1).tolist()
        [25.4, -42.5]
        """
        codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
        along = np.maximum(np.sign(codes) * speed, 0.0)
        return thrust_from_code(codes, self.at_speed(along))
