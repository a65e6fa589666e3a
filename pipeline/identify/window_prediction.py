"""Windows predicted from where their first parts show the vehicle, beside naive baselines.

The first part of a window shows where the vehicle is: its first state is estimated from those
readings alone. What comes after is a prediction from the commands, and compared with the readings:
of windows that took no part in a fit here, of whole runs in `trial_windows`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.black_box import BlackBox
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.output_error import solve
from pipeline.identify.run_nuisance import run_nuisance
from pipeline.identify.window_derivatives import FitProblem
from pipeline.identify.window_outputs import (
    OFFSET_COUNT,
    OFFSETS,
    WindowStack,
    innovations,
    stack_windows,
    turn_between,
)
from pipeline.identify.windows import Window
from pipeline.records.identification import ChannelQuality
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

#: Share of a window from which its first state is estimated.
LEAD_SHARE = 0.25


def prediction_quality(  # noqa: PLR0917 - as many as the comparison has sides
    packed: PackedVehicle,
    vector: FloatArray,
    windows: Sequence[Window],
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    black_box: BlackBox | None,
    *,
    offsets: FloatArray | None = None,
    found: PackedVehicle | None = None,
    corrected: FloatArray | None = None,
    threads: int = 2,
) -> tuple[ChannelQuality, ...]:
    """Errors per channel of the identified vehicle and of the baselines.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle; its own vector is the baseline "vehicle file".
    vector : ndarray
        The identified parameter vector.
    windows : sequence of Window
        Windows that took no part in the fit.
    runs : sequence of RunTable
        The runs that the windows are cut from, by the windows' `run`.
    channels : sequence of ChannelNoise
        What was measured.
    black_box : BlackBox or None
        Fitted on the windows of the fit.
    offsets : ndarray, shape (runs, OFFSET_COUNT), optional
        The runs' offsets, zero otherwise.
    found : PackedVehicle, optional
        The identified vehicle, where its curves of thrust are not those of `packed`.
    corrected : ndarray, optional
        The parameter vector that a corrected vehicle file gives, with the curves of `packed`.
    """
    kept = [w for w in windows if _lead(w).readings]
    if not kept:
        return ()
    known = np.zeros((len(runs), OFFSET_COUNT)) if offsets is None else offsets
    whole = stack_windows(packed, kept, channels)
    after = packed if found is None else found
    identified = _errors(after, vector, kept, channels, known, whole, threads)
    nominal = _errors(packed, packed.vector, kept, channels, known, whole, threads)
    written: list[FloatArray] | None = None
    if corrected is not None:
        # without an unknown thrust the corrected file is the identified vehicle
        same = after is packed and np.allclose(corrected, vector, rtol=1e-12, atol=0.0)
        written = (
            identified
            if same
            else _errors(packed, corrected, kept, channels, known, whole, threads)
        )
    held = _held_errors(whole)
    learned = None if black_box is None else _black_box_errors(whole, runs, black_box)
    horizon = (1.0 - LEAD_SHARE) * float(np.mean([w.duration_s for w in kept]))
    quality = []
    for number, rows in enumerate(whole.rows):
        later = _later(whole, number)
        box = None if learned is None else learned.get(rows.channel.quantity)
        quality.append(
            ChannelQuality(
                channel=rows.channel.quantity,
                unit=rows.channel.unit,
                horizon_s=horizon,
                readings=int(later.sum()),
                sensor_noise=rows.channel.of_reading(offset=offsets is None),
                rmse_identified=_rms(identified[number][later]),
                rmse_corrected_file=None if written is None else _rms(written[number][later]),
                rmse_vehicle_file=_rms(nominal[number][later]),
                rmse_last_value=_rms(_known(held[number][later])),
                rmse_black_box=None if box is None else _rms(_known(box[later])),
            )
        )
    return tuple(quality)


def _rms(values: FloatArray) -> float | None:
    """Root mean square; None of nothing, or where a prediction ran away."""
    if not values.size or not np.isfinite(values).all():
        return None
    return float(np.sqrt(np.mean(values**2)))


def _known(values: FloatArray) -> FloatArray:
    """Rows (k, c) for which the baseline had something to start from."""
    return np.asarray(values[np.isfinite(values).all(axis=1)])


def _lead(window: Window) -> Window:
    return window.lead(round(LEAD_SHARE * len(window.command)))


def _later(stack: WindowStack, number: int) -> BoolArray:
    """Which readings of a channel lie beyond the lead, (k,)."""
    rows = stack.rows[number]
    lengths = np.array([len(w.command) for w in stack.windows])
    inside = rows.sample - stack.begins[rows.window]
    return np.asarray(inside > np.round(LEAD_SHARE * lengths[rows.window]))


def _errors(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    vector: FloatArray,
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    offsets: FloatArray,
    whole: WindowStack,
    threads: int,
) -> list[FloatArray]:
    """Estimate the starts from the lead, then predict all of each window."""
    leads = [_lead(one) for one in windows]
    starts = lead_starts(packed, vector, leads, channels, offsets=offsets, threads=threads)
    if starts is None:
        return [np.full((rows.sample.size, 1), np.nan) for rows in whole.rows]
    return innovations(replace(whole, packed=packed), vector, starts, offsets)


def _held_errors(stack: WindowStack) -> list[FloatArray]:
    """Errors of holding the last reading of the lead; NaN where it has none."""
    found = []
    for number, rows in enumerate(stack.rows):
        index = np.arange(rows.sample.size)
        last = np.maximum.accumulate(np.where(_later(stack, number), -1, index))
        errors = difference(rows.channel.quantity, rows.measured, rows.measured[last])
        errors[(last < 0) | (rows.window[last] != rows.window)] = np.nan
        found.append(errors)
    return found


def difference(quantity: str, measured: FloatArray, predicted: FloatArray) -> FloatArray:
    """Measured minus predicted; for attitude the body rotation between them."""
    if quantity != "attitude":
        return np.asarray(measured - predicted)
    return turn_between(np.broadcast_to(predicted, measured.shape), measured)


def _black_box_errors(
    stack: WindowStack, runs: Sequence[RunTable], box: BlackBox
) -> dict[str, FloatArray]:
    """Errors of the black box, started from the last samples of each lead."""
    found = {rows.channel.quantity: np.full_like(rows.measured, np.nan) for rows in stack.rows}
    for number, w in enumerate(stack.windows):
        end_s = w.begin_s + w.duration_s
        forecast = box.predict(runs[w.run], w.begin_s + LEAD_SHARE * w.duration_s, end_s)
        for rows in stack.rows:
            quantity, own = rows.channel.quantity, rows.window == number
            if forecast is not None and quantity in forecast.values:
                time_s = w.begin_s + stack.into_s(rows)[own]
                found[quantity][own] = forecast.at(quantity, time_s)
    return {
        rows.channel.quantity: difference(rows.channel.quantity, rows.measured, predicted)
        for rows in stack.rows
        if np.isfinite(predicted := found[rows.channel.quantity]).any()
    }


def lead_starts(
    packed: PackedVehicle,
    vector: FloatArray,
    leads: Sequence[Window],
    channels: Sequence[ChannelNoise],
    *,
    offsets: FloatArray | None = None,
    threads: int = 2,
) -> FloatArray | None:
    """Estimate first states (windows, STATE); None where the model runs away within a lead.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle.
    vector : ndarray
        Its parameter vector.
    leads : sequence of Window
        First parts of the windows, each with readings.
    channels : sequence of ChannelNoise
        What was measured.
    offsets : ndarray, shape (runs, OFFSET_COUNT), optional
        The runs' known offsets, zero otherwise.
    threads : int
        Simulations at a time.
    """
    stack = stack_windows(packed, leads, channels)
    if offsets is not None:
        stack = _shifted(stack, offsets)
    shared = run_nuisance(stack, 1 + max(one.run for one in leads), offsets=False)
    problem = FitProblem(stack, (), vector, shared, threads)
    try:
        fitted = solve(problem, smallest_gain=0.5)
    except (CannotComputeError, np.linalg.LinAlgError):
        return None
    return problem.starts(fitted.point.starts)


def _shifted(stack: WindowStack, offsets: FloatArray) -> WindowStack:
    """Take the runs' known offsets off the readings."""
    run_of = np.array([w.run for w in stack.windows])
    rows = [
        replace(one, measured=one.measured - offsets[run_of[one.window], OFFSETS[quantity]])
        if (quantity := one.channel.quantity) in OFFSETS
        else one
        for one in stack.rows
    ]
    return replace(stack, rows=tuple(rows))
