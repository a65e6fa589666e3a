r"""Slope of acceleration against thrust: plain, with noise in both, and with further terms.

All of them fit du/dt = tau / M + ... and give M = 1 / slope; the samples overlap (a smoother made
them), so no interval counts them as independent.

- Least squares with the covariance of Newey and West (1987) over the lags of the smoother, within
  each stretch (statsmodels, ``hac-panel``). Its weights fall with the lag, and a short stretch has
  few lags: where stretches are short, the covariance is that of leaving out one at a time.
- The same slope over the reliability of the thrust, 1 - s_tau^2 / var(tau): noise in the regressor
  pulls a slope towards zero (Fuller 1987, section 1.1).
- Orthogonal distance with the known ratio of the noise variances (Deming 1943), its interval from a
  bootstrap of blocks longer than the smoother (Kuensch 1989), or where stretches are short from
  leaving out one at a time as well.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import jackknife_covariance
from pipeline.records.intervals import NORMAL_95, student_95
from pipeline.types import FloatArray, IntArray

BOOTSTRAP_DRAWS = 400
#: Stretches whose median is shorter than so many times the lags are too short for Newey and West:
#: at ten times its 95 % hold the truth 86 times of 100, beyond twenty times about 90.
LONG_STRETCH = 20
#: With so many stretches the scatter between them is known; Student's t says how badly.
FEWEST_STRETCHES = 2


@dataclass(frozen=True)
class Slope:
    """A slope [1/kg] with its standard error.

    `factor` is the half-width of its 95 % interval in standard errors.
    """

    value: float
    std: float
    factor: float = NORMAL_95
    by_stretch: bool = False
    """Whether the standard error is that of whole stretches."""


@dataclass(frozen=True)
class Regression:
    """Coefficients (k,) with standard errors (k,), in the order of the design's columns.

    `factor` and `by_stretch` as in `Slope`.
    """

    coefficients: FloatArray
    std: FloatArray
    factor: float = NORMAL_95
    by_stretch: bool = False

    def slope(self) -> Slope:
        """Return the coefficient of the first column."""
        return Slope(float(self.coefficients[0]), float(self.std[0]), self.factor, self.by_stretch)


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
    _, label, lengths = np.unique(stretch, return_inverse=True, return_counts=True)
    model = OLS(response, scaled)
    if _short(lengths, lags):
        plain = model.fit()
        covariance = jackknife_covariance(scaled, np.asarray(plain.resid), label)
        if covariance is not None:
            std = np.sqrt(np.diag(covariance)) / scale
            factor = student_95(lengths.size - 1)
            return Regression(np.asarray(plain.params) / scale, std, factor, by_stretch=True)
    found = model.fit(
        cov_type="hac-panel",
        cov_kwds={
            "groups": label,
            "maxlags": min(lags, int(lengths.max()) - 1),
            "use_correction": "hac",
        },
    )
    return Regression(np.asarray(found.params) / scale, np.asarray(found.bse) / scale)


def _short(lengths: IntArray, lags: int) -> bool:
    """Whether stretches of these lengths are to be left out one at a time."""
    return lengths.size >= FEWEST_STRETCHES and bool(np.median(lengths) < LONG_STRETCH * lags)


def plain_slope(
    thrust: FloatArray, acceleration: FloatArray, stretch: IntArray, lags: int
) -> Slope:
    """Least-squares slope with a common constant, eq. (4) of Potapov and Galyaev."""
    design = np.column_stack([thrust, np.ones_like(thrust)])
    return least_squares(design, acceleration, stretch, lags).slope()


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
    """Deming slope with its standard error: jackknife over short stretches, bootstrap of long ones.

    Parameters as `deming_bootstrap` and `least_squares` take them.
    """
    labels, lengths = np.unique(stretch, return_counts=True)
    others = [stretch != label for label in labels]
    # what is left must have a slope of its own
    if _short(lengths, lags) and all(
        np.ptp(thrust[one]) > 0.0 and np.ptp(acceleration[one]) > 0.0 for one in others
    ):
        value = deming_slope(thrust, acceleration, *noise)
        left = np.array([deming_slope(thrust[one], acceleration[one], *noise) for one in others])
        variance = (labels.size - 1) / labels.size * float(np.sum((left - value) ** 2))
        return Slope(value, variance**0.5, student_95(labels.size - 1), by_stretch=True)
    return deming_bootstrap(thrust, acceleration, stretch, 2 * lags, noise)


def deming_bootstrap(
    thrust: FloatArray,
    acceleration: FloatArray,
    stretch: IntArray,
    block: int,
    noise: tuple[float, float],
) -> Slope:
    """Deming slope with the standard error of a moving-block bootstrap.

    Parameters
    ----------
    thrust, acceleration : ndarray, shape (m,)
        Samples.
    stretch : ndarray of int, shape (m,)
        Stretch of each sample, ascending; no block spans two.
    block : int
        Samples in a block; a shorter stretch is a block as it is.
    noise : tuple of 2 floats
        Of the thrust [N] and of the acceleration [m/s^2].
    """
    generator = np.random.default_rng(0)
    blocks, share = stretch_blocks(stretch, block)
    wanted = max(round(thrust.size / float(share @ [part.stop - part.start for part in blocks])), 2)
    samples = np.arange(thrust.size)
    slopes = []
    for _ in range(BOOTSTRAP_DRAWS):
        chosen = generator.choice(len(blocks), wanted, p=share)
        index = np.concatenate([samples[blocks[one]] for one in chosen])
        # a draw of blocks at rest alone has no slope
        if np.ptp(thrust[index]) > 0.0 and np.ptp(acceleration[index]) > 0.0:
            slopes.append(deming_slope(thrust[index], acceleration[index], *noise))
    spread = (np.quantile(slopes, 0.975) - np.quantile(slopes, 0.025)) / (2 * NORMAL_95)
    return Slope(deming_slope(thrust, acceleration, *noise), float(spread))


def stretch_blocks(stretch: IntArray, block: int) -> tuple[list[slice], FloatArray]:
    """Every block that may be drawn, and the probability to draw it.

    The probabilities are such that each stretch is drawn in proportion to its samples: a stretch
    shorter than a block is one block, a longer one has a block at each sample that leaves room.

    Parameters
    ----------
    stretch : ndarray of int, shape (m,)
        Stretch of each sample, ascending.
    block : int
        Samples in a block.

    Examples
    --------
    >>> blocks, share = stretch_blocks(np.array([0, 0, 0, 1]), 2)
    >>> [(one.start, one.stop) for one in blocks], share.round(3).tolist()
    ([(0, 2), (1, 3), (3, 4)], [0.3, 0.3, 0.4])
    """
    _, firsts, lengths = np.unique(stretch, return_index=True, return_counts=True)
    blocks: list[slice] = []
    weights: list[float] = []
    for first, length in zip(firsts.tolist(), lengths.tolist(), strict=True):
        size = min(block, length)
        starts = range(first, first + length - size + 1)
        blocks += [slice(start, start + size) for start in starts]
        weights += [length / (size * len(starts))] * len(starts)
    return blocks, np.array(weights) / sum(weights)
