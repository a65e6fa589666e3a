"""How much an effect moves a measured channel, in floors: what healthy runs differ by.

What a healthy vehicle does is learned from its runs. For every velocity that was measured the
change over a second is regressed (ridge) on the velocities, their products and squares, the
attitude and the acceleration that the thrusters mean by the mass matrix, in both halves of the
second. A run that took no part is off by a remainder e. An effect has a signature s in each run:
what the regression makes of the force that the effect claims. The part of e that lies along s is
what a healthy run looks like it had of the effect. The floor of a channel is the scatter of that
part between the healthy runs, with its statistical error, and the size of an effect in a run is the
rms of its signature over it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.measured.inject import injected, thrust_wrench
from pipeline.measured.motion import measured_motion
from pipeline.physics.window_sums import means_over
from pipeline.records.run_table import RunTable, down_axis
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

CHANNELS = ("u", "v", "w", "p", "q", "r")
#: What is predicted is the change over so long; once in so long. [s]
AHEAD_S, EVERY_S = 1.0, 0.2
#: Remainders closer than this are alike: statistics are made of blocks so long. [s]
BLOCK_S = 4.0
#: Of a regression on features of unit variance, as readings at zero that it is worth. [1]
_RIDGE = 3.0


@dataclass(frozen=True)
class HealthyScatter:
    """What healthy runs are off by, each predicted from the others.

    `remainder` holds for each run (k, 6) [m/s, rad/s], not a number where a velocity was not
    measured; `response` (2, 6) is the change within a second for an acceleration along the same
    axis in its first and its second half, by all of the runs. [s]
    """

    packed: PackedVehicle
    sensors: Sensors | None
    runs: tuple[RunTable, ...]
    remainder: tuple[FloatArray, ...]
    response: FloatArray


def healthy_scatter(
    packed: PackedVehicle, runs: Sequence[RunTable], sensors: Sensors | None = None
) -> HealthyScatter:
    """Predict each healthy run from the others."""
    if len(runs) < 2:
        raise CannotComputeError(
            f"{len(runs)} healthy run was given: what runs differ by takes two at least."
        )
    samples = [_sampled(packed, run, sensors) for run in runs]
    remainder = []
    for left_out, (features, change) in enumerate(samples):
        others = [one for number, one in enumerate(samples) if number != left_out]
        level, slope = _ridge(*map(np.concatenate, zip(*others, strict=True)))
        remainder.append(change - (level + np.einsum("kfa,fa->ka", features, slope)))
    _, slope = _ridge(*map(np.concatenate, zip(*samples, strict=True)))
    return HealthyScatter(packed, sensors, tuple(runs), tuple(remainder), slope[-2:])


def channel_floors(scatter: HealthyScatter, specs: Sequence[EffectSpec]) -> FloatArray:
    """Scatter (6,) of what healthy runs seem to have of an effect [m/s, rad/s within a second].

    The size of the effect hardly matters. Not a number where a channel was not measured or the
    effect shows in no run.
    """
    parts: list[FloatArray] = []
    for healthy, remainder in zip(scatter.runs, scatter.remainder, strict=True):
        try:
            parts.append(_along(signature(scatter, healthy, specs), remainder))
        except CannotComputeError:
            continue  # nothing of the effect would show there
    if not parts:
        return np.full(6, np.nan)
    known = np.isfinite(parts)
    squares = np.where(known, np.square(parts), 0.0).sum(axis=0)
    count = known.sum(axis=0)
    return np.asarray(np.where(count > 0, np.sqrt(squares / np.maximum(count, 1)), np.nan))


def signature(scatter: HealthyScatter, run: RunTable, specs: Sequence[EffectSpec]) -> FloatArray:
    """Return what the claimed force would change within each second, (k, 6) [m/s, rad/s]."""
    packed = scatter.packed
    motion = measured_motion(run, scatter.sensors)
    new = injected(packed, run, specs, scatter.sensors, motion=motion).run
    more = thrust_wrench(packed, new, motion) - thrust_wrench(packed, run, motion)
    return np.asarray(np.einsum("kha,ha->ka", _halves(packed, more, run), scatter.response))


def _along(signature: FloatArray, remainder: FloatArray) -> FloatArray:
    """Rms (6,) of the part of a remainder along a signature, with the error that it is known to."""
    count = len(remainder)
    edges = np.arange(0, count, max(round(BLOCK_S / EVERY_S), 1))
    out = np.full(6, np.nan)
    for axis in range(6):
        s, e = signature[:, axis], remainder[:, axis]
        power = float(s @ s)
        if not np.isfinite(e).all() or power == 0.0:
            continue
        products = np.add.reduceat(s * (e - s * (s @ e) / power), edges)
        part, error = float(s @ e), float(np.sqrt(np.sum(products**2)))
        out[axis] = np.sqrt((part**2 + error**2) / power / count)
    return out


def _times(run: RunTable) -> tuple[int, IntArray]:
    ahead, every = round(AHEAD_S / run.period_s), max(round(EVERY_S / run.period_s), 1)
    return ahead, np.arange(0, run.time_s.size - ahead, every)


def _halves(packed: PackedVehicle, wrench: FloatArray, run: RunTable) -> FloatArray:
    """Mean acceleration (k, 2, 6) by a wrench in both halves of the second from each row."""
    ahead, rows = _times(run)
    rates = np.asarray(np.linalg.solve(mass_of(packed.vector), wrench.T).T, float)
    middle = rows + ahead // 2
    halves = means_over(rates, rows, middle), means_over(rates, middle, rows + ahead)
    return np.stack(halves, axis=1)


def _sampled(
    packed: PackedVehicle, run: RunTable, sensors: Sensors | None
) -> tuple[FloatArray, FloatArray]:
    """Features (k, f, 6) of each channel and changes of the velocities within a second (k, 6)."""
    motion = measured_motion(run, sensors)
    ahead, rows = _times(run)
    nu, known = motion.nu, motion.measured
    change = nu[rows + ahead] - nu[rows]
    change[:, ~known] = np.nan
    now = nu[rows][:, known]
    first, second = np.triu_indices(now.shape[1], 1)
    down = down_axis(motion.state[rows, 3:7])
    shared = np.concatenate([now, np.abs(now) * now, now[:, first] * now[:, second], down], axis=1)
    own = _halves(packed, thrust_wrench(packed, run, motion), run)
    every = np.repeat(shared[:, :, None], 6, axis=2)
    return np.concatenate([every, own], axis=1), change


def _ridge(features: FloatArray, change: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Level (6,) and slopes (f, 6) by ridge regression, on features of unit variance."""
    mean, spread = features.mean(axis=0), features.std(axis=0)
    scale = np.where(spread > 1e-9, 1.0 / np.maximum(spread, 1e-9), 0.0)
    level, slope = change.mean(axis=0), np.zeros_like(mean)
    for axis in range(6):
        x = (features[:, :, axis] - mean[:, axis]) * scale[:, axis]
        left = x.T @ x + _RIDGE * np.eye(x.shape[1])
        found = np.linalg.solve(left, x.T @ (change[:, axis] - level[axis]))
        slope[:, axis] = scale[:, axis] * found
    return np.asarray(level - np.einsum("fa,fa->a", mean, slope)), slope
