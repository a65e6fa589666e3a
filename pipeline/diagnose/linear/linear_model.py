r"""All runs as one linear model around a point: what each unknown adds to the whitened readings.

Around a point of starts n_w, outside forces d_w, shared unknowns s and departures x the readings
are

.. math:: y = S n + D d + N s + G x + e, \qquad e \sim N(0, 1)

with y the whitened residual plus what the unknowns at the point add, so the unknowns are counted
from zero, where their priors are centred. Starts and forces belong to one window, the shared
unknowns (sensor offsets, attitude wander) to a run, the departures to all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.diagnose.linear.characteristic import CurveErrors
from pipeline.diagnose.linear.coordinates import Coordinate, vector_at
from pipeline.diagnose.linear.predictions import (
    Bench,
    Motion,
    innovations,
    outside_forces,
    simulate_windows,
)
from pipeline.identify.run_nuisance import RunNuisance
from pipeline.identify.window_derivatives import FitProblem, moved_starts
from pipeline.identify.window_outputs import whitened
from pipeline.simulate.pack import mass_of
from pipeline.types import BoolArray, FloatArray

#: How far beyond what an effect allows its mirror image is believed, in the same units.
BEYOND = 0.3
#: No departure goes further: three times what is plausible, in the same units.
_FARTHEST = 6.0


@dataclass(frozen=True)
class Point:
    """Where the model is linear: starts (windows, 12), forces (windows, 6 pieces), shared (s,).

    Starts are counted in prior standard deviations, forces in `Setting.force_unit`, `departures`
    (g,) in the coordinates' units.
    """

    starts: FloatArray
    forces: FloatArray
    shared: FloatArray
    departures: FloatArray
    pull: float = 0.0
    """Share of the force that leads the nominal model along the measured motion."""


@dataclass(frozen=True)
class Setting:
    """What stays the same over a diagnosis of some runs."""

    bench: Bench
    shared: RunNuisance
    coordinates: tuple[Coordinate, ...]
    force_unit: FloatArray
    """(6,) N and N m: standard deviation of the outside force of a healthy vehicle."""
    extra: FloatArray
    """(rows, e) columns of further unknowns of unit variance."""
    row_scale: FloatArray
    """(rows,) weight of each reading: below 1 for outliers and noisy channels."""
    profiles: FloatArray
    """(steps, 6, k) forces of further unknowns of unit variance, after those of `extra`."""
    scatter: FloatArray
    """(g,) by how much the departures of a run differ from the vehicle's."""
    curves: CurveErrors
    """By how much the thrusters' curves may be off: what `profiles` are made of."""

    @property
    def problem(self) -> FitProblem:
        """Bookkeeping of the starts."""
        return FitProblem(self.bench.stack, (), self.bench.stack.packed.vector, self.shared, 1)

    def origin(self) -> Point:
        """Nominal vehicle, led along the measured motion."""
        count = self.bench.window_count
        return Point(
            np.zeros((count, 12)),
            np.zeros((count, 6 * self.bench.pieces)),
            np.zeros(self.shared.size + self.extra.shape[1] + self.profiles.shape[2]),
            np.zeros(len(self.coordinates)),
            pull=1.0,
        )


@dataclass(frozen=True)
class LinearModel:
    """Weighted columns (rows, .) at a point, and the readings y counted from zero."""

    setting: Setting
    point: Point
    local: FloatArray
    """Starts (12), then forces (6 pieces)."""
    shared: FloatArray
    extra: FloatArray
    departures: FloatArray
    readings: FloatArray
    residual: FloatArray
    """Weighted residual at the point."""

    @cached_property
    def informative_rows(self) -> BoolArray:
        """(rows,) which readings say something: all of a row is 0 where the simulation ran away.

        The supply's voltage depends on departures alone, not on where the motion started.
        """
        parts = (self.local, self.shared, self.extra, self.departures)
        return np.asarray(np.any([(part != 0.0).any(axis=1) for part in parts], axis=0))

    @property
    def lost(self) -> float:
        """Share of the readings that say nothing."""
        return float(np.mean(~self.informative_rows))


def motion_at(setting: Setting, point: Point, vector: FloatArray | None = None) -> Motion:
    """Simulate all windows at a point."""
    bench = setting.bench
    scales = setting.problem.start_scales
    starts = moved_starts(bench.stack.starts, point.starts * scales)
    at = vector_of(setting, point.departures) if vector is None else vector
    return simulate_windows(bench, at, starts, forces_at(setting, point))


def forces_at(setting: Setting, point: Point) -> FloatArray:
    """Force from outside at every step of a point, (steps, 6) [N, N m].

    Unknown ones are counted as the acceleration that they give the nominal vehicle.
    """
    bench = setting.bench
    forces = point.forces * np.tile(setting.force_unit, bench.pieces)
    if forces.any():
        here = mass_of(vector_of(setting, point.departures))
        same = np.linalg.solve(mass_of(bench.stack.packed.vector), here)
        forces = (forces.reshape(-1, 6) @ same).reshape(forces.shape)
    first = setting.shared.size + setting.extra.shape[1]
    return outside_forces(bench, forces, point.pull) + setting.profiles @ point.shared[first:]


def vector_of(setting: Setting, departures: FloatArray) -> FloatArray:
    """Parameter vector at departures, those of a product taken apart."""
    return vector_at(
        setting.bench.stack.packed, setting.coordinates, plain(setting.coordinates, departures)
    )


def plain(all_coordinates: Sequence[Coordinate], departures: FloatArray) -> FloatArray:
    """Departures with each product divided by its lead; 0 where that is next to nothing."""
    found = departures.copy()
    for index, one in enumerate(all_coordinates):
        if one.leads:
            size = one.lead_size(departures)
            found[index] = departures[index] / size if abs(size) >= one.least_lead else 0.0
    return found


def realisable(all_coordinates: Sequence[Coordinate], departures: FloatArray) -> FloatArray:
    """Departures that a vehicle can have: products without a lead are 0, places within bounds.

    What no file states has no mirror image, and beyond where it has a meaning a slope of its own.
    """
    found = departures.copy()
    for index, one in enumerate(all_coordinates):
        if not one.leads:
            low, high = one.limits
            beyond = 0.0 if one.effect.unstated else BEYOND
            found[index] = np.clip(
                found[index], max(low - beyond, -_FARTHEST), min(high + beyond, _FARTHEST)
            )
    alone = plain(all_coordinates, found)
    for index, one in enumerate(all_coordinates):
        if one.leads:
            found[index] = np.clip(alone[index], *one.bounds) * one.lead_size(found)
    return found


def residual_of(setting: Setting, point: Point, vector: FloatArray, motion: Motion) -> FloatArray:
    """Weighted whitened residual, (rows,)."""
    raw = whitened(setting.bench.stack, innovations(setting.bench, vector, motion))
    count, extra = setting.shared.size, setting.extra.shape[1]
    raw = raw - setting.shared.whitened(point.shared[:count])
    raw -= setting.extra @ point.shared[count : count + extra]
    return np.asarray(raw * setting.row_scale)


def readings_from_zero(model: LinearModel, point: Point, residual: FloatArray) -> FloatArray:
    """Weighted residual with what all unknowns at the point add, (rows,)."""
    setting, count = model.setting, model.setting.shared.size
    window = setting.shared.window
    own = np.concatenate([point.starts, point.forces], axis=1)[window]
    found = residual + np.einsum("rk,rk->r", model.local, own)
    found += setting.shared.whitened(point.shared[:count]) * setting.row_scale
    found += model.extra @ point.shared[count:]
    return np.asarray(found + model.departures @ point.departures)
