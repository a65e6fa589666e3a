"""The dead zone of a static characteristic T(N, V): Kostenko 2023, eq. (4), Table 2."""

import numpy as np

from pipeline.types import ArrayLike


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
