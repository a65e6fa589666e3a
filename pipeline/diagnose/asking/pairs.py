"""Pairs of effects: built on the strongest single ones, judged under any level of the force."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pipeline.diagnose.asking.hypotheses import (
    Finding,
    Group,
    judge,
    screen,
    subset_price,
    with_wide,
)
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import Marginal

#: Squared cosine of 15 degrees: closer signatures are no pair.
_SAME = 0.93


def pairs(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
    singles: Sequence[Finding],
    most: int,
) -> list[Finding]:
    """Second effects on top of the strongest single ones, the strongest pairs first."""
    found: dict[tuple[int, ...], Finding] = {}
    for first in singles[:most]:
        if not first.which:
            continue
        second_ground = with_wide(ground, first.which, first.variance)
        others = {g: m for g, m in groups.items() if g[0] != first.groups[0][0]}
        for second in screen(second_ground, all_coordinates, others)[:most]:
            which = tuple(sorted((*first.which, *second.which)))
            if which in found or not second.which or _says_the_same(ground, groups, first, second):
                continue
            pair = tuple(sorted((*first.groups, *second.groups), key=str))
            found[which] = _pair_under(ground, all_coordinates, groups, pair, which)
    return _strongest_first(found.values())


def pairs_under(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
    found: Iterable[Finding],
) -> list[Finding]:
    """Judge pairs that were found on some grounds on another one, the strongest first."""
    each = {(one.groups, one.which): one for one in found}
    return _strongest_first(_pair_under(ground, all_coordinates, groups, *pair) for pair in each)


def _pair_under(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
    pair: tuple[Group, ...],
    which: tuple[int, ...],
) -> Finding:
    gain, mean, covariance, variance = judge(ground, all_coordinates, which)
    for group in pair:
        gain += subset_price(groups, group, sum(k in groups[group] for k in which))
    return Finding(pair, which, gain, mean, covariance, variance)


def _strongest_first(some: Iterable[Finding]) -> list[Finding]:
    return sorted(some, key=lambda one: (-one.log_evidence, str(one.groups)))


def _says_the_same(
    ground: Marginal,
    groups: Mapping[Group, tuple[int, ...]],
    first: Finding,
    second: Finding,
) -> bool:
    """Whether either effect alone could make nearly all of what the other makes.

    Two such effects would pull against each other, with any sizes.
    """
    return any(
        _share_made(ground, one, groups[other.groups[0]]) > _SAME
        for one, other in ((first, second), (second, first))
    )


def _share_made(ground: Marginal, one: Finding, members: Sequence[int]) -> float:
    """Squared cosine of a finding's signature to the signatures of other departures."""
    index = list(members)
    own = ground.information[np.ix_(one.which, one.which)]
    whole = float(one.mean @ own @ one.mean)
    side = ground.information[np.ix_(index, one.which)] @ one.mean
    block = ground.information[np.ix_(index, index)]
    # departures that nothing shows of make nothing
    made = np.linalg.pinv(block, rcond=1e-9, hermitian=True) @ side
    return float(side @ made) / max(whole, 1e-300)
