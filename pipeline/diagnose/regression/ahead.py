"""By how much the learned response is off of runs ahead in time, beside sound ones left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.regression.grid import CHANNELS, GridRun
from pipeline.diagnose.regression.held_out import by_response, followed, starts
from pipeline.diagnose.regression.known import Reference
from pipeline.physics.window_sums import sums_over
from pipeline.records.diagnosis import ChannelGap, GapFigures
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Errors are told of the change within this, and of the velocity so far ahead. [s]
AHEAD_S, HORIZONS_S = 1.0, (0.5, 2.0, 10.0)


@dataclass(frozen=True)
class Errors:
    """What a response is off by: of each asked run (k, c), and its root mean square (c,).

    `floors` (c,) is that of runs that show what is ordinary.
    """

    each: tuple[FloatArray, ...]
    rms: FloatArray
    floors: FloatArray


def summed(values: FloatArray, period_s: float) -> FloatArray:
    """Add one-step remainders (k, c) up over `AHEAD_S`."""
    count = max(round(AHEAD_S / period_s), 1)
    first = np.arange(len(values) - count + 1)
    return sums_over(values, first, first + count)


def rms_of(values: Sequence[FloatArray]) -> FloatArray:
    """Take the root mean square (c,) of errors (k, c) of several runs."""
    every = np.concatenate(list(values))
    return np.sqrt(np.mean(np.square(every), axis=0)) if len(every) else np.zeros(every.shape[1])


def errors_of(known: Reference, runs: Sequence[GridRun]) -> Errors:
    """Return the errors of runs, `AHEAD_S` ahead."""
    response, none = known.best.response, np.zeros(len(known.directions))
    period_s = response.period_s
    each = tuple(summed(response.after(run, none)[1], period_s) for run in runs)
    floors = floors_of(known)
    return Errors(each, rms_of(each), floors)


def floors_of(known: Reference) -> FloatArray:
    """Root mean square error (c,) of runs that show what is ordinary, `AHEAD_S` ahead."""
    response, none = known.best.response, np.zeros(len(known.directions))
    left = [response.after(one.run, none, left_out=one.left_out)[1] for one in known.best.usual]
    return np.maximum(rms_of([summed(one, response.period_s) for one in left]), 1e-9)


def channel_gaps(
    errors: Errors, known: Reference, runs: Sequence[GridRun], sensors: Sensors | None
) -> dict[str, ChannelGap]:
    """Gap of every channel `AHEAD_S` ahead, and by horizon."""
    response = known.best.response
    asked = [_followed(known, run, None) for run in runs]
    sound = [_followed(known, one.run, one.left_out) for one in known.best.usual]
    found = {}
    for c, name in enumerate(response.channels):
        noise = _noise_of(sensors, name)
        by_horizon = {}
        for ahead_s in HORIZONS_S:
            own, floor = (
                float(rms_of([one[ahead_s][:, c : c + 1] for one in every])[0])
                for every in (asked, sound)
            )
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


def _followed(known: Reference, run: GridRun, left_out: int | None) -> dict[float, FloatArray]:
    response = known.best.response
    return followed(by_response(response, left_out), run, starts(run), HORIZONS_S)


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
