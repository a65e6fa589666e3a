"""Part three of the answer: how far the gap shrinks on what took no part."""

from collections.abc import Mapping

import numpy as np

from pipeline.diagnose.gap.forecast import Forecast, rms
from pipeline.records.diagnosis import Shrink, ShrinkFigures
from pipeline.types import BoolArray, FloatArray

#: Resamplings of the held-out windows (a block each).
_RESAMPLINGS = 400


def shrink(  # noqa: PLR0917 - one caller
    before: Forecast,
    after: Forecast,
    spread: Mapping[str, FloatArray],
    held_out: BoolArray,
    told: str,
    seed: int = 0,
    spread_after: Mapping[str, FloatArray] | None = None,
) -> Shrink:
    """Held-out gap before and after, by channel and over all.

    Over all, a channel's errors count in units of its healthy floor, so the floor is 1; the
    interval is of a bootstrap over windows.

    `spread` is the mean square of what healthy vehicles differ by from the model before, and
    `spread_after` from that with the answer. Where the latter is larger the errors after count over
    it: a vehicle that turns of itself with its Coriolis terms goes further astray for the same
    errors of its parameters, and that is no gap.
    """
    windows = len(held_out)
    names = [name for name, owner in before.window.items() if held_out[owner].any()]
    sums = {"before": np.zeros((len(names), windows)), "after": np.zeros((len(names), windows))}
    counts = np.zeros((len(names), windows))
    channels = {}
    for row, name in enumerate(names):
        own = held_out[before.window[name]]
        own &= np.isfinite(before.errors[name]) & np.isfinite(after.errors[name])
        if not own.any():
            # nothing of it can be predicted
            continue
        floor = before.healthy_floor(name, spread, own)
        later = floor if spread_after is None else after.healthy_floor(name, spread_after, own)
        later = max(floor, later)
        owner = before.window[name][own]
        counts[row] = np.bincount(owner, minlength=windows)
        for key, one, unit in (("before", before, floor), ("after", after, later)):
            sums[key][row] = np.bincount(
                owner, (one.errors[name][own] / unit) ** 2, minlength=windows
            )
        first, second = rms(before.errors[name][own]), rms(after.errors[name][own])
        channels[name] = ShrinkFigures(
            before=first,
            after=second,
            noise_floor=floor,
            gap_closed=_closed(first / floor, second / later),
            ci95=None,
            noise_floor_after=later if later > floor else None,
        )

    def overall(key: str, weights: FloatArray) -> float:
        total = (sums[key] @ weights) / np.maximum(counts @ weights, 1.0)
        return float(np.sqrt(np.mean(total)))

    ones = held_out.astype(float)
    first, second = overall("before", ones), overall("after", ones)
    places = np.flatnonzero(held_out)
    generator = np.random.default_rng(seed)
    closed = []
    for _ in range(_RESAMPLINGS):
        drawn = np.bincount(generator.choice(places, places.size), minlength=windows).astype(float)
        value = _closed(overall("before", drawn), overall("after", drawn))
        if value is not None:
            closed.append(value)
    enough = len(closed) > _RESAMPLINGS // 2
    low, high = np.quantile(closed, [0.025, 0.975]) if enough else (0.0, 0.0)
    return Shrink(
        before=first,
        after=second,
        noise_floor=1.0,
        gap_closed=_closed(first, second),
        ci95=(float(low), float(high)) if enough else None,
        channels=channels,
        held_out=told,
    )


def _closed(before: float, after: float) -> float | None:
    """Share of what is above the floor of 1 that is gone; None where there is next to nothing."""
    return (before - after) / (before - 1.0) if before > 1.1 else None
