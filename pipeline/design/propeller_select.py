r"""The propeller of the series that needs least power: Kostenko 2017, fig. 6, as an optimisation.

For each number of blades: least shaft power :math:`2 \pi n M` over diameter, pitch ratio, area
ratio (and shaft speed, where the drive's whole characteristic is known), with

.. math:: T \ge T_{req}, \qquad M \le M_{drive}(n), \qquad \text{no cavitation}

by scipy's differential evolution (Storn and Price 1997; constraints after Lampinen 2002) with a
fixed seed, polished by SLSQP (Kraft 1988).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, brentq, differential_evolution, minimize

from pipeline.design.propeller_cavitation import burrill, keller_area_ratio
from pipeline.design.propeller_input import PropellerInput
from pipeline.design.propeller_series import (
    TESTED_AREA_RATIOS,
    Geometry,
    reynolds,
    reynolds_correction,
    thrust_coefficient,
    torque_coefficient,
)
from pipeline.types import ArrayLike, FloatArray

#: A propeller of the series has no thrust from an advance ratio of P/D to P/D + 0.16 on, and the
#: polynomials are negative there up to P/D + 1.1 at least.
MOST_ADVANCE_BEYOND_PITCH = 0.5

_TOLERANCE = 1e-6


@dataclass(frozen=True)
class DriveLimit:
    """Largest torque [N m] of the drive between two shaft speeds [rev/s]; equal: one point."""

    torque_nm: Callable[[FloatArray], FloatArray]
    slowest_rps: float
    fastest_rps: float

    @property
    def point(self) -> bool:
        """Whether a single working point is known."""
        return self.slowest_rps == self.fastest_rps


@dataclass(frozen=True)
class Task:
    """What a file asks for, on a drive."""

    asked: PropellerInput
    drive: DriveLimit

    @property
    def thrust_n(self) -> float:
        """Thrust that is required. [N]."""
        return self.asked.required.thrust_n

    @property
    def advance_speed_mps(self) -> float:
        """Speed of the water through the propeller. [m/s]."""
        return self.asked.required.speed_mps * (1.0 - self.asked.required.wake_fraction)

    def area_ratio(self, blades: int) -> tuple[float, float]:
        """Bounds of the area ratio; where none are stated those of the series' models. [-]."""
        return self.asked.bounds.area_ratio or TESTED_AREA_RATIOS[blades]


@dataclass(frozen=True)
class Screw:
    """A propeller at a shaft speed; arrays broadcast."""

    geometry: Geometry
    shaft_speed_rps: FloatArray
    advance_ratio: FloatArray
    thrust_coefficient: FloatArray
    torque_coefficient: FloatArray
    thrust_n: FloatArray
    torque_nm: FloatArray

    @property
    def power_w(self) -> FloatArray:
        """Shaft power 2 pi n M. [W]."""
        return np.asarray(2.0 * np.pi * self.shaft_speed_rps * self.torque_nm)


def screw(task: Task, one: Geometry, shaft_speed_rps: ArrayLike) -> Screw:
    """Return thrust and torque at a shaft speed, from the series."""
    n = np.asarray(shaft_speed_rps, float)
    j = task.advance_speed_mps / (n * one.diameter_m)
    k_t, k_q = thrust_coefficient(j, one), torque_coefficient(j, one)
    water = task.asked.water
    if task.asked.reynolds_correction:
        number = reynolds(task.advance_speed_mps, n, one, water.kinematic_viscosity_m2ps)
        more_t, more_q = reynolds_correction(j, one, number)
        k_t, k_q = k_t + more_t, k_q + more_q
    rho, diameter = water.density_kgpm3, np.asarray(one.diameter_m, float)
    return Screw(
        one, n, j, k_t, k_q, k_t * rho * n**2 * diameter**4, k_q * rho * n**2 * diameter**5
    )


def _read(task: Task, blades: int, x: FloatArray) -> Screw:
    """Turn the optimiser's variables (3 or 4, ...) into a screw."""
    shaft = np.full(x.shape[1:], task.drive.slowest_rps) if task.drive.point else x[3]
    return screw(task, Geometry(blades, x[0], x[1], x[2]), shaft)


def _constraints(task: Task, found: Screw, *, thrust: bool) -> FloatArray:
    """Return values that must not be negative, all of the order of one."""
    one = found.geometry
    have = np.asarray(task.drive.torque_nm(found.shaft_speed_rps))
    rows = [have / np.maximum(have, 1e-12) - found.torque_nm / np.maximum(have, 1e-12)]
    # beyond windmilling the polynomials mean nothing, and far beyond both are positive again
    rows.append(found.torque_coefficient * 1e3 - 1e-3)
    rows.append(np.asarray(one.pitch_ratio) + MOST_ADVANCE_BEYOND_PITCH - found.advance_ratio)
    if thrust:
        rows.append(found.thrust_n / task.thrust_n - 1.0)
    asked = task.asked
    if asked.enforce_cavitation:
        pull = np.maximum(found.thrust_n, 0.0)
        least = keller_area_ratio(pull, one, asked.water, asked.keller_margin)
        loading, limit = burrill(
            pull, task.advance_speed_mps, found.shaft_speed_rps, one, asked.water
        )
        rows += [np.asarray(one.area_ratio) - least, 1.0 - loading / limit]
    return np.stack(rows)


def _optimise(
    task: Task, blades: int, objective: Callable[[Screw], FloatArray], *, thrust: bool
) -> Screw | None:
    """Minimise over the series with the constraints; None where they cannot be met."""
    bounds = task.asked.bounds
    box = [bounds.diameter_m, bounds.pitch_ratio, task.area_ratio(blades)]
    if not task.drive.point:
        box.append((task.drive.slowest_rps, task.drive.fastest_rps))
    low, high = np.array(box).T
    free = high > low
    start = 0.5 * (low + high)
    if not free.any():
        # nothing to choose: the one propeller at the one shaft speed meets the task or does not
        only = _read(task, blades, start)
        return only if np.min(_constraints(task, only, thrust=thrust)) >= -_TOLERANCE else None

    def full(y: FloatArray) -> FloatArray:
        """Put the free variables (k, ...) among the fixed ones."""
        x = np.broadcast_to(start.reshape(-1, *[1] * (y.ndim - 1)), (len(box), *y.shape[1:])).copy()
        x[free] = y
        return x

    def value(y: FloatArray, /) -> Any:  # noqa: ANN401 - one number, or one a column
        return np.asarray(objective(_read(task, blades, full(np.asarray(y, float)))))

    def held(y: FloatArray, /) -> FloatArray:
        return _constraints(task, _read(task, blades, full(np.asarray(y, float))), thrust=thrust)

    within = Bounds(low[free], high[free])
    coarse = differential_evolution(
        value,
        within,
        constraints=NonlinearConstraint(held, 0.0, np.inf),
        strategy="rand1bin",
        popsize=12,
        maxiter=45,
        tol=1e-6,
        seed=1,
        polish=False,
        vectorized=True,
        updating="deferred",
    )
    fine = minimize(  # type: ignore[call-overload]  # the stubs lack this overload
        lambda y: float(value(y)),
        np.asarray(coarse.x, float),
        method="SLSQP",
        bounds=within,
        constraints=[{"type": "ineq", "fun": held}],
        options={"ftol": 1e-10, "maxiter": 100},
    )
    ends = [y for y in (fine.x, coarse.x) if np.min(held(y)) >= -_TOLERANCE]
    if not ends:
        return None
    best = min(ends, key=lambda y: float(value(y)))
    return _read(task, blades, full(np.asarray(best)))


def least_power(task: Task, blades: int) -> Screw | None:
    """Return the propeller of the series that meets the task with least power, or None."""
    return _optimise(task, blades, lambda one: one.power_w / 100.0, thrust=True)


def most_thrust(task: Task, blades: Sequence[int]) -> Screw | None:
    """Return the propeller that gives most thrust within the bounds and the drive, or None."""
    found = [
        one
        for z in blades
        if (one := _optimise(task, z, lambda s: -s.thrust_n / task.thrust_n, thrust=False))
    ]
    return max(found, key=lambda one: float(one.thrust_n), default=None)


def full_power(task: Task, one: Geometry) -> Screw | None:
    """Return where the propeller takes all that the drive has: the highest such shaft speed."""
    if task.drive.point:
        return None
    grid = np.linspace(task.drive.slowest_rps, task.drive.fastest_rps, 200)

    def excess(n: ArrayLike) -> FloatArray:
        return np.asarray(screw(task, one, n).torque_nm - task.drive.torque_nm(np.asarray(n)))

    values = excess(grid)
    crossings = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if not crossings.size:
        return None
    at = int(crossings[-1])
    return screw(task, one, brentq(lambda n: float(excess(n)), grid[at], grid[at + 1]))


def shaft_speed_for_thrust(task: Task, one: Geometry) -> float | None:
    """Shaft speed at which a propeller gives the required thrust, within the drive. [rev/s]."""
    if task.drive.point:
        return task.drive.slowest_rps
    grid = np.linspace(task.drive.slowest_rps, task.drive.fastest_rps, 200)
    short = screw(task, one, grid).thrust_n - task.thrust_n
    crossings = np.flatnonzero((short[:-1] < 0) & (short[1:] >= 0))
    if not crossings.size:
        return None
    at = int(crossings[-1])
    return float(
        brentq(
            lambda n: float(screw(task, one, n).thrust_n - task.thrust_n), grid[at], grid[at + 1]
        )
    )
