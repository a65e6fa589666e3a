"""What the learned response is off by in all sound runs alike.

A regression on smoothed and noisy readings is biased: they answer a force later and less than the
vehicle does, and the acceleration that a heavier vehicle would resist has their noise. Sound runs
that took no part then all seem to have the same change, and so does any other run. What they share
is no change. It is taken off, channel by channel, with the error that it is known to. In which
directions, and how wide, is chosen one after the other, as long as the sound runs become clearly
more probable by it; where they share nothing, nothing is taken off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.response import Told
from pipeline.types import FloatArray

#: Standard deviations that are tried, in units of the directions, and directions of a channel.
_WIDTHS, _MOST = (0.03, 0.1, 0.3, 1.0, 3.0), 6


@dataclass(frozen=True)
class Offset:
    """Mean (c, d) and covariance (c, d, d) of what a channel is off by along the directions.

    `variance` (c, d) is what they were before any run was seen.
    """

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
        information, score = told.by_channel.copy(), told.score_by_channel.copy()
        for c, own in enumerate(told.by_channel):
            spread = runs * self.covariance[c]
            if not spread.any():
                continue
            left = score[c] - own @ self.mean[c]
            # (I^-1 + C)^-1 = (1 + I C)^-1 I, whatever the rank of either
            both = np.linalg.solve(np.eye(len(own)) + own @ spread, np.column_stack([own, left]))
            information[c] = (both[:, :-1] + both[:, :-1].T) / 2.0
            score[c] = both[:, -1]
        return Told(information, score, told.thrust)


def offset_of(sound: Sequence[Told]) -> Offset:
    """Estimate what sound runs, each predicted from the others, are off by alike."""
    information = np.sum([one.by_channel for one in sound], axis=0)
    score = np.sum([one.score_by_channel for one in sound], axis=0)
    return _told_by(
        sound, np.array([_chosen(*own) for own in zip(information, score, strict=True)])
    )


def without_offset(sound: Sequence[Told], offset: Offset) -> list[Told]:
    """Take off each sound run what the others are off by alike."""
    return [
        _told_by([*sound[:k], *sound[k + 1 :]], offset.variance).removed(one, 1)
        for k, one in enumerate(sound)
    ]


def _told_by(sound: Sequence[Told], variance: FloatArray) -> Offset:
    """Estimate an offset from runs, with its variances (c, d) before they were seen."""
    information = np.sum([one.by_channel for one in sound], axis=0)
    score = np.sum([one.score_by_channel for one in sound], axis=0)
    mean, covariance = np.zeros_like(score), np.zeros_like(information)
    for c, wide in enumerate(variance > 0.0):
        own = np.ix_(wide, wide)
        spread = np.linalg.inv(information[c][own] + np.diag(1.0 / variance[c, wide]))
        mean[c, wide], covariance[c][own] = spread @ score[c, wide], spread
    return Offset(variance, mean, covariance)


def _chosen(information: FloatArray, score: FloatArray) -> FloatArray:
    """Choose variances (d,) of the directions in which runs are off alike, the plainest first.

    Each must gain more than the choice among all directions is worth.
    """
    variance = np.zeros(score.size)
    for _ in range(_MOST):
        # (I^-1 + V)^-1 and its score: what is left of the runs once the chosen are integrated out
        left = np.linalg.solve(
            np.eye(score.size) + information * variance, np.column_stack([information, score])
        )
        own, value = np.diag(left[:, :-1]), left[:, -1]
        wide = np.square(_WIDTHS)[:, None]
        gain = 0.5 * (wide * value**2 / (1.0 + wide * own) - np.log1p(wide * own))
        width, k = np.unravel_index(int(np.argmax(gain)), gain.shape)
        if variance[k] > 0.0 or gain[width, k] <= np.log(score.size):
            break
        variance[k] = _WIDTHS[width] ** 2
    return variance
