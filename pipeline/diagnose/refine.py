"""Compare the best answers fairly: each judged at its own best point of the full model.

The linear model is exact where it was taken, so the hypothesis it was taken at has an advantage
over the others. Here the model of every answer is led along the measured motion at its own most
probable departures, and judged by the readings as they are seen from there. How the motion goes on
is first taken from the linear model, which costs little; where the two looks then
disagree about a lead, all answers are judged anew with derivatives of their own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from pipeline.diagnose.answer import Answers, Candidate
from pipeline.diagnose.decision import Share
from pipeline.diagnose.elimination import ForcePrior, Grams, marginal
from pipeline.diagnose.evidence import Prior, fit
from pipeline.diagnose.hypotheses import (
    Finding,
    prior_of,
)
from pipeline.diagnose.linear_model import (
    LinearModel,
    realisable,
    vector_of,
)
from pipeline.diagnose.own_point import cannot_be, judged_anew, log_evidence_at
from pipeline.diagnose.predictions import over_threads
from pipeline.diagnose.search import Judged, Search, force_prior, part
from pipeline.diagnose.tangent import led_readings
from pipeline.diagnose.trials import Lead
from pipeline.diagnose.verdict import departures_of, effect_alone
from pipeline.diagnose.weighing import NONE, UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Probability from which an answer is looked at.
_COUNTS = 1e-3
#: Log evidence by which two looks at a lead may differ, and the share of the lead.
_AGREED, _AGREED_SHARE = 5.0, 0.1
#: Pairs of which each effect alone is looked at, too.
_PAIRS = 2
#: A whitened reading this large is that of a simulation that ran away.
_LOST = 1e7
#: Simulations with which an answer's own point is found, at most, and by how much no departure may
#: have moved when it is (in units of half the plausible range).
_STEPS, _SETTLED = 3, 0.02

#: Departures that a hypothesis lets be wide.
Which = tuple[int, ...]


@dataclass(frozen=True)
class Refined:
    """A search whose strongest hypotheses are judged at their own points.

    `points` has the departures (g,) of those points, by what is wide; empty where the linear model
    and these agree, and no point had to be gone to.
    """

    search: Search
    points: Mapping[Which, FloatArray]

    def point_of(self, top: Candidate) -> FloatArray | None:
        """Own point of an answer, where the linear model was not right about it."""
        return self.points.get(() if top.finding is None else top.finding.which)


def refined(found: Search, first: Answers, lead: Lead, most: int) -> Refined:
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
    tasks = [partial(_correction, found, lead, *row) for row in looked_at.values()]
    changes = dict(zip(looked_at, over_threads(found.setting.bench, tasks), strict=True))
    points: dict[Which, FloatArray] = {}
    if _doubtful(looked_at, changes):
        ways = [partial(judged_anew, found, lead, *row) for row in looked_at.values()]
        seen = dict(zip(looked_at, over_threads(found.setting.bench, ways), strict=True))
        changes = {which: change for which, (change, _) in seen.items()}
        points = {which: point for which, (_, point) in seen.items()}
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
                for f in one.singles
            ),
            pairs=tuple(
                replace(f, log_evidence=f.log_evidence + gained(f) - changes[()]) for f in one.pairs
            ),
        )
        for one in found.judged
    )
    return Refined(replace(found, judged=judged), points)


def _correction(found: Search, lead: Lead, judged: Judged, finding: Finding | None) -> float:
    """Log evidence of a hypothesis seen from its own point, less that of the linear model."""
    model, normal = found.model, found.grams
    prior = prior_of(found.prior, finding)
    forces = force_prior(found.setting, judged.level)
    before = log_evidence_at(found, normal, judged, finding)
    last: FloatArray | None = None
    for _ in range(_STEPS):
        left = marginal(part(normal, found.chosen), forces)
        best = fit(left, prior)
        if finding is not None and cannot_be(found, finding, best):
            return -np.inf
        departures = realisable(model.setting.coordinates, best.mean)
        if last is not None and float(np.abs(departures - last).max()) < _SETTLED:
            break
        last = departures
        try:
            led = lead(model.setting, vector_of(model.setting, departures))
            readings = led_readings(model, led, departures)
        except CannotComputeError:
            # no vehicle can have these values
            return -np.inf
        says = model.says
        if not (np.abs(readings[says]) < _LOST).all():
            return -np.inf
        normal = _with_readings(found.grams, replace(model, readings=np.where(says, readings, 0.0)))
    there = log_evidence_at(found, normal, judged, finding)
    return there - _not_reached(found, normal, forces, prior, last) - before


def _doubtful(
    looked_at: Mapping[Which, tuple[Judged, Finding | None]], changes: Mapping[Which, float]
) -> bool:
    """Whether the two looks disagree about the lead of the first answer over any other."""
    linear = {
        which: judged.nothing
        + (0.0 if finding is None else finding.log_evidence)
        + float(np.log(judged.level.weight))
        for which, (judged, finding) in looked_at.items()
    }
    full = {which: linear[which] + changes[which] for which in looked_at}
    top = max(full, key=lambda which: full[which])
    if not np.isfinite(full[top]):
        return True
    for which in looked_at:
        leads = linear[top] - linear[which], full[top] - full[which]
        differ = abs(leads[1] - leads[0])
        if differ > max(_AGREED, _AGREED_SHARE * min(leads)):
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
    active = np.flatnonzero(np.diag(prior.covariance) > 0.0)
    block = np.ix_(active, active)
    way = (fit(left, prior).mean - last)[active]
    believed = np.linalg.pinv(prior.covariance[block], hermitian=True)
    return 0.5 * float(way @ (left.information[block] + believed) @ way)


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


def _with_readings(normal: Grams, model: LinearModel) -> Grams:
    """Renew the normal equations for other readings: only their row and column change."""
    bounds = model.setting.bench.stack.bounds
    columns = (model.local, model.shared, model.extra, model.departures)
    cross, rest = normal.cross.copy(), normal.rest.copy()
    local = model.local.shape[1]
    for number, (a, b) in enumerate(pairwise(bounds)):
        own = model.readings[a:b]
        product = np.concatenate([one[a:b].T @ own for one in columns])
        cross[number, :, -1] = product[:local]
        rest[number, :-1, -1] = rest[number, -1, :-1] = product[local:]
        rest[number, -1, -1] = own @ own
    return replace(normal, cross=cross, rest=rest)
