"""Measured, before and after over time, thinned for a picture."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.gap.forecast import CHANNELS, Forecast, Outlook
from pipeline.records.diagnosis import Series
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray

_MOST_WINDOWS, _MOST_CHANNELS = 6, 4


def series_of(  # noqa: PLR0917 - one caller
    ahead: Outlook,
    runs: Sequence[RunTable],
    before: Forecast,
    after: Forecast,
    held_out: BoolArray,
    within_s: float,
    channels: Sequence[str],
) -> tuple[Series, ...]:
    """Pieces of held-out windows, as far ahead as they took no part, in the first of some channels.

    Attitude is told as the rotation from what was measured, which is 0 therefore.
    """
    names = channels[:_MOST_CHANNELS]
    units = {name: unit for parts in CHANNELS.values() for name, unit in parts}
    measured = {}
    for rows in ahead.bench.stack.rows:
        quantity = rows.channel.quantity
        if quantity == "attitude":
            continue
        for column, (name, _) in enumerate(CHANNELS.get(quantity, ())):
            measured[name] = rows.measured[:, column]
    found = []
    for number in np.flatnonzero(held_out)[:_MOST_WINDOWS]:
        window = ahead.bench.stack.windows[number]
        for name in names:
            own = (before.window[name] == number) & (before.ahead_s[name] <= within_s)
            value = measured.get(name, np.zeros(own.size))[own]
            one, two = value - before.errors[name][own], value - after.errors[name][own]
            good = np.isfinite(one) & np.isfinite(two)
            if not good.any():
                continue
            found.append(
                Series(
                    run=runs[window.run].name,
                    channel=name,
                    unit=units[name],
                    time_s=tuple((window.begin_s + before.ahead_s[name][own][good]).tolist()),
                    measured=tuple(value[good].tolist()),
                    before=tuple(one[good].tolist()),
                    after=tuple(two[good].tolist()),
                )
            )
    return tuple(found)
