"""Judge the best answers at their own points, and take out those that no vehicle can be."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.own_point import cannot_be
from pipeline.diagnose.inference.second_look import Which, seen_closely
from pipeline.diagnose.inference.trials import Lead
from pipeline.diagnose.inference.verdict import departures_of, effect_alone, idle_effects
from pipeline.diagnose.judging.hypotheses import Finding, prior_of, with_all_parameters
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.linear.evidence import fit
from pipeline.diagnose.linear.linear_model import vector_of
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Probability from which an answer is looked at.
_COUNTS = 1e-3
#: Pairs of which each effect alone is looked at, too.
_PAIRS = 2


@dataclass(frozen=True)
class Refined:
    """A search whose strongest hypotheses are judged at their own points.

    `points` has the departures (g,) of those points, by what is wide; `sure` those hypotheses that
    were judged where they stay; `doubtful` whether the linear model was not right about the lead of
    the first over any other.
    """

    search: Search
    points: Mapping[Which, FloatArray]
    sure: frozenset[Which]
    doubtful: bool
    better_from: tuple[FloatArray, Level] | None

    def seen_from(self, top: Candidate) -> tuple[FloatArray, Level] | None:
        """Point, and level there, from which all may be seen better; None where here is as good."""
        if self.better_from is not None:
            return self.better_from
        which = () if top.finding is None else top.finding.which
        point = self.points.get(which) if self.doubtful else None
        return None if point is None else (point, top.judged.level)


def refined(
    found: Search, first: Answers, lead: Lead, most: int, elsewhere: float = np.inf
) -> Refined:
    """Judge the strongest hypotheses, and the one with nothing, at their own points.

    Parameters
    ----------
    found : Search
        As it ended.
    first : Answers
        The answers of the linear model; the first `most` of them are taken, `none`, and of the
        first two pairs each effect alone.
    lead : callable
        Leads the windows of a setting along the measured motion with the model at a vector.
    most : int
        How many.
    elsewhere : float
        How far from here (in units of half the plausible range) the first may lie for the others
        to be judged from here.
    """
    wanted = [one for one in first.ranking if one.finding is not None][:most]
    pairs = [one for one in wanted if "+" in one.name][:_PAIRS]
    alone_too = [first.of(effect) for one in pairs for effect in one.name.split("+")]
    wanted += [one for one in alone_too if one is not None and one not in wanted]
    alone = first.of(NONE)
    level = first.ranking[0].judged if alone is None else alone.judged
    looked_at: dict[Which, tuple[Judged, Finding | None]] = {(): (level, None)}
    for one in wanted:
        if one.finding is not None:
            looked_at.setdefault(one.finding.which, (one.judged, one.finding))
    whole = _with_all_parameters(found, wanted)
    for finding, judged_by in whole:
        looked_at.setdefault(finding.which, (judged_by, finding))
    seen = seen_closely(found, lead, looked_at, elsewhere)
    changes = seen.changes
    if not np.isfinite(changes[()]):
        changes[()] = 0.0
    # what was not judged anew gets what a part of it got
    least = min(value for value in changes.values() if np.isfinite(value))

    def gained(finding: Finding) -> float:
        own = changes.get(finding.which)
        if own is not None:
            return own
        inside = [which for which in changes if which and set(which) <= set(finding.which)]
        return changes[max(inside, key=len)] if inside else least

    judged = tuple(
        replace(
            one,
            nothing=one.nothing + changes[()],
            singles=tuple(
                replace(f, log_evidence=f.log_evidence + gained(f) - changes[()])
                for f in (*one.singles, *(f for f, own in whole if own is one))
            ),
            pairs=tuple(
                replace(f, log_evidence=f.log_evidence + gained(f) - changes[()]) for f in one.pairs
            ),
        )
        for one in found.judged
    )
    left_for = seen.better_from
    return Refined(
        replace(found, judged=judged),
        seen.points,
        frozenset(seen.sure),
        seen.doubtful,
        None if left_for is None else (seen.points[left_for], looked_at[left_for][0].level),
    )


def _with_all_parameters(
    found: Search, wanted: Sequence[Candidate]
) -> list[tuple[Finding, Judged]]:
    """Single effects among some answers with all of their few parameters, each under its level."""
    whole = []
    for one in wanted:
        if one.finding is None:
            continue
        finding = with_all_parameters(
            one.judged.ground, found.setting.coordinates, found.groups, one.finding
        )
        if finding is not None:
            whole.append((finding, one.judged))
    return whole


def possible_alone(found: Search, answered: Answers) -> Answers:
    """Take out answers whose values no vehicle can have; their probability goes to `unknown`.

    An effect that explains the readings only beyond what can be is not what happened.
    """
    impossible = {
        one.name
        for one in answered.ranking
        if (one.probability > _COUNTS or one.name == UNKNOWN) and _no_vehicle(found, one)
    }
    if not impossible:
        return answered
    shares = {one.name: one.probability for one in answered.ranking if one.name not in impossible}
    gone = 1.0 - sum(shares.values())
    shares[UNKNOWN] = shares.get(UNKNOWN, 0.0) + gone
    ordered = sorted(shares.items(), key=lambda row: (-row[1], row[0]))
    plain = replace(
        answered,
        ranking=tuple(
            replace(one, finding=None) if one.name in impossible else one
            for one in answered.ranking
        ),
    )
    return plain.reweighed([Share(name, value) for name, value in ordered])


def that_depart(found: Search, answered: Answers, factor: float) -> Answers:
    """Pass the probability of a pair on to one of its effects where the other does nothing.

    Readings can speak for a change of something stated that only undoes what healthy runs, or other
    runs, said of it: the vehicle is as its file says.

    Parameters
    ----------
    found : Search
        As it ended.
    answered : Answers
        The answers in order.
    factor : float
        On the intervals; see `Calibration`.
    """
    shares = {one.name: one.probability for one in answered.ranking}
    for one in answered.ranking:
        if "+" not in one.name or one.probability < _COUNTS:
            continue
        idle = idle_effects(found, one, factor)
        left = [effect for effect in one.name.split("+") if effect not in idle]
        if len(left) == 1 and left[0] in shares:
            shares[left[0]] += shares[one.name]
            shares[one.name] = 0.0
    ordered = sorted(shares.items(), key=lambda row: (-row[1], row[0]))
    return answered.reweighed([Share(name, value) for name, value in ordered])


def _no_vehicle(found: Search, one: Candidate) -> bool:
    """Whether no vehicle can have the values of an answer: out of bounds, or lighter than nothing.

    A mass in the lower part of its range may still be more than this vehicle has to lose.
    """
    if one.finding is None:
        return False
    if cannot_be(found, one.finding, fit(one.judged.found, prior_of(found.prior, one.finding))):
        return True
    best = departures_of(found, one, one.finding)
    try:
        vector_of(found.setting, best)
        vector_of(found.setting, effect_alone(found, best, one.finding))
    except CannotComputeError:
        return True
    return False
