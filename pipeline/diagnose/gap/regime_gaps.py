"""The gap of every channel in every regime: what the heat map of the page shows."""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.diagnose.gap.forecast import Forecast, rms
from pipeline.diagnose.gap.regimes import Regressor
from pipeline.records.diagnosis import RegimeGap
from pipeline.types import FloatArray

#: Parts of each regressor's readings, by quantiles: low, middle and high.
PARTS = 3
#: Fewer readings than this say nothing of a regime.
_FEWEST = 8


def regime_gaps(
    every: Sequence[Regressor],
    near: Forecast,
    spread: Mapping[str, FloatArray],
    within_s: float,
) -> tuple[RegimeGap, ...]:
    """Root mean square error over the healthy floor, by regime and channel.

    Parameters
    ----------
    every : sequence of Regressor
        Means over each window (windows,) of what a force may depend on.
    near : Forecast
        Errors of the model as it is stated.
    spread : mapping
        Channel -> (k,): mean square of what healthy vehicles differ from it, at the same readings.
    within_s : float
        Readings further ahead than this do not count. [s]

    Returns
    -------
    tuple of RegimeGap
        Low, middle and high third of each regressor; equal thirds are joined.
    """
    found = []
    for one in every:
        known = one.values[np.isfinite(one.values)]
        if not known.size:
            continue
        edges = np.unique(np.quantile(known, np.linspace(0.0, 1.0, PARTS + 1)))
        for number in range(len(edges) - 1):
            low, high = float(edges[number]), float(edges[number + 1])
            last = number == len(edges) - 2
            above = one.values <= high if last else one.values < high
            inside = (one.values >= low) & above
            ratios = _ratios(inside, near, spread, within_s)
            if ratios:
                share = float(np.mean(inside))
                found.append(
                    RegimeGap(
                        regressor=one.name,
                        unit=one.unit,
                        range=(low, high),
                        share_of_time=share,
                        ratios=ratios,
                    )
                )
    return tuple(found)


def _ratios(
    inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    near: Forecast,
    spread: Mapping[str, FloatArray],
    within_s: float,
) -> dict[str, float]:
    """Ratio of every channel that has enough readings in the windows `inside`."""
    ratios = {}
    for name in near.errors:
        rows = inside[near.window[name]] & (near.ahead_s[name] <= within_s)
        if rows.sum() < _FEWEST:
            continue
        floor = near.healthy_floor(name, spread, rows)
        ratios[name] = rms(near.counted(name, rows, floor)) / max(floor, 1e-12)
    return ratios
