"""A force that comes and goes, which no change of the library is: told from what a run leaves.

What a run leaves after a change is white once it was filtered, if the change is all there is. A
line that catches and lets go, or a current in gusts, leaves means of blocks that scatter by more
than readings within them do. The ratio of both (one-way analysis of variance) does not depend on
how noisy a run is. How large it is without such a force, and how much that differs from run to run
in all channels alike, as manoeuvres do, the sound runs say, each left out in turn. They also say
how often a single channel stands out: that which a manoeuvre moves, if no other run moves it.
"""

from collections.abc import Sequence

import numpy as np
from scipy import stats
from scipy.special import logsumexp

from pipeline.types import FloatArray

#: A block. [s]
_BLOCK_S = 4.0
#: Share of a change by which its signature is off. Runs more quiet than this are alike.
_INEXACT, _QUIET = 0.15, 0.3
#: Degrees of freedom of the ratio, fewer where blocks are less independent and noise less even.
_FREEDOM = ((5.0, 20.0), (3.0, 6.0))
_OF_POWER = ((20.0, 20.0), (5.0, 10.0))
#: Of the logarithm of a run's ratio over that of white noise: values that are tried.
_LEVELS = np.linspace(-3.0, 4.5, 61)
#: Its mean over runs and its standard deviation between them, before any was seen.
_MEANS, _MEAN_WIDTH = np.linspace(-1.0, 1.5, 11), 0.4
_SPREADS, _SPREAD_SCALE = np.array([0.1, 0.3, 0.6, 1.0, 1.5, 2.0]), 0.5
#: A force adds so many times the ordinary ratio, each as plausible; a share of the
#: channels shows it.
_FORCE, _SHOWN = np.log(np.geomspace(2.0, 300.0, 25)), np.array([0.05, 0.2, 0.5, 0.9])
#: Shares of channels that stand out without such a force; the smaller, the more plausible.
_STAND_OUT = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.3])


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


def powers(
    left: Sequence[FloatArray], explained: Sequence[FloatArray] | None, most: FloatArray
) -> list[FloatArray]:
    """Power (c,) of filtered remainders (k, c) of each run over the most of sound ones (c,).

    A change is known to a share: so much of what it `explained` (k, c) is no other force. How far
    quiet runs are below says nothing.
    """
    found = []
    for k, own in enumerate(left):
        more = 0.0 if explained is None else _INEXACT**2 * np.mean(np.square(explained[k]), axis=0)
        ratio = np.mean(np.square(own), axis=0) / (most + more)
        found.append(np.maximum(ratio, _QUIET))
    return found


def log_odds(
    sound: Sequence[FloatArray], asked: Sequence[FloatArray], *, of_power: bool = False
) -> float:
    """Log evidence of a force that comes and goes over that of none.

    Parameters
    ----------
    sound, asked : sequence of ndarray, shape (c,)
        Ratios of blocks of each run, or powers; see `block_ratios` and `powers`.
    """
    tried = [_both(sound, asked, freedom) for freedom in (_OF_POWER if of_power else _FREEDOM)]
    ordinary, forced = (logsumexp(one) for one in zip(*tried, strict=True))
    return float(forced - ordinary)


def _both(
    sound: Sequence[FloatArray], asked: Sequence[FloatArray], freedom: tuple[float, float]
) -> tuple[float, float]:
    """Log evidence of all runs without and with a force, over means, spreads and shares."""
    means, spreads = (one.ravel() for one in np.meshgrid(_MEANS, _SPREADS))
    levels = stats.norm.logpdf(_LEVELS, means[:, None], spreads[:, None])
    prior = -0.5 * (means / _MEAN_WIDTH) ** 2 - spreads / _SPREAD_SCALE
    known = prior - 0.5 * np.log(_STAND_OUT)[:, None]
    known += sum(_run(levels, *_channels(one, freedom), _STAND_OUT) for one in sound)
    ordinary, forced = known.copy(), np.repeat(known[None], _SHOWN.size, axis=0)
    for one in asked:
        own = _channels(one, freedom)
        ordinary += _run(levels, *own, _STAND_OUT)
        for k, shown in enumerate(_SHOWN):
            forced[k] += _run(levels, *own, shown + (1.0 - shown) * _STAND_OUT)
    return float(logsumexp(ordinary)), float(logsumexp(forced) - np.log(_SHOWN.size))


def _channels(ratios: FloatArray, freedom: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Log densities (c, levels) of the channels of a run, as they are and where one stands out."""
    more = logsumexp(
        _log_density(ratios, _LEVELS[:, None] + _FORCE, freedom), axis=2, b=1.0 / _FORCE.size
    )
    return _log_density(ratios, _LEVELS, freedom), more


def _run(levels: FloatArray, plain: FloatArray, more: FloatArray, share: FloatArray) -> FloatArray:
    """Log density (s, n) of a run in which channels stand out by these shares (s,), each alone."""
    each = np.logaddexp(
        np.log1p(-share)[:, None, None] + plain, np.log(share)[:, None, None] + more
    )
    return np.asarray(logsumexp(levels + each.sum(axis=1)[:, None], axis=2))


def _log_density(
    ratios: FloatArray, levels: FloatArray, freedom: tuple[float, float]
) -> FloatArray:
    """Log density (c, ...) of the ratios that are known (c,) at levels (...)."""
    own = ratios[np.isfinite(ratios)].reshape(-1, *([1] * levels.ndim))
    return np.asarray(stats.f.logpdf(own * np.exp(-levels), *freedom) - levels)
