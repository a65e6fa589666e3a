"""By how much the learned response is off of runs ahead in time, beside sound ones left out.

What is ordinary is taken off all of them: trim that a healthy vehicle may have is no gap.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.grid import CHANNELS, GridRun
from pipeline.diagnose.regression.held_out import by_response, followed, starts
from pipeline.diagnose.regression.known import Learned, ToldRun
from pipeline.physics.window_sums import sums_over
from pipeline.records.diagnosis import ChannelGap, GapFigures
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: Errors are told of the change within this, and of the velocity so far ahead. [s]
AHEAD_S, HORIZONS_S = 1.0, (0.5, 2.0, 10.0)


@dataclass(frozen=True)
class Errors:
    """What a response is off by: of each asked run (k, c), and its root mean square (c,).

    `floors` (c,) is that of a run that shows what is ordinary.
    """

    each: tuple[FloatArray, ...]
    rms: FloatArray
    floors: FloatArray


def summed(values: FloatArray, period_s: float) -> FloatArray:
    """Add one-step remainders (k, c) up over `AHEAD_S`."""
    count = max(round(AHEAD_S / period_s), 1)
    first = np.arange(len(values) - count + 1)
    return sums_over(values, first, first + count)


def typical(runs: Sequence[FloatArray]) -> FloatArray:
    """Root mean square error (c,) of a run (k, c) as most are: one that is off makes no floor."""
    each = [np.log(np.maximum(rms_of([one]), 1e-9)) for one in runs if len(one)]
    return np.exp(np.mean(each, axis=0)) if each else np.zeros(runs[0].shape[1])


def rms_of(values: Sequence[FloatArray]) -> FloatArray:
    """Take the root mean square (c,) of errors (k, c) of several runs."""
    every = np.concatenate(list(values))
    return np.sqrt(np.mean(np.square(every), axis=0)) if len(every) else np.zeros(every.shape[1])


def error_of(learned: Learned, run: ToldRun, change: FloatArray | None = None) -> FloatArray:
    """Errors (k, c) of a run `AHEAD_S` ahead, beside a change (d,) and what is ordinary."""
    return summed(learned.after(run, change)[2], learned.response.period_s)


def errors_of(learned: Learned, runs: Sequence[ToldRun]) -> Errors:
    """Return the errors of runs, `AHEAD_S` ahead."""
    each = tuple(error_of(learned, run) for run in runs)
    return Errors(each, rms_of(each), floors_of(learned))


def floors_of(learned: Learned) -> FloatArray:
    """Error (c,) of a run that shows what is ordinary, `AHEAD_S` ahead."""
    return typical([error_of(learned, run) for run in learned.usual])


def channel_gaps(
    errors: Errors, learned: Learned, runs: Sequence[ToldRun], sensors: Sensors | None
) -> dict[str, ChannelGap]:
    """Gap of every channel `AHEAD_S` ahead, and by horizon."""
    asked = [_followed(learned, run) for run in runs]
    sound = [_followed(learned, run) for run in learned.usual]
    found = {}
    for c, name in enumerate(learned.response.channels):
        noise = _noise_of(sensors, name)
        by_horizon = {}
        for ahead_s in HORIZONS_S:
            own = float(rms_of([one[ahead_s] for one in asked])[c])
            floor = float(typical([one[ahead_s] for one in sound])[c])
            if own > 0.0 and floor > 0.0:
                by_horizon[f"{ahead_s:g}"] = _figures(own, floor, noise)
        total = _figures(float(errors.rms[c]), float(errors.floors[c]), noise)
        found[name] = ChannelGap(
            **total.model_dump(),
            unit=unit_of(name),
            horizons={f"{AHEAD_S:g}": total, **by_horizon},
        )
    return found


def unit_of(channel: str) -> str:
    """Return the unit of a velocity or rate."""
    return "m/s" if channel in CHANNELS[:3] else "rad/s"


def _followed(learned: Learned, one: ToldRun) -> dict[float, FloatArray]:
    """Errors so many seconds ahead; what is ordinary is as it was along the measured motion."""
    rows, bare, left = learned.after(one)
    ordinary = np.zeros_like(one.run.velocity)
    ordinary[rows] = bare - left
    step = by_response(learned.response, one.left_out)

    def differing(now: FloatArray, before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return step(now, before, run, rows) + ordinary[rows]

    return followed(differing, one.run, starts(one.run), HORIZONS_S)


def _figures(error: float, floor: float, noise: float) -> GapFigures:
    return GapFigures(rmse=error, sensor_floor=noise, healthy_floor=floor, ratio=error / floor)


def _noise_of(sensors: Sensors | None, channel: str) -> float:
    """Noise of a difference of two readings, as the file states it."""
    own = None if sensors is None else sensors.dvl if channel in CHANNELS[:3] else sensors.imu
    if own is None:
        return 0.0
    noise = getattr(own, "noise_mps", None) if channel in CHANNELS[:3] else None
    noise = getattr(own, "rate_noise_radps", 0.0) if noise is None else noise
    return float(np.sqrt(2.0) * noise)
