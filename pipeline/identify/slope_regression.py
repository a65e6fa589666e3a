"""Slope of acceleration against thrust: plain, with noise in both, and with further terms.

All of them fit du/dt = tau / M + ... by least squares and give M = 1 / slope; the samples overlap
(a smoother made them), so no interval counts them as independent: it is that of leaving out one
block of them at a time, with Student's t for the number of blocks (`blocks_of`). Noise in the
thrust pulls a slope towards zero: over the reliability of the thrust, 1 - s_tau^2 / var(tau), it is
free of that (Fuller 1987, section 1.1).
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
