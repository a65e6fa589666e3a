"""The regression of one run, and its signatures: what a unit of each direction changes in it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from pipeline.diagnose.regression.file_step import Step
from pipeline.diagnose.regression.grid import CHANNELS, FORCES, GridRun
from pipeline.types import FloatArray, IntArray

#: The mean's answer to force is taken at what is usual along its axis: this share of that along
#: any, at the least.
_LEAST = 0.01


def stays(now: FloatArray, _before: FloatArray, _run: GridRun, _rows: IntArray) -> FloatArray:
    """Let velocities stay as they are."""
    return now


class Rows:
    """The regression of one run: features (k, f), next velocities (k, c), signatures.

    `mean` (k, c) are the next velocities before anything was learned.
    """

    def __init__(self, run: GridRun, mean: Step) -> None:
        self.run = run
        velocity = run.velocity
        self.rows = np.arange(run.first, len(velocity))
        self.now, before = velocity[self.rows - 1], velocity[self.rows - 2]
        self.next = velocity[self.rows]
        self.features = features(self.now, before, run, self.rows)
        self.mean = mean(self.now, before, run, self.rows)

        self._mean_step = mean

    @cached_property
    def by_wrench(self) -> FloatArray:
        """Change of `mean` (k, 6, c) by a newton, or newton metre, as one of many (rms)."""
        found = np.zeros((self.rows.size, 6, self.now.shape[1]))
        usual = np.sqrt(np.mean(self.run.wrench**2, axis=0))
        usual = np.maximum(usual, max(_LEAST * float(usual.max()), 1e-6))
        for axis, more in enumerate(np.diag(usual)):
            moved = self._moved(np.broadcast_to(more, self.run.wrench.shape))
            found[:, axis] = moved / usual[axis]
        return found

    def _moved(self, wrench: FloatArray) -> FloatArray:
        """Change of `mean` (k, c) by a wrench (m, 6) beside that which the thrusters have."""
        if self._mean_step is stays:
            return np.zeros_like(self.now)
        run, rows = self.run, self.rows
        other = replace(run, wrench=run.wrench + wrench)
        before = run.velocity[rows - 2]
        return np.asarray(self._mean_step(self.now, before, other, rows) - self.mean)

    def signatures(self, asked: GridRun, force: FloatArray, gained: FloatArray) -> FloatArray:
        """Change of the next velocities (k, d, c) by a unit of each direction of the same run.

        Drag takes more of a large force than of a small one: a direction that was taken at a size
        has the change that this makes. What a heavier vehicle resists is the acceleration by which
        velocities are predicted to have `gained` (k, c) over a period: that which was measured
        holds what is to be explained, and more noise than motion. It gains less than that, as the
        change s is part of it:

            s = (F - dM (gained + s) / T) B
        """
        rate = np.zeros((len(asked.velocity), 6))
        own = [CHANNELS.index(name) for name in asked.channels]
        rate[self.rows[:, None], own] = gained / asked.period_s
        more = asked.more - np.tensordot(rate, asked.heavier, axes=(1, 2))
        past = lagged(more, self.rows).transpose(0, 2, 1, 3)
        found = np.tensordot(past, force.reshape(FORCES, 6, -1), axes=2)
        by_mean = more[self.rows] @ self.by_wrench
        for k, size in asked.taken.items():
            by_mean[:, k] = self._moved(size * more[:, k]) / size
        found += by_mean
        answer = force.reshape(-1, *self.by_wrench.shape[1:]).sum(axis=0) + self.by_wrench
        for k, size in asked.taken.items():
            resisted = size * asked.heavier[k][:, own].T / asked.period_s @ answer
            found[:, k] = np.linalg.solve(
                np.eye(len(own)) + resisted.transpose(0, 2, 1), found[:, k, :, None]
            )[..., 0]
        return np.asarray(found)


def features(now: FloatArray, before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
    """Return what is regressed on (k, f): the state, then the wrenches."""
    first, second = np.triu_indices(now.shape[1], 1)
    every = [np.ones((rows.size, 1)), now, before, np.abs(now) * now]
    every += [now[:, first] * now[:, second], run.down[rows - 1]]
    every.append(lagged(run.wrench, rows).reshape(rows.size, -1))
    return np.concatenate(every, axis=1)


def by_force(sets: Sequence[Rows]) -> FloatArray:
    """Mean change of the next velocities (6, c) by a newton, or newton metre, before learning."""
    return np.asarray(np.mean([one.by_wrench.mean(axis=0) for one in sets], axis=0))


def lagged(values: FloatArray, rows: IntArray) -> FloatArray:
    """Values of the last periods (k, FORCES, ...), the newest first."""
    return np.stack([values[np.maximum(rows - back, 0)] for back in range(FORCES)], axis=1)
