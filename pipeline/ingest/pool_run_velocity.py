"""Whether a velocity is that of the motion: against depth, position, and what thrusters can do."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_convert import BODY, EARTH
from pipeline.ingest.pool_run_meant import (
    MOST_OF_UNIT,
    Reading,
    meant_otherwise,
    over_the_earth,
    rate_of,
)
from pipeline.ingest.pool_run_resample import into_body, on_rows
from pipeline.ingest.pool_run_score import Sums, mean_over
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

_TABLE_HZ = 10.0
#: Rows of a second, over which velocities are compared; fewer in all say nothing.
_SECOND, _LEAST_ROWS = 10, 60
#: Less is noise.
_LEAST_MPS = 0.02
#: A second has all its rows where their mean is above it.
_WHOLE = 0.99
_AGAINST, _AGREES = -0.6, 0.8
#: A velocity that is so much less than the rate of place may be filtered.
_LEAST_OF_UNIT = 0.4
#: A velocity less than this share of the rate of place may be right: noise of the place hides it.
_LEAST_RATIO = 0.5
#: Correlation of a way with the next one, at least: -0.5 if places are noise, near 1 in motion.
_LASTING = 0.5
#: What velocities are compared with -> which of its components are.
_COMPARED = (
    ("depth", "the rate of depth", slice(2, 3)),
    ("position", "the rate of position", slice(0, 2)),
)


def velocity_against_motion(
    run: PoolRun, vehicle: Vehicle, others: Sequence[RunChannel] = ()
) -> list[Problem]:
    """Compare a velocity with the way that depth and position have gone, and with the thrusters.

    And with `others`, velocities that might be taken in its place. A warning for each
    contradiction, with its figures and what would agree.
    """
    names = [name for name in ("velocity", "velocity_earth") if name in run.channels]
    if not names or (names == ["velocity_earth"] and "attitude" not in run.channels):
        return []
    wanted = ("attitude", "depth", "position", "angular_velocity", "specific_force")
    beside = [name for name in wanted if name in run.channels]
    table = on_rows(run, _TABLE_HZ, "velocity", *beside)
    channel = run.channels[names[0]]
    readings = _readings(channel, table)
    there = table.valid["velocity"] & table.valid.get("attitude", table.valid["velocity"])
    found = []
    for what, called, axes in _COMPARED:
        if what not in beside or (what == "position" and "attitude" not in beside):
            continue
        rows = mean_over((there & table.valid[what])[:, None], _SECOND + 1)[:, 0] > _WHOLE
        rate = rate_of(table.values[what][:, : axes.stop - axes.start], _TABLE_HZ)
        earth = [
            (one.how, _over_earth(one.velocity, table)[:, axes])
            for one in readings
            if not one.any_heading
        ]
        said = _against(earth, rate, rows, called, level="attitude" in beside)
        if said:
            is_down = f"the downward velocity ({channel.topic}) {said}"
            is_level = f"the horizontal velocity ({channel.topic}) {said}"
            found.append(is_down if what == "depth" else is_level)
    for one in others if "attitude" in beside and channel.quantity == "velocity" else ():
        theirs = on_rows(replace(run, channels={"velocity": one}), _TABLE_HZ, "velocity")
        rows = there & theirs.valid["velocity"]
        if said := over_the_earth(readings, theirs.values["velocity"], rows, one.topic):
            found.append(f"the velocity ({channel.topic}) {said}")
    if not any("{" in said for said in found):  # none says what would agree
        said = meant_otherwise(run, table, readings, there, vehicle)
        found = [f"the velocity ({channel.topic}) {said}"] if said else found
    remedy = "Check its axes, sign and unit under pool: channels in vehicle.yaml."
    return [run.place.warning(what, remedy=remedy) for what in found]


def _over_earth(velocity: FloatArray, table: RunTable) -> FloatArray:
    """Turn a velocity of the body to the earth (NED), as far as an attitude is known."""
    if "attitude" not in table.values:
        return velocity
    return into_body(velocity, table.values["attitude"] * np.array([1.0, -1.0, -1.0, -1.0]))


def _readings(channel: RunChannel, table: RunTable) -> list[Reading]:
    """Return the velocity in body axes as it was read, and as it might have been meant."""
    body, values, axes = table.values["velocity"], table.values, channel.read.axes
    read_as, found = (channel.quantity, axes), [Reading(body, "")]
    # as it stood in the messages
    over_earth = channel.quantity == "velocity_earth"
    xyz = _over_earth(body, table) @ EARTH[axes] if over_earth else body @ BODY[axes]
    for one in ("frd", "flu"):
        if read_as != ("velocity", one):
            stated = f"{{quantity: velocity, body_axes: {one}}}"
            found.append(Reading(xyz @ BODY[one].T, stated))
    found.append(Reading(-body, "{sign: -1}"))
    for one in ("ned", "enu"):
        stated, ned = f"{{quantity: velocity_earth, earth_axes: {one}}}", xyz @ EARTH[one].T
        if "attitude" in values and read_as != ("velocity_earth", one):
            found.append(Reading(into_body(ned, values["attitude"]), stated))
        elif "attitude" not in values and "angular_velocity" in values:
            # a heading from one that nobody knows
            half = np.cumsum(np.nan_to_num(values["angular_velocity"][:, 2])) / _TABLE_HZ / 2.0
            turn = np.stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)], axis=1)
            found.append(Reading(into_body(ned, turn), stated, any_heading=True))
    return found


def _agreement(
    velocity: FloatArray, rate: FloatArray, rows: BoolArray
) -> tuple[float, float] | None:
    """Correlation of a velocity (n, k) with the rate of places (n, k), and their ratio."""
    of_place = rate[rows]
    if len(of_place) < _LEAST_ROWS or np.sqrt((of_place**2).mean()) < _LEAST_MPS:
        return None
    # a steady offset of a depth says nothing
    sums = Sums.of(mean_over(velocity, _SECOND)[rows], of_place, centred=rate.shape[1] == 1)
    other, along, power = map(np.trace, (sums.motion, sums.along, sums.causes))
    if power <= of_place.size * (0.5 * _LEAST_MPS) ** 2:
        return None
    if other < 1e-4 * power:
        return 0.0, 0.0
    return float(along / np.sqrt(power * other)), float(np.sqrt(other / power))


def _lasting(rate: FloatArray, rows: BoolArray) -> bool:
    """Whether places have moved on at this rate (n, k), and were not just read with noise."""
    both = rows[:-_SECOND] & rows[_SECOND:]
    before, after = rate[:-_SECOND][both], rate[_SECOND:][both]
    power = np.sqrt((before**2).sum() * (after**2).sum())
    return bool((before * after).sum() > _LASTING * power)


def _against(
    readings: list[tuple[str, FloatArray]],
    rate: FloatArray,
    rows: BoolArray,
    what: str,
    *,
    level: bool,
) -> str:
    """Say how a velocity, the first of its readings, contradicts what it is the rate of.

    Unless it is known to be `level`, a vehicle that pitches goes down without a velocity downward.
    """
    found = _agreement(readings[0][1], rate, rows)
    if found is None:
        return ""
    correlation, ratio = found
    if correlation >= _AGREES:
        if _LEAST_OF_UNIT < ratio < MOST_OF_UNIT:
            return ""
        return f"is {ratio:.3g} times {what} (correlation {correlation:.2f}): check its unit."
    better = [
        how
        for how, velocity in readings[1:]
        if (agreement := _agreement(velocity, rate, rows)) is not None and agreement[0] >= _AGREES
    ]
    if correlation > _AGAINST and not better:
        if correlation > 0.3 or not level or not (ratio > _LEAST_RATIO or _lasting(rate, rows)):
            return ""
        return f"has nothing to do with {what} (correlation {correlation:.2f})."
    said = f"runs against {what} (correlation {correlation:.2f})."
    return said + (f" With {' or '.join(better)} it would agree." if better else "")
