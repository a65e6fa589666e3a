"""A force that comes and goes, which no change of the library is: told from what a run leaves.

What a run leaves after a change is white once it was filtered, if the change is all there is. A
line that catches and lets go, or a current in gusts, leaves means of blocks that scatter by more
than readings within them do. The ratio of both (one-way analysis of variance) does not depend on
how noisy a run is. How large it is without such a force, and how much that differs from run to run
in all channels alike, as manoeuvres do, the sound runs say, each left out in turn. They also say
how often a single channel stands out: that which a manoeuvre moves, if no other run moves it.
What motion and commands explain of the rest is the second sign: waves are too fast for blocks, and
a vehicle that meets them moves with them. Where the file stands in for sound runs, how strong the
means of blocks are is the third: what a healthy vehicle's noise is it states, and from one measured
run to the next nobody knows.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.special import logsumexp

from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.grid import CHANNELS
from pipeline.diagnose.regression.known import Learned, ToldRun
from pipeline.diagnose.regression.ordinary import INEXACT
from pipeline.diagnose.regression.weigh import with_disturbance
from pipeline.records.diagnosis import UNKNOWN
from pipeline.types import FloatArray

#: Beside changes less probable than this no other force is looked for.
_HARDLY = 0.01

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
#: Shares of channels that stand out without such a force; the smaller, the more plausible.
_STAND_OUT = np.array([0.001, 0.003, 0.01, 0.03, 0.1, 0.3])


def beside_disturbance(
    learned: Learned, runs: Sequence[ToldRun], ranking: Sequence[Change]
) -> tuple[Change, ...]:
    """Weigh that a force comes and goes beside each change that is plausible, or alone.

    It is looked for in what is left when a run differs by what is ordinary, too.

    Parameters
    ----------
    learned : Learned
        What is known of the vehicle on one grid.
    runs : sequence of ToldRun
        The runs that are asked.
    ranking : sequence of Change
        All hypotheses.
    """
    usual = [_left_of(learned, one) for one in learned.usual]
    size = np.exp(np.nanmean([np.log(one.between) for one in usual], axis=0))
    odds: dict[str, float] = {}
    for one in ranking:
        if one.probability < _HARDLY or one.name == UNKNOWN:
            continue
        changed = np.zeros(learned.ordinary.width.size)
        changed[list(one.which)] = one.mean
        asked = [
            _left_of(learned, run, changed if k in one.runs else None) for k, run in enumerate(runs)
        ]
        signs = [
            log_odds(*([left.over(left.within) for left in own] for own in (usual, asked))),
            log_odds(*([left.with_motion for left in own] for own in (usual, asked))),
        ]
        if learned.by_file:
            signs.append(log_odds(*([left.over(size) for left in own] for own in (usual, asked))))
        odds[one.name] = float(np.logaddexp.reduce(signs) - np.log(len(signs)))
    return with_disturbance(ranking, odds)


@dataclass(frozen=True)
class _Left:
    """What a run leaves, in each channel (c,): see `block_powers` and `Response.explained`.

    `did` is what the change did between blocks, `with_motion` of the linear velocities alone.
    """

    between: FloatArray
    within: FloatArray
    did: FloatArray
    with_motion: FloatArray

    def over(self, size: FloatArray) -> FloatArray:
        """Variance between blocks over what it should be, and what a change is off by."""
        return self.between / (size + INEXACT**2 * self.did)


def _left_of(learned: Learned, run: ToldRun, change: FloatArray | None = None) -> _Left:
    response, size = learned.response, learned.size(run, change)
    _, first, left = response.after(run.run, size, left_out=run.left_out)
    did, _ = block_powers(response.filtered(first - left), response.period_s)
    between, within = block_powers(response.filtered(left), response.period_s)
    of_left, rest, of_change = response.explained(run.run, size, left_out=run.left_out)
    # how motion turns a vehicle is known too poorly to say that something else does
    linear = [c for c, name in enumerate(response.channels) if name in CHANNELS[:3]]
    with_motion = of_left / (rest + INEXACT**2 * of_change)
    return _Left(between, within, did, with_motion[linear])


def block_powers(left: FloatArray, period_s: float) -> tuple[FloatArray, FloatArray]:
    """Variance between blocks, and within them, (c,) each, of filtered remainders (k, c).

    Expected to be the same for white noise. Not a number for fewer than three blocks.
    """
    length = max(round(_BLOCK_S / period_s), 2)
    count = len(left) // length
    if count < 3:
        return np.full(left.shape[1], np.nan), np.ones(left.shape[1])
    blocks = left[: count * length].reshape(count, length, -1)
    within = np.maximum(blocks.var(axis=1, ddof=1).mean(axis=0), 1e-24)
    return np.asarray(length * blocks.mean(axis=1).var(axis=0, ddof=1)), within


def log_odds(sound: Sequence[FloatArray], asked: Sequence[FloatArray]) -> float:
    """Log evidence of a force that comes and goes over that of none.

    Parameters
    ----------
    sound, asked : sequence of ndarray, shape (c,)
        Ratios of blocks of each run; variance between over that within, see `block_powers`.
    """
    tried = [_both(sound, asked, freedom) for freedom in _FREEDOM]
    ordinary, forced = np.concatenate(tried, axis=1)
    return float(logsumexp(forced) - logsumexp(ordinary))


def _both(
    sound: Sequence[FloatArray], asked: Sequence[FloatArray], freedom: tuple[float, float]
) -> FloatArray:
    """Log evidence (2, n) of all runs without and with a force, for each mean, spread and share."""
    means, spreads = (one.ravel() for one in np.meshgrid(_MEANS, _SPREADS))
    levels = stats.norm.logpdf(_LEVELS, means[:, None], spreads[:, None])
    prior = -0.5 * (means / _MEAN_WIDTH) ** 2 - spreads / _SPREAD_SCALE
    ordinary = prior - 0.5 * np.log(_STAND_OUT)[:, None]
    known = [_channels(one, freedom) for one in sound]
    ordinary += sum(_run(levels, *one, _STAND_OUT) for one in known)
    forced = ordinary.copy()
    for one in asked:
        own = _channels(one, freedom)
        ordinary += _run(levels, *own, _STAND_OUT)
        forced += _run(levels, *own, _SHOWN + (1.0 - _SHOWN) * _STAND_OUT)
    return np.stack([ordinary.ravel(), forced.ravel()])


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
