"""At which size a change is taken that is not in proportion to it: a dead zone, a lag, a tilt.

The signature is the secant to the size at which it is taken, and says how much of it there is. That
is no way to the right one: of a lag of a second each shorter one finds nine tenths of itself. It is
the size with which, as it is taken, the runs become most probable, on all grids alike. Such a
change stands beside the same direction as it differs between any two runs, which is small.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.coordinates import Added, partners
from pipeline.diagnose.regression.directions import NEVER
from pipeline.diagnose.regression.gained import Gained
from pipeline.diagnose.regression.grid import GridRun, all_at
from pipeline.diagnose.regression.known import Learned, Reference
from pipeline.diagnose.regression.ordinary import beyond_ordinary
from pipeline.diagnose.regression.weigh import weighed

#: Single changes that are taken at their sizes, in so many rounds, but for small ones (in units).
_LIKELIEST, _ROUNDS, _LEAST_SIZE = 5, 2, 0.1
#: Steps in which a size is sought, coarse and fine, and the log evidence that one must be worth.
_STEPS, _WORTH = (2.0, 2.0**0.5), 1.0
#: Share by which what is found at half the size, or at a unit, may differ of one in proportion.
_BENT = 0.05

#: Runs on all grids of each.
Asked = Sequence[Sequence[GridRun]]


def with_sizes(
    known: Reference, asked: Asked, gained: Sequence[Gained]
) -> tuple[Reference, tuple[Added, ...]]:
    """Take the likeliest single changes at their sizes, and what acts only beside them.

    Returns
    -------
    known : Reference
        With these changes as directions of their own, behind all others.
    added : tuple of Added
        Just these; see `all_at`.
    """
    taken: dict[int, Added] = {}
    beside: dict[str, tuple[Added, ...]] = {}
    claimed = asked[0][0].claimed
    for _ in range(_ROUNDS):
        added = (*taken.values(), *(one for own in beside.values() for one in own))
        learned = _beside(known.best, added)
        every = (*known.directions, *(one.direction for one in added))
        own = [all_at(grids[:1], added)[0] for grids in asked]
        ranking = weighed(learned.told(own), every, learned.ordinary, gained, learned.sound)
        singles = [one for one in ranking if one.which and "+" not in one.name]
        for one in singles[_LIKELIEST - 1 :: -1]:
            bounds = np.array([every[k].bounds for k in one.which])
            size = dict(zip(one.which, np.clip(one.mean, *bounds.T).tolist(), strict=True))
            large = [k for k in one.which if abs(size[k]) > _LEAST_SIZE and not every[k].beside]
            if large and claimed is not None:
                values = {every[k].parameter.name: every[k].value(size[k]) for k in one.which}
                first = every[large[0]]
                beside[one.name] = partners(claimed.packed, first, values, known.directions)
            for k in (k for k in large if k < len(known.directions)):
                found = _most_probable(known, [asked[run] for run in one.runs], k, size[k])
                if found is not None:
                    taken[k] = Added(every[k], found, k)
    added = (*taken.values(), *(one for own in beside.values() for one in own))
    grids = tuple(_beside(one, added) for one in known.grids)
    every = (*known.directions, *(one.direction for one in added))
    none = [NEVER if one.of is None else known.stated[one.of] for one in added]
    stated = np.concatenate([known.stated, none])
    return replace(known, directions=every, grids=grids, stated=stated), added


def _beside(learned: Learned, added: Sequence[Added]) -> Learned:
    """Add directions of changes that never are ordinary, nor what sound runs are off by."""
    if not added:
        return learned
    offset, ordinary = learned.offset, learned.ordinary
    count, more = ordinary.width.size, len(added)
    places = [*range(count), *(-1 if one.of is None else one.of for one in added)]
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
        ordinary=replace(ordinary, width=np.concatenate([ordinary.width, np.full(more, NEVER)])),
        sound=tuple(one.at(places) for one in learned.sound),
    )


def _told_at(
    known: Reference, asked: Asked, k: int, tried: float, *, grids: int
) -> list[tuple[float, float]]:
    """Information and score of a direction that is taken at a size, on so many grids."""
    added = [Added(known.directions[k], tried, k)]
    runs = [all_at(one[:grids], added) for one in asked]
    found = []
    for learned, on_one in zip(known.grids[:grids], zip(*runs, strict=True), strict=True):
        more = _beside(learned, added)
        both = [
            beyond_ordinary(one.tempered(more.ordinary.share), more.ordinary.width)
            for one in more.told(on_one)
        ]
        own = sum(float(one[-1, -1]) for one, _ in both)
        found.append((own, sum(float(one[-1]) for _, one in both)))
    return found


def _most_probable(known: Reference, asked: Asked, k: int, size: float) -> float | None:
    """Seek the size of a direction from one that was found, up and down, then finely.

    None for a change in proportion to its size.
    """
    low, high = known.directions[k].bounds

    def evidence(tried: float) -> float:
        both = _told_at(known, asked, k, tried, grids=len(known.grids))
        return float(np.mean([score * tried - 0.5 * own * tried**2 for own, score in both]))

    sizes_tried = (size, 0.5 * size, known.directions[k].side)
    at = [_told_at(known, asked, k, one, grids=1)[0] for one in sizes_tried]
    whole, *others = (score / max(own, 1e-12) for own, score in at)
    if all(abs(one - whole) <= _BENT * abs(whole) for one in others):
        return None
    best, value = size, evidence(size)
    for step in _STEPS:
        for factor in (step, 1.0 / step):
            moved = False
            while True:
                tried = min(max(best * factor, low), high)
                if tried == best or abs(tried) < _LEAST_SIZE:
                    break
                more = evidence(tried)
                if more < value + _WORTH:
                    break
                best, value, moved = tried, more, True
            if moved:
                break
    return best
