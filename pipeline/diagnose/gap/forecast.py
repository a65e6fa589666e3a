"""How far off a model is some time ahead: errors by channel from the best known starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.linear.characteristic import characteristic_profiles
from pipeline.diagnose.linear.coordinates import vector_at
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import Setting, plain, realisable
from pipeline.diagnose.linear.predictions import (
    Bench,
    innovations,
    outside_forces,
    simulate_windows,
)
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_outputs import stack_windows
from pipeline.identify.windows import Readings, Window
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray, IntArray

#: Quantity -> (name, unit) of its components in the answer.
CHANNELS: dict[str, tuple[tuple[str, str], ...]] = {
    "velocity": (("u", "m/s"), ("v", "m/s"), ("w", "m/s")),
    "angular_velocity": (("p", "rad/s"), ("q", "rad/s"), ("r", "rad/s")),
    "attitude": (("phi", "rad"), ("theta", "rad"), ("psi", "rad")),
    "depth": (("z", "m"),),
    "position": (("x", "m"), ("y", "m")),
}
#: How far ahead the gap is looked at. [s]
AHEAD_S = 10.0
#: Vehicles drawn from what is ordinary, for the healthy floor.
DRAWS = 8
#: Healthy floors that a simulation which ran away is off by.
RUN_AWAY = 30.0
_SPACING_S = 0.2


@dataclass(frozen=True)
class Forecast:
    """Errors of one model, one (k,) a channel, and where they are.

    `errors` channel -> (k,), `ahead_s` and `window` likewise.
    """

    errors: dict[str, FloatArray]
    ahead_s: dict[str, FloatArray]
    window: dict[str, IntArray]
    sensor: dict[str, float]

    def healthy_floor(self, name: str, spread: Mapping[str, FloatArray], rows: BoolArray) -> float:
        """Root mean square error of a healthy vehicle in some readings (k,) of a channel.

        `spread` is the mean square of what healthy vehicles differ from this model by, by channel.
        """
        return float(np.sqrt(np.mean(spread[name][rows]) + self.sensor[name] ** 2))

    def counted(self, name: str, rows: BoolArray, floor: float) -> FloatArray:
        """Errors of a channel in some readings (k,); see `counted`."""
        return counted(self.errors[name][rows], floor)


@dataclass(frozen=True)
class Outlook:
    """Windows that start where the runs' windows do, and last longer.

    `profiles` (steps, 6, k) as of `Setting`: forces by which healthy thrusters differ.
    """

    bench: Bench
    starts: FloatArray
    profiles: FloatArray


def outlook(
    setting: Setting,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    starts: FloatArray,
    seconds: float,
) -> Outlook:
    """Windows of `seconds` from the starts (windows, STATE), as far as the runs go."""
    windows = []
    for window, start in zip(setting.bench.stack.windows, starts, strict=True):
        run = runs[window.run]
        period = run.period_s
        stride = max(round(window.step_s / period), 1)
        begin = int(np.searchsorted(run.time_s, window.begin_s - 0.5 * period))
        last = min([*(row for row in run.changes if row > begin), run.time_s.size - 1])
        end = min(begin + round(seconds / period), last)
        end -= (end - begin) % stride
        spacing = max(round(_SPACING_S / period) // stride, 1) * stride
        index = np.arange(begin, end + 1, spacing)
        readings = {}
        for channel in channels:
            quantity = channel.quantity
            if quantity not in CHANNELS or quantity not in run.values:
                continue
            good = run.valid[quantity][index] & np.isfinite(run.values[quantity][index]).all(axis=1)
            if good.any():
                # what stands in the row is compared with the row, whenever it was read
                readings[quantity] = Readings(
                    (index[good] - begin) // stride,
                    run.values[quantity][index[good]],
                    np.zeros(int(good.sum())),
                )
        command = np.nan_to_num(run.values["command"][begin:end:stride])
        if not len(command):
            command = window.command
        outside = run.force_over(slice(begin, begin + stride * len(command), stride))
        windows.append(
            replace(window, command=command, start=start, readings=readings, outside=outside)
        )
    if not any(one.readings for one in windows):
        raise CannotComputeError("no channel of the motion was measured: there is no gap to show")
    stack = stack_windows(setting.bench.stack.packed, windows, [_plain(c) for c in channels])
    bench = replace(
        setting.bench,
        stack=stack,
        pulls=tuple(np.zeros((len(w.command), 6)) for w in windows),
    )
    packed = setting.bench.stack.packed
    profiles = characteristic_profiles(packed, stack.windows, bench.whole, setting.curves)
    return Outlook(bench, starts, profiles)


def _plain(channel: ChannelNoise) -> ChannelNoise:
    """Without wander: nothing is whitened here."""
    return replace(channel, wander=0.0)


def forecast(
    ahead: Outlook,
    vector: FloatArray,
    channels: Sequence[ChannelNoise],
    forces: FloatArray | None = None,
    curves: FloatArray | None = None,
) -> Forecast:
    """Errors of a model over the windows, with outside forces and curves (k,) that are off."""
    bench = ahead.bench
    outside = np.zeros((bench.window_count, 6 * bench.pieces)) if forces is None else forces
    pushed = outside_forces(bench, outside, 0.0)
    if curves is not None:
        pushed = pushed + ahead.profiles @ curves
    motion = simulate_windows(bench, vector, ahead.starts, pushed)
    raw = innovations(bench, vector, motion)
    errors, times, owner, sensor = {}, {}, {}, {}
    noise = {c.quantity: float(np.sqrt(c.white**2 + c.wander**2 + c.bias**2)) for c in channels}
    for rows, values in zip(bench.stack.rows, raw, strict=True):
        named = CHANNELS.get(rows.channel.quantity, ())
        for (name, _), column in zip(named, values.T, strict=False):
            errors[name] = column
            times[name] = bench.stack.into_s(rows)
            owner[name] = rows.window
            sensor[name] = noise[rows.channel.quantity]
    return Forecast(errors, times, owner, sensor)


def healthy_spread(  # noqa: PLR0917 - one caller
    ahead: Outlook,
    setting: Setting,
    prior: Prior,
    channels: Sequence[ChannelNoise],
    model: Forecast,
    seed: int,
    departures: FloatArray | None = None,
) -> dict[str, FloatArray]:
    """Mean square (k,) of what healthy vehicles would differ from a model by, by channel.

    `model` is the forecast of the nominal vehicle, or of that with some `departures` (g,).

    They lie one deviation to either side in every direction: where one direction matters most, its
    mean square is that of each (Hutchinson, A stochastic estimator of the trace, 1990).

    Raises
    ------
    CannotComputeError
        Where no vehicle can be what was drawn.
    """
    generator = np.random.default_rng(seed)
    values, vectors = np.linalg.eigh(prior.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    packed, every = setting.bench.stack.packed, setting.coordinates
    total = {name: np.zeros(one.size) for name, one in model.errors.items()}
    times = {name: np.zeros(one.size) for name, one in model.errors.items()}
    made = 0
    unit = np.tile(setting.force_unit, ahead.bench.pieces)
    middle = prior.mean if departures is None else prior.mean + departures
    for _ in range(DRAWS):
        drawn = middle + root @ generator.choice((-1.0, 1.0), len(values))
        forces = unit * generator.standard_normal((ahead.bench.window_count, unit.size))
        curves = generator.choice((-1.0, 1.0), ahead.profiles.shape[2])
        try:
            vector = vector_at(packed, every, plain(every, realisable(every, drawn)))
        except CannotComputeError:
            # no vehicle can be that: it has no buoyancy left, or no supply
            continue
        found, made = forecast(ahead, vector, channels, forces, curves), made + 1
        for name, errors in found.errors.items():
            squares = (errors - model.errors[name]) ** 2
            total[name] += np.nan_to_num(squares)
            # what ran away is no difference of nothing
            times[name] += np.isfinite(squares)
    if not made:
        raise CannotComputeError(
            "the vehicle file and the healthy runs, if there are any, lead to no vehicle that can "
            "be: none that was drawn has mass and buoyancy left. Check that they belong together: "
            "masses, volumes and the uncertainties in vehicle.yaml."
        )
    return {name: squares / np.maximum(times[name], 1.0) for name, squares in total.items()}


def counted(errors: FloatArray, floor: float) -> FloatArray:
    """Errors (k,) of which those of a simulation that ran away count as `RUN_AWAY` floors.

    >>> counted(np.array([0.2, np.nan]), 0.1)
    array([0.2, 3. ])
    """
    return np.where(np.isfinite(errors), errors, RUN_AWAY * floor)


def rms(values: FloatArray) -> float:
    """Root mean square of what is finite."""
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if good.size else 0.0


def smoothed_starts(windows: Sequence[Window], moved: FloatArray) -> FloatArray:
    """Take starts (windows, STATE) as they were moved; a window's own where that is not finite."""
    guessed = np.stack([window.start for window in windows])
    good = np.asarray(np.isfinite(moved).all(axis=1))
    return np.where(good[:, None], moved, guessed)


def whole_runs(
    setting: Setting,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    starts: FloatArray,
) -> Outlook:
    """Each run as one window, from its first start to its end."""
    windows = setting.bench.stack.windows
    owner = np.array([window.run for window in windows])
    firsts = [int(np.flatnonzero(owner == number)[0]) for number in np.unique(owner)]
    stack = replace(setting.bench.stack, windows=tuple(windows[k] for k in firsts))
    longest = max(float(run.time_s[-1]) for run in runs)
    few = replace(setting, bench=replace(setting.bench, stack=stack))
    return outlook(few, runs, channels, starts[firsts], longest)
