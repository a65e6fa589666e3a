"""What thrust at rest cannot be by its size."""

import math
from collections.abc import Hashable, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table
from pipeline.ingest.blocks import BlockColumn
from pipeline.ingest.thrust_shape import by_code
from pipeline.ingest.unit_text import unit_worth
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray

#: Thrust over the disc's area: a jet of 17 m/s. No thruster of an underwater vehicle has it. [Pa]
MOST_PRESSURE_PA = 150e3
#: Jets of 1 and 9 m/s: less, and more, is doubtful as the largest thrust.
_LEAST_PRESSURE_PA, _DOUBTFUL_PRESSURE_PA = 600.0, 40e3
#: K_T = T / (rho n^2 D^4) at rest: screws and ducted thrusters lie between 0.1 and 0.8.
LEAST_K_T, MOST_K_T = 0.02, 1.2
_USUAL_K_T = (0.1, 0.8)
_DOUBTFUL_K_T = (0.1, 0.9)
#: Ideal power over the power drawn: above 1 for an open propeller, 1.4 in a duct.
MOST_MERIT = 1.6
#: Less is left of it by no motor and propeller at their larger thrusts.
_DOUBTFUL_MERIT = 0.07
_USUAL_MERIT, _USUAL_PRESSURE_PA = 0.4, 10e3
_LARGE = 0.3
_LEAST_POINTS = 2


def thrust_problem(table: Table, points: Sequence[MooringPoint]) -> Problem | None:
    """Doubt or refuse a table whose thrust no propeller of this size gives.

    It names the unit that would fit, if there is one: a warning where the numbers are possible and
    strange, an error where they are not.
    """
    vehicle = table.vehicle
    used = [point for point in points if not point.marks]
    thrust = np.array([abs(point.thrust_n) for point in used])
    if not used or not thrust.any():
        return None
    large = thrust > _LARGE * thrust.max()
    rho, diameter = vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    area = math.pi / 4.0 * diameter**2
    speed_rps = np.array([abs(point.shaft_speed_rpm or math.nan) for point in used]) / 60.0
    with np.errstate(divide="ignore"):  # the square of a very small speed
        k_t = _median((thrust / (rho * speed_rps**2 * diameter**4))[large])
    merit = _median(_merit(table, used, thrust, rho * area)[large])
    pressure_pa = float(thrust.max()) / area
    usual = math.sqrt(_USUAL_K_T[0] * _USUAL_K_T[1])
    if k_t is not None and not _DOUBTFUL_K_T[0] <= k_t <= _DOUBTFUL_K_T[1]:
        why = (
            f"K_T at rest comes out as {k_t:.3g}, a screw has {_USUAL_K_T[0]:g} to "
            f"{_USUAL_K_T[1]:g}"
        )
        return _problem(table, why, k_t / usual, is_possible=LEAST_K_T <= k_t <= MOST_K_T)
    if merit is not None and not _DOUBTFUL_MERIT <= merit <= MOST_MERIT:
        why = f"an ideal propeller would take {merit:.3g} times the power that was drawn"
        ratio = (merit / _USUAL_MERIT) ** (2.0 / 3.0)
        return _problem(table, why, ratio, is_possible=merit <= MOST_MERIT)
    if not _LEAST_PRESSURE_PA <= pressure_pa <= _DOUBTFUL_PRESSURE_PA:
        is_possible = pressure_pa <= MOST_PRESSURE_PA
        given = "more than most give" if is_possible else "more than any gives"
        if pressure_pa < _LEAST_PRESSURE_PA:
            given = "less than most give"
        why = (
            f"{thrust.max():.3g} N on the disc of a propeller of {diameter:g} m are "
            f"{pressure_pa / 1000.0:.3g} kPa, {given}"
        )
        return _problem(table, why, pressure_pa / _USUAL_PRESSURE_PA, is_possible=is_possible)
    return None


def _median(values: FloatArray) -> float | None:
    there = values[np.isfinite(values)]
    return float(np.median(there)) if there.size >= _LEAST_POINTS else None


def _problem(table: Table, why: str, ratio: float, *, is_possible: bool) -> Problem:
    column = table.block.columns["thrust"]
    return Problem(
        "warning" if is_possible else "error",
        table.place,
        f'thrust "{column.header}" in {column.unit}: {why}.'
        f"{'' if is_possible else ' So the table was left out.'}{_likely(column, ratio)}",
        "thrust, shaft speed and diameter that belong together.",
        "Correct the unit in the file, or state it in vehicle.yaml:\n  columns:\n    mooring:\n"
        f'      thrust: {{header: "{column.header}", unit: ...}}\nor correct the diameter of the '
        "propeller there.",
    )


def _merit(
    table: Table, used: Sequence[MooringPoint], thrust: FloatArray, rho_area: float
) -> FloatArray:
    """Return ideal over drawn power, U I or that of a column."""
    drawn = {one.row: one.values.get("input_power") for one in table.live()}
    both = [(one.voltage_v or math.nan) * (one.current_a or math.nan) for one in used]
    of_column = [drawn.get(one.source.row) for one in used]
    power_w = np.array([a if b is None else b for a, b in zip(both, of_column, strict=True)])
    with np.errstate(divide="ignore", invalid="ignore"):
        merit = thrust**1.5 / math.sqrt(2.0 * rho_area) / np.abs(power_w)
    return np.asarray(np.where(np.isfinite(merit), merit, math.nan))


def _likely(column: BlockColumn, ratio: float) -> str:
    """Name the unit that would bring the thrust nearest to what is usual."""
    unit = unit_worth("force", abs(column.factor) / ratio, most_times=3.0)
    return "" if unit in {None, column.unit} else f" The numbers look like {unit}."


def curves_of(points: Sequence[MooringPoint]) -> dict[Hashable, dict[float, float]]:
    """Return the thrust of a table by voltage and code."""
    volts = [one.voltage_v for one in points if one.voltage_v is not None]
    return {round(float(np.median(volts))) if volts else None: by_code(points)}
