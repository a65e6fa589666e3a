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

from pipeline.diagnose.linear.linear_model import (
    LinearModel,
    Point,
    Setting,
    forces_at,
    motion_at,
    readings_from_zero,
    residual_of,
    vector_of,
)
from pipeline.diagnose.linear.moved_pieces import MovedPieces, Pass, seen_in
from pipeline.diagnose.linear.predictions import (
    Bench,
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

    Of the departures only those of `renew` are taken anew where some are asked for; the others are
    those of a linear model of the same windows that is known already, or none. So is what errors of
    the thrusters' curves do: half a per cent of a thrust moves a vehicle alike wherever it is
    judged. With `wide` the signature of a departure that is at neutral, and of which nothing is
    stated, is the secant to one of that size: drag in a current, or a dead zone, has next to no
    derivative where it is not there.
    """
    bench = setting.bench
    vector = vector_of(setting, point.departures)
    motion = motion_at(setting, point, vector)
    # the pieces follow the same motion: their starts are its states
    starts, forces = motion.state[bench.start_of_piece], forces_at(setting, point)
    seen = seen_in(setting, vector, starts, forces)
    base = MovedPieces(setting, point, vector, starts, forces, seen, wide)
    anew = list(range(len(setting.coordinates)) if renew is None else renew)
    tasks: list[Callable[[], Pass]] = [partial(base.from_start, k) for k in range(12)]
    tasks += [partial(base.from_force, k) for k in range(6)]
    tasks += [partial(base.from_departure, k) for k in anew]
    if known is None:
        tasks += [partial(base.from_profile, k) for k in range(setting.profiles.shape[2])]
    if point.pull != 0.0:
        tasks.append(base.from_pull)
    passes = bench.workers.each(tasks)
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
    white = _whitened_columns(setting, point, passes, moved.reshape(-1, 12, width))
    every, profiles = len(anew), 0 if known is not None else setting.profiles.shape[2]
    first = 12 + forces + every
    weight = setting.row_scale[:, None]
    if known is not None:
        departures = known.departures.copy()
        curves = known.extra[:, setting.extra.shape[1] :]
    else:
        departures = np.zeros((len(white), len(setting.coordinates)))
        curves = white[:, first : first + profiles]
    departures[:, list(anew)] = white[:, 12 + forces : first]
    model = LinearModel(
        setting,
        point,
        white[:, : 12 + forces],
        setting.shared.columns * weight,
        np.concatenate([setting.extra * weight, curves], axis=1),
        departures,
        np.zeros(0),
        residual,
    )
    free = residual
    if count > every + profiles:
        # the pull is taken away: what it moved is missing
        free = residual + white[:, -1]
    return _without_lost(replace(model, readings=readings_from_zero(model, point, free)))


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


def _whitened_columns(
    setting: Setting, point: Point, passes: Sequence[Pass], moved: FloatArray
) -> FloatArray:
    """Weighted columns (rows, 12 + forces + others) with white noise, in the residuals' order.

    `moved` (pieces, 12, columns) is how the start of each piece moves with every unknown. What is
    white already is weighted before it is spread over the columns: there are many more of them.
    """
    bench, order = setting.bench, setting.bench.stack.order
    width = moved.shape[2]
    tail = width - (len(passes) - 18)
    weight, coloured = _noise_of_entries(setting)
    owner = _piece_of_entry(bench, vector_of(setting, point.departures))[order]
    found = np.zeros((len(order), width))

    def fill(first: int, last: int) -> None:
        """Fill the rows of one window."""
        readings = np.stack([one.readings[order[first:last]] for one in passes], axis=1)
        if not np.isfinite(readings).all():
            readings = np.where(np.isfinite(readings), readings, 0.0)
        readings *= weight[first:last, None]
        for piece in np.unique(owner[first:last]):
            rows = np.flatnonzero(owner[first:last] == piece)
            own, start = readings[rows], moved[piece]
            # no reading knows of the forces that come after it
            at = 12 + 6 * (piece % bench.pieces)
            rows += first
            found[rows, :at] = own[:, :12] @ start[:, :at]
            found[rows, at : at + 6] = own[:, 12:18]
            found[rows, tail:] = own[:, :12] @ start[:, tail:] + own[:, 18:]

    bench.workers.each([partial(fill, *one) for one in pairwise(bench.stack.bounds)])
    bench.workers.each([partial(_whitened, setting, found, *one) for one in coloured])
    return found


def _noise_of_entries(setting: Setting) -> tuple[FloatArray, list[tuple[IntArray, FloatArray]]]:
    """Weight (rows,) of readings with white noise, and places and whitener of the others' windows.

    The others have weight 1: theirs is that of `Setting.row_scale`, after they are white.
    """
    stack, begin = setting.bench.stack, 0
    place = np.empty_like(stack.order)
    place[stack.order] = np.arange(stack.order.size)
    weight, coloured = setting.row_scale.copy(), []
    for rows in stack.rows:
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        own = place[begin : begin + rows.sample.size * width].reshape(-1, width)
        for members, whitener in rows.blocks:
            if isinstance(whitener, float):
                weight[own[members]] *= whitener
            else:
                weight[own[members]] = 1.0
                coloured += [(own[one], whitener) for one in members]
        begin += own.size
    return weight, coloured


def _whitened(
    setting: Setting, columns: FloatArray, places: IntArray, whitener: FloatArray
) -> None:
    """Whiten and weigh the readings of one window, in rows `places` (k, width) of the columns."""
    block = columns[places]
    white = (whitener @ block.reshape(len(places), -1)).reshape(block.shape)
    columns[places] = white * setting.row_scale[places][..., None]
