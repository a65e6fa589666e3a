"""Whether the vehicle turns as the commands and the vehicle file say: swapped thrusters show."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_health import is_noise_alone
from pipeline.ingest.pool_run_pairs import late_by, turning
from pipeline.ingest.pool_run_resample import TABLE_HZ, thrusters_of
from pipeline.ingest.pool_run_score import (
    Meaning,
    Sums,
    about_down,
    freed,
    left_of,
    rearranged,
    sums_of_parts,
)
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable, down_axis
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: In less than half a minute several orders of thrusters may make the like of one sine: then those
#: as stated must explain next to nothing, and others so much; ten seconds say nothing.
_FEWEST_ROWS, _SHORT_ROWS, _LEFT_IN_SHORT, _EXPLAINED_IN_SHORT = 200, 580, 0.9, 0.25
#: The explained share of the angular acceleration must be at least this to speak of thrusters.
_LEAST_EXPLAINED = 0.15
#: Without an attitude the righting by gravity is left in it; a wrong order may seem to explain it.
_LEAST_WITHOUT_ATTITUDE = 0.6
#: Another reading is told where it leaves at most this share of what the stated one leaves, in the
#: whole run and in each half of it.
_MOST_LEFT, _MOST_LEFT_OF_HALF = 0.75, 0.95
_ALIKE, _MOST_ALIKE = 1.05, 3
#: And at most this share of what those as stated leave, where each pushes up to so many times more
#: or less than the vehicle file says.
_OF_OWN_GAINS, _GAINS = 0.9, 2.0
#: Moments as stated have this share of the power that they would have otherwise, at the least:
#: where commands hardly ask for a moment, little of it is theirs.
_LEAST_ASKED = 0.05
#: Commands that are earlier or later leave this share of what is left; a drive lags by less. [s]
_MOST_LEFT_LATE, _LAG_OF_DRIVES_S = 0.85, 0.6
#: Share of all moments about the vertical that acts one way; a vehicle that turns no faster goes
#: straight on [rad/s]; less of the largest moments says nothing.
_ONE_WAY, _STRAIGHT_RADPS, _LEAST_OF_MOMENT = 0.7, 0.05, 0.2
#: Axes in which rates may have been read.
_OTHER_AXES = {
    "the roll rate is reversed": np.diag([-1.0, 1.0, 1.0]),
    "the pitch rate is reversed": np.diag([1.0, -1.0, 1.0]),
    "the yaw rate is reversed": np.diag([1.0, 1.0, -1.0]),
    "the rates are all reversed": -np.eye(3),
    "the rates are read with y to port and z up": np.diag([1.0, -1.0, -1.0]),
    "the rates are read turned by 90 degrees about the vertical": about_down(90.0),
    "the rates are read turned by 180 degrees about the vertical": about_down(180.0),
    "the rates are read turned by -90 degrees about the vertical": about_down(-90.0),
}


@dataclass(frozen=True)
class _Turning:
    """Angular accelerations (n, 3) and thrust shapes (n, thrusters), less what else turns it.

    Other causes are the rates, their squares and products, the direction of gravity, which rights
    a vehicle, and the velocity with its products, by which water turns it; as far as known.
    """

    acceleration: FloatArray
    effort: FloatArray
    names: tuple[str, ...]


def thrusters_against_rates(run: PoolRun, table: RunTable, vehicle: Vehicle) -> Iterator[Problem]:
    """Compare angular accelerations with the moments that the vehicle file promises.

    For each axis: acceleration = gain x moment of the commands + what other causes explain. If
    exchanging two thrusters, turning one round, or rates in other axes explain the accelerations
    plainly better, in the whole run and in both halves of it, that is told; or late commands.
    """
    found = _turning_of(run, table)
    stated = {thruster.name: thruster for thruster in vehicle.thrusters}
    if found is None or len(found.names) < 2 or not set(found.names) <= set(stated):
        return
    arms = np.array(
        [np.cross(stated[name].position_m, stated[name].direction) for name in found.names]
    )
    knows_down = "attitude" in run.channels
    whole, *_ = sums = sums_of_parts(
        found.acceleration, found.effort, np.ones(len(found.effort), np.bool_)
    )
    own, *others = _meanings(found, arms, sums)
    least = _LEAST_EXPLAINED if knows_down else _LEAST_WITHOUT_ATTITUDE
    if len(found.effort) < _SHORT_ROWS:
        least = max(least, _EXPLAINED_IN_SHORT)
        if own.left[0] < _LEFT_IN_SHORT:
            return
    better = sorted(
        (
            one
            for one in others
            if one.left[0] < 1.0 - least
            and one.is_plainly_better(own, _MOST_LEFT, _MOST_LEFT_OF_HALF)
        ),
        # of equals: without an attitude nothing tells the sign of a rate
        key=lambda one: (round(float(one.left[0]), 3), knows_down == (one.how in _OTHER_AXES)),
    )
    late = late_by(found.acceleration, found.effort @ arms)
    if (
        late is not None
        and not -0.5 * _LAG_OF_DRIVES_S < late.lag_s < _LAG_OF_DRIVES_S
        and late.left < _MOST_LEFT_LATE * late.left_as_it_is
        and not (better and late.left > _ALIKE * better[0].left[0])
    ):
        yield run.place.warning(
            f"the vehicle turns {late.lag_s:+.1f} s after the commands that turn it: their "
            f"moments explain {100 * (1 - late.left_as_it_is):.0f} % of the angular acceleration "
            f"as the times are, {100 * (1 - late.left):.0f} % with that taken off.",
            remedy="Check the clocks of commands and rates; state clock or delay_s under pool: "
            "channels in vehicle.yaml.",
        )
        return
    # thrusters as stated, of which some push more than others, are likelier than other ones
    if not better or better[0].left[0] > _OF_OWN_GAINS * whole.left_by_own_gains(arms, _GAINS):
        return
    best = better[0]
    equal = [one.how for one in better[1:] if one.left[0] < _ALIKE * best.left[0]]
    alike = f" (or {'; or '.join(equal[:_MOST_ALIKE])})" if equal else ""
    yield run.place.warning(
        f"the rates suggest that {best.how} against the vehicle file{alike}: the moments as "
        f"stated explain {100 * (1 - own.left[0]):.0f} % of the angular acceleration "
        f"that drag and gravity leave, so changed {100 * (1 - best.left[0]):.0f} %.",
        "",
        "Check the order of the thrusters in the log, their positions and directions, and the "
        "axes and the sign of the rates.",
    )


def moments_without_turning(run: PoolRun, table: RunTable, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where the commands ask for a turn all the time, and the vehicle goes straight on."""
    if not thrusters_of(run, "command") or "angular_velocity" not in table.values:
        return
    stated = {one.name: np.cross(one.position_m, one.direction)[2] for one in vehicle.thrusters}
    arms = np.array([stated.get(name, 0.0) for name in table.thrusters])
    code = np.nan_to_num(table.values["command"])
    each = code * np.abs(code) * arms
    size = np.abs(each).sum(axis=1)
    rows = table.valid["command"] & table.valid["angular_velocity"]
    rows &= size > _LEAST_OF_MOMENT * size.max(initial=0.0)
    halves = np.array_split(np.flatnonzero(rows), 2)
    if rows.sum() < _FEWEST_ROWS or (np.abs(arms) > 0.0).sum() < 2:
        return
    channel = run.channels["angular_velocity"]
    if is_noise_alone(channel.values[channel.usable()], channel.period_s):
        yield run.place.warning(
            f"the rates ({channel.topic}) are noise alone while the commands turn the vehicle: the "
            "IMU is dead or not connected, or the thrusters did not run.",
            remedy="Check the sensor.",
        )
        return
    shares = [float(each[half].sum() / size[half].sum()) for half in halves]
    turned = [abs(float(table.values["angular_velocity"][half, 2].mean())) for half in halves]
    if (min(shares) < _ONE_WAY and max(shares) > -_ONE_WAY) or max(turned) > _STRAIGHT_RADPS:
        return
    yield run.place.warning(
        f"the commands turn the vehicle one way all the time, by {100 * abs(sum(shares)) / 2:.0f} "
        f"% of what their moments about the vertical are together, and it turns by "
        f"{max(turned):.2g} rad/s: a thruster is reversed against the vehicle file, or its "
        "direction or position is another.",
        "",
        "Check signs and order of the commands, and the directions in vehicle.yaml.",
    )


def _meanings(found: _Turning, arms: FloatArray, sums: list[Sums]) -> Iterator[Meaning]:
    """Score the moments as they are stated, then with other arms, then rates in other axes."""
    stated = sums[0].power(arms)
    for how, changed in [("", arms), *rearranged(arms, found.names)]:
        # thrusters that push alike turn a vehicle whose centre of mass is not in their line
        told = np.where(stated > _LEAST_ASKED * sums[0].power(changed), changed, arms)
        yield Meaning(left_of([(sums, told)], np.eye(3)[None])[:, 0], how, how)
    for how, axes in _OTHER_AXES.items():
        yield Meaning(left_of([(sums, arms)], axes[None])[:, 0], how, how)


def _turning_of(run: PoolRun, table: RunTable) -> _Turning | None:
    names = thrusters_of(run, "command")
    known = [name for name in ("angular_velocity", "attitude") if name in run.channels]
    if not names or not known:
        return None
    known += ["velocity"] if "velocity" in table.values else []
    names = tuple(name for name in table.thrusters if name in names)
    if not names:
        return None  # the log commands thrusters that the vehicle file does not have
    codes = table.values["command"][:, [table.thrusters.index(name) for name in names]]
    rate = table.values.get("angular_velocity")
    if rate is None:
        rate = turning(table.values["attitude"], TABLE_HZ)
    rows = np.all([table.valid[name] for name in ("command", *known)], axis=0)
    largest = np.abs(codes[rows]).max(initial=0.0)
    if rows.sum() < _FEWEST_ROWS or not largest:
        return None
    smooth = _smoothed(rate, rows)
    effort = codes / largest
    # between a linear and a quadratic characteristic; thrust lags by about the smoothing
    effort = _smoothed(effort * np.sqrt(np.abs(effort)), rows)
    others = [smooth, smooth * np.abs(smooth), _products(smooth, smooth)]
    if "attitude" in known:
        others.append(_smoothed(down_axis(table.values["attitude"]), rows))
    if "velocity" in known:
        speed = _smoothed(table.values["velocity"], rows)
        others += [speed, speed * np.abs(speed), _products(speed, speed), speed * smooth]
        others += [speed * np.roll(smooth, turn, axis=1) for turn in (1, 2)]
    mixed = np.concatenate(others, axis=1)
    acceleration = np.gradient(smooth, 1.0 / TABLE_HZ, axis=0)
    there = np.isfinite(np.concatenate([acceleration, effort, mixed], axis=1)).all(axis=1)
    if there.sum() < _FEWEST_ROWS:
        return None
    acceleration, effort = freed(mixed[there], acceleration[there], effort[there])
    return _Turning(acceleration, effort, names) if acceleration.any() and effort.any() else None


def _products(one: FloatArray, other: FloatArray) -> FloatArray:
    """Products of different components."""
    return one[:, [1, 2, 0]] * other[:, [2, 0, 1]]


def _smoothed(values: FloatArray, rows: BoolArray) -> FloatArray:
    """Mean over five rows (0.25 s); not a number where one of them is missing."""
    kernel = np.full(5, 0.2)
    filled = np.where(rows[:, None], values, np.nan)
    return np.stack([np.convolve(column, kernel, mode="same") for column in filled.T], axis=1)
