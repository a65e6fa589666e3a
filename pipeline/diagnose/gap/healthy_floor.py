"""How much of what healthy runs differ by goes into the healthy floor: what they bear out.

The scatter between runs is found from what each half second shows (`scatter`), and on manoeuvres
that tell little of most parameters it can come out at several times what is stated. For the
evidence that is caution. A floor made of it would be ten times what the same runs are off by some
seconds ahead, and would hide any gap.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.gap.forecast import (
    AHEAD_S,
    forecast,
    healthy_spread,
    outlook,
    rms,
    smoothed_starts,
)
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import Setting, realisable, vector_of
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_derivatives import moved_starts
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Times what healthy runs are off by that their floor may be, in the middle of the channels. By
#: chance it is one to two, as outside forces are drawn that these runs did not have.
_AS_SEEN = 3.0
#: Shares of the scatter that are tried.
_SHARES = (1.0, 0.5, 0.25)


def borne_out(  # noqa: PLR0917 - one caller
    setting: Setting,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    moved: FloatArray,
    healthy: Prior,
    scatter: FloatArray,
) -> FloatArray:
    """Return the part of a scatter (g,) with which the floor is no larger than what runs show.

    Parameters
    ----------
    setting : Setting
        Windows of the healthy runs, with the outside force learned from them.
    runs, channels
        The healthy runs, and what to use of them.
    moved : ndarray, shape (windows, 12)
        By how much the starts of the windows are moved.
    healthy : Prior
        Departures of the vehicle.
    scatter : ndarray, shape (g,)
        By how much the departures of a run differ from them.
    """
    every = setting.coordinates
    starts = smoothed_starts(
        setting.bench.stack.windows, moved_starts(setting.bench.stack.starts, moved)
    )
    near = outlook(setting, runs, channels, starts, AHEAD_S)
    # readings of a vehicle that its model hardly fits may want a form of lag that nothing has
    unstated = np.where([one.effect.unstated for one in every], healthy.mean, 0.0)
    unstated = realisable(every, unstated)
    stated = forecast(near, vector_of(setting, unstated), channels)
    for share in _SHARES:
        part = share * scatter
        wide = with_scatter(healthy, every, part)
        try:
            spread = healthy_spread(near, setting, wide, channels, stated, 0)
        except CannotComputeError:
            continue
        over = [
            stated.healthy_floor(name, spread, np.isfinite(errors)) / max(rms(errors), 1e-12)
            for name, errors in stated.errors.items()
        ]
        if float(np.median(over)) <= _AS_SEEN:
            return part
    return np.zeros_like(scatter)


def with_scatter(healthy: Prior, every: Sequence[Coordinate], scatter: FloatArray) -> Prior:
    """Let stated departures (g,) of a run differ from the vehicle's by a scatter (g,) as well."""
    stated = np.array([one.ordinary > 0.0 for one in every])
    more = np.diag(np.where(stated, scatter, 0.0) ** 2)
    return replace(healthy, covariance=healthy.covariance + more)
