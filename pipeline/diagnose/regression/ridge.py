"""The regression of sound runs: slopes, their errors, and the noise of what they leave.

Of each velocity that was measured the next value is regressed on the values now and before, their
squares and products, the direction of gravity, and the wrench of the thrusters in each of the last
periods (ridge). How far a force along its own axis moves it the vehicle file knows to a share,
which counts where sound runs had little of that force. What remains is autocorrelated and grows
with how hard a run is flown: it is filtered by an autoregression and weighed by its size in blocks.
Each run is predicted from the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.file_step import Step
from pipeline.diagnose.regression.grid import CHANNELS, FORCES, GridRun
from pipeline.diagnose.regression.signatures import Rows, by_force, stays
from pipeline.types import FloatArray

#: Coefficients of the filter.
FILTER = 3
#: Ridge of features of unit size, in readings at zero: of any, times so many for force along other
#: axes, and of the velocity itself and the constant. Squares and products: one of these times it.
_RIDGE, _OTHER_AXES, _FREE = 10.0, 1_000_000.0, 0.01
#: Share by which the file is off in the gain of force along its own axis, and in its course.
_GAIN_OFF, _COURSE_OFF = 0.3, 0.5
#: Blocks of noise, and readings that the mean noise of a run is worth in each.
_BLOCK_S, _RUN_COUNTS = 4.0, 10.0
#: Rounds of regression, filter and weights.
_ROUNDS = 3
BENT = (100.0, 10_000.0, 1_000_000.0)
#: Times every ridge but the constant's, and less variance of the gain: more than all readings say.
STIFF = 1e12
#: Force along these axes moves a velocity: its own, and the one that a high centre of mass couples.
_MOVED_BY = {"u": (0, 4), "v": (1, 3), "w": (2,), "p": (3, 1), "q": (4, 0), "r": (5,)}


@dataclass(frozen=True)
class Fit:
    """Slopes (f, c) on scaled features, and their covariances (c, f, f)."""

    slope: FloatArray
    covariance: FloatArray


class Ridge:
    """A regression of sound runs, with all of them and with each left out.

    Parameters
    ----------
    runs : sequence of GridRun
        Sound runs with the same channels.
    bent : float
        Times the ridge for squares and products; see `BENT`.
    mean : callable, optional
        The next velocities that the regression starts from; they stay as they are without it.
    stiff : float
        Times the ridge of all but the constant; see `STIFF`.
    file : callable, optional
        The next velocities by the vehicle file, from which the gain of force is expected.

    Attributes
    ----------
    runs : tuple of GridRun
        Those that it was learned from.
    remainders : list of ndarray
        Of each run (k, c) what the others do not predict.
    """

    def __init__(
        self,
        runs: Sequence[GridRun],
        bent: float,
        mean: Step = stays,
        file: Step | None = None,
        *,
        stiff: float = 1.0,
    ) -> None:
        self.runs = tuple(runs)
        self._bent, self._mean, self._stiff = bent, mean, stiff
        self.channels = runs[0].channels
        self.period_s = runs[0].period_s
        self._sets = [Rows(run, mean) for run in runs]
        self._states = self._sets[0].features.shape[1] - 6 * FORCES
        own = np.array([[a in _MOVED_BY[name] for name in self.channels] for a in range(6)])
        self._own_axes = np.tile(own, (FORCES, 1))
        self._force = np.zeros((6 * FORCES, len(self.channels)))
        self._force[:6] = by_force(self._sets)
        as_file = self._sets if file is mean else [Rows(run, file) for run in runs if file]
        self._expected = None if file is None else by_force(as_file)
        self._scale_features()
        scaled = [self._scaled(one) for one in self._sets]
        spread = np.concatenate([one.next - one.mean for one in self._sets]).var(axis=0)
        noise = [np.broadcast_to(spread + 1e-12, one.next.shape) for one in self._sets]
        self._filter = np.zeros((len(self.channels), FILTER))
        for _ in range(_ROUNDS):
            self._fit(scaled, noise)
            self._fit_filter()
            noise = [self._noise(one) for one in self.remainders]

    @property
    def by_file(self) -> bool:
        """Whether it is the file's motion that was corrected."""
        return self._mean is not stays

    def _scale_features(self) -> None:
        every = np.concatenate([one.features for one in self._sets])
        self._middle = np.zeros(every.shape[1])
        self._middle[1 : self._states] = every[:, 1 : self._states].mean(axis=0)
        size = np.sqrt(np.mean((every - self._middle) ** 2, axis=0))
        self._scale = np.where(size > 1e-9, 1.0 / np.maximum(size, 1e-9), 0.0)
        # of a force that no sound run had, the file's gain stands
        force = self._scale[self._states :]
        force[force == 0.0] = 1.0

    def _scaled(self, one: Rows) -> FloatArray:
        return np.asarray((one.features - self._middle) * self._scale)

    def _ridge(self, channel: int) -> FloatArray:
        states = self._states
        found = np.full(self._scale.size, _RIDGE)
        other = np.ones(6, bool)
        other[list(_MOVED_BY[self.channels[channel]])] = False
        linear = 1 + 2 * len(self.channels)
        found[linear : states - 3] *= self._bent
        found[states:] *= np.where(np.tile(other, FORCES), _OTHER_AXES, 1.0)
        found[1:] *= self._stiff
        # of the velocity itself a file errs in its noise alone, which is filtered: a slope of it
        # would be that of slow runs, and wrong in a fast one
        found[[0] if self._stiff > 1.0 else [0, 1 + channel]] = _FREE
        return found

    def _before(self, channel: int) -> tuple[FloatArray, FloatArray]:
        """Slopes (f,) and their precision (f, f) before any run was seen."""
        slope, precision = np.zeros(self._scale.size), np.diag(self._ridge(channel))
        axis = CHANNELS.index(self.channels[channel])
        gain = 0.0 if self._expected is None else float(self._expected[axis, channel])
        own = self._states + axis + 6 * np.arange(FORCES)
        scale = self._scale[own]
        if gain == 0.0:
            return slope, precision
        even = np.full((FORCES, FORCES), 1.0 / FORCES)
        off = _GAIN_OFF**2 / FORCES * even + _COURSE_OFF**2 * (np.eye(FORCES) - even)
        certain = self._stiff * np.linalg.inv(gain**2 * off)
        precision[np.ix_(own, own)] = scale[:, None] * certain * scale
        slope[own[0]] = (gain - self._force[axis, channel]) / scale[0]
        return slope, precision

    def _fit(self, scaled: Sequence[FloatArray], noise: Sequence[FloatArray]) -> None:
        """Regress with each run left out, and with all."""
        count, width = len(self._sets), self._scale.size
        slopes = np.zeros((count + 1, width, len(self.channels)))
        spreads = np.zeros((count + 1, len(self.channels), width, width))
        for c in range(len(self.channels)):
            squares, products = [], []
            for one, x, own in zip(self._sets, scaled, noise, strict=True):
                both = self._whitened(np.column_stack([x, (one.next - one.mean)[:, c]]), c, own)
                squares.append(both[:, :-1].T @ both[:, :-1])
                products.append(both[:, :-1].T @ both[:, -1])
            before, ridge = self._before(c)
            square, product = sum(squares), sum(products) + ridge @ before
            for left in range(count + 1):
                out = (squares[left], products[left]) if left < count else (0.0, 0.0)
                spreads[left, c] = np.linalg.inv(square - out[0] + ridge)
                slopes[left, :, c] = spreads[left, c] @ (product - out[1])
        self._left_out = [Fit(slopes[k], spreads[k]) for k in range(count)]
        self._of_all = Fit(slopes[-1], spreads[-1])
        self.remainders = [
            one.next - one.mean - x @ fit.slope
            for one, x, fit in zip(self._sets, scaled, self._left_out, strict=True)
        ]

    def _fit_filter(self) -> None:
        for c in range(len(self.channels)):
            left, right = 1e-6 * np.eye(FILTER), np.zeros(FILTER)
            for one in self.remainders:
                own = one[:, c] / max(float(one[:, c].std()), 1e-12)
                past = np.stack([own[FILTER - 1 - k : len(own) - 1 - k] for k in range(FILTER)], 1)
                left, right = left + past.T @ past, right + past.T @ own[FILTER:]
            self._filter[c] = np.linalg.solve(left, right)

    def _filtered(self, values: FloatArray, channel: int) -> FloatArray:
        found = values.copy()
        for back, share in enumerate(self._filter[channel], start=1):
            found[back:] -= share * values[:-back]
        return found

    def filtered(self, remainder: FloatArray) -> FloatArray:
        """Return remainders (k, c) without what the readings before tell of them."""
        return np.stack([self._filtered(one, c) for c, one in enumerate(remainder.T)], axis=1)

    def _whitened(self, values: FloatArray, channel: int, noise: FloatArray) -> FloatArray:
        return np.asarray(self._filtered(values, channel) / np.sqrt(noise[:, channel, None]))

    def _noise(self, remainder: FloatArray) -> FloatArray:
        """Variance (k, c) of what is left, by blocks that lean on the whole run."""
        left = self.filtered(remainder)
        length = max(round(_BLOCK_S / self.period_s), 1)
        block = np.minimum(np.arange(len(left)) // length, max(len(left) // length, 1) - 1)
        count = np.bincount(block)[:, None]
        sums = np.stack([np.bincount(block, one) for one in np.square(left).T], axis=1)
        whole = np.mean(np.square(left), axis=0)
        return np.asarray(
            np.maximum((_RUN_COUNTS * whole + sums) / (_RUN_COUNTS + count), 1e-12)[block]
        )

    def whitened_of_sound(self, channel: int) -> FloatArray:
        """Return what sound runs leave of a channel, filtered and over its noise."""
        own = [one[:, channel : channel + 1] for one in self.remainders]
        noise = [self._noise(one) for one in self.remainders]
        white = [self._whitened(a, channel, b) for a, b in zip(own, noise, strict=True)]
        return np.concatenate(white)[:, 0]

    def _learned_force(self, slope: FloatArray) -> FloatArray:
        learned = slope[self._states :] * self._scale[self._states :, None]
        return np.where(self._own_axes, learned, 0.0)
