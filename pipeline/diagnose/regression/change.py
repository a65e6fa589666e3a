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
_WIDTH, _PRIOR = np.array([1.0, 3.0]), np.array([0.8, 0.2])
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
        beyond = [beyond_ordinary(own, ordinary.width) for own in self._told]
        self.information = np.stack([information for information, _ in beyond])
        self.score = np.stack([score for _, score in beyond])

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
        every = np.ix_(runs, which, which)
        own, score = self.information[every], self.score[np.ix_(runs, which)]
        if without[0]:
            has = np.ones(score.shape)
            has[np.ix_(np.array(runs) < without[0], np.array(without[1], int))] = 0.0
            own, score = own * has[:, None, :] * has[:, :, None], score * has
        information, score = own.sum(axis=0), score.sum(axis=0)
        inner = np.eye(len(which)) / _WIDTH[:, None, None] ** 2 + information
        covariance = np.linalg.inv(inner)
        means, stds = covariance @ score, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        values = np.log(_PRIOR) + 0.5 * means @ score - len(which) * np.log(_WIDTH)
        values -= 0.5 * np.linalg.slogdet(inner)[1]
        for row, (mean, std) in enumerate(zip(means, stds, strict=True)):
            for k, size, spread in zip(which, mean, std, strict=True):
                bounds = self._directions[k].bounds
                values[row] += log_inside(float(size), float(spread), *bounds)
                values[row] -= log_inside(0.0, float(_WIDTH[row]), *bounds)
        best = int(np.argmax(values))
        return float(np.logaddexp.reduce(values)), means[best], stds[best]

    def agrees(self, k: int, runs: Sequence[int], size: float, std: float) -> float:
        """Log density of a size that is known otherwise, by what runs say, over that at their own.

        It is Student's, as a model that is wrong elsewhere may speak against it, too.
        """
        information = float(self.information[list(runs), k, k].sum())
        off = information * size - float(self.score[list(runs), k].sum())
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
