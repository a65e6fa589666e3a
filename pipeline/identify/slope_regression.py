r"""Slope of acceleration against thrust: plain, with noise in both, and with further terms.

All of them fit du/dt = tau / M + ... and give M = 1 / slope; the samples overlap (a smoother made
them), so no interval counts them as independent.

- Least squares with the covariance of Newey and West (1987) over the lags of the smoother, within
  each stretch (statsmodels, ``hac-panel``).
- The same slope over the reliability of the thrust, 1 - s_tau^2 / var(tau): noise in the regressor
  pulls a slope towards zero (Fuller 1987, section 1.1).
- Orthogonal distance with the known ratio of the noise variances (Deming 1943), its interval from a
  bootstrap of blocks longer than the smoother (Kuensch 1989).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray, IntArray

_NORMAL_95 = 1.959964
BOOTSTRAP_DRAWS = 400


@dataclass(frozen=True)
class Slope:
    """A slope [1/kg] with its standard error."""

    value: float
    std: float


@dataclass(frozen=True)
class Regression:
    """Coefficients (k,) with standard errors (k,), in the order of the design's columns."""

    coefficients: FloatArray
    std: FloatArray


def least_squares(
    design: FloatArray, response: FloatArray, stretch: IntArray, lags: int
) -> Regression:
    """Ordinary least squares with a covariance that honours autocorrelation within stretches.

    Parameters
    ----------
    design : ndarray, shape (m, k)
        Regressors, the constant included.
    response : ndarray, shape (m,)
        Acceleration.
    stretch : ndarray of int, shape (m,)
        Label of the stretch of each sample, ascending; nothing correlates across stretches.
    lags : int
        Samples up to which residuals go together.

    Raises
    ------
    CannotComputeError
        With too few samples, or regressors that depend on each other.
    """
    from statsmodels.regression.linear_model import OLS

    scale = np.max(np.abs(design), axis=0)
    scaled = design / np.where(scale > 0, scale, 1.0)
    if len(response) < 3 * design.shape[1] or np.linalg.matrix_rank(scaled) < design.shape[1]:
        raise CannotComputeError(
            f"{len(response)} samples do not determine {design.shape[1]} coefficients: too few, or "
            "the thrust hardly varies"
        )
    _, label = np.unique(stretch, return_inverse=True)
    longest = int(np.bincount(label).max())
    found = OLS(response, scaled).fit(
        cov_type="hac-panel",
        cov_kwds={"groups": label, "maxlags": min(lags, longest - 1), "use_correction": "hac"},
    )
    return Regression(np.asarray(found.params) / scale, np.asarray(found.bse) / scale)


def plain_slope(
    thrust: FloatArray, acceleration: FloatArray, stretch: IntArray, lags: int
) -> Slope:
    """Least-squares slope with a common constant, eq. (4) of Potapov and Galyaev."""
    design = np.column_stack([thrust, np.ones_like(thrust)])
    found = least_squares(design, acceleration, stretch, lags)
    return Slope(float(found.coefficients[0]), float(found.std[0]))


def reliability(thrust: FloatArray, thrust_noise: float) -> float:
    """Share of the thrust's variance that is signal, not noise; not below 0.05."""
    return float(max(1.0 - thrust_noise**2 / max(float(np.var(thrust)), 1e-300), 0.05))


def deming_slope(
    thrust: FloatArray, acceleration: FloatArray, thrust_noise: float, acceleration_noise: float
) -> float:
    r"""Slope of least orthogonal distance for known noise of both variables.

    With ratio k = s_a^2 / s_tau^2 and central moments S:
    (S_aa - k S_tt + sqrt((S_aa - k S_tt)^2 + 4 k S_ta^2)) / (2 S_ta).

    >>> x = np.array([0.0, 1.0, 2.0, 3.0])
    >>> round(deming_slope(x, 2 * x + 1, 0.1, 0.1), 6)
    2.0
    """
    covariance = np.cov(thrust, acceleration)
    if thrust_noise <= 0.0:
        return float(covariance[0, 1] / covariance[0, 0])
    if acceleration_noise <= 0.0:
        return float(covariance[1, 1] / covariance[0, 1])
    ratio = (acceleration_noise / thrust_noise) ** 2
    if covariance[0, 1] == 0.0:
        return 0.0
    difference = covariance[1, 1] - ratio * covariance[0, 0]
    root = np.sqrt(difference**2 + 4 * ratio * covariance[0, 1] ** 2)
    if difference < 0:
        # the same root without the loss of digits
        return float(2 * ratio * covariance[0, 1] / (root - difference))
    return float((difference + root) / (2 * covariance[0, 1]))


def deming_bootstrap(
    thrust: FloatArray,
    acceleration: FloatArray,
    stretch: IntArray,
    block: int,
    noise: tuple[float, float],
    *,
    draws: int = BOOTSTRAP_DRAWS,
    seed: int = 0,
) -> Slope:
    """Deming slope with the standard error of a moving-block bootstrap.

    Parameters
    ----------
    thrust, acceleration : ndarray, shape (m,)
        Samples.
    stretch : ndarray of int, shape (m,)
        Stretch of each sample; no block spans two.
    block : int
        Samples in a block.
    noise : tuple of 2 floats
        Of the thrust [N] and of the acceleration [m/s^2].
    draws, seed : int
        Of the bootstrap.
    """
    generator = np.random.default_rng(seed)
    begins = np.concatenate(
        [
            np.flatnonzero(stretch == label)[: max(int(np.sum(stretch == label)) - block + 1, 1)]
            for label in np.unique(stretch)
        ]
    )
    wanted = max(round(thrust.size / block), 2)
    slopes = []
    for _ in range(draws):
        chosen = generator.choice(begins, wanted)
        index = (chosen[:, None] + np.arange(block)).ravel()
        index = index[index < thrust.size]
        # a draw of blocks at rest alone has no slope
        if np.ptp(thrust[index]) > 0.0 and np.ptp(acceleration[index]) > 0.0:
            slopes.append(deming_slope(thrust[index], acceleration[index], *noise))
    spread = (np.quantile(slopes, 0.975) - np.quantile(slopes, 0.025)) / (2 * _NORMAL_95)
    return Slope(deming_slope(thrust, acceleration, *noise), float(spread))
