r"""A linear black box as a baseline: what commands and past readings predict without any physics.

.. math:: s_{k+1} = s_k + A s_k + B s_{k-1} + C f(u_k) + c

with s the measured velocities, rates, roll, pitch and depth, u the commands over their largest
values and f(u) = (u, u|u|): an ARX model of second order (Ljung 1999, section 4.2), fitted by ridge
regression. Velocities, rates and depth are what it is judged by.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.windows import Window
from pipeline.records.run_table import RunTable, angles
from pipeline.types import FloatArray

#: Period of the model [s], and ridge penalty on regressors of unit variance.
PERIOD_S = 0.1
RIDGE = 1e-6
#: A forecast is held within this many times the range seen in the fit: it may be unstable.
RANGE_FACTOR = 3.0
#: What s is made of, and columns of each.
_STATE = {"velocity": 3, "angular_velocity": 3, "attitude": 2, "depth": 1}


@dataclass(frozen=True)
class BlackBox:
    """The fitted model; `quantities` name what s is made of, in order."""

    quantities: tuple[str, ...]
    code_max: FloatArray
    coefficients: FloatArray
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
        first = _samples(run, time_s[:2], self.quantities)
        if first is None:
            return None
        drive = _drive(run, time_s, self.code_max)
        s = np.empty((time_s.size, self.low.size))
        s[:2] = first
        for k in range(1, time_s.size - 1):
            x = np.concatenate([s[k], s[k - 1], drive[k], [1.0]])
            s[k + 1] = np.clip(s[k] + x @ self.coefficients, self.low, self.high)
        ends = np.cumsum([_STATE[quantity] for quantity in self.quantities])
        parts = dict(zip(self.quantities, np.split(s, ends[:-1], axis=1), strict=True))
        parts.pop("attitude", None)
        return time_s, parts


def fit_black_box(
    runs: Sequence[RunTable], windows: Sequence[Window], code_max: FloatArray
) -> BlackBox | None:
    """Fit the model on the windows of runs that the vehicle is fitted on.

    `code_max` (n,) is the largest command of each thruster. None where there is nothing to predict
    or less than ten samples a coefficient.
    """
    quantities = tuple(q for q in _STATE if all(q in run.values for run in runs))
    regressors, increments = [], []
    for window in windows if quantities else ():
        run = runs[window.run]
        time_s = np.arange(window.begin_s, window.begin_s + window.duration_s, PERIOD_S)
        s = _samples(run, time_s, quantities)
        if s is None or len(s) < 3:
            continue
        drive = _drive(run, time_s, code_max)[1:-1]
        regressors.append(np.hstack([s[1:-1], s[:-2], drive, np.ones((len(drive), 1))]))
        increments.append(s[2:] - s[1:-1])
    if not regressors:
        return None
    x, y = np.concatenate(regressors), np.concatenate(increments)
    if len(x) < 10 * x.shape[1]:
        return None
    low, high = x[:, : y.shape[1]].min(0), x[:, : y.shape[1]].max(0)
    wider = (RANGE_FACTOR - 1.0) / 2.0 * (high - low)
    # on regressors of unit size; the constant is free
    scale = np.sqrt(np.mean(x**2, axis=0))
    scaled = x / np.where(scale > 0, scale, 1.0)
    penalty = RIDGE * len(x) * np.diag([*np.ones(x.shape[1] - 1), 0.0])
    found = np.linalg.solve(scaled.T @ scaled + penalty, scaled.T @ y)
    coefficients = found / np.where(scale > 0, scale, 1.0)[:, None]
    return BlackBox(quantities, code_max, coefficients, low - wider, high + wider)


def _drive(run: RunTable, time_s: FloatArray, code_max: FloatArray) -> FloatArray:
    index = np.searchsorted(run.time_s, time_s + 1e-9, side="right") - 1
    u = np.nan_to_num(run.values["command"])[np.clip(index, 0, None)] / code_max
    return np.hstack([u, u * np.abs(u)])


def _samples(run: RunTable, time_s: FloatArray, quantities: Sequence[str]) -> FloatArray | None:
    """Channels at times (k,); None where one is missing, or has no valid sample near by."""
    columns: list[FloatArray] = []
    for quantity in quantities:
        good = run.trusted(quantity) if quantity in run.values else np.zeros(0, bool)
        known = run.time_s[good] if good.sum() > 1 else np.array([-np.inf])
        near = np.abs(known[np.clip(np.searchsorted(known, time_s), 0, known.size - 1)] - time_s)
        if near.max() > 1.0:
            return None
        values = run.values[quantity][good]
        if quantity == "attitude":
            values = angles(values)[:, :2]
        columns += [np.interp(time_s, known, column) for column in values.T]
    return np.column_stack(columns)
