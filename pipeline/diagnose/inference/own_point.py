"""A hypothesis linear around its own point: the most probable departures and motion under it."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.trials import Lead
from pipeline.diagnose.judging.hypotheses import (
    IMPOSSIBLE,
    Finding,
    judge,
    log_evidence_of,
    prior_of,
    with_ordinary,
)
from pipeline.diagnose.judging.search import Judged, Search, force_prior, part
from pipeline.diagnose.linear.elimination import Grams, grams, marginal
from pipeline.diagnose.linear.evidence import Fit, fit, posterior, promise
from pipeline.diagnose.linear.linear_model import BEYOND, LinearModel, realisable, vector_of
from pipeline.diagnose.linear.most_probable import moved_to
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: A point is reached when no departure moves further (in units of half the plausible range).
_SETTLED = 0.1
#: Or, of what is known no better than that, by more than this share of its deviation.
_OPEN_SHARE = 0.5
#: Or when the log evidence stays within this, and the next step promises no more.
_AS_GOOD = 2.0
#: Steps to an own point, at most.
_STEPS = 3
#: No further step is worth its time.
_STAYS = 0.05
#: A step up to which what is stated keeps its derivatives at the end of it.
_NEAR = 0.15
#: Answers whose values are estimated anew, and how probable they are at least.
_MOST_ANSWERS, _PROBABLE = 2, 0.01
#: Steps to their values, at most, and by how much none moves when it stays (in deviations).
_STEPS_TO_VALUES, _VALUES_STAY = 8, 0.1
#: Log evidence by which a step may be worse, and steps that are taken at once at most.
_WORSE, _MOST_AHEAD = 5.0, 4.0


@dataclass(frozen=True)
class Reached:
    """How a hypothesis looks from where it was followed to.

    `value` is its log evidence, `point` the departures (g,) there, `settled` whether it stays, and
    `behind` whether it is near its end, and that too far behind to matter.
    """

    value: float
    point: FloatArray
    settled: bool
    behind: bool = False


def judged_anew(  # noqa: PLR0917 - one caller
    found: Search,
    lead: Lead,
    judged: Judged,
    finding: Finding | None,
    begin: FloatArray,
    enough: float,
) -> Reached:
    """Judge a hypothesis linear around its own point: its most probable departures and motion.

    Parameters
    ----------
    found : Search
        Where all was judged.
    lead : callable
        Leads the windows of a setting along the measured motion with the model at a vector.
    judged, finding : Judged, Finding or None
        The hypothesis under its level.
    begin : ndarray, shape (g,)
        Departures from which it is sought. Where that does not settle also from what is ordinary,
        with the effect as it was found: what the derivatives of another point promise may be
        nothing that a vehicle does, as one that nearly capsizes.
    enough : float
        Log evidence below which the hypothesis does not matter, and is looked at no closer.
    """
    prior, forces = prior_of(found.prior, finding), force_prior(found.setting, judged.level)
    reached = _followed(found, found.model, begin, judged, finding, enough)
    if reached.settled or reached.behind:
        return reached
    which = () if finding is None else finding.which
    at = found.prior.mean.copy()
    if finding is not None:
        at[list(which)] = finding.mean
    at = realisable(found.setting.coordinates, at)
    try:
        led = lead(found.setting, vector_of(found.setting, at))
        point = replace(led.origin(), departures=at)
        there = linear_model(led, point, known=found.model, renew=which)
        at = fit(marginal(part(grams(there), found.chosen), forces), prior).mean
        again = _followed(found, there, at, judged, finding, enough)
    except CannotComputeError:
        # no vehicle can have these values
        return reached
    return max(reached, again, key=lambda one: one.value)


def _followed(  # noqa: PLR0917 - two callers
    found: Search,
    there: LinearModel,
    at: FloatArray,
    judged: Judged,
    finding: Finding | None,
    enough: float,
) -> Reached:
    """Go to the most probable motion of a hypothesis, from a model near it and its departures."""
    every = found.setting.coordinates
    prior, forces = prior_of(found.prior, finding), force_prior(found.setting, judged.level)
    which = () if finding is None else finding.which
    free = tuple(k for k, one in enumerate(every) if one.ordinary > 0.0 or k in which)
    reached = Reached(-np.inf, at, settled=False)
    normal = grams(there) if there is not found.model else found.grams
    # on the way what is stated keeps its derivatives; where it counts it has its own
    at = realisable(every, at)
    move, known_free = np.inf, False
    for number in range(_STEPS):
        point = moved_to(there, normal, forces, at)
        if point is None:
            return reached
        renew = which if number == 0 or (known_free and move < _NEAR) else free
        known_free = known_free or renew == free
        there = linear_model(there.setting, point, known=there, renew=renew)
        if there.lost > found.model.lost:
            return reached
        normal = grams(there)
        left = marginal(part(normal, found.chosen), forces)
        best = fit(left, prior)
        if finding is not None and cannot_be(found, finding, best):
            return Reached(-np.inf, at, settled=True)
        goes_to = realisable(every, best.mean)
        # what the readings leave open wanders, and it does not matter
        known = np.minimum(_SETTLED / np.maximum(_OPEN_SHARE * best.std, 1e-12), 1.0)
        move = float((known * np.abs(goes_to - at))[list(free)].max(initial=0.0))
        value = log_evidence_at(found, normal, judged, finding)
        better, promised = value - reached.value, promise(left, prior, goes_to - at)
        as_good = max(abs(better), promised) < _AS_GOOD
        behind = known_free and value + max(better, promised) < enough
        reached = Reached(value, at, move < _SETTLED or as_good, behind and number > 0)
        if reached.behind or as_good or (move < _STAYS and known_free):
            break
        if reached.settled and value < enough:
            break
        at = goes_to
    return reached


def log_evidence_at(found: Search, normal: Grams, judged: Judged, finding: Finding | None) -> float:
    """Log evidence of a hypothesis by the normal equations of some point."""
    forces = force_prior(found.setting, judged.level)
    ground = with_ordinary(marginal(part(normal, found.chosen), forces), found.prior)
    gain = 0.0
    if finding is not None and finding.which:
        gain = judge(ground, found.setting.coordinates, finding.which)[0]
    return log_evidence_of(ground) + gain


def cannot_be(found: Search, finding: Finding, best: Fit) -> bool:
    """Whether a departure of a hypothesis, the ordinary part included, is beyond what can be."""
    for index in finding.which:
        one = found.setting.coordinates[index]
        if one.leads:
            continue
        low, high = one.bounds
        far = IMPOSSIBLE * float(best.std[index]) + BEYOND
        if not low - far <= best.mean[index] <= high + far:
            return True
    return False


def with_own_values(found: Search, answered: Answers) -> Answers:
    """Estimate the first answers anew, each at its own most probable point.

    What they weigh stays: all answers were judged with the same few steps.

    Parameters
    ----------
    found : Search
        Where all was judged.
    answered : Answers
        The answers in order.
    """
    # what `unknown` is best imitated by has no values that are told
    told = [
        one
        for one in answered.ranking
        if one.finding is not None and one.name != UNKNOWN and one.probability >= _PROBABLE
    ][:_MOST_ANSWERS]
    settled = found.setting.bench.workers.each([partial(_settled, found, one) for one in told])
    anew = {
        one.name: replace(one, judged=judged) for one, judged in zip(told, settled, strict=True)
    }
    return replace(answered, ranking=tuple(anew.get(one.name, one) for one in answered.ranking))


def _settled(found: Search, one: Candidate) -> Judged:
    """Judge an answer's parameters, linear at its own point; as they were where that is lost."""
    if one.finding is None:
        return one.judged
    every, which = found.setting.coordinates, list(one.finding.which)
    prior, forces = prior_of(found.prior, one.finding), force_prior(found.setting, one.judged.level)
    there, normal, judged = found.model, found.grams, one.judged
    at, best = posterior(judged.found, prior).mean, -np.inf
    last: FloatArray | None = None
    for _ in range(_STEPS_TO_VALUES):
        at = realisable(every, at)
        point = moved_to(there, normal, forces, at)
        if point is None:
            break
        there = linear_model(there.setting, point, known=there, renew=which)
        if there.lost > found.model.lost:
            break
        normal = grams(there)
        seen = marginal(part(normal, found.chosen), forces)
        value = log_evidence_at(found, normal, one.judged, one.finding)
        if value < best - _WORSE:
            break
        best, judged = max(best, value), replace(one.judged, found=seen)
        left = posterior(seen, prior)
        std = np.sqrt(np.maximum(np.diag(left.covariance), 1e-18))
        goes_to = realisable(every, left.mean)
        step = ((goes_to - at) / std)[which]
        if float(np.abs(step).max()) < _VALUES_STAY:
            break
        at, last = goes_to + ahead(step, last) * (goes_to - at), step
    return judged


def ahead(step: FloatArray, last: FloatArray | None) -> float:
    """How many steps (k,) more to take at once, by how the last two shrank: Aitken 1926.

    Steps that go on in one direction, each r times the one before, end after 1 / (1 - r) of them
    (Proc. Royal Soc. Edinburgh 46, 289-305).
    """
    if last is None or float(step @ last) <= 0.0:
        return 0.0
    shrinks = float(np.linalg.norm(step) / np.linalg.norm(last))
    return min(shrinks / max(1.0 - shrinks, 1e-6), _MOST_AHEAD)
