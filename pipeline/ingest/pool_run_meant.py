"""How a velocity was meant: which reading of it follows best what moves the vehicle.

One score compares all readings: the share of the velocity that a reference leaves unexplained, the
rate of position in body axes, the acceleration that the IMU feels, or the push of the thrusters,
which a vehicle follows with a lag, with the rate of depth. Readings are the velocity as it is, with
other axes, over the earth, turned about the vertical, speeds along the beams of a DVL, and
thrusters that are swapped or reversed.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pipeline.ingest.pool_run_convert import BODY, EARTH
from pipeline.ingest.pool_run_resample import TABLE_HZ, into_body, resample, thrusters_of
from pipeline.ingest.pool_run_score import (
    SECOND,
    Meaning,
    Sums,
    about_down,
    effort_of,
    left_of,
    mean_over,
    rate_of,
    rearranged,
    sums_of_parts,
)
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable, down_axis
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: How a vehicle may lag behind the push. [s]
_LAGS_S = (0.5, 1.5, 4.0, 10.0)
#: Less way may be a drift or noise; fewer rows say nothing. [m/s, -]
_UNDER_WAY_MPS, _FEWEST_ROWS = 0.05, 240
#: Less way ahead or sideways is noise [m/s]; nearly all of a run.
_LEVEL_WAY_MPS, _MOST_OF_TIME = 0.1, 0.95
#: What is unexplained at least before another reading is looked for, one that has a free angle or
#: order, and one that has none (a third of a turn of 90 degrees leaves 0.25); and what another
#: leaves of that at most. Changes of a velocity, unlike itself, are explained to the last bit.
_OF_SPEEDS, _OF_CHANGES = (0.25, 0.08, 0.4), (0.05, 0.05, 0.55)
#: What another reading leaves at most in each half of the run.
_MOST_LEFT_OF_HALF = 0.75
#: What the rate of position leaves at most of a velocity that is as it was read.
_AGREES = 0.1
#: Readings that leave so little more than the best are told beside it, up to so many.
_ALIKE, _MOST_TOLD = 0.03, 3
#: A current that a vehicle may drift in [m/s]; rows that tell it.
_CURRENT_MPS, _ENOUGH_ROWS = 0.5, 2_000
#: A sensor stands so far from another on a vehicle, at the least that shows and at the most. [m]
_LEAST_ARM_M, _LONGEST_ARM_M = 0.3, 5.0
_TURNS_DEG, _TILTS_DEG = range(-165, 181, 15), (-45, -30, -15, 15, 30, 45)
#: Where three beams of a DVL look, clockwise from the bow: opposite, round, three in all. [deg]
_BEAMS_DEG = (
    (0, 180, 90),
    (0, 180, -90),
    (0, 90, 180),
    (0, -90, 180),
    (0, 120, 240),
    (0, 240, 120),
)
_SLANT = np.radians(25.0)


@dataclass(frozen=True)
class Reading:
    """A velocity (n, 3) in body axes as it may have been meant; how that is said or stated."""

    velocity: FloatArray
    how: str
    any_heading: bool = False
    """It is turned about the vertical by an angle that nobody knows."""


def readings_of(run: PoolRun, table: RunTable) -> list[Reading]:
    """Return the velocity in body axes as it was read, and as it might have been meant."""
    if "velocity" not in table.values:
        return []
    channel = run.channels.get("velocity") or run.channels["velocity_earth"]
    body, axes = table.values["velocity"], channel.read.axes
    read_as, found = (channel.quantity, axes), [Reading(body, "")]
    # as it stood in the messages
    is_turned = channel.quantity == "velocity_earth"
    xyz = over_earth(body, table) @ EARTH[axes] if is_turned else body @ BODY[axes]
    for one in ("frd", "flu"):
        if read_as != ("velocity", one):
            how = f"{{quantity: velocity, body_axes: {one}}}"
            found.append(Reading(xyz @ BODY[one].T, how))
    found.append(Reading(-body, "{sign: -1}"))
    attitude, rate = (table.values.get(one) for one in ("attitude", "angular_velocity"))
    turn = attitude
    if turn is None and rate is not None:  # a heading from one that nobody knows
        half = np.cumsum(np.nan_to_num(rate[:, 2])) / TABLE_HZ / 2.0
        turn = np.stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)], axis=1)
    for one in ("ned", "enu"):
        if turn is not None and read_as != ("velocity_earth", one):
            how, ned = f"{{quantity: velocity_earth, earth_axes: {one}}}", xyz @ EARTH[one].T
            found.append(Reading(into_body(ned, turn), how, any_heading=attitude is None))
    for signs in ([-1, 1, 1], [1, -1, 1], [1, 1, -1]):
        own = (xyz * signs) @ (EARTH if is_turned else BODY)[axes].T
        if is_turned and attitude is not None:
            own = into_body(own, attitude)
        found.append(Reading(own, f"{{sign: {signs}}}"))
    return found


def over_earth(velocity: FloatArray, table: RunTable) -> FloatArray:
    """Turn a velocity of the body to the earth (NED), as far as an attitude is known."""
    if "attitude" not in table.values:
        return velocity
    return into_body(velocity, table.values["attitude"] * np.array([1.0, -1.0, -1.0, -1.0]))


def meant_otherwise(
    run: PoolRun, table: RunTable, readings: Sequence[Reading], vehicle: Vehicle
) -> str:
    """Say by which readings (the first as it was read) a velocity would plainly be explained."""
    values = table.values
    rows = table.valid["velocity"] & table.valid.get("attitude", table.valid["velocity"])
    rows &= np.linalg.norm(readings[0].velocity, axis=1) > _UNDER_WAY_MPS
    if rows.sum() < _FEWEST_ROWS:
        return ""
    dvl = None if vehicle.sensors is None else vehicle.sensors.dvl
    if dvl is not None and any(dvl.position_m) and "angular_velocity" in values:
        place = np.cross(np.nan_to_num(values["angular_velocity"]), dvl.position_m)
        readings = [replace(one, velocity=one.velocity - place) for one in readings]
    if {"position", "attitude"} <= set(values):
        way = into_body(np.nan_to_num(rate_of(values["position"])), values["attitude"])
        by_place = _meanings(readings, lambda one: [(sums_of_parts(one, way, rows), np.eye(3))])
        if said := _told(by_place, "the rate of position"):
            return said
        if by_place[0].left[0] < _AGREES:
            readings = readings[:1]  # a vehicle that turns may slip sideways
    if {"specific_force", "attitude"} <= set(values):
        down = vehicle.water.gravity_mps2 * down_axis(values["attitude"])
        felt = _lively(values["specific_force"] + down)

        def changes(velocity: FloatArray) -> list[tuple[list[Sums], FloatArray]]:
            return [(sums_of_parts(_lively(change_of(velocity, table)), felt, rows), np.eye(3))]

        by_force = _meanings(readings, changes)
        by_force += _with_an_arm(readings[0].velocity, felt, rows, table, changes)
        if said := _told(by_force, "the acceleration that the IMU feels", _OF_CHANGES):
            return said
    return _by_push(run, table, readings, rows, vehicle)


def over_the_earth(
    run: PoolRun, table: RunTable, readings: Sequence[Reading], other: RunChannel
) -> str:
    """Say how a velocity of the body is over the earth, as that of another topic has it."""
    if "attitude" not in table.values:
        return ""
    theirs = resample(replace(run, channels={"velocity": other}), TABLE_HZ, off_rows=False)
    rows = np.all(
        [*(table.valid[one] for one in ("velocity", "attitude")), theirs.valid["velocity"]], axis=0
    )
    if rows.sum() < _FEWEST_ROWS // 2:
        return ""
    velocity = theirs.values["velocity"]
    meanings = _meanings(
        (readings[0], *(one for one in readings[1:] if "velocity_earth" in one.how)),
        lambda one: [(sums_of_parts(one, velocity, rows), np.eye(3))],
        is_mounted=True,
    )
    return _told(meanings, f"the velocity of {other.topic}")


def _by_push(
    run: PoolRun, table: RunTable, readings: Sequence[Reading], rows: BoolArray, vehicle: Vehicle
) -> str:
    """Say which readings, or which other order of thrusters, the push of the thrusters explains."""
    from scipy.signal import lfilter

    if not thrusters_of(run, "command"):
        return ""
    effort = effort_of(table)
    direction = {one.name: one.direction for one in vehicle.thrusters}
    arms = np.array([direction.get(name, (0.0, 0.0, 0.0)) for name in table.thrusters])
    if not effort.any() or not arms.any():
        return ""
    knows_depth = "depth" in table.values
    by_depth = np.ones((len(effort), 1))
    if knows_depth:
        by_depth = np.nan_to_num(rate_of(table.values["depth"]))
    shares = [1.0 - np.exp(-1.0 / (TABLE_HZ * lag_s)) for lag_s in _LAGS_S]
    lagging = [
        np.column_stack([lfilter([one], [1.0, one - 1.0], effort, axis=0), by_depth])
        for one in shares
    ]

    def pushes(velocity: FloatArray, *, centred: bool = False) -> list[list[Sums]]:
        return [sums_of_parts(velocity, one, rows, centred=centred) for one in lagging]

    def left(sums: Sequence[list[Sums]], some: FloatArray) -> FloatArray:
        return left_of(_with_arms(sums, some, knows_depth=knows_depth), _AS_IT_IS)[:, 0]

    found = _meanings(readings, lambda one: _with_arms(pushes(one), arms, knows_depth=knows_depth))
    if "attitude" in table.values:
        push = [one[:, :-1] @ arms for one in lagging]
        for one in push:
            one[:, 2] = by_depth[:, 0] if knows_depth else one[:, 2]
        attitude = table.values["attitude"]
        drifting = [_in_a_current(readings[0].velocity, one, attitude, rows) for one in push]
        found[0] = min([found[0], *drifting], key=lambda one: float(one.left[0]))
    moved, changed = (pushes(readings[0].velocity, centred=centred) for centred in (False, True))
    as_stated = left(changed, arms)
    for how, other in rearranged(arms, table.thrusters):
        # steady thrust does not tell thrusters
        if (left(changed, other) <= _MOST_LEFT_OF_HALF * as_stated).all():
            found.append(Meaning(left(moved, other), how, how))
    said = _told(found, "the push of the thrusters")
    return said or _against_push(readings[0].velocity, effort @ arms, rows)


def _against_push(velocity: FloatArray, push: FloatArray, rows: BoolArray) -> str:
    """Say where a vehicle goes one way throughout, and its thrusters push the other."""
    rows = rows & push.any(axis=1) & (np.linalg.norm(velocity[:, :2], axis=1) > _LEVEL_WAY_MPS)
    along = (velocity[:, :2] * push[:, :2]).sum(axis=1)[rows]
    if along.size < _FEWEST_ROWS // 2 or (along < 0.0).mean() < _MOST_OF_TIME:
        return ""
    return (
        f"is against the push of the thrusters in {100 * (along < 0.0).mean():.0f} % of the run: "
        "its axes, or the signs of the commands or of the directions in the vehicle file, are "
        "others, or a current drives the vehicle."
    )


def _in_a_current(
    velocity: FloatArray, push: FloatArray, attitude: FloatArray, rows: BoolArray
) -> Meaning:
    """Score a velocity as it was read, in water that moves: a drift is none of the thrusters'."""
    from scipy.optimize import lsq_linear

    there = np.flatnonzero(rows & np.isfinite(attitude).all(axis=1))
    there = there[:: 1 + there.size // _ENOUGH_ROWS]
    causes = np.zeros((there.size, 3, 5))
    causes[:, range(3), range(3)] = push[there]
    for axis in (0, 1):
        earth = np.tile(np.eye(3)[axis], (there.size, 1))
        causes[:, :, 3 + axis] = into_body(earth, attitude[there])
    bounds = ([0.0] * 3 + [-_CURRENT_MPS] * 2, [np.inf] * 3 + [_CURRENT_MPS] * 2)
    found = lsq_linear(causes.reshape(-1, 5), velocity[there].ravel(), bounds).x
    rest = ((velocity[there] - causes @ found) ** 2).sum(axis=1)
    power, half = (velocity[there] ** 2).sum(axis=1), there.size // 2
    parts = (slice(None), slice(0, half), slice(half, None))
    left = np.array([rest[part].sum() / max(float(power[part].sum()), 1e-9) for part in parts])
    return Meaning(left, "", "")


def _with_arms(
    sums: Sequence[list[Sums]], arms: FloatArray, *, knows_depth: bool
) -> list[tuple[list[Sums], FloatArray]]:
    """Return references with the arms of thrusters; the last cause acts downwards alone."""
    wide = np.vstack([arms, np.zeros(3)])
    down = np.zeros_like(wide)
    down[-1, 2] = 1.0
    if knows_depth:
        return [(one, wide * [1.0, 1.0, 0.0] + down) for one in sums]
    # without a depth a vehicle may also rise or sink by itself
    return [*((one, wide) for one in sums), (sums[0], down), (sums[0], -down)]


def _told(
    found: Sequence[Meaning], what: str, limits: tuple[float, float, float] = _OF_SPEEDS
) -> str:
    """Put the better readings into words, the best of each kind that is about as good."""
    as_read, (least_fitted, least_fixed, most_left) = found[0], limits
    better = [
        one
        for one in found[1:]
        if as_read.left[0] > (least_fitted if one.fitted else least_fixed)
        and one.is_plainly_better(as_read, most_left, _MOST_LEFT_OF_HALF)
    ]
    better.sort(key=lambda one: one.left[0])
    kinds = {one.kind: one for one in reversed(better) if one.left[0] < better[0].left[0] + _ALIKE}
    if not kinds:
        return ""
    listed = "; ".join(
        f"{100.0 * (1.0 - one.left[0]):.0f} % if {one.how}"
        for one in sorted(kinds.values(), key=lambda one: one.left[0])[:_MOST_TOLD]
    )
    share = f"{100.0 * (1.0 - as_read.left[0]):.0f} %"
    return f"contradicts the motion: {what} explains {share} of it as it was read; {listed}."


def _meanings(
    readings: Sequence[Reading],
    references: Callable[[FloatArray], Sequence[tuple[Sequence[Sums], FloatArray]]],
    *,
    is_mounted: bool = False,
) -> list[Meaning]:
    """Score all readings that need no other order of thrusters; the first is as it was read.

    Those of a sensor that stands turned are left out where it `is_mounted` as stated.
    """
    found = []
    for reading in readings:
        how = f"stated as {reading.how}"
        matrices = _ABOUT_DOWN if reading.any_heading else _AS_IT_IS
        each = left_of(references(reading.velocity), matrices)
        found.append(Meaning(each[:, each[0].argmin()], how, how, fitted=reading.any_heading))
    if len(readings) > 1 and not is_mounted:
        turned = left_of(references(readings[0].velocity), _TURNED).T
        for (kind, how), left in zip(_TURNED_HOW, turned, strict=True):
            found.append(Meaning(left, how, kind))
    return found


def _with_an_arm(
    velocity: FloatArray,
    felt: FloatArray,
    rows: BoolArray,
    table: RunTable,
    references: Callable[[FloatArray], Sequence[tuple[Sequence[Sums], FloatArray]]],
) -> Iterator[Meaning]:
    """Score a velocity as that of a sensor away from the IMU, on a vehicle that turns."""
    if "angular_velocity" not in table.values:
        return
    rate = np.nan_to_num(table.values["angular_velocity"])
    own = [np.cross(rate, axis) for axis in np.eye(3)]
    more = (_lively(change_of(velocity, table)) - felt)[rows].ravel()
    causes = np.stack([_lively(change_of(one, table))[rows].ravel() for one in own], axis=1)
    arm = np.linalg.lstsq(np.nan_to_num(causes), np.nan_to_num(more), rcond=None)[0]
    if not _LEAST_ARM_M < np.linalg.norm(arm) < _LONGEST_ARM_M:
        return
    place = ", ".join(f"{one:.1f}" for one in arm)
    how = f"it is read at ({place}) m from the IMU (sensors: dvl: position_m)"
    left = left_of(references(velocity - np.cross(rate, arm)), _AS_IT_IS)[:, 0]
    yield Meaning(left, how, "arm")


def change_of(velocity: FloatArray, table: RunTable) -> FloatArray:
    """Return the acceleration (n, 3) of a velocity in body axes [m/s2]."""
    change = rate_of(velocity)
    if "angular_velocity" in table.values:
        change += np.cross(np.nan_to_num(table.values["angular_velocity"]), velocity)
    return change


def _lively(values: FloatArray) -> FloatArray:
    """Return the mean over a second less that over ten, in which an attitude drifts."""
    return mean_over(values, SECOND) - mean_over(values, 10 * SECOND)


def _of_beams(azimuths_deg: Sequence[float]) -> FloatArray:
    """Return the matrix that makes a velocity of three speeds along beams."""
    angle = np.radians(azimuths_deg)
    across, along = np.sin(_SLANT), np.full(3, np.cos(_SLANT))
    return np.linalg.inv(np.stack([across * np.cos(angle), across * np.sin(angle), along], axis=1))


def _about(tilt_deg: float, axis: str) -> FloatArray:
    """Return the matrix that takes a tilt about an axis off a vector."""
    turn = about_down(tilt_deg)
    order = [2, 0, 1] if axis == "x" else [1, 2, 0]
    return turn[np.ix_(order, order)]


def _turned() -> Iterator[tuple[tuple[str, str], FloatArray]]:
    for turn in _TURNS_DEG:
        about = about_down(turn)
        if turn:
            how = f"it is read turned by {turn} degrees (sensors: dvl: rotation_deg)"
            yield ("turned", how), about
            flipped = f"it is read with y to port and z up, turned by {turn} degrees"
            yield ("flipped", flipped), about @ BODY["flu"]
        for azimuths in _BEAMS_DEG:
            for sign in (1.0, -1.0):
                of_beams = "it is read as speeds along the beams of a DVL"
                yield ("beams", of_beams), sign * about @ _of_beams(azimuths)
    for tilt, axis in product(_TILTS_DEG, "xy"):
        how = f"it is read tilted by {tilt} degrees about {axis} (sensors: dvl: rotation_deg)"
        yield ("tilted", how), _about(tilt, axis)


_AS_IT_IS = np.eye(3)[None]
_ABOUT_DOWN = np.array([about_down(turn) for turn in _TURNS_DEG])
_TURNED_HOW = [how for how, _ in _turned()]
_TURNED = np.array([matrix for _, matrix in _turned()])
