r"""Derivatives of all readings, along one motion, by everything that is unknown.

The motion is cut into pieces of half a second. Each piece is simulated anew from where the motion
is at its begin, moved a little in one of twelve directions, with a little outside force along one
of six axes, or with one departure a little off. That gives for each piece how its end moves,

.. math:: \delta_{i+1} = A_i \delta_i + B_i f_i + g_i x

and how the readings within move; the rest is linear algebra along the window. So the outside force
may change every half second at no further cost in simulation.

An outside force is counted as the acceleration that it gives, times the nominal mass matrix. Were
it counted in newtons, a vehicle of less mass, less drag and less thrust would need less of it for
the same motion, and that would speak for it: all of them came out too small together.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from pipeline.diagnose.linear_model import (
    LEAST_LEAD,
    Chain,
    LinearModel,
    Point,
    Setting,
    forces_at,
    motion_at,
    readings_from_zero,
    residual_of,
    vector_of,
)
from pipeline.diagnose.predictions import (
    Bench,
    Motion,
    drives_at,
    innovations,
    other_drives,
    over_threads,
    same_motion,
)
from pipeline.identify.window_derivatives import moved_starts
from pipeline.simulate.kernel import BODY
from pipeline.simulate.kernel_hull import mass_matrix
from pipeline.simulate.pieces import run_pieces
from pipeline.types import FloatArray, IntArray

#: Steps of the derivatives: position [m], attitude [rad], velocity [m/s], turning rate [rad/s].
_STEPS = np.repeat([1e-3, 1e-5, 1e-4, 1e-4], 3)
#: The same of the outside forces, in the unit of a healthy vehicle's.
_FORCE_STEP = 0.1
#: The same of the characteristic's unknowns, in their standard deviations.
_PROFILE_STEP = 0.01
#: The same of the pull, of which all is taken away.
_PULL_STEP = 1e-3
#: Departure below which a wide step is taken where one is asked for.
_AT_NEUTRAL = 0.02
#: A whitened derivative or residual this large is that of a simulation that ran away.
_LOST = 1e7
#: Departure of a lead while the departure that needs it is moved.
_LEAD_STEP = 0.02


@dataclass(frozen=True)
class Pass:
    """One way of moving all pieces: readings (entries,) and ends (pieces, 12), per unit."""

    readings: FloatArray
    ends: FloatArray


@dataclass(frozen=True)
class _Known:
    """Motion of all pieces, their readings (entries,) and ends (pieces, STATE)."""

    motion: Motion
    readings: FloatArray
    ends: FloatArray


@dataclass(frozen=True)
class _Base:
    """Where the pieces start, what pushes them, and what comes out."""

    setting: Setting
    point: Point
    vector: FloatArray
    starts: FloatArray
    forces: FloatArray
    known: _Known
    wide: float

    def from_start(self, index: int) -> Pass:
        """Move the starts in one of twelve directions."""
        by = np.zeros((len(self.starts), 12))
        by[:, index] = _STEPS[index]
        moved = _known(self.setting, self.vector, moved_starts(self.starts, by), self.forces)
        return _way(self.known, moved, _STEPS[index])

    def from_force(self, axis: int) -> Pass:
        """Push along one axis."""
        nominal = _mass(self.setting.bench.stack.packed.vector)
        more = np.zeros(6)
        more[axis] = _FORCE_STEP * self.setting.force_unit[axis]
        more = _mass(self.vector) @ np.linalg.solve(nominal, more)
        return self._from_forces(self.forces + more, _FORCE_STEP)

    def from_profile(self, number: int) -> Pass:
        """Push as one of the characteristic's unknowns does."""
        more = _PROFILE_STEP * self.setting.profiles[:, :, number]
        return self._from_forces(self.forces + more, _PROFILE_STEP)

    def from_pull(self) -> Pass:
        """Take a little of the pull away."""
        pull = self.point.pull * np.concatenate(self.setting.bench.pulls)
        return self._from_forces(self.forces - _PULL_STEP * pull, -_PULL_STEP)

    def _from_forces(self, forces: FloatArray, by: float) -> Pass:
        return _way(self.known, _known(self.setting, self.vector, self.starts, forces), by)

    def from_departure(self, number: int) -> Pass:
        """Move one departure off where it is."""
        setting, one = self.setting, self.setting.coordinates[number]
        moved, known, vector, by = self.point.departures.copy(), self.known, self.vector, one.step
        unstated = one.ordinary == 0.0 and one.lead is None
        if self.wide and unstated and abs(moved[number]) < _AT_NEUTRAL:
            by = self.wide * np.sign(one.step)
        if one.lead is not None:
            if abs(moved[one.lead]) < LEAST_LEAD:
                # without its lead it does nothing: taken where the lead is at its own step
                moved[one.lead] = _LEAD_STEP * np.sign(setting.coordinates[one.lead].step)
                moved[number] = 0.0
                vector = vector_of(setting, moved)
                known = _known(setting, vector, self.starts, self._forces_of(vector))
            by = one.step * moved[one.lead]
        moved[number] += by
        changed = vector_of(setting, moved)
        if same_motion(changed, vector):
            readings = _raw(setting.bench, changed, known.motion)
            return Pass((known.readings - readings) / by, np.zeros((len(self.starts), 12)))
        begin = self.starts
        if other_drives(changed, vector):
            # the drives are not where they were when the piece begins
            pieces = setting.bench.start_of_piece
            ways = [drives_at(setting.bench, one, pieces) for one in (vector, changed)]
            begin = self.starts.copy()
            begin[:, BODY : BODY + ways[0].shape[1]] += ways[1] - ways[0]
        return _way(known, _known(setting, changed, begin, self._forces_of(changed)), by)

    def _forces_of(self, vector: FloatArray) -> FloatArray:
        """Return what pushes a vehicle of other masses as the forces here push this one."""
        here, there = _mass(self.vector), _mass(vector)
        if np.array_equal(here, there):
            return self.forces
        return np.asarray(self.forces @ np.linalg.solve(here, there))


def _mass(vector: FloatArray) -> FloatArray:
    """Mass matrix (6, 6) of a parameter vector, added masses included."""
    matrix = np.empty((6, 6))
    mass_matrix(vector, 1.0, matrix)
    return matrix


def linear_model(
    setting: Setting,
    point: Point,
    *,
    wide: float = 0.0,
    known: LinearModel | None = None,
    renew: Sequence[int] | None = None,
) -> LinearModel:
    """Linearise along the motion at a point.

    Of the departures only those of `renew` are taken anew where a linear model of the same windows
    is known already. With `wide` the signature of a departure that is at neutral, and of which
    nothing is stated, is the secant to one of that size: drag in a current, or a dead zone, has
    next to no derivative where it is not there.
    """
    bench = setting.bench
    vector = vector_of(setting, point.departures)
    motion = motion_at(setting, point, vector)
    # the pieces follow the same motion: their starts are its states
    starts, forces = motion.state[bench.start_of_piece], forces_at(setting, point)
    seen = _known(setting, vector, starts, forces)
    base = _Base(setting, point, vector, starts, forces, seen, wide)
    anew = list(range(len(setting.coordinates)) if renew is None or known is None else renew)
    tasks: list[Callable[[], Pass]] = [partial(base.from_start, k) for k in range(12)]
    tasks += [partial(base.from_force, k) for k in range(6)]
    tasks += [partial(base.from_departure, k) for k in anew]
    tasks += [partial(base.from_profile, k) for k in range(setting.profiles.shape[2])]
    if point.pull != 0.0:
        tasks.append(base.from_pull)
    passes = over_threads(bench, tasks)
    residual = residual_of(setting, point, vector, motion)
    return chained(setting, point, passes, residual, known, anew)


def _way(first: _Known, second: _Known, by: float) -> Pass:
    """Take derivatives from two motions of the pieces; readings are measured less predicted."""
    return Pass((first.readings - second.readings) / by, _between(first.ends, second.ends) / by)


def _known(setting: Setting, vector: FloatArray, starts: FloatArray, forces: FloatArray) -> _Known:
    """Simulate all pieces."""
    bench = setting.bench
    states, rates = run_pieces(bench.stack.packed, bench.cut, vector, starts, forces)
    rows = bench.row_of_sample
    motion = Motion(states[rows], rates[rows])
    return _Known(motion, _raw(bench, vector, motion), states[bench.cut.last_row])


def _raw(bench: Bench, vector: FloatArray, motion: Motion) -> FloatArray:
    """Innovations of all channels as one vector (entries,)."""
    return np.concatenate([one.ravel() for one in innovations(bench, vector, motion)])


def _between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Way (k, 12) from first to second states: place, body rotation, velocity."""
    found = np.empty((len(first), 12))
    found[:, :3] = second[:, :3] - first[:, :3]
    found[:, 6:] = second[:, 7:13] - first[:, 7:13]
    a, b = first[:, 3:7], second[:, 3:7]
    found[:, 3:6] = 2.0 * (a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:]))
    return found


def chained(  # noqa: PLR0917 - one caller
    setting: Setting,
    point: Point,
    passes: Sequence[Pass],
    residual: FloatArray,
    known: LinearModel | None,
    anew: Sequence[int],
) -> LinearModel:
    """Follow the derivatives through the pieces of each window and whiten them."""
    bench, pieces = setting.bench, setting.bench.pieces
    windows = bench.window_count
    count = len(passes) - 18
    ends = np.stack([one.ends for one in passes], axis=2)
    ends = np.where(np.isfinite(ends), ends, 0.0).reshape(windows, pieces, 12, len(passes))
    a, b, c = ends[..., :12], ends[..., 12:18], ends[..., 18:]
    forces = 6 * pieces
    width = 12 + forces + count
    # how the start of each piece moves with every unknown
    moved = np.zeros((windows, pieces, 12, width))
    moved[:, 0, :, :12] = np.eye(12)
    for i in range(1, pieces):
        moved[:, i] = a[:, i - 1] @ moved[:, i - 1]
        moved[:, i, :, 12 + 6 * (i - 1) : 12 + 6 * i] += b[:, i - 1]
        moved[:, i, :, 12 + forces :] += c[:, i - 1]
    scales = setting.problem.start_scales
    moved[:, :, :, :12] *= scales[:, None, None, :]
    starts = moved.reshape(windows * pieces, 12, width)
    readings = np.stack([one.readings for one in passes], axis=1)
    readings = np.where(np.isfinite(readings), readings, 0.0)
    owner = _piece_of_entry(bench)
    order = np.argsort(owner, kind="stable")
    bounds = np.searchsorted(owner[order], np.arange(windows * pieces + 1))
    raw = np.empty((len(owner), width))
    for piece, (first, last) in enumerate(pairwise(bounds)):
        rows = order[first:last]
        own = readings[rows]
        columns = own[:, :12] @ starts[piece]
        at = 12 + 6 * (piece % pieces)
        columns[:, at : at + 6] += own[:, 12:18]
        columns[:, 12 + forces :] += own[:, 18:]
        raw[rows] = columns
    white = _whitened_columns(bench, raw) * setting.row_scale[:, None]
    every, profiles = len(anew), setting.profiles.shape[2]
    first = 12 + forces + every
    weight = setting.row_scale[:, None]
    departures = white[:, 12 + forces : first]
    if known is not None:
        departures = known.departures.copy()
        departures[:, list(anew)] = white[:, 12 + forces : first]
    model = LinearModel(
        setting,
        point,
        white[:, : 12 + forces],
        setting.shared.columns * weight,
        np.concatenate([setting.extra * weight, white[:, first : first + profiles]], axis=1),
        departures,
        np.zeros(0),
        residual,
        Chain(a, readings[:, :12].copy(), owner),
    )
    free = residual
    if count > every + profiles:
        # the pull is taken away: what it moved is missing
        free = residual + white[:, -1]
    return _without_lost(replace(model, readings=readings_from_zero(model, point, free)))


def led_readings(model: LinearModel, setting: Setting, departures: FloatArray) -> FloatArray:
    """Compute the readings from zero as a model at other departures sees them, led likewise.

    Only the residual and what the pull takes away are simulated anew; how the motion goes on is
    taken from `model`, since it is the same motion. Unlike a simulation without the pull this runs
    away for no hypothesis, however wrong.

    Parameters
    ----------
    model : LinearModel
        Linear around that motion.
    setting : Setting
        The same windows, led by the model at the departures.
    departures : ndarray, shape (g,)
        Where that model is.

    Returns
    -------
    ndarray, shape (rows,)
        Not finite where the simulation ran away all the same.
    """
    bench = setting.bench
    point = replace(setting.origin(), departures=departures)
    vector = vector_of(setting, departures)
    motion = motion_at(setting, point, vector)
    starts, forces = motion.state[bench.start_of_piece], forces_at(setting, point)
    known = _known(setting, vector, starts, forces)
    taken = _Base(setting, point, vector, starts, forces, known, 0.0).from_pull()
    ends = taken.ends.reshape(bench.window_count, bench.pieces, 12)
    moved = np.zeros_like(ends)
    for i in range(1, bench.pieces):
        moved[:, i] = np.einsum("wij,wj->wi", model.chain.ends[:, i - 1], moved[:, i - 1])
        moved[:, i] += ends[:, i - 1]
    raw = taken.readings + np.einsum(
        "ek,ek->e", model.chain.readings, moved.reshape(-1, 12)[model.chain.piece]
    )
    white = _whitened_columns(bench, raw[:, None])[:, 0] * setting.row_scale
    residual = residual_of(setting, point, vector, motion)
    return readings_from_zero(model, point, residual + white)


def _without_lost(model: LinearModel) -> LinearModel:
    """Let windows say nothing in which the simulation ran away: all their rows become zero."""
    parts = (model.local, model.shared, model.extra, model.departures, model.readings[:, None])
    sound = np.all([(np.abs(part) < _LOST).all(axis=1) for part in parts], axis=0)
    sound &= np.abs(model.residual) < _LOST
    if sound.all():
        return model
    window = model.setting.shared.window
    lost = np.zeros(model.setting.bench.window_count, bool)
    lost[window[~sound]] = True
    kept = ~lost[window]

    def zeroed(values: FloatArray) -> FloatArray:
        return np.where(kept if values.ndim == 1 else kept[:, None], values, 0.0)

    return replace(
        model,
        local=zeroed(model.local),
        shared=zeroed(model.shared),
        extra=zeroed(model.extra),
        departures=zeroed(model.departures),
        readings=zeroed(model.readings),
        residual=zeroed(model.residual),
    )


def _piece_of_entry(bench: Bench) -> IntArray:
    """Piece of each entry of `_raw` (entries,)."""
    found = []
    for rows in bench.stack.rows:
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        found.append(np.repeat(bench.piece_of_sample[rows.sample], width))
    return np.concatenate(found)


def _whitened_columns(bench: Bench, raw: FloatArray) -> FloatArray:
    """Columns (entries, k) of `_raw` with white noise, in the order of the residuals."""
    stack = bench.stack
    found = np.empty_like(raw)
    begin = 0
    for rows in stack.rows:
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        end = begin + rows.sample.size * width
        values = raw[begin:end].reshape(rows.sample.size, width, -1)
        out = found[begin:end].reshape(values.shape)
        for members, whitener in rows.blocks:
            if isinstance(whitener, float):
                out[members] = values[members] * whitener
            else:
                for one in members:
                    block = values[one].reshape(len(one), -1)
                    out[one] = (whitener @ block).reshape(len(one), width, -1)
        begin = end
    return found[stack.order]
