"""What channels say of each other and of the vehicle file: suspicions, told and nothing else."""

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.errors import CannotComputeError, Problem
from pipeline.ingest.message_fields import impossible
from pipeline.ingest.pool_run_down import (
    CHECK_UNIT,
    depth_against_felt,
    depth_too_fast,
    doubtful_depths,
    down_against_level,
    gravity_against_attitude,
    position_against_depth,
    turning,
    turning_of_gravity,
)
from pipeline.ingest.pool_run_late import lags
from pipeline.ingest.pool_run_resample import TABLE_HZ, on_one_base
from pipeline.ingest.pool_run_shafts import (
    shafts_against_commands,
    shafts_too_slow,
    tips_too_fast,
)
from pipeline.ingest.pool_run_thrusters import moments_without_turning, thrusters_against_rates
from pipeline.ingest.pool_run_velocity import velocity_against_motion
from pipeline.ingest.quantities import largest
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Ratio between what was read and what would be plausible -> what it looks like.
_FACTORS = (
    (1000.0, "thousandths (milli)"),
    (0.001, "thousands (kilo)"),
    (100.0, "hundredths (centi)"),
    (0.01, "hundreds (hecto)"),
    (180.0 / np.pi, "degrees"),
    (np.pi / 180.0, "radians taken for degrees"),
    (1.0 / 9.80665, "multiples of g"),
    (1000.0 / 9.80665, "thousandths of g"),
    (9.80665, "m/s2 taken for multiples of g"),
)
#: Rates and attitudes that go together like this differ by a factor alone.
_CLEARLY = 0.9
#: Rates of axes that do not go together at all, and what is too slow to tell. [-, rad/s]
_UNCLEAR, _LEAST_RATE_RADPS = 0.5, 1e-3
_FEWEST_ROWS = 100
_AXES = ("roll", "pitch", "yaw")
#: More than a turn a second is no vehicle's: these are degrees. [rad/s]
_FAST_RADPS = 2.0 * np.pi


def consistency_problems(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Compare channels with each other and with the vehicle file.

    Warns of units off by a factor, impossible readings, two opinions of where down is, shaft speeds
    that contradict commands, thrusters that seem to be swapped or reversed. It changes nothing.
    """
    yield from _sizes(run)
    yield from tips_too_fast(run, vehicle)
    yield from _impossible(run)
    yield from _voltage(run, vehicle)
    yield from doubtful_depths(run, vehicle)
    yield from down_against_level(run)
    try:  # what follows lays the readings on a common time base
        table = on_one_base(run)
        yield from contradictions(run, vehicle, table)
        yield from position_against_depth(run, table)
        yield from shafts_against_commands(run, table)
        yield from shafts_too_slow(run, table, vehicle)
        yield from moments_without_turning(run, table, vehicle)
        yield from thrusters_against_rates(run, table, vehicle)
    except CannotComputeError as error:
        yield run.place.warning(
            f"channels were not compared with each other: {error}.",
            remedy="Check the clock of the recorder; cut a log of many days into runs.",
        )


def contradictions(
    run: PoolRun, vehicle: Vehicle, table: RunTable, others: Sequence[RunChannel] = ()
) -> Iterator[Problem]:
    """Say where attitude, rates, specific force, velocity, depth and position contradict another.

    `others` are velocities beside that of the run. Raises `CannotComputeError` where the times of
    the run make no table.
    """
    yield from depth_too_fast(run, table)
    yield from depth_against_felt(run, table, vehicle)
    yield from gravity_against_attitude(run, table)
    yield from _turning_against_rates(run, table)
    yield from velocity_against_motion(run, vehicle, others)
    yield from lags(run, table, vehicle)


def _sizes(run: PoolRun) -> Iterator[Problem]:
    """Say where a quantity is larger than it can be, or gravity is not what it should be."""
    for name, channel in run.channels.items():
        size, high = _usual_and_large(channel)
        if channel.quantity == "specific_force" and size > 0:
            likely = _factor(size / 9.81, tolerance=0.15)
            if likely and not 5.0 < size < 20.0:
                yield run.place.warning(
                    f"{name} ({channel.topic}) is {size:.4g} m/s2 on average where gravity "
                    f"alone is 9.81: it looks like {likely}.",
                    remedy=CHECK_UNIT,
                )
                continue
            if size < 5.0:
                yield run.place.warning(
                    f"{name} ({channel.topic}) is {size:.3g} m/s2 on average; a specific force "
                    "holds gravity, 9.81. It was taken out, or the unit is another.",
                    remedy="Record what the accelerometer reads, or leave the channel out.",
                )
                continue
        if channel.quantity == "angular_velocity" and high > _FAST_RADPS:
            yield run.place.warning(
                f"{name} ({channel.topic}) reaches {high:.3g} rad/s, more than a turn a second: it "
                "looks like degrees.",
                remedy=CHECK_UNIT,
            )
        if high > largest(channel.quantity):
            yield run.place.warning(
                f"{name} ({channel.topic}) reaches {high:.4g} {_unit(channel)}, more than is "
                "possible: its unit is probably off by a factor such as 1000.",
                remedy=CHECK_UNIT,
            )


def _impossible(run: PoolRun) -> Iterator[Problem]:
    """Say which channels have readings that stand for none, and that these are left out."""
    for name, channel in run.channels.items():
        wrong = impossible(channel.quantity, channel.values)
        if wrong.any():
            size = float(np.nanmax(np.abs(channel.values[wrong])))
            yield run.place.warning(
                f"{name} ({channel.topic}) is up to {size:.4g} {_unit(channel)} in {wrong.sum()} "
                f"of {wrong.size} readings, more than is possible; they are left out.",
                remedy="Some sensors write such a number where they measure nothing.",
            )


def _unit(channel: RunChannel) -> str:
    return channel.columns[0].rsplit("_", maxsplit=1)[-1]


def _usual_and_large(channel: RunChannel) -> tuple[float, float]:
    """Return the usual size of a reading and a large one; nan and 0 where there are none."""
    kept = channel.values[channel.usable()]
    some = kept[:: max(1, len(kept) // 20_000)]
    numbers = np.abs(some[np.isfinite(some)])
    if not numbers.size:
        return float("nan"), 0.0
    usual = float(np.nanmedian(np.linalg.norm(some, axis=1)))
    return usual, float(np.quantile(numbers, 0.99))


def _factor(ratio: float, tolerance: float = 0.1) -> str:
    for factor, says in _FACTORS:
        if abs(ratio / factor - 1.0) < tolerance:
            return says
    return ""


def _turning_against_rates(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Compare rates with how the attitude turns, or gravity where there is no attitude.

    They may have another unit, sign or axes.
    """
    other = "attitude" if "attitude" in table.values else "specific_force"
    if not {other, "angular_velocity"} <= set(table.values):
        return
    rows = table.valid[other] & table.valid["angular_velocity"]
    rows[1:-1] &= rows[:-2] & rows[2:]
    rows[[0, -1]] = False
    if rows.sum() < _FEWEST_ROWS:
        return
    rate = table.values["angular_velocity"]
    if other == "attitude":
        turns, measured = turning(table.values["attitude"], TABLE_HZ)[rows], rate[rows]
    else:
        force = np.where(rows[:, None], table.values[other], np.nan)
        turns, measured = turning_of_gravity(force, rate, TABLE_HZ)
    if len(turns) < _FEWEST_ROWS:
        return
    by, topic = f"{other} ({run.channels[other].topic})", run.channels["angular_velocity"].topic
    remedy = "Check unit, sign and axes of both under pool: channels in vehicle.yaml."
    swapped = _swapped(turns, measured)
    if swapped:
        what = (
            f"the {swapped[0]} rate by {by} is the {swapped[1]} rate of angular_velocity "
            f"({topic}): the axes of one of them are swapped."
        )
        yield run.place.warning(what, remedy=remedy)
        return
    for name, a, m in zip(_AXES, turns.T, measured.T, strict=False):
        what = _odd_rate(a, m, by)
        if what:
            yield run.place.warning(f"the {name} rate ({topic}) {what}", remedy=remedy)


def _odd_rate(turns: FloatArray, measured: FloatArray, by: str) -> str:
    """Say how a rate differs from what it should be; nothing where it agrees or hardly moves."""
    # what hardly moves in one may move in the other, where its unit is another
    sizes = turns.std(), measured.std()
    if max(sizes) < 0.02 or min(sizes) < 1e-6:
        return ""
    correlation = float(np.corrcoef(turns, measured)[0, 1])
    ratio = float(sizes[1] / sizes[0])
    likely = _factor(ratio, tolerance=0.3)
    if abs(correlation) < 0.7:
        return ""
    if not 0.5 < ratio < 2.0 and (likely or abs(correlation) > _CLEARLY):
        looks = f": it looks like {likely}" if likely else ""
        return f"is {ratio:.3g} times that by {by}{looks}; or the times are others."
    if correlation < 0:
        return f"has the opposite sign of that by {by} (correlation {correlation:.2f})."
    return ""


def _swapped(turns: FloatArray, measured: FloatArray) -> tuple[str, str] | None:
    """Return an axis whose rate another axis has that was measured, and that one; None for none.

    Over half a second each: a vehicle that hardly tilts shows its axes, too.
    """
    half = np.full(round(0.5 * TABLE_HZ), 2.0 / TABLE_HZ)
    both, axes = np.concatenate([turns, measured], axis=1), turns.shape[1]
    both = np.stack([np.convolve(one - one.mean(), half, mode="valid") for one in both.T], axis=1)
    alike = np.abs(np.nan_to_num(both.T @ both / len(both)))
    size = np.sqrt(alike.diagonal())
    alike = (alike / np.maximum(np.outer(size, size), _LEAST_RATE_RADPS**2))[:axes, axes:]
    own = alike.diagonal()
    told = (alike > _CLEARLY) & (np.maximum.outer(own, own) < _UNCLEAR)
    found = np.argwhere(told)
    return (_AXES[found[0, 0]], _AXES[found[0, 1]]) if len(found) else None


def _voltage(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    channel = run.channels.get("voltage")
    sensor = None if vehicle.sensors is None else vehicle.sensors.voltage
    if channel is None or sensor is None:
        return
    size, _ = _usual_and_large(channel)
    if not size > 0 or 0.5 < size / sensor.nominal_v < 1.5:
        return
    likely = _factor(size / sensor.nominal_v, tolerance=0.4)
    looks = f": it looks like {likely}" if likely else ""
    yield run.place.warning(
        f"the supply ({channel.topic}) is {size:.4g} V where the vehicle file says "
        f"{sensor.nominal_v:g} V{looks}.",
        remedy=CHECK_UNIT,
    )
