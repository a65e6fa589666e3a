"""Depths that cannot be: a pressure in another unit than stated, or counted upwards."""

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: A run under water moves by more than a centimetre of it. [Pa]
_STILL_PA = 100.0
#: One atmosphere and some metres of water, read as pascals above the surface -> the unit it is.
_ATMOSPHERES = ((800.0, 1500.0, "hPa (mbar)"), (80.0, 150.0, "kPa"))
_ABOVE_WATER_M = -0.3
_FEW, _MOVING_M, _AGAINST = 50, 0.03, -0.8


def doubtful_depths(run: PoolRun, vehicle: Vehicle, place: Place) -> list[Problem]:
    """Warn where depths are those of a pressure in another unit, or lie above the water.

    The vehicle's water turns depths back into pressures.
    """
    channel = run.channels.get("depth")
    if channel is None:
        return []
    depth = _readings(channel)
    if not depth.size:
        return []
    middle = float(np.median(depth))
    if channel.read.quantity == "pressure" and channel.read.unit_from != "vehicle file":
        # near the surface a gauge reads as little, but then it also reads about zero
        raw_pa = depth * vehicle.water.density_kgpm3 * vehicle.water.gravity_mps2
        low, typical = float(np.quantile(raw_pa, 0.02)), float(np.median(raw_pa))
        for least, most, unit in _ATMOSPHERES:
            if least <= low and typical <= most:
                return [
                    Problem(
                        "warning",
                        place,
                        f"the pressure ({channel.topic}) is about {typical:.4g} Pa above the "
                        f"surface throughout, a depth of {middle:.2g} m: this looks like {unit}.",
                        "pressure in Pa.",
                        "State the unit under pool: channels in vehicle.yaml.",
                    )
                ]
        if 0.0 < float(np.ptp(raw_pa)) < _STILL_PA and abs(typical) < 10.0 * _STILL_PA:
            return [
                Problem(
                    "warning",
                    place,
                    f"the pressure ({channel.topic}) stays within {np.ptp(raw_pa):.2g} Pa of the "
                    f"surface throughout, a depth of {middle:.2g} m: the vehicle was not under "
                    "water, or this is bar, dbar, psi or mbar.",
                    "pressure in Pa.",
                    "State the unit under pool: channels in vehicle.yaml.",
                )
            ]
    # on deck a gauge reads 0: only a wrong sign or surface makes it negative for a while
    middle = min(middle, float(np.quantile(depth, 0.05)))
    if middle < _ABOVE_WATER_M:
        return [
            Problem(
                "warning",
                place,
                f"the depth ({channel.topic}) is {middle:.3g} m for a good part of the run: "
                "above the water. Its sign, or the pressure at the surface, is another.",
                "depth positive downwards.",
                "State sign: -1, or surface_pressure_pa, under pool: channels in vehicle.yaml.",
            )
        ]
    return []


def position_against_depth(run: PoolRun, place: Place) -> list[Problem]:
    """Say where the third component of a position falls as the depth grows: it points up."""
    position, depth = run.channels.get("position"), run.channels.get("depth")
    if position is None or depth is None or position.topic == depth.topic:
        return []
    rows, there = position.usable(), depth.usable()
    if min(rows.sum(), there.sum()) < _FEW:
        return []
    at = depth.time_ns[there]
    order = np.argsort(at, kind="stable")
    expected = np.interp(position.time_ns[rows], at[order], depth.values[there, 0][order])
    down = position.values[rows, 2]
    good = np.isfinite(expected) & np.isfinite(down)
    if good.sum() < _FEW or min(np.std(expected[good]), np.std(down[good])) < _MOVING_M:
        return []
    correlation = float(np.corrcoef(expected[good], down[good])[0, 1])
    if correlation > _AGAINST:
        return []
    return [
        Problem(
            "warning",
            place,
            f"the position ({position.topic}) rises as the depth ({depth.topic}) grows "
            f"(correlation {correlation:.2f}): its z axis points up.",
            f"a position in {position.read.axes}.",
            "State earth_axes: enu (or nwu) of the position under pool: channels in vehicle.yaml.",
        )
    ]


def _readings(channel: RunChannel) -> FloatArray:
    values = channel.values[channel.usable()].ravel()
    return np.asarray(values[np.isfinite(values)])
