"""What two channels say of one motion: one comparison for all pairs of a run.

A pair is what a channel reads and what another makes of it: rates and the turning of the attitude,
or of gravity; a velocity and the rate of depth and position; its changes, or those of a depth, and
what the accelerometer feels. Over a second each, they go together and are about as large, at one
time. Where not, the correlation tells a sign or other axes, the ratio a unit, the lag a delay.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.log_source import TABLE
from pipeline.ingest.pool_run_meant import Reading, change_of, over_earth
from pipeline.ingest.pool_run_resample import TABLE_HZ
from pipeline.ingest.pool_run_score import SECOND, mean_over, rate_of
from pipeline.ingest.pool_run_sizes import LEAST_MPS2, MOST_APART_DEG, down_apart_deg, looks_like
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable, down_axis, quaternion_product
from pipeline.types import BoolArray, FloatArray

#: Fewer rows say nothing; a second has all its rows where their mean is above it.
_LEAST_ROWS, _WHOLE = 120, 0.99
#: Correlations from which on a ratio tells a unit, and another reading would surely agree.
_ALIKE, _SURELY, _CERTAINLY = 0.8, 0.9, 0.95
#: Share of the least motion that is none of noise where another reading agrees.
_HARDLY = 0.3
#: A quantity that is smaller may be right where noise hides the other, which then does not last:
#: its correlation with itself a second later is -0.5 for noise, near 1 in motion.
_LEAST_RATIO, _LASTING = 0.5, 0.5
#: Rates of the angles, not of the body, as nobody can state them: a reading that leaves so much is
#: one of them where that leaves so little of it.
_OF_ANGLES = "the rates taken for those of the angles roll, pitch and yaw"
_APART, _NEAR = 0.03, 0.3
#: Which shows where a vehicle pitches by more than 24 degrees, in such a share of the run.
_STEEP, _LEAST_STEEP = 0.4, 0.05
#: What moves so many times more than noise, and than the other, moves alone.
_PLAINLY = 4.0
#: Shorter runs, and what lags less, say nothing: filters of sensors take that long. [s]
_SHORTEST_S, _LEAST_LAG_S, _MOST_LAG_S = 20.0, 0.4, 6.0
#: With its lag taken off a channel leaves at most so much of another, and of what it left before;
#: which is little where sensors stand apart on a vehicle that turns.
_LEFT_OF_SHORT, _LEFT_OF_LONG, _LONG_S, _LITTLE = (0.36, 0.5), (0.5, 0.6), 1.0, 0.06
#: Lags of the halves of a run agree [s]; less motion is noise [m/s, m/s2 or rad/s].
_LAGS_ALIKE_S, _LEAST_MOTION = 0.45, 0.01


@dataclass(frozen=True)
class Kind:
    """How two quantities are compared, and what is said of them.

    Components of several names are compared one by one, less their means; under one name all
    together. What they are compared with is `called`. `least` motion is none of noise; ratios
    within `usual` are of one unit; a correlation up to `against` is told, and one up to `apart`
    where the motion is plain.
    """

    names: tuple[str, ...]
    called: str
    least: float
    usual: tuple[float, float] = (0.4, 1.7)
    against: float = -0.6
    apart: float = -1.0
    is_timed: bool = True
    moves: bool = False
    """What moves in one moves in the other, whatever its unit."""


_RATES = ("the roll rate", "the pitch rate", "the yaw rate")
_ANY = (0.0, float("inf"))
#: What is said and what says it, in SI.
_KINDS = {
    ("angular_velocity", "attitude"): Kind(
        _RATES, "the turning", 0.01, (0.5, 2.0), -0.7, moves=True
    ),
    ("angular_velocity", "specific_force"): Kind(
        _RATES[:2], "the turning", 0.01, (0.5, 2.0), -0.7, is_timed=False
    ),
    ("specific_force", "attitude"): Kind(
        ("the specific force ahead", "the specific force to starboard"),
        "gravity",
        *(0.4, _ANY, -0.6, 0.3),
        is_timed=False,
    ),
    ("depth", "specific_force"): Kind(
        ("the change of the depth",), "the acceleration", 0.02, (0.6, 1.7), -0.9, is_timed=False
    ),
    ("position", "depth"): Kind(
        ("the downward position",), "the motion", 0.03, _ANY, -0.8, is_timed=False
    ),
    ("velocity", "depth"): Kind(
        ("the downward velocity",), "the motion", 0.02, apart=0.3, moves=True
    ),
    ("velocity", "position"): Kind(
        ("the horizontal velocity",), "the motion", 0.02, apart=0.3, moves=True
    ),
    ("velocity", "specific_force"): Kind(
        ("the change of the velocity",), "the acceleration", 0.02, (0.0, 1.4), -1.0
    ),
}


@dataclass(frozen=True)
class Pair:
    """What a channel reads (n, k), what another makes of it, in which rows (n,) both are known."""

    kind: Kind
    of: str
    by: str
    read: FloatArray
    made: FloatArray
    rows: BoolArray
    otherwise: Mapping[str, FloatArray]
    """How else it may have been meant -> what it then reads (n, k)."""


@dataclass(frozen=True)
class Late:
    """How much later [s] a motion tells another, what is left of it then, and as the times are."""

    lag_s: float
    left: float
    left_as_it_is: float


def pairs_of(
    run: PoolRun, table: RunTable, gravity_mps2: float, readings: Sequence[Reading]
) -> Iterator[Pair]:
    """Yield the pairs of a run on its table; `readings` of its velocity, the first as it is."""
    for (of, by), read, made, otherwise in _signals(table, gravity_mps2, readings):
        own = of if of in run.channels else "velocity_earth"
        if run.channels[own].topic == run.channels[by].topic and of == "position":
            continue
        used = {of, by} | ({"attitude"} & set(table.values))
        rows = np.all([table.trusted(one) for one in used], axis=0)
        kind = _KINDS[of, by]
        if of == "specific_force" and down_apart_deg(table) >= MOST_APART_DEG:
            continue
        if (of, by) == ("velocity", "depth") and "attitude" not in used:
            # a vehicle that pitches goes down without a velocity downward
            kind = replace(kind, apart=-1.0, moves=False)
        yield Pair(kind, own, by, read, made, rows, otherwise)


_Signals = tuple[tuple[str, str], FloatArray, FloatArray, Mapping[str, FloatArray]]


def _signals(
    table: RunTable, gravity_mps2: float, readings: Sequence[Reading]
) -> Iterator[_Signals]:
    """Yield what is said and by what, as it was read, as it is made, and as it was meant."""
    wanted = ("attitude", "angular_velocity", "specific_force", "depth", "position")
    attitude, rate, force, depth, position = (table.values.get(one) for one in wanted)
    if rate is not None:
        yield from _of_rates(rate, attitude, force)
    felt = None
    if attitude is not None and force is not None:
        up = -gravity_mps2 * down_axis(attitude)
        felt = force - up
        yield ("specific_force", "attitude"), force[:, :2], up[:, :2], {}
    if depth is not None and force is not None:
        # whatever the tilt, gravity is felt less by what a vehicle accelerates downwards
        downwards = gravity_mps2 - np.linalg.norm(force, axis=1, keepdims=True)
        if felt is not None and attitude is not None:
            downwards = (felt * down_axis(attitude)).sum(axis=1, keepdims=True)
        swings = rate_of(rate_of(depth))
        smooth = mean_over(mean_over(downwards, SECOND), SECOND)
        yield ("depth", "specific_force"), swings, smooth, {}
    if position is not None and depth is not None:
        yield ("position", "depth"), position[:, 2:], depth, {}
    earth = {one.how: over_earth(one.velocity, table) for one in readings if not one.any_heading}
    for by, values, axes in (("depth", depth, [2]), ("position", position, [0, 1])):
        if earth and values is not None and (by == "depth" or attitude is not None):
            otherwise = {how: one[:, axes] for how, one in earth.items()}
            rates = rate_of(values[:, : len(axes)])
            yield ("velocity", by), otherwise.pop(""), rates, otherwise
    if readings and felt is not None:
        change = change_of(readings[0].velocity, table)
        if all(np.isfinite(one).any(axis=0).all() for one in (change, felt)):
            # an attitude that is off feels gravity all the time
            both = [one - np.nanmean(one, axis=0) for one in (change, felt)]
            yield ("velocity", "specific_force"), both[0], both[1], {}


def _of_rates(
    rate: FloatArray, attitude: FloatArray | None, force: FloatArray | None
) -> Iterator[_Signals]:
    """Yield rates by how an attitude turns, or else gravity."""
    orders = {"x and y": [1, 0, 2], "x and z": [2, 1, 0], "y and z": [0, 2, 1]}
    otherwise = {f"the axes {two} swapped": rate[:, order] for two, order in orders.items()}
    if attitude is not None:
        if (np.abs(down_axis(attitude)[:, 0]) > _STEEP).mean() > _LEAST_STEEP:
            otherwise[_OF_ANGLES] = _of_angles(rate, attitude)
        yield ("angular_velocity", "attitude"), rate, turning(attitude, TABLE_HZ), otherwise
    elif force is not None:
        otherwise = {how: one[:, :2] for how, one in otherwise.items()}
        turns = _turning_of_gravity(force)
        yield ("angular_velocity", "specific_force"), rate[:, :2], turns, otherwise


def compared(run: PoolRun, pair: Pair) -> Iterator[Problem]:
    """Say where what a channel reads is at odds with what another makes of it."""
    topic = run.channels[pair.of].topic
    whole = mean_over(pair.rows[:, None], SECOND + 1)[:, 0] > _WHOLE
    if whole.sum() < _LEAST_ROWS:
        return

    def smooth(values: FloatArray) -> FloatArray:
        return mean_over(np.where(pair.rows[:, None], values, 0.0), SECOND)[whole]

    made, otherwise = smooth(pair.made), {how: smooth(one) for how, one in pair.otherwise.items()}
    readings = {"": smooth(pair.read), **otherwise}
    called = f"{pair.kind.called} by {pair.by} ({run.channels[pair.by].topic})"
    for number, name in enumerate(pair.kind.names):
        part = slice(number, number + 1) if len(pair.kind.names) > 1 else slice(None)
        each = {how: one[:, part] for how, one in readings.items()}
        if said := _at_odds(pair.kind, called, each, made[:, part]):
            yield run.place.warning(
                f"{name} ({topic}) {said}",
                remedy="Check its axes, sign and unit under pool: channels in vehicle.yaml.",
            )


def _at_odds(kind: Kind, called: str, readings: Mapping[str, FloatArray], made: FloatArray) -> str:
    """Say how what was read, the first of its readings, is at odds with what it should be."""
    agreement = {how: _agreement(one, made) for how, one in readings.items()}
    correlation, ratio = agreement[""]
    small, large = sorted(float(np.sqrt((one**2).mean())) for one in (made, readings[""]))
    if correlation >= _ALIKE:
        return _in_size(kind, called, agreement, small) if large >= kind.least else ""
    moves, still = (float(one.std(axis=0).max()) for one in (readings[""], made))
    if kind.moves and moves > _PLAINLY * max(kind.least, still):
        return f"moves, and {called} does not: one of the two is dead, or not connected."
    better = [how for how, (alike, _) in agreement.items() if alike >= _SURELY]
    # what hardly moves in one may move in the other, where its axes are others
    if np.sqrt((made**2).mean()) < (_HARDLY if better else 1.0) * kind.least:
        return ""
    if correlation <= kind.against or better:
        would = f" With {' or '.join(better)} it would agree." if better else ""
        return f"runs against {called} (correlation {correlation:.2f}).{would}"
    before, after = made[:-SECOND], made[SECOND:]
    lasts = (before * after).sum() > _LASTING * np.sqrt((before**2).sum() * (after**2).sum())
    is_nothing = correlation <= kind.apart and (ratio > _LEAST_RATIO or lasts)
    said = f"has nothing to do with {called} (correlation {correlation:.2f})."
    return said if is_nothing else ""


def _in_size(
    kind: Kind, called: str, agreement: Mapping[str, tuple[float, float]], small: float
) -> str:
    """Say how what goes with what it should be is larger or smaller; the smaller one is `small`."""
    left = {how: 1.0 + ratio**2 - 2.0 * alike * ratio for how, (alike, ratio) in agreement.items()}
    correlation, ratio = agreement[""]
    is_sure, is_plain, (low, high) = correlation >= _SURELY, small >= kind.least, kind.usual
    if low < ratio < high:
        is_other = left.get(_OF_ANGLES, 1.0) < _NEAR * left[""]
        said = f"is {ratio:.3g} times {called}: with {_OF_ANGLES} it would agree."
        return said if is_plain and left[""] > _APART and is_other else ""
    looks = looks_like(ratio, 0.3)
    is_plain |= bool(looks) or correlation >= _CERTAINLY
    if not (is_plain and (is_sure or (ratio > 1.0 and small >= kind.least))):
        return ""
    looks = f": it looks like {looks}" if looks else ""
    return f"is {ratio:.3g} times {called}{looks}; check its unit, or the times are others."


def _agreement(read: FloatArray, made: FloatArray) -> tuple[float, float]:
    """Correlation of what is read (n, k) with what is made of it, and the ratio of their sizes.

    One component alone is taken less its mean: an offset of a sensor says nothing.
    """
    if made.shape[1] == 1:
        read, made = read - read.mean(), made - made.mean()
    size, power = float((read**2).sum()), float((made**2).sum())
    if min(size, power) < 1e-8 * max(size, power, 1e-9):
        return 0.0, 0.0
    return float((read * made).sum() / np.sqrt(size * power)), float(np.sqrt(size / power))


def turning(attitude: FloatArray, rate_hz: float) -> FloatArray:
    """Return the rates (n, 3) in body axes of attitudes (n, 4) that follow at `rate_hz`.

    [rad/s], each from the attitude before to the one after; not a number at both ends.
    """
    step = quaternion_product(attitude[:-2] * np.array([1.0, -1.0, -1.0, -1.0]), attitude[2:])
    rate = np.full((len(attitude), 3), np.nan)
    rate[1:-1] = step[:, 1:] * np.where(step[:, :1] < 0, -1.0, 1.0) * rate_hz
    return rate


def _of_angles(rates: FloatArray, attitude: FloatArray) -> FloatArray:
    """Return the rates (n, 3) of a body whose angles roll, pitch and yaw have these rates."""
    roll, pitch, yaw = rates.T
    down = down_axis(attitude)
    level = np.maximum(np.hypot(down[:, 1], down[:, 2]), 1e-6)
    sin, cos = down[:, 1] / level, down[:, 2] / level
    turned = [
        roll + yaw * down[:, 0],
        pitch * cos + yaw * down[:, 1],
        yaw * down[:, 2] - pitch * sin,
    ]
    return np.stack(turned, axis=1)


def _turning_of_gravity(force: FloatArray) -> FloatArray:
    """Return rates of roll and pitch (n, 2) by how gravity turns, of a specific force (n, 3).

    A vehicle that is about level has df_y / dt = p f_z and df_x / dt = -q f_z.
    """
    down, change = float(np.nanmedian(force[:, 2])), rate_of(force)
    if not abs(down) > LEAST_MPS2:
        return np.zeros((len(force), 2))
    return np.stack([change[:, 1], -change[:, 0]], axis=1) / down


def late(run: PoolRun, pair: Pair) -> Iterator[Problem]:
    """Say where a channel tells a motion at another time than another one."""
    rows = pair.rows & np.isfinite(pair.read).all(axis=1) & np.isfinite(pair.made).all(axis=1)
    if rows.sum() < _SHORTEST_S * TABLE_HZ or not pair.kind.is_timed:
        return
    both = [
        mean_over(np.where(rows[:, None], one - one[rows].mean(axis=0), 0.0), SECOND)
        for one in (pair.read, pair.made)
    ]
    found = late_by(both[0], both[1]) if min(one.std() for one in both) > _LEAST_MOTION else None
    is_long = found is not None and abs(found.lag_s) >= _LONG_S
    most, most_left = _LEFT_OF_LONG if is_long else _LEFT_OF_SHORT
    if (
        found is None
        or abs(found.lag_s) < _LEAST_LAG_S
        or found.left_as_it_is < _LITTLE
        or found.left > min(most, most_left * found.left_as_it_is)
    ):
        return
    names = (pair.of, pair.by) if found.lag_s > 0.0 else (pair.by, pair.of)
    topics = [run.channels[name].topic for name in names]
    if topics[0] != topics[1] or topics[0] == TABLE:
        yield run.place.warning(
            f"{names[0]} ({topics[0]}) is {abs(found.lag_s):.1f} s behind {names[1]} ({topics[1]}):"
            f" with that taken off it explains {100 * (1 - found.left):.0f} % of that motion, as "
            f"the times are {100 * (1 - found.left_as_it_is):.0f} %.",
            remedy="Check the clocks of both; state clock or delay_s under pool: channels in "
            "vehicle.yaml.",
        )


def late_by(one: FloatArray, other: FloatArray) -> Late | None:
    """Return by how much one motion (n, k) is behind another; None where the halves differ.

    Each component has a gain of its own, which is not negative.
    """
    most, half = round(_MOST_LAG_S * TABLE_HZ), len(one) // 2
    if half < 4 * most:
        return None
    whole = _explained(one, other, most)
    best = int(whole.argmax())
    for part in (slice(0, half), slice(half, None)):
        own = int(_explained(one[part], other[part], most).argmax())
        if abs(own - best) > _LAGS_ALIKE_S * TABLE_HZ:
            return None
    return Late((best - most) / TABLE_HZ, 1.0 - float(whole[best]), 1.0 - float(whole[most]))


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
