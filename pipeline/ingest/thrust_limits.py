"""What a propeller can and cannot do at rest: thrust against its disc, shaft speed and power."""

import math
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.blocks import BlockColumn
from pipeline.ingest.unit_text import factor, known_units
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Thrust over the disc's area: a jet of 17 m/s. No thruster of an underwater vehicle has it. [Pa]
MOST_PRESSURE_PA = 150e3
#: K_T = T / (rho n^2 D^4) at rest: screws and ducted thrusters lie between 0.1 and 0.8.
LEAST_K_T, MOST_K_T = 0.02, 1.2
_USUAL_K_T = (0.1, 0.8)
#: Ideal power over the power drawn: above 1 for an open propeller, 1.4 in a duct.
MOST_MERIT = 1.6
_LARGE = 0.3
_LEAST_POINTS = 4


def thrust_problem(
    place: Place, points: Sequence[MooringPoint], vehicle: Vehicle, column: BlockColumn
) -> Problem | None:
    """Refuse a table whose thrust no propeller of this size gives.

    Parameters
    ----------
    place : Place
        The table, for the message.
    points : sequence of MooringPoint
        Its points.
    vehicle : Vehicle
        Propeller and water.
    column : BlockColumn
        The column of thrust.

    Returns
    -------
    Problem or None
        An error that names the unit that would fit, if there is one.
    """
    used = [point for point in points if not point.marks]
    thrust = np.array([abs(point.thrust_n) for point in used])
    if not used or not thrust.any():
        return None
    large = thrust > _LARGE * thrust.max()
    rho, diameter = vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    area = math.pi / 4.0 * diameter**2
    speed_rps = np.array([abs(point.shaft_speed_rpm or math.nan) for point in used]) / 60.0
    k_t = thrust / (rho * speed_rps**2 * diameter**4)
    k_t = k_t[large & np.isfinite(k_t)]
    pressure_pa = float(thrust.max()) / area
    why, ratio = "", 1.0
    if k_t.size >= _LEAST_POINTS and not LEAST_K_T <= (median := float(np.median(k_t))) <= MOST_K_T:
        why = f"K_T at rest comes out as {median:.3g}, a screw has {_USUAL_K_T[0]:g} to "
        why += f"{_USUAL_K_T[1]:g}"
        ratio = median / math.sqrt(_USUAL_K_T[0] * _USUAL_K_T[1])
    elif pressure_pa > MOST_PRESSURE_PA:
        why = f"{thrust.max():.3g} N on the disc of a propeller of {diameter:g} m are "
        why += f"{pressure_pa / 1000.0:.3g} kPa, more than any gives"
        ratio = pressure_pa / 10e3
    else:
        merit = _merit(used, thrust, rho * area)[large]
        merit = merit[np.isfinite(merit)]
        if merit.size >= _LEAST_POINTS and float(np.median(merit)) > MOST_MERIT:
            why = f"an ideal propeller would take {np.median(merit):.3g} times the power U I that "
            why += "was drawn"
            ratio = float(np.median(merit)) ** (2.0 / 3.0) * 1.5
    if not why:
        return None
    return Problem(
        "error",
        place,
        f'thrust "{column.header}" in {column.unit}: {why}. So the table was left out.'
        f"{_likely(column, ratio)}",
        "thrust, shaft speed and diameter that belong together.",
        "Correct the unit in the file, or state it in vehicle.yaml:\n  columns:\n    mooring:\n"
        f'      thrust: {{header: "{column.header}", unit: ...}}\nor correct the diameter of the '
        "propeller there.",
    )


def _merit(used: Sequence[MooringPoint], thrust: FloatArray, rho_area: float) -> FloatArray:
    power_w = np.array([(one.voltage_v or math.nan) * (one.current_a or math.nan) for one in used])
    return np.asarray(thrust**1.5 / math.sqrt(2.0 * rho_area) / np.abs(power_w))


def _likely(column: BlockColumn, ratio: float) -> str:
    """Name the unit that would bring the thrust nearest to what is usual."""
    worth = abs(column.factor) / ratio
    units = [(unit, factor(unit, "force")) for unit in known_units("force")]
    unit, nearest = min(units, key=lambda one: abs(math.log(one[1] / worth)))
    if unit == column.unit or abs(math.log(nearest / worth)) > math.log(3.0):
        return ""
    return f" The numbers look like {unit}."
