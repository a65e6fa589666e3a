"""Windows predicted by the model from where their first parts show the vehicle.

The first part of a window, its lead, shows where the vehicle is: its first state is estimated from
those readings alone, and a velocity that none of them shows is the model's. What comes after is a
prediction from the commands, compared with the readings: here of windows that took no part in a
fit, beside naive baselines, and of whole runs in `trial_windows`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.output_error import solve
from pipeline.identify.window_derivatives import FitProblem
from pipeline.identify.window_outputs import (
    OFFSETS,
    WindowStack,
    innovations,
    stack_windows,
    turn_between,
)
from pipeline.identify.windows import Window
from pipeline.records.identification import ChannelQuality
from pipeline.records.run_table import RunTable, angles
from pipeline.simulate.kernel import STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

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


#: Share of a window from which its first state is estimated.
LEAD_SHARE = 0.25
#: Starts that are estimated together; more only make the equations larger.
_BATCH = 16

#: A vehicle with its curves of thrust, and a parameter vector of it.
Model = tuple[PackedVehicle, FloatArray]


def lead_starts(
    model: Model,
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    steps: Sequence[int],
    *,
    threads: int = 2,
) -> FloatArray:
    """Estimate first states (windows, STATE) from leads of so many `steps`.

    NaN where a lead shows none, or the model runs away in it. Windows of one run share the wander
    of its attitude.
    """
    leads = [one.lead(count) for one, count in zip(windows, steps, strict=True)]
    starts = np.full((len(windows), STATE), np.nan)
    shown = [k for k, one in enumerate(leads) if one.readings]
    for at in range(0, len(shown), _BATCH):
        batch = shown[at : at + _BATCH]
        # one window that runs away must not take its neighbours with it
        for part in (batch, *([k] for k in batch)):
            found = _estimated(model, [leads[k] for k in part], channels, threads)
            if found is not None:
                starts[part] = found
                if part is batch:
                    break
    return starts


def _estimated(
    model: Model, leads: Sequence[Window], channels: Sequence[ChannelNoise], threads: int
) -> FloatArray | None:
    packed, vector = model
    stack = stack_windows(packed, leads, channels)
    runs = 1 + max(one.run for one in leads)
    problem = FitProblem(stack, (), vector, runs, threads, offsets=False)
    try:
        return problem.starts(solve(problem, smallest_gain=0.5).point.starts)
    except (CannotComputeError, np.linalg.LinAlgError):
        return None


def prediction_quality(
    models: Mapping[str, Model],
    windows: Sequence[Window],
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    black_box: BlackBox | None,
    *,
    offsets: FloatArray | None = None,
    threads: int = 2,
) -> tuple[ChannelQuality, ...]:
    """Errors per channel, on windows that took no part in a fit, of vehicles and of the baselines.

    `models` are vehicles by what `ChannelQuality` calls the error of each: ``identified``,
    ``vehicle_file``, ``corrected_file``. `windows` are cut from the `runs`, whose `offsets` (runs,
    OFFSET_COUNT) are zero where none are given; `black_box` was fitted on the windows of the fit.
    """
    kept = [w for w in windows if w.lead(_lead_of(w)).readings]
    if not kept:
        return ()
    packed = next(iter(models.values()))[0]
    whole = stack_windows(packed, kept, channels)
    clean = whole
    if offsets is not None:
        clean = stack_windows(packed, [_without(w, offsets[w.run]) for w in kept], channels)
    steps = [_lead_of(one) for one in kept]
    ends = whole.begins[:-1] + np.array(steps)
    later = [np.asarray(rows.sample > ends[rows.window]) for rows in whole.rows]
    errors = {
        name: _errors(model, clean, channels, steps, threads) for name, model in models.items()
    }
    errors["last_value"] = _held_errors(whole, later)
    errors["black_box"] = _black_box_errors(whole, runs, black_box)
    return tuple(
        ChannelQuality(
            channel=rows.channel.quantity,
            unit=rows.channel.unit,
            horizon_s=(1.0 - LEAD_SHARE) * float(np.mean([w.duration_s for w in kept])),
            readings=int(later[number].sum()),
            sensor_noise=rows.channel.of_reading(offset=offsets is None),
            **{
                f"rmse_{name}": _rms(own[number][later[number]], whole=name in models)
                for name, own in errors.items()
            },
        )
        for number, rows in enumerate(whole.rows)
    )


def _without(window: Window, offsets: FloatArray) -> Window:
    """Take known offsets (OFFSET_COUNT,) off the readings of a window."""
    readings = {
        name: replace(own, values=own.values - offsets[OFFSETS[name]]) if name in OFFSETS else own
        for name, own in window.readings.items()
    }
    return replace(window, readings=readings)


def _lead_of(window: Window) -> int:
    return round(LEAD_SHARE * len(window.command))


def _rms(errors: FloatArray, *, whole: bool) -> float | None:
    """Root mean square; None of nothing, or where a vehicle, `whole`, ran away.

    Of a baseline rows (k, c) count for which it had something to start from.
    """
    values = errors if whole else errors[np.isfinite(errors).all(axis=1)]
    if not values.size or not np.isfinite(values).all():
        return None
    return float(np.sqrt(np.mean(values**2)))


def _errors(
    model: Model,
    whole: WindowStack,
    channels: Sequence[ChannelNoise],
    steps: Sequence[int],
    threads: int,
) -> list[FloatArray]:
    """Predict all of each window from its lead; NaN where that tells no start."""
    starts = lead_starts(model, whole.windows, channels, steps, threads=threads)
    lost = np.asarray(~np.isfinite(starts).all(axis=1))
    starts[lost] = whole.starts[lost]
    found = innovations(replace(whole, packed=model[0]), model[1], starts)
    for rows, errors in zip(whole.rows, found, strict=True):
        errors[lost[rows.window]] = np.nan
    return found


def _held_errors(stack: WindowStack, later: Sequence[BoolArray]) -> list[FloatArray]:
    """Errors of holding the last reading of the lead; NaN where it has none."""
    found = []
    for rows, beyond in zip(stack.rows, later, strict=True):
        last = np.maximum.accumulate(np.where(beyond, -1, np.arange(beyond.size)))
        held = rows.measured[last]
        if rows.channel.quantity == "attitude":
            errors = turn_between(held, rows.measured)
        else:
            errors = rows.measured - held
        errors[(last < 0) | (rows.window[last] != rows.window)] = np.nan
        found.append(errors)
    return found


def _black_box_errors(
    stack: WindowStack, runs: Sequence[RunTable], box: BlackBox | None
) -> list[FloatArray]:
    """Errors of the black box, started from the last samples of each lead; NaN without."""
    found = [np.full_like(rows.measured, np.nan) for rows in stack.rows]
    for number, w in enumerate(stack.windows):
        end_s = w.begin_s + w.duration_s
        lead_end_s = w.begin_s + LEAD_SHARE * w.duration_s
        forecast = None if box is None else box.predict(runs[w.run], lead_end_s, end_s)
        for rows, errors in zip(stack.rows, found, strict=True):
            if forecast is None or rows.channel.quantity not in forecast[1]:
                continue
            own = rows.window == number
            time_s, columns = w.begin_s + stack.into_s(rows)[own], forecast[1]
            at = [np.interp(time_s, forecast[0], one) for one in columns[rows.channel.quantity].T]
            errors[own] = rows.measured[own] - np.stack(at, axis=1)
    return found
