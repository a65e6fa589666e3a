"""Part three of the answer: how far the gap shrinks on what took no part."""

from collections.abc import Mapping

import numpy as np

from pipeline.diagnose.gap.forecast import AHEAD_S, Forecast, rms
from pipeline.records.diagnosis import Shrink, ShrinkFigures
from pipeline.types import BoolArray, FloatArray, IntArray

#: Resamplings of the held-out windows, in blocks of so many: what is predicted of one reaches into
#: the next.
_RESAMPLINGS, _BLOCK = 400, 2


def shrink(  # noqa: PLR0917 - one caller
    before: Forecast,
    after: Forecast,
    spread: Mapping[str, FloatArray],
    held_out: BoolArray,
    told: str,
    seed: int = 0,
    spread_after: Mapping[str, FloatArray] | None = None,
    within_s: float = AHEAD_S,
) -> Shrink:
    """Held-out gap before and after, by channel and over all.

    Over all, a channel's errors count in units of its healthy floor, so the floor is 1; the
    interval is of a bootstrap over windows, none where fewer than two were held out. Readings
    further ahead than `within_s` do not count: where a window is held out between others, what is
    predicted beyond its end took part.

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
        own = held_out[before.window[name]] & (before.ahead_s[name] <= within_s)
        own &= np.isfinite(before.errors[name]) | np.isfinite(after.errors[name])
        if not own.any():
            # nothing of it can be predicted
            continue
        floor = before.healthy_floor(name, spread, own)
        later = floor if spread_after is None else after.healthy_floor(name, spread_after, own)
        later = max(floor, later)
        owner = before.window[name][own]
        counts[row] = np.bincount(owner, minlength=windows)
        errors = before.counted(name, own, floor), after.counted(name, own, later)
        for key, one, unit in zip(sums, errors, (floor, later), strict=True):
            sums[key][row] = np.bincount(owner, (one / unit) ** 2, minlength=windows)
        first, second = rms(errors[0]), rms(errors[1])
        channels[name] = ShrinkFigures(
            before=first,
            after=second,
            noise_floor=floor,
            gap_closed=_closed(first / floor, second / later),
            ci95=None,
            noise_floor_after=later if later > floor else None,
        )

    def overall(key: str, weights: FloatArray) -> float:
        size = counts @ weights
        known = size > 0.0
        total = (sums[key] @ weights)[known] / size[known]
        return float(np.sqrt(np.mean(total))) if total.size else 0.0

    ones = held_out.astype(float)
    first, second = overall("before", ones), overall("after", ones)
    places = np.flatnonzero(held_out)
    generator = np.random.default_rng(seed)
    closed = []
    # of one window, or none, there is nothing to draw from
    for _ in range(_RESAMPLINGS if places.size > 1 else 0):
        drawn = np.bincount(_blocks(generator, places), minlength=windows).astype(float)
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


def _blocks(generator: np.random.Generator, places: IntArray) -> IntArray:
    """Draw as many windows as there are, neighbours together (moving blocks, Kunsch 1989).

    Of so few that they make one block each is drawn by itself: one block would be all of them.
    """
    length = min(_BLOCK, max(places.size // 2, 1))
    firsts = generator.integers(0, places.size - length + 1, -(-places.size // length))
    drawn: IntArray = places[(firsts[:, None] + np.arange(length)).ravel()]
    return drawn[: places.size]


def _closed(before: float, after: float) -> float | None:
    """Share of what is above the floor of 1 that is gone; None where there is next to nothing."""
    return (before - after) / (before - 1.0) if before > 1.1 else None
