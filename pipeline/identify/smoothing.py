r"""Smoothing and derivatives, each with its bandwidth and the noise that it leaves.

Both smoothers are linear filters of fixed length: with coefficients d_j of the derivative, in 1/s,
white noise of standard deviation s leaves :math:`s \sqrt{\sum d_j^2}`, and the bandwidth is the
frequency at which |D(f)| / (2 pi f) has fallen by 3 dB. The moving average is that of Potapov and
Galyaev; the local polynomial (Savitzky and Golay 1964, Anal. Chem. 36(8), 1627-1639) leaves less
noise at equal bandwidth and bends the peaks less.
"""

from dataclasses import dataclass
from itertools import accumulate
from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.types import BoolArray, FloatArray

Method = Literal["moving_average", "local_polynomial"]
POLYNOMIAL_ORDER = 3


@dataclass(frozen=True)
class Smoother:
    """A smoother of one length: coefficients in the order of time, oldest sample first.

    `value` and `derivative` (n,) with n odd; `derivative` in 1/s.
    """

    method: Method
    period_s: float
    value: FloatArray
    derivative: FloatArray

    @property
    def length_s(self) -> float:
        """Time between the first and the last sample that one output is made of [s]."""
        return (self.derivative.size - 1) * self.period_s

    @property
    def derivative_noise_gain(self) -> float:
        """Standard deviation of the derivative over that of a sample [1/s]."""
        return float(np.sqrt(np.sum(self.derivative**2)))

    @property
    def derivative_bandwidth_hz(self) -> float:
        """-3 dB of the derivative against an ideal one [Hz]."""
        return _three_decibels(self.derivative, self.period_s)


@dataclass(frozen=True)
class Smoothed:
    """A smoothed channel; arrays (m,) or (m, k).

    `valid` (m,) is False within half a filter length of an end or of a sample that is not finite:
    nothing is made up there.
    """

    value: FloatArray
    derivative: FloatArray
    valid: BoolArray


def moving_average(samples: int, period_s: float) -> Smoother:
    """Mean of `samples` (odd) values, and the central difference of neighbouring means.

    >>> [round(float(c), 6) for c in moving_average(3, 0.5).derivative]
    [-0.333333, -0.333333, 0.0, 0.333333, 0.333333]
    """
    _check(samples, period_s)
    value = np.full(samples, 1.0 / samples)
    difference = np.array([-0.5, 0.0, 0.5]) / period_s
    return Smoother("moving_average", period_s, value, np.convolve(value, difference))


def local_polynomial(samples: int, period_s: float) -> Smoother:
    """Value and slope in the middle of the least-squares cubic through `samples` (odd) values.

    >>> (35 * local_polynomial(5, 0.1).value).round(6).tolist()
    [-3.0, 12.0, 17.0, 12.0, -3.0]
    """
    from scipy.signal import savgol_coeffs

    _check(samples, period_s)
    value = savgol_coeffs(samples, POLYNOMIAL_ORDER, use="dot")
    derivative = savgol_coeffs(samples, POLYNOMIAL_ORDER, deriv=1, delta=period_s, use="dot")
    return Smoother("local_polynomial", period_s, np.asarray(value), np.asarray(derivative))


def leaky_sum(values: FloatArray, keep: float) -> FloatArray:
    """Sum y_k = x_k + keep y_(k-1) of values (m,), which forgets; `scipy.signal` takes a second.

    >>> leaky_sum(np.array([1.0, 0.0, 1.0]), 0.5).tolist()
    [1.0, 0.5, 1.25]
    """
    return np.array(list(accumulate(values.tolist(), lambda before, x: keep * before + x)))


def smoother_of_bandwidth(method: Method, bandwidth_hz: float, period_s: float) -> Smoother:
    """Return the longest smoother whose derivative keeps a bandwidth, its -3 dB [Hz], at least.

    Raises
    ------
    CannotComputeError
        If even the shortest smoother has less: the samples, every `period_s`, are too far apart.
    """
    make = moving_average if method == "moving_average" else local_polynomial
    shortest = 1 if method == "moving_average" else POLYNOMIAL_ORDER + 2
    best = make(shortest, period_s)
    if best.derivative_bandwidth_hz < bandwidth_hz:
        raise CannotComputeError(
            f"samples every {period_s:g} s carry a derivative up to "
            f"{best.derivative_bandwidth_hz:.2g} Hz, and {bandwidth_hz:g} Hz is wanted"
        )
    samples = shortest
    while True:
        longer = make(samples + 2, period_s)
        if longer.derivative_bandwidth_hz < bandwidth_hz:
            return best
        best, samples = longer, samples + 2


def smooth(values: FloatArray, smoother: Smoother) -> Smoothed:
    """Smooth a regularly sampled channel (m,) or (m, k), NaN where there is no sample."""
    finite = np.asarray(np.isfinite(values).reshape(len(values), -1).all(axis=1), bool)
    known = np.where(finite if values.ndim == 1 else finite[:, None], values, 0.0)
    half = max(smoother.value.size, smoother.derivative.size) // 2
    whole = np.asarray(_correlate(finite.astype(float), np.ones(2 * half + 1)) > 2 * half + 0.5)
    whole[:half] = whole[whole.size - half :] = False
    return Smoothed(
        _correlate(known, smoother.value), _correlate(known, smoother.derivative), whole
    )


def white_noise_std(values: FloatArray) -> float:
    """Noise of one sample from third differences, robust against outliers and slow motion.

    A white noise of standard deviation s has third differences of s sqrt(20); motion that is slow
    against the sampling has hardly any. Returns 0 for fewer than four samples.

    >>> float(white_noise_std(np.arange(50.0) ** 2))
    0.0
    """
    third = np.diff(values, 3, axis=0)
    third = third[np.isfinite(third)]
    return float(np.median(np.abs(third)) / 0.6745 / np.sqrt(20.0)) if third.size else 0.0


def _check(samples: int, period_s: float) -> None:
    if samples < 1 or samples % 2 == 0 or period_s <= 0.0:
        raise CannotComputeError(
            f"a smoother over {samples} samples of {period_s:g} s: an odd number of samples and a "
            "period above zero are expected"
        )


def _correlate(values: FloatArray, coefficients: FloatArray) -> FloatArray:
    from scipy.ndimage import correlate1d

    return np.asarray(correlate1d(values, coefficients, axis=0, mode="constant"))


def _three_decibels(derivative: FloatArray, period_s: float) -> float:
    """First frequency at which a slope has lost 3 dB; the Nyquist frequency if none."""
    place = (np.arange(derivative.size) - (derivative.size - 1) / 2) * period_s
    nyquist = 0.5 / period_s
    grid = np.linspace(nyquist / 2000, nyquist, 2000)
    turn = 2 * np.pi * grid
    excess = np.abs(np.exp(1j * np.outer(turn, place)) @ derivative) / turn - np.sqrt(0.5)
    if (excess >= 0.0).all():
        return nyquist
    first = max(int(np.argmax(excess < 0.0)), 1)
    return float(np.interp(0.0, -excess[first - 1 : first + 1], grid[first - 1 : first + 1]))
