"""What the sizes of one channel say: units off by a factor, impossible readings, a wrong down."""

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.message_fields import impossible
from pipeline.ingest.pool_run_resample import TABLE_HZ
from pipeline.ingest.pool_run_score import SECOND
from pipeline.ingest.quantities import largest
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable, down_axis
from pipeline.vehicle.schema import Vehicle

CHECK_UNIT = "State the unit under pool: channels in vehicle.yaml."
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
#: More than a turn a second is no vehicle's: these are degrees. [rad/s]
_FAST_RADPS = 2.0 * np.pi
_LEAST_ROWS = 100
#: About half of gravity: less does not say where down is.
LEAST_MPS2 = 5.0
#: A vehicle that accelerates by a third of gravity feels it 18 degrees off.
MOST_APART_DEG, _MOST_TILTED_DEG = 30.0, 60.0
#: A run under water leaves its first decimetres, or moves by more than one of it. [Pa]
_NEAR_PA, _STILL_PA = 2500.0, 1000.0
#: One atmosphere and some metres of water, read as pascals above the surface -> the unit it is.
_ATMOSPHERES = ((800.0, 1500.0, "hPa (mbar)"), (80.0, 150.0, "kPa"))
_ABOVE_WATER_M = -0.3
#: Trials are not as deep; whose are can state the unit. [m]
_DEEP_M = 100.0
#: Nothing dives or surfaces faster but what falls free. [m/s]
_FASTEST_MPS = 4.0
#: Two depths of one vehicle differ by places of sensors, air pressure and water: [m], and a share.
_LEAST_APART_M, _APART = 0.5, 0.15


def sizes(run: PoolRun) -> Iterator[Problem]:
    """Say where a quantity is larger than it can be, or gravity is not what it should be."""
    for name, channel in run.channels.items():
        size, high = _usual_and_large(channel)
        if channel.quantity == "specific_force" and size > 0:
            likely = looks_like(size / 9.81, tolerance=0.15)
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


def impossible_readings(run: PoolRun) -> Iterator[Problem]:
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


def supply(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where the supply is far from the voltage of the vehicle file."""
    channel = run.channels.get("voltage")
    sensor = None if vehicle.sensors is None else vehicle.sensors.voltage
    if channel is None or sensor is None:
        return
    size, _ = _usual_and_large(channel)
    if not size > 0 or 0.5 < size / sensor.nominal_v < 1.5:
        return
    likely = looks_like(size / sensor.nominal_v, tolerance=0.4)
    looks = f": it looks like {likely}" if likely else ""
    yield run.place.warning(
        f"the supply ({channel.topic}) is {size:.4g} V where the vehicle file says "
        f"{sensor.nominal_v:g} V{looks}.",
        remedy=CHECK_UNIT,
    )


def down_apart(run: PoolRun, table: RunTable) -> Iterator[Problem]:
    """Compare down by the specific force and by the attitude, or the one of them that there is.

    At rest an accelerometer feels gravity upwards, f = -g R^T e_z. Under way its median direction
    is still that, as no vehicle accelerates one way for half of the time; nor is one tilted by more
    than `_MOST_TILTED_DEG` for half of a run, unless it is upside down.
    """
    names = [one for one in ("specific_force", "attitude") if one in table.values]
    channels = [run.channels[one] for one in names]
    if len(names) == 2 and (apart_deg := down_apart_deg(table)) >= MOST_APART_DEG:
        force, attitude = (one.topic for one in channels)
        yield run.place.warning(
            f"down by the specific force ({force}) and down by the attitude ({attitude}) are "
            f"{apart_deg:.0f} degrees apart.",
            remedy="Check axes, sign and, of a quaternion, order of both under pool: channels in "
            "vehicle.yaml.",
        )
    elif len(names) == 1 and (apart_deg := down_apart_deg(table)) >= _MOST_TILTED_DEG:
        is_force = names == ["specific_force"]
        yield run.place.warning(
            f"down by the {'specific force' if is_force else 'attitude'} ({channels[0].topic}) is "
            f"{apart_deg:.0f} degrees from the z axis of the body, with the axes "
            f"{channels[0].read.axes}: the vehicle lay on its side or back, or the axes"
            f"{'' if is_force else ', unit or order'} are others.",
            remedy="State body_axes (such as flu) or order (wxyz) under pool: channels in "
            "vehicle.yaml.",
        )


def down_apart_deg(table: RunTable) -> float:
    """Median angle between two opinions of down, or one and that of a level vehicle [deg].

    0 where little or no gravity is felt.
    """
    names = [one for one in ("specific_force", "attitude") if one in table.values]
    rows = np.all([table.trusted(one) for one in names], axis=0)
    each = [table.values[one][rows] for one in names]
    downs = [-one if one.shape[1] == 3 else down_axis(one) for one in each]
    felt = np.all([one.any(axis=1) for one in downs], axis=0)
    if felt.sum() < _LEAST_ROWS or np.median(np.linalg.norm(each[0], axis=1)) < (
        LEAST_MPS2 if len(names) == 1 and names[0] == "specific_force" else 0.0
    ):
        return 0.0
    first, second = (one[felt] for one in (*downs, np.tile([0.0, 0.0, 1.0], (len(felt), 1)))[:2])
    cosine = (first * second).sum(axis=1) / np.linalg.norm(first, axis=1)
    cosine /= np.linalg.norm(second, axis=1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1.0, 1.0)))))


def doubtful_depths(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Warn where depths are those of a pressure in another unit, or lie above the water."""
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
        unit = next(
            (one for least, most, one in _ATMOSPHERES if least <= low and typical <= most), ""
        )
        is_still = 0.0 < high - low < _STILL_PA and abs(typical) < _NEAR_PA
        said = ""
        if unit:
            said = (
                f"the pressure ({channel.topic}) is about {typical:.4g} Pa above the "
                f"surface throughout, a depth of {middle:.2g} m: this looks like {unit}."
            )
        elif is_still or 0.0 < low < high < _NEAR_PA:
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
    change = np.abs(depth[SECOND:] - depth[:-SECOND]) * TABLE_HZ / SECOND
    change = change[np.isfinite(change)]
    fast = float(np.quantile(change, 0.9)) if change.size > SECOND else 0.0
    if fast > _FASTEST_MPS:
        yield run.place.warning(
            f"the depth ({channel.topic}) changes by {fast:.3g} m a second for a good part of the "
            "run, more than is possible: its unit is probably off by a factor such as 100.",
            remedy=CHECK_UNIT,
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


def looks_like(ratio: float, tolerance: float) -> str:
    """Return what a ratio of what was read and what was expected looks like; nothing for none."""
    for factor, says in _FACTORS:
        if abs(ratio / factor - 1.0) < tolerance:
            return says
    return ""
