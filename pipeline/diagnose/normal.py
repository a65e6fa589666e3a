"""How much of a normal distribution lies between two bounds."""

import numpy as np
from scipy.special import log_ndtr


def log_inside(mean: float, std: float, low: float, high: float) -> float:
    """Log of the probability that a normal variable lies between two bounds.

    >>> round(log_inside(0.0, 1.0, -1.959964, 1.959964), 4)
    -0.0513
    """
    std = max(std, 1e-12)
    below, above = (low - mean) / std, (high - mean) / std
    if below > 0:
        below, above = -above, -below
    # Phi(above) - Phi(below), both on the side where the logarithms are accurate
    first, second = float(log_ndtr(above)), float(log_ndtr(below))
    return first + float(np.log1p(-np.exp(min(second - first, -1e-15))))
