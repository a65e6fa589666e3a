"""Whether accelerometer, attitude, rates, depth and position agree on where down is."""

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.pool_run_resample import TABLE_HZ
from pipeline.ingest.pool_run_score import mean_over
from pipeline.ingest.quantities import largest
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable, down_axis, quaternion_product
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

CHECK_UNIT = "State the unit under pool: channels in vehicle.yaml."
_LEAST_ROWS = 100
#: A vehicle that accelerates by a third of gravity feels it 18 degrees off.
_MOST_APART_DEG = 30.0
#: Tilts of two degrees tell whether both go with each other, and how far they may be at odds.
_LEAST_TILT, _MOST_AGAINST = 0.04, 0.3
#: A second of the table.
_SMOOTH = 20
#: About half of gravity: less does not say where down is.
_LEAST_MPS2 = 5.0
#: No vehicle spends half of a run tilted further, unless it is upside down.
_MOST_TILTED_DEG = 60.0
#: A run under water leaves its first decimetres, or moves by more than one of it. [Pa]
_NEAR_PA, _STILL_PA = 2500.0, 1000.0
#: One atmosphere and some metres of water, read as pascals above the surface -> the unit it is.
_ATMOSPHERES = ((800.0, 1500.0, "hPa (mbar)"), (80.0, 150.0, "kPa"))
_ABOVE_WATER_M = -0.3
#: Trials are not as deep; whose are can state the unit. [m]
_DEEP_M = 100.0
#: Nothing dives or surfaces faster but what falls free. [m/s]
_FASTEST_MPS = 4.0
_MOVING_M, _AGAINST = 0.03, -0.8
#: A depth that swings so many times as much as is felt is in a smaller unit; how alike both are.
_MOST_OF_UNIT, _FELT_ALIKE = 1.7, 0.6
#: Two depths of one vehicle differ by places of sensors, air pressure and water: [m], and a share.
_LEAST_APART_M, _APART = 0.5, 0.15


def gravity_against_attitude(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Compare the direction of the specific force with down as the attitude has it.

    At rest an accelerometer feels gravity upwards, f = -g R^T e_z. Under way its median direction
    is still that, as no vehicle accelerates one way for half of the time.
    """
    if not {"attitude", "specific_force"} <= set(table.values):
        return
    rows = table.valid["attitude"] & table.valid["specific_force"]
    force = table.values["specific_force"][rows]
    down = down_axis(table.values["attitude"][rows])
    apart_deg = _apart_deg(force, down)
    attitude, specific = run.channels["attitude"].topic, run.channels["specific_force"].topic
    if apart_deg >= _MOST_APART_DEG:
        said = f"{apart_deg:.0f} degrees apart"
    else:
        tilts = [_correlation(-down[:, axis], force[:, axis], _LEAST_TILT) for axis in (0, 1)]
        against = min((one for one in tilts if one is not None), default=1.0)
        if against > _MOST_AGAINST:
            return
        said = f"at odds when the vehicle tilts (correlation {against:.2f})"
    yield run.place.warning(
        f"down by the specific force ({specific}) and down by the attitude ({attitude}) are "
        f"{said}.",
        remedy="Check axes, sign and, of a quaternion, order of both under pool: channels in "
        "vehicle.yaml.",
    )


def turning_of_gravity(
    force: FloatArray, rate: FloatArray, rate_hz: float
) -> tuple[FloatArray, FloatArray]:
    """Return rates of roll and pitch (k, 2) by how gravity turns, and as they were measured.

    Of a specific force and rates (n, 3) at `rate_hz`. A vehicle that is about level has
    df_y / dt = p f_z and df_x / dt = -q f_z. Over a second each, and a second: the noise of an
    accelerometer is far above its change in a step.
    """
    change = (force[_SMOOTH:] - force[:-_SMOOTH]) * rate_hz / _SMOOTH
    down = float(np.nanmedian(force[:, 2]))
    if not abs(down) > _LEAST_MPS2:
        return np.zeros((0, 2)), np.zeros((0, 2))
    both = np.stack([change[:, 1], -change[:, 0]], axis=1) / down
    second = np.full(_SMOOTH, 1.0 / _SMOOTH)
    measured = np.stack([np.convolve(one, second, "valid")[:-1] for one in rate[:, :2].T], axis=1)
    there = np.isfinite(both).all(axis=1) & np.isfinite(measured).all(axis=1)
    return mean_over(both[there], _SMOOTH), mean_over(measured[there], _SMOOTH)


def _correlation(first: FloatArray, second: FloatArray, least: float) -> float | None:
    """Correlation of what moves, None where the first moves less than `least`."""
    if first.size < _LEAST_ROWS or np.std(first) < least or not np.std(second) > 0.0:
        return None
    return float(np.corrcoef(first, second)[0, 1])


def down_against_level(run: PoolRun) -> Iterator[Problem]:
    """Compare down by the attitude or by the specific force with that of a level vehicle.

    For logs that have one of them, where nothing else shows that axes or order are others.
    """
    both = [run.channels.get(name) for name in ("attitude", "specific_force")]
    channel = both[0] or both[1]
    if channel is None or all(both):
        return
    kept = channel.values[channel.usable()]
    kept = kept[np.isfinite(kept).all(axis=1) & kept.any(axis=1)]
    is_force = channel is both[1]
    if is_force and (not kept.size or np.median(np.linalg.norm(kept, axis=1)) < _LEAST_MPS2):
        return  # gravity was taken out, which is told of the sizes
    down = -kept if is_force else down_axis(kept / np.linalg.norm(kept, axis=1, keepdims=True))
    apart_deg = _apart_deg(np.tile([0.0, 0.0, -1.0], (len(kept), 1)), down)
    if apart_deg < _MOST_TILTED_DEG:
        return
    by = "specific force" if is_force else "attitude"
    what = (
        f"down by the {by} ({channel.topic}) is {apart_deg:.0f} degrees from the z axis "
        f"of the body, with the axes {channel.read.axes}: the vehicle lay on its side or back, or "
        f"the axes{'' if is_force else ', unit or order'} are others."
    )
    remedy = "State body_axes (such as flu) or order (wxyz) under pool: channels in vehicle.yaml."
    yield run.place.warning(what, remedy=remedy)


def _apart_deg(force: FloatArray, down: FloatArray) -> float:
    """Median angle between what accelerometers feel and up (n, 3); 0 where there is little."""
    size = np.linalg.norm(force, axis=1)
    felt = size > 0.0
    if felt.sum() < _LEAST_ROWS:
        return 0.0
    other = down[felt] / np.linalg.norm(down[felt], axis=1, keepdims=True)
    cosine = -(force[felt] / size[felt, None] * other).sum(axis=1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1.0, 1.0)))))


def turning(attitude: FloatArray, rate_hz: float) -> FloatArray:
    """Return the rates (n, 3) in body axes of attitudes (n, 4) that follow at `rate_hz`.

    [rad/s], each from the attitude before to the one after; not a number at both ends.
    """
    step = quaternion_product(attitude[:-2] * np.array([1.0, -1.0, -1.0, -1.0]), attitude[2:])
    rate = np.full((len(attitude), 3), np.nan)
    rate[1:-1] = step[:, 1:] * np.where(step[:, :1] < 0, -1.0, 1.0) * rate_hz
    return rate


def doubtful_depths(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Warn where depths are those of a pressure in another unit, or lie above the water.

    The vehicle's water turns depths back into pressures.
    """
    channel = run.channels.get("depth")
    depth = np.zeros(0) if channel is None else channel.values[channel.usable()].ravel()
    depth = depth[np.isfinite(depth)]
    if channel is None or not depth.size:
        return
    middle = float(np.median(depth))
    is_stated = channel.read.unit_from in {"vehicle file", "notes of the run"}
    assumed = "" if is_stated else channel.read.quantity
    if assumed == "depth" and _DEEP_M < middle < largest("depth"):
        yield run.place.warning(
            f"the depth ({channel.topic}) is {middle:.4g} m for half of the run, and nobody says "
            f"that it is in m: in cm it would be {middle / 100.0:.3g} m, in mm "
            f"{middle / 1000.0:.3g} m.",
            remedy=CHECK_UNIT,
        )
        return
    if assumed == "pressure":
        # near the surface a gauge reads as little, but then it also reads about zero
        raw_pa = depth * vehicle.water.density_kgpm3 * vehicle.water.gravity_mps2
        low, typical, high = (float(one) for one in np.quantile(raw_pa, [0.02, 0.5, 0.98]))
        said = ""
        for least, most, unit in _ATMOSPHERES:
            if least <= low and typical <= most:
                said = (
                    f"the pressure ({channel.topic}) is about {typical:.4g} Pa above the "
                    f"surface throughout, a depth of {middle:.2g} m: this looks like {unit}."
                )
        is_still = 0.0 < high - low < _STILL_PA and abs(typical) < _NEAR_PA
        if not said and (is_still or 0.0 < low < high < _NEAR_PA):
            said = (
                f"the pressure ({channel.topic}) stays within {max(high - low, abs(typical)):.2g} "
                f"Pa of the surface throughout, a depth of {middle:.2g} m: the vehicle was not "
                "under water, or this is bar, dbar, psi, kPa or hPa (mbar), or the pressure "
                "inside of it."
            )
        if said:
            yield run.place.warning(said, "pressure in Pa.", CHECK_UNIT)
            return
    # on deck a gauge reads 0: only a wrong sign or surface makes it negative for a while
    middle = min(middle, float(np.quantile(depth, 0.05)))
    if middle < _ABOVE_WATER_M:
        yield run.place.warning(
            f"the depth ({channel.topic}) is {middle:.3g} m for a good part of the run: "
            "above the water. Its sign, or the pressure at the surface, is another.",
            "depth positive downwards.",
            "State sign: -1, or surface_pressure_pa, under pool: channels in vehicle.yaml.",
        )


def depth_against_pressure(channel: RunChannel, by_pressure: Sequence[RunChannel]) -> str:
    """Say how many times that by a pressure a depth is, where that is more than a calibration.

    Pascals show by themselves that they are some; metres do not.
    """
    depth = _median(channel)
    for other in by_pressure if channel.read.quantity == "depth" else ():
        of_other = _median(other)
        least = _LEAST_APART_M + _APART * abs(of_other)
        if abs(depth - of_other) > least and of_other > _LEAST_APART_M:
            by = f"({other.topic}: {', '.join(other.read.fields)})"
            return (
                f"the depth ({channel.topic}: {', '.join(channel.read.fields)}) is "
                f"{depth / of_other:.3g} times that by the pressure {by}: check its unit"
            )
    return ""


def _median(channel: RunChannel) -> float:
    values = channel.values[channel.usable()]
    return float(np.nanmedian(values)) if np.isfinite(values).any() else float("nan")


def depth_too_fast(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Say where a depth changes faster than any vehicle sinks or rises."""
    channel = run.channels.get("depth")
    if channel is None:
        return
    depth = table.values["depth"][:, 0]
    change = np.abs(depth[_SMOOTH:] - depth[:-_SMOOTH]) * TABLE_HZ / _SMOOTH
    change = change[np.isfinite(change)]
    fast = float(np.quantile(change, 0.9)) if change.size > _SMOOTH else 0.0
    if fast > _FASTEST_MPS:
        yield run.place.warning(
            f"the depth ({channel.topic}) changes by {fast:.3g} m a second for a good part of the "
            "run, more than is possible: its unit is probably off by a factor such as 100.",
            remedy=CHECK_UNIT,
        )


def depth_against_felt(run: PoolRun, table: RunTable, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where a depth swings plainly more than the accelerometer feels the vehicle do.

    z(t + s) - 2 z(t) + z(t - s) is the acceleration downwards, weighted by a triangle over 2 s.
    """
    if not {"depth", "attitude", "specific_force"} <= set(table.values):
        return
    depth, force = table.values["depth"][:, 0], table.values["specific_force"]
    felt = (force * down_axis(table.values["attitude"])).sum(axis=1) + vehicle.water.gravity_mps2
    weight = 1.0 - np.abs(np.arange(1 - _SMOOTH, _SMOOTH)) / _SMOOTH
    if len(depth) < _LEAST_ROWS:
        return
    swing = depth[2 * _SMOOTH :] - 2.0 * depth[_SMOOTH:-_SMOOTH] + depth[: -2 * _SMOOTH]
    made = np.convolve(felt, weight, "valid")[1:-1] * _SMOOTH / TABLE_HZ**2
    there = np.isfinite(swing) & np.isfinite(made)
    if there.sum() < _LEAST_ROWS:
        return
    swing, made = swing[there] - swing[there].mean(), made[there] - made[there].mean()
    along, power = float(swing @ made), max(float(made @ made), 1e-12)
    alike = along / max(float(np.sqrt(power * (swing @ swing))), 1e-12)
    if alike > _FELT_ALIKE and along > _MOST_OF_UNIT * power:
        yield run.place.warning(
            f"the depth ({run.channels['depth'].topic}) changes {along / power:.3g} times as "
            "much as the acceleration that the IMU feels has it: check its unit.",
            remedy=CHECK_UNIT,
        )


def position_against_depth(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Say where the third component of a position falls as the depth grows: it points up."""
    position, depth = run.channels.get("position"), run.channels.get("depth")
    if position is None or depth is None or position.topic == depth.topic:
        return
    rows = table.valid["position"] & table.valid["depth"]
    expected, down = table.values["depth"][rows, 0], table.values["position"][rows, 2]
    if rows.sum() < _LEAST_ROWS or min(np.std(expected), np.std(down)) < _MOVING_M:
        return
    correlation = float(np.corrcoef(expected, down)[0, 1])
    if correlation <= _AGAINST:
        yield run.place.warning(
            f"the position ({position.topic}) rises as the depth ({depth.topic}) grows "
            f"(correlation {correlation:.2f}): its z axis points up.",
            f"a position in {position.read.axes}.",
            "State earth_axes: enu (or nwu) of the position under pool: channels in vehicle.yaml.",
        )
