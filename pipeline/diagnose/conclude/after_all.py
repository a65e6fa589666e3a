"""Whether an effect explains after all what is `unknown` by the force that it leaves.

The force is counted in that of a healthy vehicle, and on an axis that hardly anything pushes a
healthy one along any small flaw of an effect is many times that: a tether is not quite a drag and a
pull, and the moment that is left may be a hundred times the ordinary and move nothing. What is
`unknown` is what leaves a gap. So the strongest effects under the force that was needed are looked
at by the gap that they leave; none of what comes and goes, or sets in, is closed by anything
constant.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from pipeline.diagnose.conclude.consequences import Ahead
from pipeline.diagnose.conclude.gap_left import ratios_left
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.nil import matters
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.decision import CLEAR_GAP, HEALTHY_GAP
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.errors import CannotComputeError

#: Single effects and pairs that are looked at.
_SINGLES, _PAIRS = 3, 2
#: Share of the probability of `unknown` that goes to what explains the runs.
_PASSED_ON = 0.9


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
