"""Weights of readings: by the noise of their channel, and of their window where it has its own."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.diagnose.asking.run_marginals import departures_of
from pipeline.diagnose.linear.elimination import Solution
from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.types import FloatArray

#: Root mean square of a window's whitened readings from which its noise is its own.
_OF_WINDOW = 1.4
#: Beyond this many (widened) standard deviations a reading counts for less.
_OUTLIER = 4.0


def residual_left(model: LinearModel, best: Solution, departures: FloatArray) -> FloatArray:
    """Weighted residual (rows,) of the linear model; departures (d,), or of each run (runs, d)."""
    setting = model.setting
    count, extra = setting.shared.size, setting.extra.shape[1]
    window = setting.shared.window
    own = np.concatenate([best.starts, best.forces], axis=1)[window]
    found = model.readings - np.einsum("rk,rk->r", model.local, own)
    found -= setting.shared.whitened(best.shared[:count]) * setting.row_scale
    found -= model.extra[:, :extra] @ best.shared[count:]
    columns = departures_of(model)
    if departures.ndim == 1:
        return np.asarray(found - columns @ departures)
    run = np.array([one.run for one in setting.bench.stack.windows])
    of_row = np.searchsorted(np.unique(run), run)[window]
    for number, at in enumerate(departures):
        mine = of_row == number
        found[mine] -= columns[mine] @ at
    return np.asarray(found)


def widened_by_window(
    model: LinearModel, residual: FloatArray, factors: Mapping[str, float]
) -> LinearModel:
    """Weigh readings by their channel's noise, windows by theirs, and outliers so they do no harm.

    A window in which the readings contradict each other (a vehicle that tumbles faster than a
    camera sees) has more noise than its channel: there it is what the residual shows, as in a
    normal distribution whose variance differs from block to block (Student's t; Lange, Little and
    Taylor 1989, J. Am. Stat. Assoc. 84, 881-896). `residual` (rows,) is that with the outside force
    free, so that what a model lacks is no noise.
    """
    stack, window = model.setting.bench.stack, model.setting.shared.window
    weight = np.ones(residual.size)
    count = model.setting.bench.window_count
    for number, rows in enumerate(stack.rows):
        own = stack.owner == number
        factor = factors.get(rows.channel.quantity, 1.0)
        size = np.minimum(np.abs(residual[own]) / factor, _OUTLIER * _OF_WINDOW)
        number_of = np.maximum(np.bincount(window[own], minlength=count), 1)
        rms = np.sqrt(np.bincount(window[own], size**2, minlength=count) / number_of)
        rms = np.where(rms > _OF_WINDOW, rms, 1.0)
        # clipped where all of a window is far off: then by the median
        for one in np.flatnonzero(rms > _OF_WINDOW * 2.0):
            inside = window[own] == one
            rms[one] = max(rms[one], 1.4826 * np.median(np.abs(residual[own][inside])) / factor)
        weight[own] /= factor * rms[window[own]]
    size = np.abs(residual) * weight
    weight *= np.sqrt(_OUTLIER / np.maximum(size, _OUTLIER))
    return weighed(model, weight)


def weighed(model: LinearModel, weight: FloatArray) -> LinearModel:
    """Weigh the readings by further weights (rows,)."""
    return replace(
        model,
        setting=replace(model.setting, row_scale=model.setting.row_scale * weight),
        local=model.local * weight[:, None],
        shared=model.shared * weight[:, None],
        extra=model.extra * weight[:, None],
        departures=model.departures * weight[:, None],
        rest=model.rest * weight[:, None],
        readings=model.readings * weight,
        residual=model.residual * weight,
    )
