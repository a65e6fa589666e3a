"""Where the gap lies: the channels, regimes and times that the answer names."""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.diagnose.conclude.consequences import Consequence
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.gap.channel_gaps import gap_channels
from pipeline.diagnose.gap.forecast import AHEAD_S, Forecast, rms
from pipeline.diagnose.gap.regimes import excess, regime_shares, time_shares
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.records.diagnosis import Where
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Share of what the effects of the answer do in the worst channel from which they act in another.
_ACTS = 0.5


def where_told(
    seen: GapSeen,
    led_to: Consequence,
    setting: Setting,
    runs: Sequence[RunTable],
    *,
    after: Forecast | None,
    unknown: bool,
) -> Where:
    """Name where the gap lies.

    The channels that carry it, or the worst one where no effect explains what is no clear gap in
    any; then those in which the effects of the answer act most: a DVL's scale that is half a floor
    in surge is told from the motion as a whole, and the errors of surge alone do not show it. The
    regimes are those in which the effects act; of what no effect explains those in which its force
    acts, and first what that goes with; without a gap those in which the errors lie. An effect that
    `none` cannot be told from is looked for where it would act.

    Parameters
    ----------
    seen, led_to
        The gap without and with the answer.
    setting, runs
        The windows, and their runs.
    after : Forecast or None
        With the effects that are named, or stand beside `none`; None where there are none.
    unknown : bool
        No effect explains the gap, whatever else is named.
    """
    gaps, ahead, every = seen.channels, seen.ahead, seen.every
    windows = setting.bench.window_count
    carried = excess(ahead.stated, ahead.spread, windows, AHEAD_S)
    channels, by_regime = gap_channels(gaps), carried
    goes_with: dict[str, float] = {}
    if unknown:
        channels = channels or (max(gaps, key=lambda name: gaps[name].ratio),)
        by_regime, left = led_to.left_by_window, led_to.left
        if left.depends_on is not None and left.correlation is not None:
            goes_with[left.depends_on] = left.correlation
    elif after is not None and after is not ahead.stated:
        difference = made(ahead.stated, after, ahead.spread)
        size = {name: rms(values) for name, values in difference.items()}
        most = max(size.values(), default=0.0)
        acted = [name for name in size if size[name] >= max(_ACTS * most, 1e-12)]
        acted = [name for name in acted if name not in channels]
        channels = (*channels, *sorted(acted, key=lambda name: -size[name]))
        by_regime = by_window(difference, ahead.stated, windows)
    return Where(
        channels=channels,
        regimes=regime_shares(every, by_regime, goes_with),
        times=time_shares(setting.bench.stack.windows, runs, carried),
    )


def made(
    before: Forecast, after: Forecast, spread: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Difference that an answer makes to each reading, in healthy floors, by channel (k,).

    Free of the sensors' noise. Not a number where the reading is too far ahead, or where a
    simulation ran away.
    """
    found = {}
    for name, errors in before.errors.items():
        difference = errors - after.errors[name]
        own = (before.ahead_s[name] <= AHEAD_S) & np.isfinite(difference)
        if own.any():
            floor = before.healthy_floor(name, spread, own)
            found[name] = np.where(own, difference / max(floor, 1e-12), np.nan)
    return found


def by_window(difference: Mapping[str, FloatArray], near: Forecast, windows: int) -> FloatArray:
    """Mean squares of differences in each window, summed over channels (windows,)."""
    total = np.zeros(windows)
    for name, values in difference.items():
        own = np.isfinite(values)
        sums = np.bincount(near.window[name][own], values[own] ** 2, minlength=windows)
        total += sums / np.maximum(np.bincount(near.window[name][own], minlength=windows), 1)
    return total
