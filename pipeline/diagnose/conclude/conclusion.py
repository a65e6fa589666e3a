"""From weighed answers to what is said: each rule on the gap that is left, in its order."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pipeline.diagnose.conclude.after_all import explained_after_all
from pipeline.diagnose.conclude.consequences import Consequence, consequence
from pipeline.diagnose.conclude.gap_left import by_gap_left, gaps_left
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.inference.answer import Answers, Candidate, effect_count, equals
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.decision import Decided, decide, for_the_gap, with_gap
from pipeline.diagnose.rules.helping import demote_without_heldout_gain
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.sureness import with_sure_second
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN


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
