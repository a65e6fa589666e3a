r"""Slope of acceleration against thrust: plain, with noise in both, and with further terms.

All of them fit du/dt = tau / M + ... and give M = 1 / slope; the samples overlap (a smoother made
them), so no interval counts them as independent: it is that of leaving out one block of them at a
time, with Student's t for the number of blocks (`blocks_of`).

- Least squares (`linear_fit`).
- The same slope over the reliability of the thrust, 1 - s_tau^2 / var(tau): noise in the regressor
  pulls a slope towards zero (Fuller 1987, section 1.1).
- Orthogonal distance with the known ratio of the noise variances (Deming 1943).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import Judgement, LinearFit, fit_linear
from pipeline.records.intervals import NORMAL_95, student_95
from pipeline.types import FloatArray, IntArray

#: Lengths of a block that are tried, in lags of the smoother, until every block can be left out.
#: Longer blocks depend on each other less, and are fewer.
_BLOCK_LAGS = (10, 5, 2, 1)
#: The least that a scatter between blocks is taken from where one stretch is all there is.
_FEWEST_BLOCKS = 4


@dataclass(frozen=True)
class Slope:
    """A slope [1/kg] with its standard error.

    `factor` is the half-width of its 95 % interval in standard errors.
    """

    value: float
    std: float
    factor: float = NORMAL_95


def blocks_of(stretch: IntArray, length: int) -> IntArray:
    """Cut stretches into blocks of about `length` samples, and number them (m,).

    Parameters
    ----------
    stretch : ndarray of int, shape (m,)
        Stretch of each sample, ascending; no block spans two, a short one is a block as it is.
    length : int
        Samples in a block.

    Examples
    --------
    >>> blocks_of(np.array([0, 0, 0, 0, 1]), 2).tolist()
    [0, 0, 1, 1, 2]
    """
    _, sizes = np.unique(stretch, return_counts=True)
    least = _FEWEST_BLOCKS if sizes.size == 1 else 1
    parts, first = [], 0
    for size in sizes.tolist():
        count = min(max(round(size / length), least), size)
        parts.append(first + np.arange(size) * count // size)
        first += count
    return np.concatenate(parts)


def least_squares(
    design: FloatArray, response: FloatArray, stretch: IntArray, lags: int
) -> LinearFit:
    """Ordinary least squares with a covariance that honours autocorrelation within stretches.

    The thrust is the first of the regressors `design` (m, k), the constant is among them. `stretch`
    (m,) labels samples, ascending; nothing correlates across stretches, and up to `lags` samples
    residuals go together.

    Raises
    ------
    CannotComputeError
        With too few samples, or regressors that depend on each other or show in one place alone.
    """
    every = Judgement(np.zeros(response.size), np.zeros(response.size, bool))
    for size in _BLOCK_LAGS:
        block = blocks_of(stretch, size * lags)
        try:
            found = fit_linear(design, response, clusters=block, judged=every)
        except CannotComputeError as error:
            raise CannotComputeError(f"acceleration against thrust: {error}") from None
        if found.clustered:
            return found
    raise CannotComputeError("the thrust, or what acts beside it, varies in a single moment alone")


def slope_of(fit: LinearFit) -> Slope:
    """Return the coefficient of the first regressor."""
    std = float(np.sqrt(fit.covariance[0, 0]))
    return Slope(float(fit.coefficients[0]), std, student_95(fit.degrees_of_freedom))


def plain_slope(
    thrust: FloatArray, acceleration: FloatArray, stretch: IntArray, lags: int
) -> Slope:
    """Least-squares slope with a common constant, eq. (4) of Potapov and Galyaev."""
    design = np.column_stack([thrust, np.ones_like(thrust)])
    return slope_of(least_squares(design, acceleration, stretch, lags))


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


def deming_estimate(
    thrust: FloatArray,
    acceleration: FloatArray,
    stretch: IntArray,
    lags: int,
    noise: tuple[float, float],
) -> Slope:
    """Deming slope with its standard error; `noise` of thrust [N] and acceleration [m/s^2].

    Samples as `least_squares` takes them.

    Raises
    ------
    CannotComputeError
        If the thrust varies in one place alone.
    """
    value = deming_slope(thrust, acceleration, *noise)
    for size in _BLOCK_LAGS:
        block = blocks_of(stretch, size * lags)
        others = [block != number for number in range(int(block[-1]) + 1)]
        # what is left must have a slope of its own
        if all(np.ptp(thrust[one]) > 0.0 and np.ptp(acceleration[one]) > 0.0 for one in others):
            left = np.array(
                [deming_slope(thrust[one], acceleration[one], *noise) for one in others]
            )
            variance = (len(others) - 1) / len(others) * float(np.sum((left - value) ** 2))
            return Slope(value, variance**0.5, student_95(len(others) - 1))
    raise CannotComputeError("the thrust, or what acts beside it, varies in a single moment alone")
