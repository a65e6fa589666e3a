"""Whether a velocity is that of the motion: against depth, position, and what thrusters can do."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.pool_run_resample import into_body, resample, thrusters_of
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

_TABLE_HZ = 10.0
#: Way is compared over so many rows, from every so many on. 1 s, 0.5 s
_WINDOW, _STEP = 10, 5
_LEAST_WINDOWS = 12
#: Less way in a window is noise. [m]
_LEAST_WAY_M = 0.02
_AGAINST, _AGREES = -0.6, 0.8
#: A velocity less than this share of the rate of place may be right: noise of the place hides it.
_LEAST_RATIO = 0.5
#: Correlation of a way with the next one, at least: -0.5 if places are noise, near 1 in motion.
_LASTING = 0.5
#: Of its size, the share of a velocity across the vehicle that no thruster makes.
_MOST_ACROSS, _LITTLE_ACROSS = 0.5, 0.25
_ACROSS_THRUST = 0.2
#: Of the largest push; less way may be a drift; no vehicle brakes for most of its run. [-, m/s, -]
_PUSHED, _UNDER_WAY_MPS, _MOSTLY_AGAINST = 0.3, 0.05, 0.8


@dataclass(frozen=True)
class _Reading:
    """The velocity (n, 3) over the earth (NED) if it were read otherwise; how that is stated."""

    velocity_ned: FloatArray
    stated: str


def velocity_against_motion(run: PoolRun, vehicle: Vehicle, place: Place) -> list[Problem]:
    """Compare a velocity with the way that depth and position have gone, and with the thrusters.

    A warning for each contradiction, with its figures and what would agree.
    """
    names = [name for name in ("velocity", "velocity_earth") if name in run.channels]
    if not names or (names == ["velocity_earth"] and "attitude" not in run.channels):
        return []
    beside = [name for name in ("attitude", "depth", "position") if name in run.channels]
    table = resample(run, _TABLE_HZ, quantities=("velocity", *beside))
    own, others = _readings(run, table)
    topic = run.channels[names[0]].topic
    there = table.valid["velocity"] & table.valid.get("attitude", table.valid["velocity"])
    found = []
    if "depth" in beside:
        rows = there & table.valid["depth"]
        depth = table.values["depth"]
        said = _against(own, others, depth, rows, slice(2, 3), "the rate of depth")
        found += [f"the downward velocity ({topic}) {said}"] if said else []
    if "position" in beside and "attitude" in beside:
        rows = there & table.valid["position"]
        way = table.values["position"][:, :2]
        said = _against(own, others, way, rows, slice(0, 2), "the rate of position")
        found += [f"the horizontal velocity ({topic}) {said}"] if said else []
    if "attitude" in beside and not found:
        said = _across(table, others, there, vehicle)
        found += [f"the velocity ({topic}) {said}"] if said else []
    if not found:
        said = _against_thrust(run, table, there, vehicle)
        found += [f"the velocity ({topic}) {said}"] if said else []
    remedy = "Check its axes, sign and unit under pool: channels in vehicle.yaml."
    return [place.warning(what, remedy=remedy) for what in found]


def _readings(run: PoolRun, table: RunTable) -> tuple[FloatArray, list[_Reading]]:
    """Return the velocity over the earth as it was read, and as it might have been meant."""
    body = table.values["velocity"]
    attitude = table.values.get("attitude")
    channel = run.channels.get("velocity")

    def over_earth(velocity: FloatArray) -> FloatArray:
        if attitude is None:
            return velocity
        return into_body(velocity, attitude * np.array([1.0, -1.0, -1.0, -1.0]))

    others = [_Reading(over_earth(-body), "sign: -1")]
    if channel is not None:
        axes = channel.read.axes
        turned = "frd" if axes == "flu" else "flu"
        across = np.array([1.0, -1.0, -1.0])
        others.insert(0, _Reading(over_earth(body * across), f"body_axes: {turned}"))
        if attitude is not None:
            ned = body if axes != "flu" else np.stack([-body[:, 1], body[:, 0], body[:, 2]], axis=1)
            earth = "enu" if axes == "flu" else "ned"
            stated = f"quantity: velocity_earth, earth_axes: {earth}"
            others.append(_Reading(ned, stated))
    return over_earth(body), others


def _ways(values: FloatArray, rows: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Add values (n, k) up over each window, and say which windows have all their rows."""
    begin = np.arange(0, values.shape[0] - _WINDOW, _STEP)
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    count = np.concatenate([[0], np.cumsum(rows)])
    return total[begin + _WINDOW] - total[begin], count[begin + _WINDOW] - count[begin] == _WINDOW


def _agreement(
    velocity: FloatArray, place: FloatArray, rows: BoolArray
) -> tuple[float, float] | None:
    """Correlation of the way by velocity (n, k) with that by places (n, k), and their ratio."""
    rows = rows & np.concatenate([[False], rows[:-1]])  # a change needs two places
    speed = np.where(rows[:, None], velocity, 0.0)
    change = np.zeros_like(place)
    change[1:] = np.diff(place, axis=0)
    change[~rows] = 0.0
    by_velocity, whole = _ways(speed / _TABLE_HZ, rows)
    by_place, _ = _ways(change, rows)
    by_velocity, by_place = by_velocity[whole], by_place[whole]
    if by_place.shape[0] < _LEAST_WINDOWS or np.sqrt((by_place**2).mean()) < _LEAST_WAY_M:
        return None
    if by_place.shape[1] == 1:  # a steady offset of a depth says nothing
        by_velocity, by_place = by_velocity - by_velocity.mean(), by_place - by_place.mean()
    power = float((by_place**2).sum())
    other = float((by_velocity**2).sum())
    if power <= by_place.size * (0.5 * _LEAST_WAY_M) ** 2:
        return None
    if other < 1e-4 * power:
        return 0.0, 0.0
    along = float((by_velocity * by_place).sum())
    return along / np.sqrt(power * other), float(np.sqrt(other / power))


def _lasting(place: FloatArray, rows: BoolArray) -> bool:
    """Whether places (n, k) have moved on, and were not just read with noise."""
    change = np.diff(place, axis=0, prepend=place[:1])
    rows = rows & np.concatenate([[False], rows[:-1]])
    ways, whole = _ways(np.where(rows[:, None], change, 0.0), rows)
    apart = _WINDOW // _STEP
    both = whole[:-apart] & whole[apart:]
    before, after = ways[:-apart][both], ways[apart:][both]
    power = np.sqrt((before**2).sum() * (after**2).sum())
    return bool((before * after).sum() > _LASTING * power)


def _against(  # noqa: PLR0917  one comparison
    own: FloatArray,
    others: list[_Reading],
    place: FloatArray,
    rows: BoolArray,
    axes: slice,
    what: str,
) -> str:
    """Say how a velocity contradicts what it is the rate of; nothing where it agrees."""
    found = _agreement(own[:, axes], place, rows)
    if found is None:
        return ""
    correlation, ratio = found
    if correlation >= _AGREES:
        if 0.4 < ratio < 2.5:
            return ""
        return f"is {ratio:.3g} times {what} (correlation {correlation:.2f}): check its unit."
    better = [
        one.stated
        for one in others
        if (agreement := _agreement(one.velocity_ned[:, axes], place, rows)) is not None
        and agreement[0] >= _AGREES
    ]
    if correlation > _AGAINST and not better:
        if correlation > 0.3 or not (ratio > _LEAST_RATIO or _lasting(place, rows)):
            return ""
        return f"has nothing to do with {what} (correlation {correlation:.2f})."
    said = f"runs against {what} (correlation {correlation:.2f})."
    listed = " or ".join(f"{{{one}}}" for one in better)
    return said + (f" With {listed} it would agree." if better else "")


def _across(table: RunTable, others: list[_Reading], rows: BoolArray, vehicle: Vehicle) -> str:
    """Say where a vehicle goes sideways that no thruster pushes sideways, and what it might be."""
    pushes = [abs(one.direction[1]) for one in vehicle.thrusters]
    if not pushes or max(pushes) > _ACROSS_THRUST or rows.sum() < _LEAST_WINDOWS * _STEP:
        return ""
    share = _share_across(table.values["velocity"][rows])
    if share < _MOST_ACROSS:
        return ""
    over_earth = [one for one in others if "velocity_earth" in one.stated]
    for one in over_earth:
        turned = into_body(one.velocity_ned[rows], table.values["attitude"][rows])
        there = _share_across(turned)
        if there < _LITTLE_ACROSS:
            return (
                f"is sideways by {100 * share:.0f} % of its size, and no thruster pushes "
                f"sideways; as one over the earth, {{{one.stated}}}, it would be so by "
                f"{100 * there:.0f} %."
            )
    return (
        f"is sideways by {100 * share:.0f} % of its size, and no thruster pushes sideways: the "
        "sensor is mounted turned (sensors: dvl: rotation_deg), its axes are others, or a current "
        "drives the vehicle."
    )


def _against_thrust(run: PoolRun, table: RunTable, rows: BoolArray, vehicle: Vehicle) -> str:
    """Say where a vehicle goes astern while its thrusters push ahead, or the other way."""
    if not thrusters_of(run, "command"):
        return ""
    code = np.nan_to_num(resample(run, _TABLE_HZ, quantities=("command",)).values["command"])
    ahead = {thruster.name: thruster.direction[0] for thruster in vehicle.thrusters}
    along = np.array([ahead.get(name, 0.0) for name in table.thrusters])
    push = (code * np.abs(code)) @ along
    speed = table.values["velocity"][:, 0]
    driven = rows & (np.abs(push) > _PUSHED * np.abs(push).max()) & (np.abs(speed) > _UNDER_WAY_MPS)
    if driven.sum() < _LEAST_WINDOWS * _WINDOW:
        return ""
    against = float((np.sign(speed[driven]) != np.sign(push[driven])).mean())
    if against < _MOSTLY_AGAINST:
        return ""
    return (
        f"goes against what the thrusters push in {100 * against:.0f} % of the time: the sensor is "
        "mounted turned (sensors: dvl: rotation_deg), its axes or the directions of the thrusters "
        "are others, or a current drives the vehicle."
    )


def _share_across(velocity: FloatArray) -> float:
    size = float(np.sqrt((velocity[:, :2] ** 2).sum(axis=1).mean()))
    return float(np.sqrt((velocity[:, 1] ** 2).mean())) / size if size > _LEAST_WAY_M else 0.0


def disagreeing_frames(tables: Mapping[str, RunTable], axes: Mapping[str, str]) -> dict[str, str]:
    """Find velocities that are over the earth although they are said to be of the body.

    `tables` have velocity and attitude, `axes` the body axes in which it was read, by topic.
    Returns the figures: turned by the attitude it is the velocity of another topic.
    """
    found: dict[str, str] = {}
    for topic, table in tables.items():
        rows = table.valid["velocity"] & table.valid["attitude"]
        body = table.values["velocity"]
        ned = body if axes[topic] != "flu" else np.stack([-body[:, 1], body[:, 0], body[:, 2]], 1)
        turned = into_body(ned, table.values["attitude"])
        for other, theirs in tables.items():
            both = rows & theirs.valid["velocity"]
            if other == topic or both.sum() < _LEAST_WINDOWS * _STEP or other in found:
                continue
            as_read = _difference(body[both], theirs.values["velocity"][both])
            as_turned = _difference(turned[both], theirs.values["velocity"][both])
            if as_read > 0.4 and as_turned < 0.2:
                found[topic] = (
                    f"{topic} is over the earth, whatever its frame says: turned by the attitude "
                    f"it differs from {other} by {100 * as_turned:.0f} %, as it stands by "
                    f"{100 * as_read:.0f} %"
                )
    return found


def _difference(first: FloatArray, second: FloatArray) -> float:
    """Size of the difference of two velocities against that of the second."""
    size = float(np.linalg.norm(second))
    return float(np.linalg.norm(first - second)) / size if size > 0 else float("inf")
