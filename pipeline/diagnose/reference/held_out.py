"""Predict sound runs that took no part: by the reference, and by what it has to beat."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.asking.run_marginals import of_curves, of_rest, possible, vector_with
from pipeline.diagnose.case import Case, rest_along, setting_of, windows_of
from pipeline.diagnose.gap.forecast import Outlook, outlook
from pipeline.diagnose.linear.linear_model import Point, Setting, forces_at
from pipeline.diagnose.linear.predictions import (
    Bench,
    Motion,
    innovations,
    simulate_windows,
    window_begins,
)
from pipeline.diagnose.reference.learn import Learned
from pipeline.identify.black_box import BlackBox, fit_black_box
from pipeline.identify.channel_noise import ChannelNoise, was_measured
from pipeline.identify.windows import Window
from pipeline.physics.parameters import read
from pipeline.records.reference import Prediction
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray

#: How far ahead is predicted, and how far from it a reading may lie. [s]
AHEAD_S, _NEAR_S = (3.0, 6.0), 0.3
#: Parts that are left out in turn, at most: each costs as much as the reference itself.
MOST_PARTS = 6
#: How often the forces of the rest are computed along the motion that they lead to.
_ROUNDS = 3
#: A model that runs away is off by so many times the rms error of the last value held.
_RUN_AWAY = 10.0
#: Age beyond which a reading is no last value. [s]
_FRESH_S = 1.0
_UNITS = {"velocity": "m/s", "angular_velocity": "rad/s", "position": "m"}

#: Errors (k, c) of a quantity over the readings of all windows.
_Errors = dict[str, FloatArray]
_Learn = Callable[[Sequence[RunTable], Callable[[Sequence[Window]], BoolArray] | None], Learned]


@dataclass(frozen=True)
class Part:
    """Windows that are left out together; `runs` are those that teach, None: their other half."""

    left_out: BoolArray
    runs: tuple[int, ...]
    halves: bool


@dataclass(frozen=True)
class Identified:
    """A vehicle file with identified values, and the runs that it was identified from."""

    packed: PackedVehicle
    runs: frozenset[int]


def parts_of(windows: Sequence[Window], lengths_s: Sequence[float]) -> list[Part]:
    """Say what is left out in turn.

    One run where there are three or more (several together where there are more than
    `MOST_PARTS`), half of each run otherwise.
    """
    owner = np.array([window.run for window in windows])
    count = len(lengths_s)
    if count >= 3:
        group = np.arange(count) % min(count, MOST_PARTS)
        return [
            Part(group[owner] == k, tuple(np.flatnonzero(group != k).tolist()), halves=False)
            for k in range(int(group.max()) + 1)
        ]
    begin = np.array([window.begin_s for window in windows])
    late = begin >= 0.5 * np.array(lengths_s)[owner]
    return [Part(side, tuple(range(count)), halves=True) for side in (late, ~late)]


def predictions(
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    learn: _Learn,
    *,
    identified: Identified | None = None,
    threads: int = 2,
    tell: Callable[[str], None] = lambda _: None,
) -> tuple[Prediction, ...]:
    """Predict each window by what was learned without it.

    Parameters
    ----------
    case : Case
        The vehicle.
    runs : sequence of RunTable
        Its sound runs.
    channels : sequence of ChannelNoise
        What is used of them.
    learn : callable
        Learns a reference from some of the runs, or of their windows.
    identified : Identified, optional
        The vehicle as it was identified; runs that it was identified from are not predicted by it.
    threads : int
        Simulations side by side.
    tell : callable
        Told what is done now.
    """
    setting = setting_of(case, runs, channels, threads=threads)
    windows = windows_of(case.packed, runs, channels)
    quantity = "velocity" if any(was_measured(run, "velocity") for run in runs) else "position"
    quantities = (quantity, "angular_velocity")
    ahead = _outlook_of(setting, case.packed, windows, runs, channels)
    found: dict[str, _Errors] = {
        "reference": {},
        "vehicle file": _errors(ahead.bench, case.packed.vector, _plainly(ahead, case.packed)),
        "last value": _of_last_values(ahead.bench, runs),
        "black box": {},
    }
    if identified is not None:
        other = _outlook_of(
            setting,
            identified.packed,
            windows_of(identified.packed, runs, channels),
            runs,
            channels,
        )
        motion = _plainly(other, identified.packed)
        own = _errors(other.bench, identified.packed.vector, motion)
        known = np.array([window.run in identified.runs for window in windows])
        found["identified file"] = _without(other.bench, own, known)
    parts = parts_of(windows, [float(run.time_s[-1]) for run in runs])
    for number, part in enumerate(parts, 1):
        if not part.left_out.any() or part.left_out.all():
            continue
        tell(f"predicting what is left out ({number} of {len(parts)})")
        learned = _learned(part, runs, windows, learn)
        motion = _by_reference(setting, ahead, learned)
        vector = vector_with(setting, possible(setting, learned.vehicle))
        _take(found["reference"], ahead.bench, _errors(ahead.bench, vector, motion), part)
        box = _black_box(case.packed, runs, windows, part)
        if box is not None:
            _take(found["black box"], ahead.bench, _of_black_box(ahead.bench, runs, box), part)
    return _table(ahead.bench, found, quantities)


def _learned(
    part: Part, runs: Sequence[RunTable], windows: Sequence[Window], learn: _Learn
) -> Learned:
    if not part.halves:
        return learn([runs[k] for k in part.runs], None)
    kept = {
        (window.run, window.begin_s)
        for window, out in zip(windows, part.left_out, strict=True)
        if not out
    }
    return learn(
        runs, lambda cut: np.array([(window.run, window.begin_s) in kept for window in cut])
    )


def _outlook_of(
    setting: Setting,
    packed: PackedVehicle,
    windows: Sequence[Window],
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
) -> Outlook:
    """Windows that start as measured: what comes later must not show in a prediction."""
    stack = replace(setting.bench.stack, packed=packed, windows=tuple(windows))
    bench = replace(setting.bench, stack=stack, drive_states={})
    starts = np.stack([window.start for window in windows])
    return outlook(replace(setting, bench=bench), runs, channels, starts, max(AHEAD_S))


def _plainly(ahead: Outlook, packed: PackedVehicle) -> Motion:
    """Motion by a vehicle file alone."""
    forces = np.zeros((len(ahead.bench.whole.commands), 6))
    return simulate_windows(ahead.bench, packed.vector, ahead.starts, forces)


def _by_reference(setting: Setting, ahead: Outlook, learned: Learned) -> Motion:
    """Motion with the learned departures; forces of the rest along the motion they lead to."""
    bench = ahead.bench
    departures = possible(setting, learned.vehicle)
    terms = learned.beliefs.terms
    count = len(setting.coordinates)
    own = replace(learned.model.setting, bench=bench, profiles=ahead.profiles)
    first = own.shared.size + own.extra.shape[1]
    curves = departures[of_curves(learned.model.setting)]
    point = Point(
        np.zeros((bench.window_count, 12)),
        np.zeros((bench.window_count, 6 * bench.pieces)),
        np.concatenate([np.zeros(first), curves]),
        departures[:count],
        departures[of_rest(learned.model.setting)],
    )
    vector = vector_with(setting, departures)
    motion = simulate_windows(bench, vector, ahead.starts, np.zeros((len(bench.whole.commands), 6)))
    for _ in range(_ROUNDS):
        along = replace(own, rest=rest_along(bench, terms, motion, setting.force_unit))
        motion = simulate_windows(bench, vector, ahead.starts, forces_at(along, point))
    return motion


def _errors(bench: Bench, vector: FloatArray, motion: Motion) -> _Errors:
    found = innovations(bench, vector, motion)
    return {
        rows.channel.quantity: values
        for rows, values in zip(bench.stack.rows, found, strict=True)
        if rows.channel.quantity in _UNITS
    }


def _times(bench: Bench, quantity: str) -> tuple[IntArray, FloatArray, FloatArray]:
    """Window, seconds ahead, and time in the run of each reading of a quantity."""
    rows = next(rows for rows in bench.stack.rows if rows.channel.quantity == quantity)
    step = np.array([window.step_s for window in bench.stack.windows])[rows.window]
    begin = np.array([window.begin_s for window in bench.stack.windows])[rows.window]
    ahead = (rows.sample - window_begins(bench)[rows.window]) * step
    return rows.window, ahead, begin + ahead


def _of_last_values(bench: Bench, runs: Sequence[RunTable]) -> _Errors:
    """Errors of what was last read before a window began."""
    found = {}
    for rows in bench.stack.rows:
        quantity = rows.channel.quantity
        if quantity not in _UNITS:
            continue
        held = np.full((bench.window_count, rows.measured.shape[1]), np.nan)
        for k, window in enumerate(bench.stack.windows):
            run = runs[window.run]
            good = run.valid[quantity] & np.isfinite(run.values[quantity]).all(axis=1)
            age = window.begin_s - run.time_s
            there = np.flatnonzero(good & (age >= -1e-6) & (age <= _FRESH_S))
            if there.size:
                held[k] = run.values[quantity][there[-1], : held.shape[1]]
        found[quantity] = rows.measured - held[rows.window]
    return found


def _black_box(
    packed: PackedVehicle, runs: Sequence[RunTable], windows: Sequence[Window], part: Part
) -> BlackBox | None:
    kept = [
        replace(window, run=part.runs.index(window.run))
        for window, out in zip(windows, part.left_out, strict=True)
        if not out
    ]
    largest = read(packed.vector, "code_max")[: len(packed.thruster_names)]
    return fit_black_box([runs[k] for k in part.runs], kept, largest)


def _of_black_box(bench: Bench, runs: Sequence[RunTable], box: BlackBox) -> _Errors:
    found = {}
    for rows in bench.stack.rows:
        quantity = rows.channel.quantity
        if quantity not in _UNITS or quantity not in box.quantities:
            continue
        owner, _, time_s = _times(bench, quantity)
        errors = np.full(rows.measured.shape, np.nan)
        for k, window in enumerate(bench.stack.windows):
            own = owner == k
            until = window.begin_s + window.duration_s
            said = box.predict(runs[window.run], window.begin_s, until) if own.any() else None
            if said is not None:
                errors[own] = rows.measured[own] - said.at(quantity, time_s[own])
        found[quantity] = errors
    return found


def _take(into: _Errors, bench: Bench, errors: _Errors, part: Part) -> None:
    """Keep the errors in the windows that were left out."""
    for quantity, values in errors.items():
        own = part.left_out[_times(bench, quantity)[0]]
        into.setdefault(quantity, np.full(values.shape, np.nan))[own] = values[own]


def _without(bench: Bench, errors: _Errors, windows: BoolArray) -> _Errors:
    """Take out the errors in some windows."""
    return {
        quantity: np.where(windows[_times(bench, quantity)[0]][:, None], np.nan, values)
        for quantity, values in errors.items()
    }


def _table(
    bench: Bench, found: Mapping[str, _Errors], quantities: Sequence[str]
) -> tuple[Prediction, ...]:
    """Rms errors over the readings that the last value and the black box speak of."""
    rows = []
    for quantity in quantities:
        last = found["last value"].get(quantity)
        if last is None:
            continue
        _, ahead, _ = _times(bench, quantity)
        box = found["black box"].get(quantity)
        for seconds in AHEAD_S:
            # a flight of physics that ran away counts; a reading that nothing was held of does not
            own = (np.abs(ahead - seconds) <= _NEAR_S) & np.isfinite(last).all(axis=1)
            if box is not None:
                own &= np.isfinite(box).all(axis=1)
            if not own.any():
                continue
            most = _RUN_AWAY * max(_rms(last[own]), 1e-9)
            for method, errors in found.items():
                rows += _row(method, quantity, seconds, errors.get(quantity), own, most)
    return tuple(rows)


def _row(  # noqa: PLR0917 - one caller
    method: str,
    quantity: str,
    seconds: float,
    errors: FloatArray | None,
    own: BoolArray,
    most: float,
) -> list[Prediction]:
    if errors is None or (method == "identified file" and not np.isfinite(errors[own]).any()):
        return []
    values = errors[own]
    if method == "identified file":
        values = values[np.isfinite(values).all(axis=1)]
    values = np.clip(np.nan_to_num(values, nan=most, posinf=most, neginf=-most), -most, most)
    return [
        Prediction.model_validate(
            {
                "method": method,
                "quantity": quantity,
                "unit": _UNITS[quantity],
                "ahead_s": seconds,
                "rmse": _rms(values),
                "readings": len(values),
            }
        )
    ]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
