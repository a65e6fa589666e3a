"""Codes at the ends of their drive's range, and beyond a dead zone of their own."""

import numpy as np

from pipeline.types import ArrayLike, BoolArray, FloatArray


def at_limit(code: FloatArray, lowest: ArrayLike, highest: ArrayLike) -> BoolArray:
    """Tell which codes are at an end of their range, within half a code.

    Parameters
    ----------
    code : ndarray
        Commanded codes. [-]
    lowest, highest : array_like, broadcast with `code`
        Ends of the range. A drive that turns one way only idles at its low end: that is no limit.

    >>> at_limit(np.array([127.0, -60.0, 60.0]), -60, 127).tolist()
    [True, True, False]
    >>> at_limit(np.array([0.0, 199.6]), 0, 200).tolist()
    [False, True]
    """
    low, high = np.asarray(lowest, float), np.asarray(highest, float)
    return np.asarray((code >= high - 0.5) | ((low < 0) & (code <= low + 0.5)))


def beyond_dead_zone(code: ArrayLike, lost: ArrayLike, code_max: ArrayLike) -> FloatArray:
    """Codes to send so that `code` takes effect where a thruster loses `lost` at either side of 0.

    Full code still is full code: d + (N_max - d) |N| / N_max, and 0 for 0; not rounded.

    >>> beyond_dead_zone([0.0, 50.0, -100.0], 10.0, 100.0).tolist()
    [0.0, 55.0, -100.0]
    """
    size, lost, largest = np.abs(code), np.asarray(lost, float), np.asarray(code_max, float)
    return np.asarray(np.sign(code) * (lost + size * (1.0 - lost / largest)) + 0.0)
