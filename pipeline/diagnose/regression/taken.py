"""At which size a change is taken that is not in proportion to it: a dead zone, a lag, a tilt.

The signature is the secant to the size at which it is taken, and says how much of it there is. That
is no way to the right one: of a lag of a second each shorter one finds nine tenths of itself. It is
the size with which, as it is taken, the runs become most probable, on all grids alike. Such a
change stands beside the same direction as it differs between any two runs, which is small.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.coordinates import Added, partners, scaled_by
from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.directions import NEVER
from pipeline.diagnose.regression.gained import Gained
from pipeline.diagnose.regression.grid import GridRun, all_at
from pipeline.diagnose.regression.known import Learned, Reference
from pipeline.diagnose.regression.ordinary import beyond_ordinary
from pipeline.diagnose.regression.weigh import weighed
from pipeline.types import FloatArray

#: Single changes taken at their sizes, in so many rounds, but for small ones (in units), and
#: those that are no larger than so many standard deviations.
_LIKELIEST, _ROUNDS, _LEAST_SIZE, _TOLD = 5, 3, 0.02, 2.0
#: A size that is this share off the one at which it was taken is taken anew.
_MOVED = 0.2
#: Steps in which a size is sought, coarse and fine, and the log evidence that one must be worth.
_STEPS, _WORTH = (2.0, 2.0**0.5), 1.0
#: Share by which what is found at half the size, or at a unit, may differ of one in proportion.
_BENT = 0.05

#: Runs on all grids of each.
Asked = Sequence[Sequence[GridRun]]


def with_sizes(
    known: Reference, asked: Asked, gained: Sequence[Gained]
) -> tuple[Reference, tuple[Added, ...], Asked]:
    """Take the likeliest single changes at their sizes, and what acts only beside them.

    Each round begins where the one before ended: a run moves as the most probable change has it,
    and what moved away from the size at which it was taken is taken anew.

    Returns
    -------
    known : Reference
        With these changes as directions of their own, behind all others.
    added : tuple of Added
        Just these; see `all_at`.
    asked : sequence of sequence of GridRun
        The runs, settled by the most probable change; see `Response.settled`.
    """
    taken: dict[int, Added] = {}
    beside: dict[str, tuple[Added, ...]] = {}
    added: tuple[Added, ...] = ()
    claimed, settled = asked[0][0].claimed, asked
    for _ in range(_ROUNDS):
        learned = _beside(known.best, added)
        every = (*known.directions, *(one.direction for one in added))
        runs = [all_at(grids, added) for grids in settled]
        told = learned.told([grids[0] for grids in runs])
        ranking = weighed(told, every, learned.ordinary, gained, learned.sound)
        settled = _settled(known, added, runs, ranking[0])
        before = dict(taken)
        singles = [one for one in ranking if one.which and "+" not in one.name]
        for one in singles[_LIKELIEST - 1 :: -1]:
            bounds = np.array([every[k].bounds for k in one.which])
            size = dict(zip(one.which, np.clip(one.mean, *bounds.T).tolist(), strict=True))
            least = dict(zip(one.which, np.maximum(_TOLD * one.std, _LEAST_SIZE), strict=True))
            large = [k for k in one.which if abs(size[k]) > least[k]]
            first = next((every[k] for k in large if not every[k].beside), None)
            if first is not None and claimed is not None:
                values = {every[k].parameter.name: every[k].value(size[k]) for k in one.which}
                beside[one.name] = (
                    *partners(claimed.packed, first, values, known.directions),
                    *scaled_by(first, values, known.directions, len(asked)),
                )
            where = {k: _place(k, known, added) for k in large}
            plain = {place: size[k] for k, place in where.items() if place is not None}
            if any(_moved(plain[k], taken.get(k)) for k in plain):
                own = [settled[run] for run in one.runs]
                taken |= _together(known, own, sorted(plain), plain)
        added = (*taken.values(), *(one for own in beside.values() for one in own))
        if taken == before:
            break
    grids = tuple(_beside(one, added) for one in known.grids)
    every = (*known.directions, *(one.direction for one in added))
    none = [NEVER if one.of is None else known.stated[one.of] for one in added]
    stated = np.concatenate([known.stated, none])
    return replace(known, directions=every, grids=grids, stated=stated), added, settled


def _place(k: int, known: Reference, added: Sequence[Added]) -> int | None:
    """Return the place of a direction among those that are taken where they are small."""
    count = len(known.directions)
    return k if k < count else added[k - count].of


def _moved(size: float, before: Added | None) -> bool:
    """Whether a size is not that at which a direction was taken."""
    return before is None or abs(size - before.size) > _MOVED * abs(before.size)


def _settled(
    known: Reference, added: Sequence[Added], runs: Asked, first: Change
) -> list[list[GridRun]]:
    """Return runs, without directions at sizes, that move as a change has it."""
    change = np.zeros(len(known.directions) + len(added))
    change[list(first.which)] = first.mean
    return [
        [
            learned.response.settled(grid, change) if k in first.runs else grid.unsettled
            for learned, grid in zip(known.grids, grids, strict=True)
        ]
        for k, grids in enumerate(runs)
    ]


def _beside(learned: Learned, added: Sequence[Added]) -> Learned:
    """Add directions of changes that never are ordinary, nor what sound runs are off by.

    What a change goes with is ordinary as far as the file states it.
    """
    if not added:
        return learned
    offset, ordinary = learned.offset, learned.ordinary
    count, more = ordinary.width.size, len(added)
    places = [*range(count), *(-1 if one.of is None else one.of for one in added)]
    own = [one.direction.ordinary if one.direction.within else NEVER for one in added]
    none = np.zeros((len(offset.share), more))
    covariance = np.zeros((len(offset.share), count + more, count + more))
    covariance[:, :count, :count] = offset.covariance
    return replace(
        learned,
        offset=replace(
            offset,
            variance=np.hstack([offset.variance, none]),
            mean=np.hstack([offset.mean, none]),
            covariance=covariance,
        ),
        ordinary=replace(ordinary, width=np.concatenate([ordinary.width, own])),
        sound=tuple(one.at(places) for one in learned.sound),
    )


def _together(
    known: Reference, asked: Asked, which: Sequence[int], size: Mapping[int, float]
) -> dict[int, Added]:
    """Take parameters of one effect at their sizes, each beside those before it.

    Drag goes with the square of the speed: that of a current to the north and the east is not the
    sum of both. Those that are in proportion to their size, beside others as alone, are left out.
    """
    found: dict[int, Added] = {}
    before: tuple[Added, ...] = ()
    for k in which:
        plain = known.directions[k]
        values = ((one.direction.parameter.name, one.direction.value(one.size)) for one in before)
        own = Added(replace(plain, beside=tuple(values)), size[k], k)
        best = _most_probable(known, asked, before, own)
        if best is not None:
            found[k] = own = replace(own, size=best)
        before = (*before, own)
    return found


def _told_at(
    known: Reference, asked: Asked, added: Sequence[Added], *, grids: int
) -> list[tuple[FloatArray, FloatArray]]:
    """Information (n, n) and score (n,) of directions that are taken at sizes, on so many grids."""
    runs = [all_at(one[:grids], added) for one in asked]
    found = []
    for learned, on_one in zip(known.grids[:grids], zip(*runs, strict=True), strict=True):
        more = _beside(learned, added)
        last = slice(-len(added), None)
        both = [
            beyond_ordinary(one.tempered(more.ordinary.share), more.ordinary.width)
            for one in more.told(on_one)
        ]
        information = np.sum([one[last, last] for one, _ in both], axis=0)
        found.append((information, np.sum([one[last] for _, one in both], axis=0)))
    return found


def _most_probable(
    known: Reference, asked: Asked, before: Sequence[Added], one: Added
) -> float | None:
    """Seek the size of a direction from one that was found, up and down, then finely.

    None for a change in proportion to its size.
    """
    direction = one.direction

    def at(tried: Added, grids: int) -> list[tuple[FloatArray, FloatArray]]:
        return _told_at(known, asked, (*before, tried), grids=grids)

    def evidence(size: float) -> float:
        sizes = np.array([*(other.size for other in before), size])
        both = at(replace(one, size=size), len(known.grids))
        return float(np.mean([score @ sizes - 0.5 * sizes @ own @ sizes for own, score in both]))

    def estimate(tried: Added) -> float:
        (own, score) = at(tried, 1)[0]
        return float(np.linalg.lstsq(own, score, rcond=None)[0][-1])

    sizes = (one.size, 0.5 * one.size, direction.side)
    alone = replace(one, direction=replace(direction, beside=()))
    whole, *others = (estimate(tried) for tried in (*(replace(one, size=s) for s in sizes), alone))
    if all(abs(other - whole) <= _BENT * abs(whole) for other in others):
        return None
    return _highest(evidence, one.size, direction.bounds)


def _highest(evidence: Callable[[float], float], size: float, bounds: tuple[float, float]) -> float:
    """Climb from a size to the highest evidence, coarsely and then finely."""
    best, value = size, evidence(size)
    for step in _STEPS:
        for factor in (step, 1.0 / step):
            moved = False
            while True:
                tried = min(max(best * factor, bounds[0]), bounds[1])
                if tried == best or abs(tried) < _LEAST_SIZE:
                    break
                more = evidence(tried)
                if more < value + _WORTH:
                    break
                best, value, moved = tried, more, True
            if moved:
                break
    return best
