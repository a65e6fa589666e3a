"""A change, and what runs say of it together: evidence, size, and the runs that carry it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.normal import log_inside
from pipeline.diagnose.regression.directions import OF_ALL_THRUSTERS
from pipeline.diagnose.regression.ordinary import Ordinary, beyond_ordinary
from pipeline.diagnose.regression.told import Told
from pipeline.types import FloatArray

#: Prior widths of a change, in its units, and the probability of each: as plausible, or beyond.
_WIDTHS = ((1.0, 0.8), (3.0, 0.2))
#: How much thrust a run may have of what the sound ones had. [1]
_SCALES = (0.3, 3.0)
#: Degrees of freedom by which runs and a test agree: few, tails are heavy.
_TAIL = 4.0
#: Prior probability that all runs carry a change.
_ALL_RUNS = 0.7


@dataclass(frozen=True)
class Change:
    """A hypothesis: directions (none for `none` and `unknown`) and the runs that carry them.

    `evidence` is the logarithm over that of `none`; `mean` and `std` are of the sizes in the units
    of the directions, before they are held to where they may lie, at the thrust of the sound runs.
    `thrust` is the share of it that these runs have, and its standard deviation.
    """

    name: str
    which: tuple[int, ...]
    runs: tuple[int, ...]
    evidence: float
    probability: float
    mean: FloatArray
    std: FloatArray
    thrust: tuple[float, float] = (1.0, 0.0)


class Shared:
    """What each run says of changes that it shares with others."""

    def __init__(
        self, told: Sequence[Told], directions: Sequence[Coordinate], ordinary: Ordinary
    ) -> None:
        self.count, self._directions, self._width = len(told), directions, ordinary.width
        self._of_all = np.array([one.effect.id in OF_ALL_THRUSTERS for one in directions])
        self._told = [one.tempered(ordinary.share) for one in told]
        self.information, self.score = [], []
        for own in self._told:
            information, score = beyond_ordinary(own, ordinary.width)
            self.information.append(information)
            self.score.append(score)

    def over(self, width: FloatArray) -> float:
        """Log evidence of these widths over others, where nothing changed."""
        return sum(_evidence(one, self._width) - _evidence(one, width) for one in self._told)

    def shared(
        self,
        which: Sequence[int],
        runs: Sequence[int],
        without: tuple[int, Sequence[int]] = (0, ()),
    ) -> tuple[float, FloatArray, FloatArray]:
        """Log evidence, mean and standard deviation of a change that some runs share.

        So many first runs are `without` those of the directions that have these places.
        """
        own, places = np.ix_(which, which), list(which)
        information, score = np.zeros((len(which), len(which))), np.zeros(len(which))
        for r in runs:
            has = np.ones(len(which))
            if r < without[0]:
                has[list(without[1])] = 0.0
            information += self.information[r][own] * np.outer(has, has)
            score += self.score[r][places] * has
        tried = []
        for width, prior in _WIDTHS:
            inner = np.eye(len(which)) / width**2 + information
            covariance = np.linalg.inv(inner)
            mean, std = covariance @ score, np.sqrt(np.diag(covariance))
            value = float(np.log(prior)) + 0.5 * float(score @ mean)
            value -= 0.5 * float(np.linalg.slogdet(inner * width**2)[1])
            for k, size, spread in zip(which, mean, std, strict=True):
                bounds = self._directions[k].bounds
                value += log_inside(float(size), float(spread), *bounds)
                value -= log_inside(0.0, width, *bounds)
            tried.append((value, mean, std))
        total = float(np.logaddexp.reduce([one[0] for one in tried]))
        _, mean, std = max(tried, key=lambda one: one[0])
        return total, mean, std

    def agrees(self, k: int, runs: Sequence[int], size: float, std: float) -> float:
        """Log density of a size that is known otherwise, by what runs say, over that at their own.

        It is Student's, as a model that is wrong elsewhere may speak against it, too.
        """
        information = sum(float(self.information[r][k, k]) for r in runs)
        off = information * size - sum(float(self.score[r][k]) for r in runs)
        square = off**2 / max(information + (information * std) ** 2, 1e-12)
        return -0.5 * (_TAIL + 1.0) * float(np.log1p(square / _TAIL))

    def thrust_of(
        self, which: Sequence[int], runs: Sequence[int], mean: FloatArray
    ) -> tuple[float, float]:
        """Share of the thrust of sound runs that these have, and its standard deviation.

        By what is ordinary between runs, and by a change of all thrusters where one is among these.
        """
        scales, errors, weights = [], [], []
        for run in runs:
            told, thrust = self._told[run], self._told[run].thrust * self._of_all
            inner = np.eye(thrust.size) + self._width[:, None] * told.information * self._width
            score = told.score - told.information[:, list(which)] @ mean
            every = np.column_stack([self._width * score, self._width * thrust])
            solved = self._width[:, None] * np.linalg.solve(inner, every)
            scales.append(1.0 + float(thrust[list(which)] @ mean + thrust @ solved[:, 0]))
            errors.append(float(thrust @ solved[:, 1]))
            weights.append(float(np.trace(self.information[run][np.ix_(which, which)])))
        share = np.array(weights) / max(float(np.sum(weights)), 1e-12)
        error = float(np.sqrt(share**2 @ errors))
        return float(np.clip(share @ scales, *_SCALES)), error


def _evidence(told: Told, width: FloatArray) -> float:
    """Log evidence that directions differ by these widths, over that they do not differ."""
    inner = np.eye(width.size) + width[:, None] * told.information * width
    score = width * told.score
    value = score @ np.linalg.solve(inner, score) - np.linalg.slogdet(inner)[1]
    return 0.5 * float(value)


def carried(
    runs: Shared, which: Sequence[int]
) -> list[tuple[float, tuple[int, ...], FloatArray, FloatArray]]:
    """Log evidence with prior, runs, mean and deviation of a change: in all, or in some of them.

    Those that speak for it most are put together.
    """
    alone = [runs.shared(which, (r,))[0] for r in range(runs.count)]
    order = np.argsort([-one for one in alone]).tolist()
    found = []
    for n in range(runs.count):
        own = tuple(sorted(order[: n + 1]))
        value, mean, std = runs.shared(which, own)
        share = _ALL_RUNS if len(own) == runs.count else (1.0 - _ALL_RUNS) / (2**runs.count - 2)
        if runs.count == 1:
            share = 1.0
        found.append((value + float(np.log(share)), own, mean, std))
    return found
