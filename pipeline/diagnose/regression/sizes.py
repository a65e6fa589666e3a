"""How large a change is, with its interval, where it may lie."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.directions import OF_ALL_THRUSTERS


def sizes(
    change: Change, directions: Sequence[Coordinate], inexact: float
) -> dict[int, tuple[float, float, float]]:
    """Median and 95 % interval of each size, in the parameter's unit, where it may lie.

    What a signature is off by is in the interval; of two changes each has the error of both. It is
    that of highest density: it reaches the end of what is possible where the most probable size
    lies there. A thruster that gives g, where all give a share s of what they give in the sound
    runs, stands there as a change of s (g - 1).

    Parameters
    ----------
    change : Change
        With its sizes in the units of the directions.
    directions : sequence of Coordinate
        All of them.
    inexact : float
        Share of what a change does that its signature may be off by.
    """
    # more than a second of imports, of which other diagnoses have no need
    from scipy.stats import norm, truncnorm

    found = {}
    effects = {(directions[k].effect.id, directions[k].target) for k in change.which}
    share, error = change.thrust
    for k, seen, own in zip(change.which, change.mean, change.std, strict=True):
        one = directions[k]
        mean, std = seen, np.hypot(own, len(effects) * inexact * seen)
        if one.effect.id not in OF_ALL_THRUSTERS and (one.effect.of_thrusters or one.target):
            mean, std = seen / share, np.hypot(std, seen * error / share) / share
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
