"""Where a campaign stands against its goals, one row a goal, and every case that it missed."""

from collections.abc import Sequence
from itertools import chain

from pipeline.blind.rates import Goal, Rate, at_least, at_most, between, rate
from pipeline.blind.verdict_score import CaseScore, asked
from pipeline.records.base import Record

#: From this gap on, over the healthy floor, an effect is to be seen without fail.
CLEAR_GAP = 3.0
_TOLD = ((True, "with healthy runs"), (False, "without healthy runs"))


class Miss(Record):
    """A case whose answer is not what it should be, and in which respect."""

    score: CaseScore
    fault: str


#: Of effects whose gap is small.
SMALL_GAP = Goal(">= 80 %, otherwise it abstains", low=0.80)
#: False alarms on a healthy vehicle, with healthy runs given and without.
FALSE_ALARMS = {
    "with healthy runs": Goal("0 of 300", high=0.0),
    "without healthy runs": at_most(0.02),
}


def against_goals(scores: Sequence[CaseScore]) -> tuple[Rate, ...]:
    """Rates of the strata that the goals are stated for; the severity bands are finer."""
    single = [one for one in scores if one.kind == "single"]
    small = [one for one in single if one.gap_ratio < CLEAR_GAP]
    clear = [one for one in single if one.gap_ratio >= CLEAR_GAP]
    told = [(word, [one for one in scores if one.healthy == yes]) for yes, word in _TOLD]
    outside = [(word, [one for one in part if one.kind == "outside"]) for word, part in told]
    left_out = [one for one in scores if one.kind == "leave_one_out"]
    sure = ("surely wrong", "confidently_wrong")
    groups: tuple[list[Rate], ...] = (
        *(
            asked(part, word, ("healthy vehicle called ill", "false_alarm", FALSE_ALARMS[word]))
            for word, part in told
        ),
        _of_singles(small, "single, gap 1-3", SMALL_GAP),
        _of_singles(clear, "single, gap from 3", at_least(0.95)),
        asked(single, "single", sure),
        *(
            asked(part, f"pair, {word}", ("both named", "pair_exact", at_least(0.80)))
            for word, part in told
        ),
        asked(scores, "pair", ("at least one named", "pair_any", at_least(0.97))),
        *(
            asked(part, f"outside the library, {word}", (*_CALLED_UNKNOWN, at_least(0.90)))
            for word, part in outside
        ),
        asked(scores, "single or pair", ("known, called unknown", "called_unknown", at_most(0.03))),
        asked(left_out, "left out of the library", sure),
        *(
            asked(part, f"single, {where}", ("right channel", "channel_right", at_least(0.98)))
            for where, part in (("gap 1-3", small), ("gap from 3", clear))
        ),
        asked(single, "single", ("right regime", "regime_right", at_least(0.90))),
    )
    covered = [width.inside for one in scores for width in one.intervals]
    interval = rate("95 % interval holds the truth", "all", covered, between(0.93, 0.97))
    return (*chain.from_iterable(groups), interval)


_CALLED_UNKNOWN = ("called unknown", "unknown_right")


def missed(scores: Sequence[CaseScore]) -> tuple[Miss, ...]:
    """List the cases that a goal counts against the diagnosis, by number."""
    found = ((one, _fault(one)) for one in sorted(scores, key=lambda one: one.case))
    return tuple(Miss(score=one, fault=fault) for one, fault in found if fault)


def _fault(one: CaseScore) -> str:
    """Say what is wrong with an answer, the worst first; nothing where it is what it should be."""
    sure = " for sure" if one.confidently_wrong else ""
    clear = one.gap_ratio >= CLEAR_GAP and one.separable
    of_its_kind: dict[str, tuple[tuple[bool | None, str], ...]] = {
        "none": ((one.false_alarm, "healthy, called ill"),),
        "single": (
            (not one.in_set, f"truth not in the set{sure}"),
            (clear and not one.first_right, "in the set, not first"),
        ),
        "pair": (
            (not one.pair_any, f"neither named{sure}"),
            (not one.pair_exact, f"not this pair{sure}"),
        ),
        "outside": ((not one.unknown_right, f"not called unknown{sure}"),),
        "leave_one_out": ((one.confidently_wrong, f"another effect{sure}"),),
    }
    faults = ((bool(one.refused), "refused"), *of_its_kind[one.kind])
    return next((fault for wrong, fault in faults if wrong), "")


def _of_singles(part: Sequence[CaseScore], where: str, goal: Goal) -> list[Rate]:
    """Single effects of one range of gaps."""
    apart = [one for one in part if one.separable]
    return [
        *asked(
            apart,
            f"{where}, can be told apart",
            ("first", "first_right", goal),
            ("first, or abstains", "right_or_abstains"),
        ),
        *asked(part, where, ("in the answer set", "in_set", at_least(0.99))),
    ]
