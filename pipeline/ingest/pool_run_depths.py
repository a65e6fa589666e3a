"""Depths that cannot be: a pressure in another unit than stated, or counted upwards."""

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: One atmosphere and some metres of water, read as pascals above the surface -> the unit it is.
_ATMOSPHERES = ((800.0, 1500.0, "hPa (mbar)"), (80.0, 150.0, "kPa"))
_ABOVE_WATER_M = -0.3


def doubtful_depths(run: PoolRun, vehicle: Vehicle, place: Place) -> list[Problem]:
    """Say where depths are those of a pressure in another unit, or lie above the water.

    Parameters
    ----------
    run : PoolRun
        The run.
    vehicle : Vehicle
        Its water turns depths back into pressures.
    place : Place
        The log, for messages.

    Returns
    -------
    list of Problem
        Warnings.
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
    if middle < _ABOVE_WATER_M:
        return [
            Problem(
                "warning",
                place,
                f"the depth ({channel.topic}) is {middle:.3g} m in the middle of its readings: "
                "above the water. Its sign, or the pressure at the surface, is another.",
                "depth positive downwards.",
                "State sign: -1, or surface_pressure_pa, under pool: channels in vehicle.yaml.",
            )
        ]
    return []


def _readings(channel: RunChannel) -> FloatArray:
    values = channel.values[channel.usable()].ravel()
    return np.asarray(values[np.isfinite(values)])
