r"""A linear black box as a baseline: what commands and past readings predict without any physics.

.. math:: s_{k+1} = s_k + A s_k + B s_{k-1} + C f(u_k) + c

with s the measured velocities, rates, roll, pitch and depth, u the commands over their largest
values and f(u) = (u, u|u|): an ARX model of second order (Ljung 1999, section 4.2), fitted by ridge
regression. Heading is the sum of its own increments; specific force is a linear function of s and
f(u).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.identify.windows import Window
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Period of the model [s], and ridge penalty on regressors of unit variance.
PERIOD_S = 0.1
RIDGE = 1e-6
#: A forecast is held within this many times the range seen in the fit: it may be unstable.
RANGE_FACTOR = 3.0


@dataclass(frozen=True)
class BlackBox:
    """The fitted model; `quantities` name what s is made of, in order."""

    quantities: tuple[str, ...]
    code_max: FloatArray
    coefficients: FloatArray
    output: FloatArray | None
    low: FloatArray
    high: FloatArray

    def predict(
        self, run: RunTable, from_s: float, to_s: float
    ) -> tuple[FloatArray, dict[str, FloatArray]] | None:
        """Run the model freely over a stretch of a run, from the two samples before it.

        Times (k,) and the channels there (k, c); None where a channel of the model has no valid
        sample near the start.
        """
        time_s = np.arange(from_s - PERIOD_S, to_s + PERIOD_S, PERIOD_S)
        sampled = _samples(run, time_s[:2], self.quantities)
        if sampled is None:
            return None
        drive = _drive(run, time_s, self.code_max)
        s = np.empty((time_s.size, self.low.size + 1))
        s[:2] = sampled
        for k in range(1, time_s.size - 1):
            x = np.concatenate([s[k, :-1], s[k - 1, :-1], drive[k], [1.0]])
            s[k + 1] = s[k] + x @ self.coefficients
            s[k + 1, :-1] = np.clip(s[k + 1, :-1], self.low, self.high)
        return time_s, self._channels(s, drive)

    def _channels(self, s: FloatArray, drive: FloatArray) -> dict[str, FloatArray]:
        values, column, roll_pitch = {}, 0, None
        for quantity in self.quantities:
            if quantity == "attitude":
                roll_pitch = s[:, column : column + 2]
                column += 2
                continue
            width = 1 if quantity == "depth" else 3
            values[quantity] = s[:, column : column + width]
            column += width
        if roll_pitch is not None:
            angles = np.column_stack([s[:, -1], roll_pitch[:, 1], roll_pitch[:, 0]])
            x, y, z, w = Rotation.from_euler("ZYX", angles).as_quat().T
            values["attitude"] = _same_sign(np.column_stack([w, x, y, z]))
        if self.output is not None:
            regressors = np.column_stack([s[:, :-1], drive, np.ones(len(s))])
            values["specific_force"] = regressors @ self.output
        return values


def fit_black_box(
    runs: Sequence[RunTable], windows: Sequence[Window], code_max: FloatArray
) -> BlackBox | None:
    """Fit the model on the windows of runs that the vehicle is fitted on.

    `code_max` (n,) is the largest command of each thruster. None where there is nothing to predict
    or less than ten samples a coefficient.
    """
    quantities = tuple(
        q
        for q in ("velocity", "angular_velocity", "attitude", "depth")
        if all(q in run.values for run in runs)
    )
    if not quantities:
        return None
    force = all("specific_force" in run.values for run in runs)
    regressors, increments, instant, forces = [], [], [], []
    for window in windows:
        time_s = np.arange(window.begin_s, window.begin_s + window.duration_s, PERIOD_S)
        run = runs[window.run]
        s = _samples(run, time_s, quantities)
        measured = _samples(run, time_s, ("specific_force",)) if force else s
        if s is None or measured is None or len(s) < 3:
            continue
        drive = _drive(run, time_s, code_max)
        one = np.ones((len(s), 1))
        regressors.append(np.hstack([s[1:-1, :-1], s[:-2, :-1], drive[1:-1], one[2:]]))
        increments.append(s[2:] - s[1:-1])
        instant.append(np.hstack([s[:, :-1], drive, one]))
        forces.append(measured[:, :-1])
    if not regressors:
        return None
    x = np.concatenate(regressors)
    if len(x) < 10 * x.shape[1]:
        return None
    seen = np.concatenate([block[:, : increments[0].shape[1] - 1] for block in regressors])
    middle, half = (seen.max(0) + seen.min(0)) / 2, (seen.max(0) - seen.min(0)) / 2
    return BlackBox(
        quantities,
        code_max,
        _ridge(x, np.concatenate(increments)),
        _ridge(np.concatenate(instant), np.concatenate(forces)) if force else None,
        middle - RANGE_FACTOR * half,
        middle + RANGE_FACTOR * half,
    )


def _ridge(x: FloatArray, y: FloatArray) -> FloatArray:
    """Ridge regression on regressors scaled to unit size, the constant last and free."""
    scale = np.sqrt(np.mean(x**2, axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    normal = (x / scale).T @ (x / scale)
    penalty = RIDGE * len(x) * np.eye(x.shape[1])
    penalty[-1, -1] = 0.0
    return np.asarray(np.linalg.solve(normal + penalty, (x / scale).T @ y) / scale[:, None])


def _drive(run: RunTable, time_s: FloatArray, code_max: FloatArray) -> FloatArray:
    index = np.searchsorted(run.time_s, time_s + 1e-9, side="right") - 1
    u = np.nan_to_num(run.values["command"])[np.clip(index, 0, None)] / code_max
    return np.hstack([u, u * np.abs(u)])


def _samples(run: RunTable, time_s: FloatArray, quantities: Sequence[str]) -> FloatArray | None:
    """Channels at times (k,), the heading last; None where one has no valid sample near by.

    Nor where the run lacks one: a run that judges the model need not have all that it was made of.
    """
    columns, heading = [], np.zeros(time_s.size)
    for quantity in quantities:
        if quantity not in run.values:
            return None
        good = run.trusted(quantity)
        known = run.time_s[good]
        if known.size < 2:
            return None
        near = np.abs(known[np.clip(np.searchsorted(known, time_s), 0, known.size - 1)] - time_s)
        if near.max() > 1.0:
            return None
        values = run.values[quantity][good]
        if quantity == "attitude":
            angles = Rotation.from_quat(values[:, [1, 2, 3, 0]]).as_euler("ZYX")
            heading = np.interp(time_s, known, np.unwrap(angles[:, 0]))
            values = angles[:, [2, 1]]
        columns += [np.interp(time_s, known, column) for column in values.T]
    return np.column_stack([*columns, heading])


def _same_sign(quaternion: FloatArray) -> FloatArray:
    """Choose the sign of each quaternion so that neighbours can be interpolated."""
    flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0
    signs = np.concatenate([[1.0], np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)])
    return np.asarray(quaternion * signs[:, None])
