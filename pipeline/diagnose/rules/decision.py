"""From weighed answers to what is said: one answer, several that cannot be told apart, or unknown.

Only numbers: a diagnosis and the setting of its thresholds decide by the same function.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from pipeline.diagnose.kinematics.dead_reckoning import MEASUREMENT
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.sureness import (
    BESIDE_NONE,
    none_first,
    with_measured_supply,
    with_sure_effect,
)
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN

#: Gap of a healthy vehicle, and one that is clear over all channels, in healthy floors.
HEALTHY_GAP, CLEAR_GAP = 1.0, 1.5
#: Held-out gap that an effect leaves by itself from which on `unknown` stands beside it: of 93
#: right answers to generated cases three left as much.
_LEAVES_MUCH = 1.2
#: Gap that is hardly one, and the probability at most of an answer that something else stands
#: beside: of `unknown` there, and of an effect that leaves a clear gap.
_HARDLY, _UNSURE = 1.15, 0.55
#: Times the largest gap of `none` from which on it is not the answer, whatever the others are.
_FAR_BEYOND = 2.0
#: Logarithm of the odds against `none` from which on an effect is told however small its gap: a
#: healthy vehicle's flaws made 11 at most in some 25 generated cases, an added mass that the
#: floor hid 1290.
_PLAIN = 20.0
#: Beyond this many times the limit more force makes `unknown` no surer.
_MOST_TIMES = 10.0


@dataclass(frozen=True)
class Decided:
    """What is said.

    Attributes
    ----------
    ranking : tuple of Share
        Answers, most probable first.
    names, ambiguous : tuple of str
        The first answer, and what these runs cannot tell from it.
    too_small : str
        Of `none`: the answer that the readings speak for, but which makes no gap; or nothing.
    """

    ranking: tuple[Share, ...]
    names: tuple[str, ...]
    ambiguous: tuple[str, ...]
    too_small: str = ""


def without_gap(
    ranking: Sequence[Share],
    worst_ratio: float,
    worst_since: float,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> tuple[Share, ...]:
    """Put `none` first where the vehicle file predicts every channel as well as a healthy vehicle.

    With enough readings the flaws of any model are significant. What is no gap needs no cause. With
    healthy runs a gap is what came since: what the vehicle has always differed from its file by
    would otherwise be part of the error and of the floor, and hide as much again. Without them the
    floor is what the file states to be unsure of, which the evidence has weighed already. What the
    readings speak for plainly is told at any gap.

    A force that no healthy vehicle has is told from a gap on that is larger than a healthy one's,
    with `none` beside it where it is hardly larger. An error of measurement is told all the same:
    the sensors contradict each other, whatever moves the vehicle, and the prediction starts from
    what they show.

    Parameters
    ----------
    ranking : sequence of Share
        Answers, most probable first.
    worst_ratio : float
        Error of the worst channel over its healthy floor.
    worst_since : float
        The same since the healthy runs; as `worst_ratio` where there are none.
    limits : Calibration
        Thresholds.
    healthy_known : bool
        The floor was learned from healthy runs.
    """
    top = ranking[0].name
    if top == NONE or set(top.split("+")) <= MEASUREMENT:
        return tuple(ranking)
    if top != UNKNOWN:
        none = next((one.probability for one in ranking if one.name == NONE), 0.0)
        plain = none < ranking[0].probability * math.exp(-_PLAIN)
        told = not healthy_known or plain or worst_since >= limits.least_gap
        return tuple(ranking) if told else none_first(ranking)
    least = min(limits.least_gap, HEALTHY_GAP)
    if least <= worst_ratio < _HARDLY:
        return _with_beside(ranking, NONE)
    return tuple(ranking) if worst_ratio >= least else none_first(ranking)


def with_gap(
    ranking: Sequence[Share],
    worst_ratio: float,
    effect_count: int,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> tuple[Share, ...]:
    """Take `none` from its first place where the vehicle file predicts far worse than it should.

    What is stated as uncertain could explain the readings, at values that hardly any healthy
    vehicle has. A gap this large is one all the same: where the readings speak for another answer
    at all, the others share the place. Where they speak for none of them `unknown` stands beside
    it, and where the gap is larger still it is `unknown`.

    Parameters
    ----------
    ranking, worst_ratio, limits
        As of `without_gap`.
    effect_count : int
        Effects that share the prior probability of a single one.
    healthy_known : bool
        The floor was learned from healthy runs.
    """
    most = limits.most_none_gap_healthy if healthy_known else limits.most_none_gap
    top, others = ranking[0], [one for one in ranking if one.name != NONE]
    if worst_ratio <= most or top.name != NONE:
        return tuple(ranking)
    none = top.probability * BESIDE_NONE
    second = max((one.probability for one in others), default=0.0)
    if second / top.probability <= limits.single / max(effect_count, 1) / limits.none:
        # not even as probable as before the readings were seen
        if worst_ratio <= _FAR_BEYOND * most:
            return _with_beside(ranking, UNKNOWN)
        return Share(UNKNOWN, 1.0 - none), Share(NONE, none)
    grown = (1.0 - none) / sum(one.probability for one in others)
    shares = [
        replace(one, probability=none if one.name == NONE else grown * one.probability)
        for one in ranking
    ]
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def for_the_gap(
    ranking: Sequence[Share], grown: Sequence[Share], left: Left | None
) -> tuple[Share, ...]:
    """Let `none` keep its place unless what took it for the gap's sake makes the gap smaller.

    Parameters
    ----------
    ranking, grown : sequence of Share
        Answers before and after `with_gap`.
    left : Left or None
        What the first answer of `grown` leaves, where that is known.
    """
    moved = grown[0].name not in {ranking[0].name, UNKNOWN}
    if moved and left is not None and left.alone >= 1.0:
        return tuple(ranking)
    return tuple(grown)


def _with_beside(ranking: Sequence[Share], beside: str) -> tuple[Share, ...]:
    """Give an answer what the first one has of probability beyond what an unsure one may have."""
    kept = min(ranking[0].probability, _UNSURE)
    others = tuple(one for one in ranking[1:] if one.name != beside)
    rest = 1.0 - kept - sum(one.probability for one in others)
    shares = (replace(ranking[0], probability=kept), Share(beside, rest), *others)
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def with_unknown(
    ranking: Sequence[Share], left: Left, limits: Calibration, *, healthy_known: bool
) -> tuple[Share, ...]:
    """Put `unknown` first where the best answer leaves what no healthy vehicle does.

    The outside force that an answer leaves is compared with that of a healthy vehicle, axis by
    axis; a fault that starts in mid-run or comes and goes leaves much of it at some times. An
    effect must also shrink the held-out gap: one that makes it worse explains nothing. Beside one
    that leaves a gap stands `unknown`: it may be the nearest to an effect that is not known.
    """
    top = ranking[0]
    if top.name == UNKNOWN:
        return tuple(ranking)
    most = limits.most_force_healthy if healthy_known else limits.most_force
    # a force that moves nothing is no gap, where what took no part agrees
    explains = left.was_unknown and left.before >= CLEAR_GAP and left.after <= HEALTHY_GAP
    too_much = left.force > most and not explains
    if top.name != NONE and left.before > limits.most_gap:
        explained = left.gap_closed if left.gap_closed is not None else 0.0
        too_much = too_much or (left.after > limits.most_gap and explained < 0.5)
    if not too_much:
        leaves_much = top.name != NONE and left.alone_after >= _LEAVES_MUCH
        return _with_beside(ranking, UNKNOWN) if leaves_much else tuple(ranking)
    # what the evidence says within the library still counts, among what is left
    times = min(left.force / most, _MOST_TIMES)
    unknown = max(times / (1.0 + times), 0.5)
    others = (
        replace(one, probability=one.probability * (1.0 - unknown))
        for one in ranking
        if one.name != UNKNOWN
    )
    return Share(UNKNOWN, unknown), *others


def verdict_of(
    ranking: Sequence[Share], alike: Sequence[str], limits: Calibration
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the first answer, and what these runs cannot tell from it.

    Parameters
    ----------
    ranking : sequence of Share
        Answers, most probable first.
    alike : sequence of str
        Effects whose signature lies too close to what the first answer explains.
    limits : Calibration
        Thresholds.
    """
    top = ranking[0]
    names = tuple(top.name.split("+"))
    others: list[str] = []
    if top.probability < limits.verdict:
        total = top.probability
        for one in ranking[1:]:
            if others and total >= limits.set_level:
                break
            others.extend(one.name.split("+"))
            total += one.probability
    if top.name not in {NONE, UNKNOWN}:
        others.extend(alike)
    return names, tuple(dict.fromkeys(name for name in others if name not in names))


def decide(
    ranking: Sequence[Share],
    left: Left | None,
    worst_ratio: float,
    limits: Calibration,
    *,
    healthy_known: bool,
    worst_since: float | None = None,
) -> Decided:
    """Decide what is said, once `demote_without_heldout_gain` has put the answers in order.

    Parameters
    ----------
    ranking, worst_ratio, worst_since, limits
        As of `without_gap`.
    left : Left or None
        What the first answer leaves, where that is known.
    healthy_known : bool
        The floor was learned from healthy runs.
    """
    shares = tuple(ranking)
    since = worst_ratio if worst_since is None else worst_since
    if left is not None:
        shares = with_unknown(shares, left, limits, healthy_known=healthy_known)
    if left is not None and left.gap_there is not None and shares[0].name != UNKNOWN:
        # a gap in channels in which the answer does nothing is not its
        worst_ratio = min(worst_ratio, left.gap_there)
        since = min(since, left.gap_there if left.gap_since is None else left.gap_since)
    held_out = 0.0 if left is None else left.held_out
    shares = with_sure_effect(shares, held_out, worst_ratio, limits, healthy_known=healthy_known)
    if left is not None and not left.supply_known:
        shares = with_measured_supply(shares, worst_ratio, limits, healthy_known=healthy_known)
    first, shares = (
        shares[0].name,
        without_gap(shares, worst_ratio, since, limits, healthy_known=healthy_known),
    )
    too_small = first if shares[0].name == NONE and first not in {NONE, UNKNOWN} else ""
    told = verdict_of(shares, () if left is None else left.alike, limits)
    return Decided(shares, *told, too_small)
