"""When a commanded code counts as at an end of its drive's range."""

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

    Examples
    --------
    >>> at_limit(np.array([127.0, -60.0, 60.0]), -60, 127).tolist()
    [True, True, False]
    >>> at_limit(np.array([0.0, 199.6]), 0, 200).tolist()
    [False, True]
    """
    low, high = np.asarray(lowest, float), np.asarray(highest, float)
    return np.asarray((code >= high - 0.5) | ((low < 0) & (code <= low + 0.5)))
