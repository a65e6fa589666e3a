"""How far what runs differ from sound ones by shrinks where no size was taken from."""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.ahead import floors_of, rms_of, summed, unit_of
from pipeline.diagnose.regression.claimed import Late
from pipeline.diagnose.regression.decide import Said
from pipeline.diagnose.regression.grid import GridRun
from pipeline.diagnose.regression.known import Learned, Reference, ToldRun
from pipeline.diagnose.regression.ordinary import beyond_ordinary
from pipeline.records.diagnosis import Interval, Series, Shrink, ShrinkFigures
from pipeline.types import FloatArray, IntArray

#: Blocks that are drawn from, and how often. [s]
_BLOCK_S, _RESAMPLINGS, _FEWEST_BLOCKS = 6.0, 400, 4
#: Gap from which on there is something to close, in floors.
_LEAST_GAP = 1.1


def _halves(run: GridRun) -> tuple[GridRun, GridRun]:
    """Cut a run in the middle."""
    middle, rows = len(run.time_s) // 2, len(run.time_s)

    def part(which: slice) -> GridRun:
        own = {
            one.name: getattr(run, one.name)[which]
            for one in fields(run)
            if isinstance(getattr(run, one.name), np.ndarray)
            and len(getattr(run, one.name)) == rows
            and one.name != "heavier"
        }
        late = {
            k: Late(*(values[which] for values in (one.slip, one.read, one.true, one.wrench)))
            for k, one in run.late.items()
        }
        return replace(run, **own, late=late, base=None, settled_of=None)

    return part(slice(0, middle)), part(slice(middle, rows))


def shrink_of(
    case: Case,
    known: Reference,
    said: Said,
    runs: Sequence[ToldRun],
    held: Sequence[GridRun],
    *,
    named: bool,
) -> tuple[Shrink, tuple[Series, ...]]:
    """How far the error shrinks where the sizes were not taken from."""
    learned, parts = known.best, list[tuple[ToldRun, FloatArray]]()
    none = np.zeros(len(known.directions))
    if held:
        carried = [runs[k] for k in said.first.runs]
        size = _size_from(learned, said, carried) if named else none
        parts = [(run, size) for run in learned.told_runs(held)]
        told = "runs " + ", ".join(run.name for run in case.holdout)
    else:
        halves = [_halves(one.run) for one in runs]
        sides = [learned.told_runs([one[side] for one in halves]) for side in (0, 1)]
        for side in (0, 1):
            carried = [sides[1 - side][k] for k in said.first.runs]
            size = _size_from(learned, said, carried) if named else none
            parts += [
                (one, size if k in said.first.runs else none) for k, one in enumerate(sides[side])
            ]
        told = "each half of the runs, with the size from the other half"
    period, floors = learned.response.period_s, floors_of(learned)
    before, after, series = [], [], []
    for one_run, size in parts:
        rows, _, first = learned.after(one_run)
        left, right = summed(first, period), summed(learned.after(one_run, size)[2], period)
        before.append(left)
        after.append(right)
        series += _series(one_run.run, rows[len(rows) - len(left) :], left, right)
    one, other = rms_of(before), rms_of(after)
    whole, by_channel = _intervals(before, after, floors, period)
    channels = {
        name: ShrinkFigures(
            before=float(one[c]),
            after=float(other[c]),
            noise_floor=float(floors[c]),
            gap_closed=_closed(float(one[c] / floors[c]), float(other[c] / floors[c])),
            ci95=by_channel[c],
        )
        for c, name in enumerate(learned.response.channels)
    }
    first_all = float(np.sqrt(np.mean((one / floors) ** 2)))
    second_all = float(np.sqrt(np.mean((other / floors) ** 2)))
    return Shrink(
        before=first_all,
        after=second_all,
        noise_floor=1.0,
        gap_closed=_closed(first_all, second_all),
        ci95=whole,
        channels=channels,
        held_out=told,
    ), tuple(series)


def _intervals(
    before: Sequence[FloatArray], after: Sequence[FloatArray], floors: FloatArray, period_s: float
) -> tuple[Interval | None, list[Interval | None]]:
    """95 % intervals of the share that is gone, over all channels and of each, by block bootstrap.

    None where too few blocks are there, or next to no gap in most that are drawn.
    """
    length = max(round(_BLOCK_S / period_s), 1)
    every = []
    for pair in zip(before, after, strict=True):
        squares = np.square(np.stack(pair, axis=1))
        count = len(squares) // length
        every += [one.mean(axis=0) for one in np.array_split(squares, max(count, 1))[:count]]
    blocks = np.array(every).reshape(-1, 2, len(floors)) / floors**2
    if len(blocks) < _FEWEST_BLOCKS:
        return None, [None] * len(floors)
    drawn = np.random.default_rng(0).integers(0, len(blocks), (_RESAMPLINGS, len(blocks)))
    ratios = blocks[drawn].mean(axis=1)
    each = [_interval(np.sqrt(ratios[:, :, c])) for c in range(len(floors))]
    return _interval(np.sqrt(ratios.mean(axis=2))), each


def _interval(drawn: FloatArray) -> Interval | None:
    every = [_closed(float(one), float(other)) for one, other in drawn]
    closed = [one for one in every if one is not None]
    if len(closed) <= len(every) // 2:
        return None
    low, high = np.quantile(closed, [0.025, 0.975])
    return float(low), float(high)


def _closed(before: float, after: float) -> float | None:
    return (before - after) / (before - 1.0) if before > _LEAST_GAP else None


def _size_from(learned: Learned, said: Said, runs: Sequence[ToldRun]) -> FloatArray:
    """Size of each direction that is named, from some runs alone."""
    ordinary, own = learned.ordinary, list(said.first.which)
    every = [beyond_ordinary(one.told.tempered(ordinary.share), ordinary.width) for one in runs]
    found = np.zeros(ordinary.width.size)
    information = np.sum([one for one, _ in every], axis=0)[np.ix_(own, own)]
    score = np.sum([one for _, one in every], axis=0)[own]
    found[own] = np.linalg.solve(information + np.eye(len(own)), score)
    return found


def _series(run: GridRun, rows: IntArray, before: FloatArray, after: FloatArray) -> list[Series]:
    return [
        Series(
            run=run.name,
            channel=name,
            unit=unit_of(name),
            time_s=tuple(run.time_s[rows].tolist()),
            measured=tuple(run.velocity[rows, c].tolist()),
            before=tuple((run.velocity[rows, c] - before[:, c]).tolist()),
            after=tuple((run.velocity[rows, c] - after[:, c]).tolist()),
        )
        for c, name in enumerate(run.channels)
    ]
