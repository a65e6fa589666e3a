"""Find the straight stretches of a run: motion along one body axis without turning or tilting."""

from dataclasses import dataclass

import numpy as np

from pipeline.identify.manoeuvre_signals import stretches
from pipeline.identify.smoothing import moving_average, smooth
from pipeline.records.run_components import angles
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Largest angular rate about any axis, after a mean over so long. [rad/s], [s]
TURN_RATE_RADPS, MEAN_S = 0.03, 0.5
#: Largest speed across the axis over that along it, or the speed, if that is more. [1], [m/s]
DRIFT, DRIFT_MPS = 0.10, 0.03
#: Largest roll and pitch. [rad]
TILT_RAD = 0.10
#: Shorter stretches are left out. [s]
SHORTEST_S = 4.0


@dataclass(frozen=True)
class Stretch:
    """Samples [begin, end) of a run's table, and how straight they are."""

    begin: int
    end: int
    largest_turn_rate_radps: float
    largest_drift: float


def straight_stretches(run: RunTable, velocity: FloatArray, axis: int) -> list[Stretch]:
    """Find stretches along one axis.

    Parameters
    ----------
    run : RunTable
        With angular velocity; roll and pitch are judged where attitude was measured.
    velocity : ndarray, shape (m, 3)
        Of the body origin, body axes; NaN where unknown. [m/s]
    axis : int
        0 surge, 1 sway, 2 heave.

    Returns
    -------
    list of Stretch
        In the order of time.
    """
    period = run.period_s
    samples = 2 * max(round(MEAN_S / period / 2), 1) + 1
    rate = np.where(run.valid["angular_velocity"][:, None], run.values["angular_velocity"], np.nan)
    steady = smooth(rate, moving_average(samples, period))
    turning = np.max(np.abs(steady.value), axis=1)
    known = np.where(np.isfinite(velocity).all(axis=1, keepdims=True), velocity, 0.0)
    along = np.abs(known[:, axis])
    across = np.max(np.abs(np.delete(known, axis, axis=1)), axis=1)
    straight = (
        run.valid["command"]
        & steady.valid
        & np.isfinite(velocity).all(axis=1)
        & (turning <= TURN_RATE_RADPS)
        & (across <= np.maximum(DRIFT * along, DRIFT_MPS))
        & _level(run)
    )
    found = []
    for begin, end in stretches(straight):
        if (end - begin) * period < SHORTEST_S:
            continue
        moving = along[begin:end] > DRIFT_MPS
        drift = across[begin:end][moving] / along[begin:end][moving]
        found.append(
            Stretch(
                begin,
                end,
                float(turning[begin:end].max()),
                float(drift.max(initial=0.0)),
            )
        )
    return found


def _level(run: RunTable) -> BoolArray:
    if "attitude" not in run.values:
        return np.ones(run.time_s.size, bool)
    tilt = np.abs(angles(run.values["attitude"])[:, :2]).max(axis=1)
    return np.asarray(run.valid["attitude"] & (tilt <= TILT_RAD))
