"""What is ordinary: how much sound runs differ along each direction, and how far noise is trusted.

Before any run is seen each direction differs by what the vehicle file states (`stated_widths`).
Sound runs move that (empirical Bayes): directions of one parameter share a scale, lognormal around
what was stated, around which each has its own, drawn towards it as by a few runs. That few runs
tell a scale poorly is counted where runs are weighed. No width grows beyond a
little more than was stated: what differs by more is noise, for which the information of all runs is
tempered, channel by channel, until their scatter along independent directions is as large as it
claims to be.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.told import Told
from pipeline.types import FloatArray

#: Share of what a change does that its signature may be off by: by a response that was learned, and
#: by the motion of the file. [1]
INEXACT, INEXACT_OF_FILE = 0.1, 0.05
#: Standard deviation of ln of a parameter's scale of variances before any run was seen, and steps
#: to the most probable one; runs that the scale is worth for each direction of the parameter.
_SCALE_WIDTH, _NEWTON, _OWN_RUNS = 1.5, 20, 4.0
#: No direction is wider than so many times what was stated.
_WIDEST = 1.5
_ROUNDS = 40
#: Directions that are told to less than this of their width say nothing of the noise. Squares of
#: three standard deviations and more count as three. Least share of the information that is left.
_LEAST_TOLD, _MOST_SQUARE, _LEAST_SHARE = 0.05, 9.0, 0.01


@dataclass(frozen=True)
class Ordinary:
    """Standard deviation (d,) of each direction between runs, and the share of information (c,).

    `inexact` is the share of what a change does that its signature may be off by.
    """

    width: FloatArray
    share: FloatArray
    inexact: float = INEXACT

    @property
    def trusted(self) -> float:
        """Share of the information that is left over all channels."""
        return float(np.exp(np.mean(np.log(self.share))))

    def of(self, told: Told, change: FloatArray | float) -> FloatArray:
        """Return by what a run most probably differs (d,), beside a change of it (d,)."""
        own = told.tempered(self.share)
        score = own.score - own.information @ np.broadcast_to(change, own.score.shape)
        inner = np.eye(score.size) + self.width[:, None] * own.information * self.width
        return np.asarray(self.width * np.linalg.solve(inner, self.width * score))


def ordinary_of(
    told: Sequence[Told], directions: Sequence[Coordinate], stated: FloatArray
) -> Ordinary:
    """Learn from what the sound runs say, each left out in turn.

    Parameters
    ----------
    told : sequence of Told
        Of each sound run.
    directions : sequence of Coordinate
        The directions.
    stated : ndarray, shape (d,)
        Their widths before any run was seen.
    """
    channels = range(len(told[0].by_channel))
    share = np.array([_share([one.of_channel(c) for one in told], stated) for c in channels])
    place: dict[tuple[str, str], int] = {}
    group = np.array(
        [place.setdefault((one.effect.id, one.parameter.name), len(place)) for one in directions]
    )
    count = len(told)
    told_of = np.asarray(count * np.bincount(group), float)
    width = stated.copy()
    for _ in range(_ROUNDS):
        squares = np.zeros(stated.size)
        for one in told:
            mean, variance = posterior(one.tempered(share), width)
            squares += mean**2 + variance
        relative = squares / stated**2
        scale = _scale(np.asarray(np.bincount(group, relative), float), told_of)
        each = (_OWN_RUNS * scale[group] + relative) / (_OWN_RUNS + count)
        width = stated * np.sqrt(np.minimum(each, _WIDEST**2))
    return Ordinary(width, share)


def _scale(squares: FloatArray, count: FloatArray) -> FloatArray:
    """Most probable scale (g,) of variances, by squares and their count; lognormal around one.

    Of ln s = t: -count / 2 t - squares / 2 e^-t - t^2 / 2 w^2 has one maximum.
    """
    log = np.zeros(squares.size)
    for _ in range(_NEWTON):
        pull = 0.5 * squares * np.exp(-log)
        slope = -0.5 * count + pull - log / _SCALE_WIDTH**2
        log += np.clip(slope / (pull + 1.0 / _SCALE_WIDTH**2), -1.0, 1.0)
    return np.asarray(np.exp(log))


def posterior(told: Told, width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and variance (d,) of all directions at once, each within its width."""
    inner = np.eye(width.size) + width[:, None] * told.information * width
    inverse = np.linalg.inv(inner)
    mean = width * (inverse @ (width * told.score))
    return mean, width**2 * np.diag(inverse)


def beyond_ordinary(told: Told, width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Information (d, d) and score (d,) of changes once what is ordinary is integrated out."""
    inner = np.eye(width.size) + width[:, None] * told.information * width
    every = np.column_stack([told.information, told.score])
    solved = np.linalg.solve(inner, width[:, None] * every)
    across = told.information * width
    return told.information - across @ solved[:, :-1], told.score - across @ solved[:, -1]


def share_as_claimed(told: Sequence[Told], width: FloatArray) -> FloatArray:
    """Share (c,) of the information with which runs of one vehicle scatter as it says alone."""
    channels = range(len(told[0].by_channel))
    return np.array(
        [_share([one.of_channel(c) for one in told], width, alike=True) for c in channels]
    )


def _share(told: Sequence[Told], stated: FloatArray, *, alike: bool = False) -> float:
    """Share of the information with which the sound runs scatter as it and the widths say."""
    low, high = _LEAST_SHARE, 1.0
    if _scatter(told, stated, high, alike=alike) <= 1.0:
        return high
    for _ in range(12):
        middle = float(np.sqrt(low * high))
        over = _scatter(told, stated, middle, alike=alike) > 1.0
        low, high = (low, middle) if over else (middle, high)
    return float(np.sqrt(low * high))


def _scatter(told: Sequence[Told], stated: FloatArray, share: float, *, alike: bool) -> float:
    """Mean square of independent combinations of the directions, over what it should be.

    Runs that are `alike` differ by noise alone, not by the widths.
    """
    found: list[FloatArray] = []
    for one in told:
        values, vectors = np.linalg.eigh(stated[:, None] * share * one.information * stated)
        score = vectors.T @ (stated * share * one.score)
        known = values > _LEAST_TOLD
        differ = 1.0 if alike else 1.0 + values[known]
        found.append(score[known] ** 2 / (values[known] * differ))
    every = np.concatenate(found)
    return float(np.minimum(every, _MOST_SQUARE).mean()) if every.size else 0.0
