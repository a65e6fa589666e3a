"""A force that comes and goes, which no change of the library is: told from what a run leaves.

What a run leaves after a change is white once it was filtered, if the change is all there is. A
line that catches and lets go, or a current in gusts, leaves means of blocks that scatter by more
than readings within them do. The ratio of both (one-way analysis of variance) does not depend on
how noisy a run is. How large it is without such a force, and how much that differs from run to run
in all channels alike, as manoeuvres do, the sound runs say, each left out in turn.
"""

from collections.abc import Sequence

import numpy as np
from scipy import stats
from scipy.special import logsumexp

from pipeline.types import FloatArray

#: A block. [s]
_BLOCK_S = 4.0
#: Degrees of freedom of the ratio, fewer where blocks are less independent and noise less even.
_FREEDOM = ((5.0, 20.0), (3.0, 6.0))
#: Of the logarithm of a run's ratio over that of white noise: values that are tried.
_LEVELS = np.linspace(-3.0, 4.5, 61)
#: Its mean over runs and its standard deviation between them, before any was seen.
_MEANS, _MEAN_WIDTH = np.linspace(-1.0, 1.5, 11), 0.4
_SPREADS, _SPREAD_SCALE = np.array([0.1, 0.3, 0.6, 1.0, 1.5, 2.0]), 0.5
#: A force adds so many times the ordinary ratio, each as plausible; a channel shows it or not.
_FORCE, _SHOWN = np.log(np.geomspace(2.0, 100.0, 25)), 0.5


def block_ratios(left: FloatArray, period_s: float) -> FloatArray:
    """Variance between blocks over that within (c,) of filtered remainders (k, c).

    Expected to be one for white noise. Not a number for fewer than three blocks.
    """
    length = max(round(_BLOCK_S / period_s), 2)
    count = len(left) // length
    if count < 3:
        return np.full(left.shape[1], np.nan)
    blocks = left[: count * length].reshape(count, length, -1)
    within = blocks.var(axis=1, ddof=1).mean(axis=0)
    return np.asarray(length * blocks.mean(axis=1).var(axis=0, ddof=1) / np.maximum(within, 1e-24))


def log_odds(sound: Sequence[FloatArray], asked: Sequence[FloatArray]) -> float:
    """Log evidence of a force that comes and goes over that of none.

    Parameters
    ----------
    sound, asked : sequence of ndarray, shape (c,)
        Ratios of blocks of each run; see `block_ratios`.
    """
    tried = [_both(sound, asked, freedom) for freedom in _FREEDOM]
    ordinary, forced = np.concatenate(tried, axis=1)
    return float(logsumexp(forced) - logsumexp(ordinary))


def _both(
    sound: Sequence[FloatArray], asked: Sequence[FloatArray], freedom: tuple[float, float]
) -> FloatArray:
    """Log evidence (2, n) of all runs without and with a force, for each mean and spread."""
    means, spreads = (one.ravel() for one in np.meshgrid(_MEANS, _SPREADS))
    levels = stats.norm.logpdf(_LEVELS, means[:, None], spreads[:, None])
    ordinary = -0.5 * (means / _MEAN_WIDTH) ** 2 - spreads / _SPREAD_SCALE
    for one in sound:
        own = _log_density(one, _LEVELS, freedom)
        ordinary += logsumexp(levels + own.sum(axis=0), axis=1)
    forced = ordinary.copy()
    for one in asked:
        without = _log_density(one, _LEVELS, freedom)
        shifted = _log_density(one, _LEVELS[:, None] + _FORCE, freedom)
        more = logsumexp(shifted, axis=2, b=_SHOWN / _FORCE.size)
        either = np.logaddexp(np.log(1.0 - _SHOWN) + without, more)
        ordinary += logsumexp(levels + without.sum(axis=0), axis=1)
        forced += logsumexp(levels + either.sum(axis=0), axis=1)
    return np.stack([ordinary, forced])


def _log_density(
    ratios: FloatArray, levels: FloatArray, freedom: tuple[float, float]
) -> FloatArray:
    """Log density (c, ...) of the ratios that are known (c,) at levels (...)."""
    own = ratios[np.isfinite(ratios)].reshape(-1, *([1] * levels.ndim))
    return np.asarray(stats.f.logpdf(own * np.exp(-levels), *freedom) - levels)
