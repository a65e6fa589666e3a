"""Find the straight stretches of a run: motion along one body axis without turning or tilting."""

from dataclasses import dataclass

import numpy as np

from pipeline.identify.smoothing import moving_average, smooth
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray


@dataclass(frozen=True)
class Straightness:
    """What counts as straight.

    `turn_rate_radps`: largest angular rate about any axis after a mean over `mean_s`. `drift`:
    largest speed across the axis over the speed along it, or `drift_mps` if that is more.
    `tilt_rad`: largest roll and pitch. `shortest_s`: shorter stretches are left out.
    """

    turn_rate_radps: float = 0.03
    drift: float = 0.10
    drift_mps: float = 0.03
    tilt_rad: float = 0.10
    mean_s: float = 0.5
    shortest_s: float = 4.0


@dataclass(frozen=True)
class Stretch:
    """Samples [begin, end) of a run's table, and how straight they are."""

    begin: int
    end: int
    largest_turn_rate_radps: float
    largest_drift: float


def straight_stretches(
    run: RunTable, velocity: FloatArray, axis: int, limits: Straightness | None = None
) -> list[Stretch]:
    """Find stretches along one axis.

    Parameters
    ----------
    run : RunTable
        With angular velocity; roll and pitch are judged where attitude was measured.
    velocity : ndarray, shape (m, 3)
        Of the body origin, body axes; NaN where unknown. [m/s]
    axis : int
        0 surge, 1 sway, 2 heave.
    limits : Straightness, optional
        Thresholds.

    Returns
    -------
    list of Stretch
        In the order of time.
    """
    bounds = Straightness() if limits is None else limits
    period = float(np.median(np.diff(run.time_s)))
    samples = 2 * max(round(bounds.mean_s / period / 2), 1) + 1
    rate = np.where(run.valid["angular_velocity"][:, None], run.values["angular_velocity"], np.nan)
    steady = smooth(rate, moving_average(samples, period), 0.0)
    turning = np.max(np.abs(steady.value), axis=1)
    known = np.where(np.isfinite(velocity).all(axis=1, keepdims=True), velocity, 0.0)
    along = np.abs(known[:, axis])
    across = np.max(np.abs(np.delete(known, axis, axis=1)), axis=1)
    straight = (
        run.valid["command"]
        & steady.valid
        & np.isfinite(velocity).all(axis=1)
        & (turning <= bounds.turn_rate_radps)
        & (across <= np.maximum(bounds.drift * along, bounds.drift_mps))
        & _level(run, bounds.tilt_rad)
    )
    edges = np.flatnonzero(np.diff(np.concatenate([[0], straight.astype(int), [0]])))
    found = []
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if (end - begin) * period < bounds.shortest_s:
            continue
        moving = along[begin:end] > bounds.drift_mps
        drift = across[begin:end][moving] / along[begin:end][moving]
        found.append(
            Stretch(
                int(begin),
                int(end),
                float(turning[begin:end].max()),
                float(drift.max(initial=0.0)),
            )
        )
    return found


def _level(run: RunTable, tilt_rad: float) -> BoolArray:
    if "attitude" not in run.values:
        return np.ones(run.time_s.size, bool)
    w, x, y, z = run.values["attitude"].T
    pitch = np.arcsin(np.clip(2 * (w * y - x * z), -1, 1))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return np.asarray(
        run.valid["attitude"] & (np.abs(pitch) <= tilt_rad) & (np.abs(roll) <= tilt_rad)
    )
