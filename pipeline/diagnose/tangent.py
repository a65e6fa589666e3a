r"""Derivatives of all readings, along one motion, by everything that is unknown.

The motion is cut into pieces of half a second. Each piece is simulated anew from where the motion
is at its begin, moved a little in one of twelve directions, with a little outside force along one
of six axes, or with one departure a little off. That gives for each piece how its end moves,

.. math:: \delta_{i+1} = A_i \delta_i + B_i f_i + g_i x

and how the readings within move; the rest is linear algebra along the window. So the outside force
may change every half second at no further cost in simulation.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from pipeline.diagnose.linear_model import (
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
from pipeline.diagnose.moved_pieces import MovedPieces, Pass, seen_in
from pipeline.diagnose.predictions import (
    Bench,
    over_threads,
    shown_samples,
)
from pipeline.types import FloatArray, IntArray

#: A whitened derivative or residual this large is that of a simulation that ran away.
_LOST = 1e7


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
    seen = seen_in(setting, vector, starts, forces)
    base = MovedPieces(setting, point, vector, starts, forces, seen, wide)
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
    owner = _piece_of_entry(bench, vector_of(setting, point.departures))
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
    known = seen_in(setting, vector, starts, forces)
    taken = MovedPieces(setting, point, vector, starts, forces, known, 0.0).from_pull()
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


def _piece_of_entry(bench: Bench, vector: FloatArray) -> IntArray:
    """Piece of the motion that each entry of the readings shows (entries,).

    What a DVL shows late lies in an earlier piece than what the other sensors show by then.
    """
    found = []
    for rows in bench.stack.rows:
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        sample = shown_samples(bench, vector, rows)
        found.append(np.repeat(bench.piece_of_sample[sample], width))
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
