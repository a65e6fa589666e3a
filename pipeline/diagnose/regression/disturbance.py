"""A force that comes and goes, which no change of the library is: told from what a run leaves.

What a run leaves after a change is white once it was filtered, if the change is all there is. A
line that catches and lets go, or a current in gusts, leaves means of blocks that scatter by more
than readings within them do. The ratio of both (one-way analysis of variance) does not depend on
how noisy a run is. How large it is without such a force the sound runs say, each left out in turn.
"""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from pipeline.types import FloatArray

#: A block. [s]
_BLOCK_S = 4.0
#: Degrees of freedom of the ratio of one run, at most: blocks are not independent, nor noise even.
_BETWEEN, _WITHIN = 5.0, 20.0
#: Ratio of sound runs: values that are tried, and the width of its logarithm before any was seen.
_ORDINARY, _ORDINARY_WIDTH = np.geomspace(0.2, 5.0, 33), 0.4
#: A force adds so many times the ordinary ratio, each as plausible; a channel shows it or not.
_FORCE, _SHOWN = np.geomspace(2.0, 100.0, 25), 0.5


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
    total = 0.0
    for of_sound, of_asked in zip(np.transpose(sound), np.transpose(asked), strict=True):
        prior = stats.norm.logpdf(np.log(_ORDINARY), scale=_ORDINARY_WIDTH)
        without = prior + _log_density(of_sound, _ORDINARY).sum(axis=0)
        ordinary = _log_density(of_asked, _ORDINARY)
        forced = np.mean(
            [np.exp(_log_density(of_asked, one * _ORDINARY) - ordinary) for one in _FORCE], axis=0
        )
        weights = np.exp(without + ordinary.sum(axis=0) - np.max(without + ordinary.sum(axis=0)))
        shown = np.prod(1.0 - _SHOWN + _SHOWN * forced, axis=0)
        total += float(np.log(np.sum(weights * shown) / np.sum(weights)))
    return total


def _log_density(ratios: FloatArray, scales: FloatArray) -> FloatArray:
    """Log density (r, s) of ratios (r,) that are so many times (s,) those of white noise."""
    known = np.where(np.isfinite(ratios), ratios, 1.0)[:, None]
    found = stats.f.logpdf(known / scales, _BETWEEN, _WITHIN) - np.log(scales)
    return np.where(np.isfinite(ratios)[:, None], found, 0.0)
