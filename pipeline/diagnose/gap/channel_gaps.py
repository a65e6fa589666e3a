"""Part one of the answer: how large the gap is by channel and horizon, against its two floors."""

from collections.abc import Collection, Mapping

import numpy as np

from pipeline.diagnose.gap.forecast import CHANNELS, Forecast, counted, rms
from pipeline.records.diagnosis import ChannelGap, GapFigures
from pipeline.types import FloatArray

#: Seconds ahead, and the width of the slice of errors around it.
HORIZONS = {"0.5": (0.5, 0.25), "2": (2.0, 0.5), "10": (10.0, 1.0)}
UNITS = {name: unit for parts in CHANNELS.values() for name, unit in parts}
#: A channel whose error is this many times its healthy floor carries a gap.
GAP_RATIO = 1.5


def figures(errors: FloatArray, spread: FloatArray, sensor: float) -> GapFigures:
    """Error and floors of some readings (k,): `spread` is the healthy mean square of the motion."""
    healthy = float(np.sqrt(np.mean(spread) + sensor**2)) if spread.size else sensor
    error = rms(counted(errors, healthy))
    return GapFigures(
        rmse=error, sensor_floor=sensor, healthy_floor=healthy, ratio=error / max(healthy, 1e-12)
    )


def channel_gaps(
    near: Forecast,
    near_spread: Mapping[str, FloatArray],
    whole: Forecast,
    whole_spread: Mapping[str, FloatArray],
) -> dict[str, ChannelGap]:
    """Gap of every channel: `near` some seconds ahead of every window, `whole` from the start."""
    found = {}
    for name, errors in near.errors.items():
        sensor, spread, ahead = near.sensor[name], near_spread[name], near.ahead_s[name]
        by_horizon = {}
        for label, (middle, half) in HORIZONS.items():
            inside = np.abs(ahead - middle) <= half
            if inside.any():
                by_horizon[label] = figures(errors[inside], spread[inside], sensor)
        if name in whole.errors:
            by_horizon["run"] = figures(whole.errors[name], whole_spread[name], sensor)
        total = figures(errors, spread, sensor)
        found[name] = ChannelGap(**total.model_dump(), unit=UNITS[name], horizons=by_horizon)
    return found


def worst_gap(
    near: Forecast, spread: Mapping[str, FloatArray], among: Collection[str] | None = None
) -> float:
    """Error of the worst channel over its healthy floor, of all or `among` some."""
    return max(
        (
            figures(errors, spread[name], near.sensor[name]).ratio
            for name, errors in near.errors.items()
            if among is None or name in among
        ),
        default=0.0,
    )


def gap_channels(found: Mapping[str, ChannelGap]) -> tuple[str, ...]:
    """Channels that carry the gap, the largest ratio first; the worst alone may be below all."""
    carrying = [name for name, one in found.items() if one.ratio >= GAP_RATIO]
    largest = max((one.ratio for one in found.values()), default=0.0)
    # what is far smaller than the worst goes along with it
    carrying = [name for name in carrying if found[name].ratio >= 0.25 * largest]
    return tuple(sorted(carrying, key=lambda name: -found[name].ratio))


def shown_channels(found: Mapping[str, ChannelGap]) -> tuple[str, ...]:
    """Channels to be looked at, the largest ratio first: all with an error above a healthy one's.

    >>> shown_channels({})
    ()
    """
    first = sorted(found, key=lambda name: -found[name].ratio)
    return tuple(name for number, name in enumerate(first) if not number or found[name].ratio > 1.0)
