"""Whether the readings are as noisy as believed; a channel that is not, counts for less."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.linear.elimination import Solution
from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.types import FloatArray

#: Within these the noise model is right.
VARIANCE = (0.8, 1.2)
LAG1 = 0.1
#: A channel is not widened further: what is left then is for the verdict to explain.
_MOST = 3.0
#: Beyond this many (widened) standard deviations a reading counts for less.
_OUTLIER = 4.0


@dataclass(frozen=True)
class NoiseFound:
    """Variance and lag-1 correlation of a channel's whitened residual, and what follows."""

    variance: float
    lag1: float
    widen: float


def residual_with(model: LinearModel, best: Solution, departures: FloatArray) -> FloatArray:
    """Weighted residual (rows,) of the linear model at given unknowns."""
    setting, count = model.setting, model.setting.shared.size
    own = np.concatenate([best.starts, best.forces], axis=1)[setting.shared.window]
    found = model.readings - np.einsum("rk,rk->r", model.local, own)
    found -= setting.shared.whitened(best.shared[:count]) * setting.row_scale
    return np.asarray(found - model.extra @ best.shared[count:] - model.departures @ departures)


def noise_found(model: LinearModel, residual: FloatArray) -> dict[str, NoiseFound]:
    """Check every channel; the residual's own outliers are left out (beyond four deviations)."""
    stack, found = model.setting.bench.stack, {}
    window = model.setting.shared.window
    for number, rows in enumerate(stack.rows):
        own = stack.owner == number
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        values = residual[own].reshape(-1, width)
        inside = window[own].reshape(-1, width)[:, 0]
        spread = 1.4826 * float(np.median(np.abs(values)))
        clipped = np.clip(values, -_OUTLIER * spread, _OUTLIER * spread)
        variance = float(np.mean(clipped**2))
        joined = inside[1:] == inside[:-1]
        product = float(np.mean((clipped[1:] * clipped[:-1])[joined])) if joined.any() else 0.0
        lag1 = product / max(variance, 1e-12)
        widen = np.sqrt(max(variance, 1.0) if variance > VARIANCE[1] else 1.0)
        if lag1 > LAG1:
            widen *= np.sqrt((1.0 + lag1) / max(1.0 - lag1, 0.1))
        found[rows.channel.quantity] = NoiseFound(variance, lag1, float(min(widen, _MOST)))
    return found


def widened(model: LinearModel, residual: FloatArray, factors: dict[str, float]) -> LinearModel:
    """Weigh readings by their channel's noise, and outliers down to where they do no harm."""
    stack = model.setting.bench.stack
    weight = np.ones(residual.size)
    for number, rows in enumerate(stack.rows):
        own = stack.owner == number
        weight[own] /= factors.get(rows.channel.quantity, 1.0)
    size = np.abs(residual) * weight
    weight *= np.sqrt(_OUTLIER / np.maximum(size, _OUTLIER))
    return replace(
        model,
        setting=replace(model.setting, row_scale=model.setting.row_scale * weight),
        local=model.local * weight[:, None],
        shared=model.shared * weight[:, None],
        extra=model.extra * weight[:, None],
        departures=model.departures * weight[:, None],
        readings=model.readings * weight,
        residual=model.residual * weight,
    )
