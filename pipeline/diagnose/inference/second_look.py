"""Look at answers a second time: each simulated at its own most probable departures and motion.

The linear model is exact where it was taken, so the hypothesis it was taken at has an advantage
over the others. How the motion changes is first taken from it, which costs little. What is simpler
than the first answer is then always judged with derivatives of its own (`own_point`), and where two
looks at a lead disagree all answers that come near it are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from pipeline.diagnose.inference.own_point import cannot_be, judged_anew, log_evidence_at
from pipeline.diagnose.inference.trials import Lead
from pipeline.diagnose.judging.hypotheses import Finding, prior_of
from pipeline.diagnose.judging.search import Judged, Search, force_prior, part
from pipeline.diagnose.linear.elimination import ForcePrior, Grams, marginal, with_readings
from pipeline.diagnose.linear.evidence import Prior, fit, promise
from pipeline.diagnose.linear.linear_model import realisable
from pipeline.diagnose.linear.most_probable import most_probable, readings_there
from pipeline.types import FloatArray

#: Log evidence by which two looks at a lead may differ, and the share of the lead.
_AGREED, _AGREED_SHARE = 5.0, 0.2
#: Log evidence from which on an answer that is behind the first is looked at no closer, and by
#: which the linear model is not right about the first at all.
_FAR_BEHIND = 100.0
#: Departure (in units of half the plausible range) from where all was judged up to which an answer
#: was judged at its own point.
_NEAR = 0.1
#: Simulations with which an answer's own point is found, at most, and by how much no departure may
#: have moved when it is (in units of half the plausible range).
_STEPS, _SETTLED = 3, 0.02

#: Departures that a hypothesis lets be wide.
Which = tuple[int, ...]
#: Hypotheses under their levels.
LookedAt = Mapping[Which, tuple[Judged, Finding | None]]


@dataclass
class Closely:
    """How hypotheses are seen closely: by the change of their log evidence, where, how surely."""

    changes: dict[Which, float]
    points: dict[Which, FloatArray] = field(default_factory=dict)
    sure: set[Which] = field(default_factory=set)
    doubtful: bool = False
    better_from: Which | None = None
    """The hypothesis from whose own point the others, left as they are, are better seen."""


def seen_closely(
    found: Search, lead: Lead, looked_at: LookedAt, elsewhere: float = np.inf
) -> Closely:
    """See all hypotheses as the linear model leads to them, and those that count from there.

    Where the first one's own point is further than `elsewhere` away (in units of half the plausible
    range) from where all was judged, and the linear model was not right about it or its lead, the
    others are left as they are: they are better seen from there.
    """
    tasks = [partial(_correction, found, *row) for row in looked_at.values()]
    corrected = dict(zip(looked_at, found.setting.bench.workers.each(tasks), strict=True))
    changes = {which: change for which, (change, _) in corrected.items()}
    points = {which: point for which, (_, point) in corrected.items()}
    look = _Look(found, lead, looked_at, points, _linear(looked_at), Closely(changes))
    top = look.at_the_first()
    if look.better_from(top, elsewhere):
        look.closely.doubtful = True
        look.closely.better_from = top
        return look.closely
    enough = look.value(top) - _FAR_BEHIND
    look.at_the_simpler(top, enough)
    look.at_the_others(enough)
    return look.closely


@dataclass(frozen=True)
class _Look:
    """A look at hypotheses: where the linear model leads to, what it says, and what is seen."""

    found: Search
    lead: Lead
    looked_at: LookedAt
    corrected: dict[Which, FloatArray]
    linear: dict[Which, float]
    closely: Closely

    def value(self, which: Which) -> float:
        """Log evidence of a hypothesis as it is seen."""
        return self.linear[which] + self.closely.changes[which]

    def at_the_first(self) -> Which:
        """Judge the first hypothesis where it is: what it leaves there is what it leaves."""
        closely = self.closely
        closely.sure = {which for which in self.looked_at if self._near(which)}
        top = max(self.looked_at, key=self.value)
        if abs(closely.changes[top]) < _AGREED:
            closely.sure.add(top)
            closely.points[top] = self.corrected[top]
        if top not in closely.sure:
            self._judge_anew([top], -np.inf)
        return top

    def better_from(self, top: Which, far: float) -> bool:
        """Whether the others are better judged from where the first hypothesis is."""
        here = self.found.model.point.departures
        away = float(np.abs(self.closely.points.get(top, here) - here).max()) > far
        if not away or top != max(self.looked_at, key=self.value):
            return False
        wrong = abs(self.closely.changes[top]) > _FAR_BEHIND
        return wrong or _doubtful(self.linear, self.closely)

    def at_the_simpler(self, top: Which, enough: float) -> None:
        """Judge nothing, and each effect of a pair alone, at their own points."""
        closely = self.closely
        simpler = [one for one in _simpler(self.looked_at, top) if one not in closely.sure]
        self._judge_anew(simpler, enough)
        for which in simpler:
            if which not in closely.sure:
                # what runs away on its way says nothing against a simpler answer: the lead stays
                closely.changes[which] = max(closely.changes[which], closely.changes[top])

    def at_the_others(self, enough: float) -> None:
        """Judge all that may come near the first at their own points, if its lead is doubtful."""
        closely = self.closely
        closely.doubtful = _doubtful(self.linear, closely)
        if closely.doubtful:
            others = self.linear.keys() - closely.points.keys() - closely.sure
            best = {
                which: self.linear[which] + max(closely.changes[which], 0.0)
                for which in self.looked_at
                if which in others
            }
            self._judge_anew([which for which in best if best[which] > enough], enough)

    def _near(self, which: Which) -> bool:
        """Whether all was judged at the own point of a hypothesis."""
        here = self.found.model.point.departures
        way = np.abs(self.corrected[which] - here)[_own(self.found, which)]
        return abs(self.closely.changes[which]) < _AGREED and float(way.max(initial=0.0)) < _NEAR

    def _judge_anew(self, some: Sequence[Which], enough: float) -> None:
        found, closely = self.found, self.closely
        ways = [
            partial(
                judged_anew, found, self.lead, *self.looked_at[which], self.corrected[which], enough
            )
            for which in some
        ]
        for which, reached in zip(some, found.setting.bench.workers.each(ways), strict=True):
            before = log_evidence_at(found, found.grams, *self.looked_at[which])
            closely.changes[which] = reached.value - before
            closely.points[which] = reached.point
            if reached.settled:
                closely.sure.add(which)


def _own(found: Search, which: Which) -> list[int]:
    """Departures that a hypothesis lets go: what is stated, and its own."""
    every = found.setting.coordinates
    return [k for k, one in enumerate(every) if one.ordinary > 0.0 or k in which]


def _correction(found: Search, judged: Judged, finding: Finding | None) -> tuple[float, FloatArray]:
    """Log evidence of a hypothesis seen from its own point, less that of the linear model.

    With the departures (g,) of that point.
    """
    model, normal = found.model, found.grams
    prior = prior_of(found.prior, finding)
    forces = force_prior(found.setting, judged.level)
    last: FloatArray | None = None
    departures = found.prior.mean
    for _ in range(_STEPS):
        left = marginal(part(normal, found.chosen), forces)
        best = fit(left, prior)
        departures = realisable(model.setting.coordinates, best.mean)
        if finding is not None and cannot_be(found, finding, best):
            return -np.inf, departures
        if last is not None and float(np.abs(departures - last).max()) < _SETTLED:
            break
        last = departures
        readings = readings_there(model, most_probable(normal, forces, departures))
        if readings is None:
            return -np.inf, departures
        normal = with_readings(found.grams, replace(model, readings=readings))
    there = log_evidence_at(found, normal, judged, finding)
    there -= _not_reached(found, normal, forces, prior, last)
    return there - log_evidence_at(found, found.grams, judged, finding), departures


def _linear(looked_at: LookedAt) -> dict[Which, float]:
    """Log evidence of each hypothesis by the linear model, with the prior of its level."""
    return {
        which: judged.nothing
        + (0.0 if finding is None else finding.log_evidence)
        + float(np.log(judged.level.weight))
        for which, (judged, finding) in looked_at.items()
    }


def _simpler(looked_at: LookedAt, top: Which) -> list[Which]:
    """Return nothing, and each effect of a pair alone: to be seen from their own points, too.

    Of a vehicle that nearly capsizes both looks can agree that an effect leads none by thousands,
    and be wrong.
    """
    finding = looked_at[top][1]
    effects = set() if finding is None else set(finding.effects)
    return [
        which
        for which, (_, one) in looked_at.items()
        if which != top and (one is None or (len(one.effects) == 1 and set(one.effects) < effects))
    ]


def _doubtful(linear: Mapping[Which, float], closely: Closely) -> bool:
    """Whether the looks disagree about the lead of the first answer over any other.

    The first by either look. Over one that was surely seen, more of a lead is no doubt.
    """
    full = {which: linear[which] + closely.changes[which] for which in linear}
    for top in {max(linear, key=lambda w: linear[w]), max(full, key=lambda w: full[w])}:
        if not np.isfinite(full[top]) or top not in closely.sure:
            return True
        for which in linear:
            before, after = linear[top] - linear[which], full[top] - full[which]
            differ = before - after if which in closely.sure else abs(after - before)
            if differ > max(_AGREED, _AGREED_SHARE * min(before, after)):
                return True
    return False


def _not_reached(
    found: Search, normal: Grams, forces: ForcePrior, prior: Prior, last: FloatArray | None
) -> float:
    """Log evidence that a hypothesis is promised beyond the last point that was simulated.

    Where the steps do not settle the linear model keeps promising a better point that is not there.
    """
    if last is None:
        return 0.0
    left = marginal(part(normal, found.chosen), forces)
    every = found.setting.coordinates
    promised = fit(left, prior).mean
    # what is promised of the form of the lag beyond where it is one is so from every point
    form = [k for k, one in enumerate(every) if one.effect.unstated]
    promised[form] = realisable(every, promised)[form]
    return promise(left, prior, promised - last)
