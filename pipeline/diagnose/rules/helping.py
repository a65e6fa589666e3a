"""Answers must help: those with which what took no part is predicted no better give way."""

from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace

from pipeline.diagnose.kinematics.dead_reckoning import MEASUREMENT
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.decision import CLEAR_GAP
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN

#: Share of its probability that an answer keeps with which the held-out gap is no smaller, and how
#: many are asked.
_NO_HELP, _ASKED = 0.1, 4
#: Probability over that of a pair below which one of its effects alone is out by the readings, and
#: the share of the pair's gap that it may leave then to take its place all the same; otherwise it
#: must leave less by what chance does not make.
_NOT_OUT, _CLEARLY, _LESS = 1e-12, 0.9, 0.95
#: Probability of all other answers together from which on they share what such an answer loses.
_OTHERS = 0.05


def demote_without_heldout_gain(
    ranking: Sequence[Share],
    left_of: Callable[[Sequence[Share]], Left | None],
    worst_ratio: float,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> tuple[Share, ...]:
    """Let answers give way with which the runs that took no part are predicted no better.

    A flaw of the model can be explained with certainty by an effect that pulls against others, and
    by itself only makes the gap larger; and so a second effect beside a true one. Errors of
    measurement are told all the same, see `without_gap`, and so are effects that do not act in what
    took no part: straight runs say nothing of a thruster that turns.

    Parameters
    ----------
    ranking, worst_ratio, limits
        As of `without_gap`.
    left_of : callable
        What the first of some answers leaves, where that is known.
    healthy_known : bool
        The floor was learned from healthy runs.
    """
    shares, refused = tuple(ranking), set[str]()
    for _ in range(_ASKED):
        top, left = shares[0], left_of(shares)
        sensors = set(top.name.split("+")) <= MEASUREMENT
        if top.name in {NONE, UNKNOWN} or sensors or left is None:
            break
        simpler = _enough_alone(shares, left, left_of)
        if simpler is not None:
            shares = _passed_on(shares, simpler)
        elif left.alone >= 1.0 and left.tested:
            refused.add(top.name)
            most = limits.most_none_gap_healthy if healthy_known else limits.most_none_gap
            clear = worst_ratio > most and left.before >= CLEAR_GAP
            shares = _given_way(shares, refused, UNKNOWN if clear else NONE)
        else:
            break
    return shares


def _enough_alone(
    ranking: Sequence[Share], left: Left, left_of: Callable[[Sequence[Share]], Left | None]
) -> str | None:
    """Name the effect of a pair with which alone the held-out gap is smaller than with both.

    Of two such effects the more probable: two that do nearly the same close the same gap. One that
    the readings rule out without the other must leave clearly less: a true second effect may act
    little where the held-out runs were flown.
    """
    top = ranking[0]
    for one in ranking[1:]:
        if one.name not in top.name.split("+"):
            continue
        by_itself = left_of([one, *(other for other in ranking if other is not one)])
        share = _LESS if one.probability >= _NOT_OUT * top.probability else _CLEARLY
        if by_itself is not None and by_itself.alone < min(share * left.alone, 1.0):
            return one.name
    return None


def _passed_on(ranking: Sequence[Share], heir: str) -> tuple[Share, ...]:
    """Pass most of the probability of the first answer on to another one."""
    passed = ranking[0].probability * (1.0 - _NO_HELP)
    worth = {one.name: one.probability for one in ranking}
    worth[ranking[0].name] -= passed
    worth[heir] = worth.get(heir, 0.0) + passed
    shares = [Share(name, value) for name, value in worth.items()]
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def _given_way(
    ranking: Sequence[Share], refused: AbstractSet[str], otherwise: str
) -> tuple[Share, ...]:
    """Take most of its probability from the first answer, for others or what is said otherwise."""
    top = ranking[0]
    rest = sum(one.probability for one in ranking if one.name not in refused)
    if rest < _OTHERS:
        return _passed_on(ranking, otherwise)
    kept = top.probability * _NO_HELP
    grown = 1.0 + (top.probability - kept) / rest
    shares = [
        replace(one, probability=one.probability * (1.0 if one.name in refused else grown))
        for one in ranking[1:]
    ]
    shares.append(replace(top, probability=kept))
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))
