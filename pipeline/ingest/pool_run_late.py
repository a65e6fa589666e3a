"""Whether channels that tell one motion tell it at one time: a topic may come seconds late.

Each pair is what one channel reads and what others make of it, over a second: rates and the turning
of the attitude, a velocity and the way of depth, of position, or what the accelerometer feels of
its change.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_down import turning
from pipeline.ingest.pool_run_resample import TABLE_HZ, into_body
from pipeline.ingest.pool_run_score import mean_over
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable, down_axis
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: Shorter runs, and what lags less, say nothing: filters of sensors take that long. [s]
_SHORTEST_S, _LEAST_LAG_S, _MOST_LAG_S = 20.0, 0.4, 6.0
#: With its lag taken off a channel leaves at most so much of another, and of what it left before;
#: which is little where sensors stand apart on a vehicle that turns.
_LEFT_AT_MOST, _MOST_LEFT, _LITTLE = 0.36, 0.5, 0.06
#: Lags of the halves of a run agree. [s]
_ALIKE_S = 0.45
#: Less motion is noise. [m/s, m/s2 or rad/s]
_LEAST_MOTION = 0.01


@dataclass(frozen=True)
class Pair:
    """What a channel reads (n, k), what others make of it, and in which rows (n,) both are known.

    `of` and `by` are the channels that are compared first of all.
    """

    of: str
    by: str
    read: FloatArray
    made: FloatArray
    rows: BoolArray


@dataclass(frozen=True)
class Late:
    """How much later [s] a motion tells another, what is left of it then, and as the times are."""

    lag_s: float
    left: float
    left_as_it_is: float


def pairs_of(run: PoolRun, table: RunTable, gravity_mps2: float) -> Iterator[Pair]:
    """Yield the pairs of a run, on the rows of its table."""
    values, valid = table.values, table.valid
    attitude, velocity, rate = (
        values.get(name) for name in ("attitude", "velocity", "angular_velocity")
    )
    if attitude is None:
        return
    own = "velocity" if "velocity" in run.channels else "velocity_earth"
    if rate is not None:
        rows = valid["attitude"] & valid["angular_velocity"]
        yield Pair("angular_velocity", "attitude", rate, turning(attitude, TABLE_HZ), rows)
    if velocity is None:
        return
    there = valid["attitude"] & valid["velocity"]
    over_earth = into_body(velocity, attitude * [1.0, -1.0, -1.0, -1.0])
    for by, axes in (("depth", slice(2, 3)), ("position", slice(0, 2))):
        if by in values:
            change = np.gradient(values[by][:, : axes.stop - axes.start], axis=0) * TABLE_HZ
            yield Pair(own, by, over_earth[:, axes], change, there & valid[by])
    if "specific_force" in values and own == "velocity":
        felt = values["specific_force"] + gravity_mps2 * down_axis(attitude)
        change = np.gradient(velocity, axis=0) * TABLE_HZ
        if rate is not None:
            change += np.cross(rate, velocity)
        yield Pair(own, "specific_force", change, felt, there & valid["specific_force"])


def lags(run: PoolRun, table: RunTable, vehicle: Vehicle) -> Iterator[Problem]:
    """Say which channels tell the motion of others at another time."""
    if run.duration_s < _SHORTEST_S or "attitude" not in run.channels:
        return
    for pair in pairs_of(run, table, vehicle.water.gravity_mps2):
        late = _late(pair)
        if late is None:
            continue
        names = (pair.of, pair.by) if late.lag_s > 0.0 else (pair.by, pair.of)
        topics = [run.channels[name].topic for name in names]
        if topics[0] == topics[1]:
            continue
        yield run.place.warning(
            f"{names[0]} ({topics[0]}) is {abs(late.lag_s):.1f} s behind {names[1]} ({topics[1]}): "
            f"with that taken off it explains {100 * (1 - late.left):.0f} % of that motion, as the "
            f"times are {100 * (1 - late.left_as_it_is):.0f} %.",
            remedy="Check the clocks of both; state clock or delay_s under pool: channels in "
            "vehicle.yaml.",
        )


def _late(pair: Pair) -> Late | None:
    rows = pair.rows & np.isfinite(pair.read).all(axis=1) & np.isfinite(pair.made).all(axis=1)
    if rows.sum() < _SHORTEST_S * TABLE_HZ:
        return None
    both = [
        mean_over(np.where(rows[:, None], one - one[rows].mean(axis=0), 0.0), round(TABLE_HZ))
        for one in (pair.read, pair.made)
    ]
    if min(one.std() for one in both) < _LEAST_MOTION:
        return None
    late = late_by(both[0], both[1], TABLE_HZ)
    if (
        late is None
        or abs(late.lag_s) < _LEAST_LAG_S
        or late.left_as_it_is < _LITTLE
        or late.left > min(_LEFT_AT_MOST, _MOST_LEFT * late.left_as_it_is)
    ):
        return None
    return late


def late_by(one: FloatArray, other: FloatArray, rate_hz: float) -> Late | None:
    """Return by how much one motion (n, k) is behind another; None where the halves differ.

    Each component has a gain of its own, which is not negative.
    """
    most = round(_MOST_LAG_S * rate_hz)
    half = len(one) // 2
    if half < 4 * most:
        return None
    whole = _explained(one, other, most)
    best = int(whole.argmax())
    for part in (slice(0, half), slice(half, None)):
        own = int(_explained(one[part], other[part], most).argmax())
        if abs(own - best) > _ALIKE_S * rate_hz:
            return None
    return Late((best - most) / rate_hz, 1.0 - float(whole[best]), 1.0 - float(whole[most]))


def _explained(one: FloatArray, other: FloatArray, most: int) -> FloatArray:
    """Return the share of a motion that another one explains, from so many rows before it on."""
    from scipy.signal import correlate

    middle = len(one) - 1
    power, size = (one**2).sum(axis=0), (other**2).sum(axis=0)
    found = np.zeros(2 * most + 1)
    for axis in np.flatnonzero((power > 0.0) & (size > 1e-4 * size.max())):
        along = correlate(one[:, axis], other[:, axis], mode="full", method="fft")
        found += np.maximum(along[middle - most : middle + most + 1], 0.0) ** 2 / size[axis]
    return np.asarray(found / max(float(power.sum()), 1e-12))
