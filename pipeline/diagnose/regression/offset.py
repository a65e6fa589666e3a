"""What the learned response is off by in all sound runs alike.

The file's motion, begun from smoothed and noisy readings, is biased: they answer a force later and
less than the vehicle does, and the acceleration that a heavier vehicle would resist has their
noise. So is what a ridge learned from few runs. Sound runs that took no part then all seem to have
the same change, and so does any other. What they share is no change. It is taken off, channel by
channel, with the error that it is known to. In which directions, and how wide, is chosen one after
the other, as long as each sound run is predicted from the others clearly better by it; where they
share nothing, nothing is taken off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.told import Told
from pipeline.types import FloatArray

#: Standard deviations that are tried, in units of the directions, and directions of a channel.
_WIDTHS, _MOST = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), 6


@dataclass(frozen=True)
class Offset:
    """Mean (c, d) and covariance (c, d, d) of what a channel is off by along the directions.

    `share` (c,) of the information of a run was trusted to tell it, and is of any other run;
    `variance` (c, d) is what the directions were before any run was seen.
    """

    share: FloatArray
    variance: FloatArray
    mean: FloatArray
    covariance: FloatArray

    def removed(self, told: Told, runs: int) -> Told:
        """Take the offset off what a run says.

        Parameters
        ----------
        told : Told
            What the run says.
        runs : int
            Runs that are weighed together. They share the error of the offset, and each counts it
            as so many times larger, so that together they are told no better than it is known.
        """
        tempered = told.tempered(self.share)
        information, score = tempered.by_channel.copy(), tempered.score_by_channel.copy()
        for c, own in enumerate(tempered.by_channel):
            spread = runs * self.covariance[c]
            if not spread.any():
                continue
            left = score[c] - own @ self.mean[c]
            # (I^-1 + C)^-1 = (1 + I C)^-1 I, whatever the rank of either
            both = np.linalg.solve(np.eye(len(own)) + own @ spread, np.column_stack([own, left]))
            information[c] = (both[:, :-1] + both[:, :-1].T) / 2.0
            score[c] = both[:, -1]
        return Told(information, score, told.thrust)


def offset_of(
    sound: Sequence[Told], share: FloatArray, most: FloatArray | float = np.inf
) -> Offset:
    """Estimate what sound runs, each predicted from the others, are off by alike.

    Parameters
    ----------
    sound : sequence of Told
        Of each sound run.
    share : ndarray, shape (c,)
        Share of the information of each channel that is trusted.
    most : ndarray, shape (d,), optional
        Standard deviation beyond which an offset of a direction is not believed.
    """
    variance = np.zeros_like(sound[0].score_by_channel)
    for c in range(len(variance)):
        own = [one.of_channel(c) for one in sound]
        for _ in range(_MOST):
            removed = _removed(own, share[c : c + 1], variance[c : c + 1])
            found = _plainest(removed, np.sqrt(np.maximum(np.square(most) - variance[c], 0.0)))
            if found is None:
                break
            # one that was chosen before was not wide enough
            variance[c, found[0]] += found[1]
    return _told_by(sound, share, variance)


def without_offset(
    sound: Sequence[Told], share: FloatArray, most: FloatArray | float = np.inf
) -> list[Told]:
    """Take off each sound run what the others are off by alike, and nothing that it chose."""
    others = (_others(sound, k) for k in range(len(sound)))
    return [
        offset_of(rest, share, most).removed(one, 1)
        for one, rest in zip(sound, others, strict=True)
    ]


def _removed(sound: Sequence[Told], share: FloatArray, variance: FloatArray) -> list[Told]:
    return [
        _told_by(_others(sound, k), share, variance).removed(one, 1) for k, one in enumerate(sound)
    ]


def _others(sound: Sequence[Told], left_out: int) -> list[Told]:
    return [*sound[:left_out], *sound[left_out + 1 :]]


def _told_by(sound: Sequence[Told], share: FloatArray, variance: FloatArray) -> Offset:
    """Estimate an offset from runs, with its variances (c, d) before they were seen."""
    tempered = [one.tempered(share) for one in sound]
    information = np.sum([one.by_channel for one in tempered], axis=0)
    score = np.sum([one.score_by_channel for one in tempered], axis=0)
    mean, covariance = np.zeros_like(score), np.zeros_like(information)
    for c, wide in enumerate(variance > 0.0):
        own = np.ix_(wide, wide)
        spread = np.linalg.inv(information[c][own] + np.diag(1.0 / variance[c, wide]))
        mean[c, wide], covariance[c][own] = spread @ score[c, wide], spread
    return Offset(share, variance, mean, covariance)


def _plainest(sound: Sequence[Told], most: FloatArray) -> tuple[int, float] | None:
    """Choose the direction in which runs of one channel are off alike, and its variance.

    Each run is predicted from the others, with an offset and without; what is gained over all runs
    must be more than the choice among all directions is worth.
    """
    own = np.array([np.diag(one.information) for one in sound])
    score = np.array([one.score for one in sound])
    gain = np.zeros((len(_WIDTHS), score.shape[1]))
    for row, width in enumerate(_WIDTHS):
        spread = 1.0 / (own.sum(axis=0) - own + 1.0 / width**2)
        mean = spread * (score.sum(axis=0) - score)
        # log N(score / own; mean, 1 / own + spread) over log N(score / own; 0, 1 / own)
        grown = 1.0 + own * spread
        each = (spread * score**2 + 2.0 * mean * score - own * mean**2) / grown - np.log(grown)
        gain[row] = np.where(width <= most, 0.5 * each.sum(axis=0), 0.0)
    best, k = divmod(int(np.argmax(gain)), gain.shape[1])
    return (k, _WIDTHS[best] ** 2) if gain[best, k] > np.log(score.shape[1]) else None
