"""How large a change is, with its interval, where it may lie."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.change import Change

#: Share of what a change does that its signature may be off by. [1]
INEXACT = 0.1


def sizes(
    change: Change, directions: Sequence[Coordinate]
) -> dict[int, tuple[float, float, float]]:
    """Median and 95 % interval of each size, in the parameter's unit, where it may lie.

    What a signature is off by is in the interval. It is that of highest density: it reaches the end
    of what is possible where the most probable size lies there.
    """
    # more than a second of imports, of which other diagnoses have no need
    from scipy.stats import norm, truncnorm

    found = {}
    spread = np.hypot(change.std, INEXACT * change.mean)
    for k, mean, std in zip(change.which, change.mean, spread, strict=True):
        one = directions[k]
        low, high = one.bounds
        held = truncnorm((low - mean) / std, (high - mean) / std, mean, std)
        if not np.isfinite(held.ppf(0.5)):
            held = norm(np.clip(mean, low, high), std)
        ends = [held.ppf(0.5), *_densest(held.cdf, float(np.clip(mean, low, high)), high - low)]
        ends = np.clip(ends, low, high)
        values = one.parameter.neutral + one.unit_size * ends
        found[k] = (float(values[0]), float(values[1]), float(values[2]))
    return found


def _densest(cdf: Callable[[float], float], top: float, length: float) -> tuple[float, float]:
    """Return the ends of what holds 95 % around the most probable size."""

    def beyond(half: float) -> float:
        return float(cdf(top + half) - cdf(top - half)) - 0.95

    half = float(brentq(beyond, 0.0, 2.0 * length))
    return top - half, top + half
