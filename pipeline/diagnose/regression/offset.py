"""What the learned response is off by in all sound runs alike.

A regression on noisy readings is biased: noise of a velocity is in what is to be explained and in
the acceleration that a heavier vehicle would resist. Sound runs that took no part then all seem to
have the same change, and so does any other run. What they share is no change. It is taken off,
channel by channel, with the error that it is known to; how large it may be is set so that the sound
runs are most probable (empirical Bayes), and where they share nothing nothing is taken off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.response import Told
from pipeline.types import FloatArray

#: Standard deviations that are tried, in units of the directions; 0 stands before them.
_WIDTHS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)


@dataclass(frozen=True)
class Offset:
    """Mean (c, d) and covariance (c, d, d) of what a channel is off by along the directions."""

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
    mean, covariance = np.zeros_like(score), np.zeros_like(information)
    for c, (own, value) in enumerate(zip(information, score, strict=True)):
        best = 0.0
        for width in _WIDTHS:
            inner = np.eye(len(own)) + width**2 * own
            solved = width**2 * np.linalg.solve(inner, np.column_stack([value, np.eye(len(own))]))
            evidence = 0.5 * float(value @ solved[:, 0] - np.linalg.slogdet(inner)[1])
            if evidence > best:
                best, mean[c] = evidence, solved[:, 0]
                covariance[c] = (solved[:, 1:] + solved[:, 1:].T) / 2.0
    return Offset(mean, covariance)


def without_offset(sound: Sequence[Told]) -> list[Told]:
    """Take off each sound run what the others are off by alike."""
    return [
        offset_of([other for n, other in enumerate(sound) if n != k]).removed(one, 1)
        for k, one in enumerate(sound)
    ]
