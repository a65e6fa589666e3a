"""From weighed answers to what is said: each rule on the gap that is left, in its order."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from pipeline.diagnose.conclude.consequences import Ahead, Consequence, consequence
from pipeline.diagnose.conclude.gap_left import by_gap_left, gaps_left, ratios_left
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.inference.answer import Answers, Candidate, effect_count, equals
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.nil import matters
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.decision import (
    CLEAR_GAP,
    HEALTHY_GAP,
    Decided,
    decide,
    for_the_gap,
    with_gap,
)
from pipeline.diagnose.rules.helping import demote_without_heldout_gain
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.sureness import with_sure_second
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.errors import CannotComputeError

#: Single effects and pairs that are looked at.
_SINGLES, _PAIRS = 3, 2
#: Share of the probability of `unknown` that goes to what explains the runs.
_PASSED_ON = 0.9


@dataclass(frozen=True)
class Conclusion:
    """What is said.

    Attributes
    ----------
    said : Decided
        Effects, or `none` or `unknown`, what cannot be told from them, and the shares of all.
    answered : Answers
        All answers, in the order and with the probabilities that are told.
    top : Candidate
        The answer that was looked at: the first before errors of measurement and gaps below the
        floor had their say.
    led_to : Consequence
        What that one leads to.
    beside : Consequence or None
        Where `none` is said with an effect beside it: what that would lead to.
    """

    said: Decided
    answered: Answers
    top: Candidate
    led_to: Consequence
    beside: Consequence | None = None

    @property
    def names_effects(self) -> bool:
        """Whether effects are named: else nothing goes into the model, whatever was looked at."""
        return not {NONE, UNKNOWN} & set(self.said.names)

    @property
    def acting(self) -> Consequence | None:
        """What effects that are named, or stand beside `none`, lead to: there is where to look."""
        return self.led_to if self.names_effects else self.beside


def conclude(
    found: Search,
    answered: Answers,
    seen: GapSeen,
    limits: Calibration,
    *,
    healthy_known: bool,
    supply_known: bool,
) -> Conclusion:
    """Conclude from the answers and from the gap that each leaves.

    Parameters
    ----------
    found : Search
        Where the search ended.
    answered : Answers
        The answers, weighed.
    seen : GapSeen
        The gap without any.
    limits : Calibration
        Thresholds.
    healthy_known : bool
        The floor was learned from healthy runs.
    supply_known : bool
        A logged voltage, or shaft speeds, show the supply.
    """
    ahead, worst_ratio = seen.ahead, seen.worst_ratio
    was_first, answered = answered.ranking[0].name, explained_after_all(found, ahead, answered)
    after_all = answered.ranking[0].name if answered.ranking[0].name != was_first else ""
    looked_at: dict[str, tuple[Consequence, Left]] = {}

    def led_to_by(shares: Sequence[Share]) -> tuple[Consequence, Left]:
        """See what the first of the answers in the order of their shares leads to."""
        name = shares[0].name
        if name not in looked_at:
            ordered = answered.reweighed(shares)
            top = ordered.ranking[0]
            one = consequence(found, ahead, top, ordered.force_scale, seen.every)
            left = one.decides(equals(found, top), answered.held_out.get(name, 0.0))
            looked_at[name] = one, left
        return looked_at[name]

    def left_of(shares: Sequence[Share]) -> Left:
        return led_to_by(shares)[1]

    weighed = by_gap_left(
        [Share(one.name, one.probability) for one in answered.ranking],
        gaps_left(found, ahead, answered),
    )
    weighed = with_sure_second(weighed, limits)
    count = effect_count(found)
    grown = with_gap(weighed, worst_ratio, count, limits, healthy_known=healthy_known)
    shares = for_the_gap(weighed, grown, left_of(grown))
    shares = demote_without_heldout_gain(
        shares, left_of, worst_ratio, limits, healthy_known=healthy_known
    )
    led_to, left = led_to_by(shares)
    top = answered.reweighed(shares).ranking[0]
    left = replace(left, was_unknown=top.name == after_all, supply_known=supply_known)
    said = decide(
        shares,
        left,
        worst_ratio,
        limits,
        healthy_known=healthy_known,
        worst_since=seen.worst_since,
    )
    ordered = answered.reweighed(shares).reweighed(said.ranking)
    effects = _beside_none(said)
    beside = led_to_by(effects)[0] if effects else None
    return Conclusion(said, ordered, top, led_to, beside)


def _beside_none(said: Decided) -> tuple[Share, ...]:
    """Answers in their order from the first one with effects that `none` cannot be told from."""
    if said.names != (NONE,):
        return ()
    for number, one in enumerate(said.ranking):
        if one.name not in {NONE, UNKNOWN} and set(one.name.split("+")) <= set(said.ambiguous):
            return said.ranking[number:]
    return ()


def explained_after_all(found: Search, ahead: Ahead, answered: Answers) -> Answers:
    """Let the strongest effect that closes a clear gap go before `unknown`, where that is first.

    Parameters
    ----------
    found : Search
        As it ended.
    ahead : Ahead
        What is predicted without any answer.
    answered : Answers
        The answers in order.
    """
    first = answered.ranking[0]
    if first.name != UNKNOWN or _gap(ahead, found, None) < CLEAR_GAP:
        return answered
    # answers count from the best without any effect
    nothing = max(one.nothing for one in found.judged if one.level.ordinary)
    for finding in _strongest(found, first):
        one = Candidate(
            "+".join(finding.effects),
            first.probability * _PASSED_ON,
            first.judged.nothing + finding.log_evidence - nothing,
            finding,
            first.judged,
        )
        if _gap(ahead, found, one) <= HEALTHY_GAP:
            return _before_unknown(answered, one)
    return answered


def _before_unknown(answered: Answers, one: Candidate) -> Answers:
    unknown, *others = answered.ranking
    left = replace(unknown, probability=unknown.probability - one.probability)
    known = answered.of(one.name)
    if known is not None:
        one = replace(one, probability=one.probability + known.probability)
    rows = [one, left, *(other for other in others if other.name != one.name)]
    return replace(
        answered, ranking=tuple(sorted(rows, key=lambda row: (-row.probability, row.name)))
    )


def _strongest(found: Search, unknown: Candidate) -> Iterator[Finding]:
    """Effects, then pairs, that are strongest under the force that was needed."""
    judged, coordinates = unknown.judged, found.setting.coordinates
    for some, most in ((judged.singles, _SINGLES), (judged.pairs, _PAIRS)):
        ordered = sorted(some, key=lambda one: -one.log_evidence)
        counted = [one for one in ordered if one.which and matters(one, found.reach, coordinates)]
        yield from counted[:most]


def _gap(ahead: Ahead, found: Search, one: Candidate | None) -> float:
    """Gap over the healthy floor on the chosen windows, over all channels."""
    try:
        ratios = ratios_left(found, ahead, one)
    except CannotComputeError:
        # no vehicle can be that
        return math.inf
    return math.sqrt(sum(value**2 for value in ratios.values()) / max(len(ratios), 1))
