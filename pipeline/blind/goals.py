"""Where a campaign stands against its goals, one row a goal, and every case that it missed."""

from collections.abc import Iterable, Sequence

from pipeline.blind.rates import Goal, Rate, at_least, at_most, between, rate
from pipeline.blind.verdict_score import CaseScore
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
    return (
        *(
            rate(
                "healthy vehicle called ill",
                word,
                (one.false_alarm for one in part),
                FALSE_ALARMS[word],
            )
            for word, part in told
        ),
        *_of_singles(small, "single, gap 1-3", SMALL_GAP),
        *_of_singles(clear, "single, gap from 3", at_least(0.95)),
        rate("surely wrong", "single", (one.confidently_wrong for one in single)),
        *(rate("both named", f"pair, {word}", _exact(part), at_least(0.80)) for word, part in told),
        rate("at least one named", "pair", (one.pair_any for one in scores), at_least(0.97)),
        *(
            rate(
                "called unknown",
                f"outside the library, {word}",
                (one.unknown_right for one in part if one.kind == "outside"),
                at_least(0.90),
            )
            for word, part in told
        ),
        rate(
            "known, called unknown",
            "single or pair",
            (one.called_unknown for one in scores),
            at_most(0.03),
        ),
        rate(
            "surely wrong",
            "left out of the library",
            (one.confidently_wrong for one in scores if one.kind == "leave_one_out"),
        ),
        *(
            rate(
                "right channel",
                f"single, {where}",
                (one.channel_right for one in part),
                at_least(0.98),
            )
            for where, part in (("gap 1-3", small), ("gap from 3", clear))
        ),
        rate("right regime", "single", (one.regime_right for one in single), at_least(0.90)),
        rate(
            "95 % interval holds the truth",
            "all",
            (width.inside for one in scores for width in one.intervals),
            between(0.93, 0.97),
        ),
    )


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
        rate("first", f"{where}, can be told apart", (one.first_right for one in apart), goal),
        rate(
            "first, or abstains",
            f"{where}, can be told apart",
            (one.first_right or one.abstained for one in apart),
        ),
        rate("in the answer set", where, (one.in_set for one in part), at_least(0.99)),
    ]


def _exact(part: Iterable[CaseScore]) -> Iterable[bool | None]:
    return (one.pair_exact for one in part)
