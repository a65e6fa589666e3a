"""Go on with the first answers until their values stay where they are.

All answers are judged around one point, with a few steps towards their own. That is enough to weigh
them and not for their values. Two effects of the same force multiply: where all was judged at a
supply that is low, a thrust deduction in its place comes out too large. A payload has a valley:
what weighs in water is known from depth and trim, and the sum of mass and displaced water, felt as
inertia beside thrust and added masses, is hardly. Along it a step of the linear model is short of
the most probable point by a share that does not shrink.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.own_point import log_evidence_at
from pipeline.diagnose.judging.hypotheses import prior_of
from pipeline.diagnose.judging.search import Judged, Search, force_prior, part
from pipeline.diagnose.linear.elimination import grams, marginal
from pipeline.diagnose.linear.evidence import posterior
from pipeline.diagnose.linear.linear_model import realisable
from pipeline.diagnose.linear.most_probable import moved_to
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.types import FloatArray

#: Answers that are looked at, and how probable they are at least.
_MOST_ANSWERS, _PROBABLE = 2, 0.01
#: Steps, at most, and by how much no departure of the answer moves when it stays (in deviations).
_STEPS, _STAYS = 8, 0.1
#: Log evidence by which a step may be worse, and steps that are taken at once at most.
_WORSE, _MOST_AHEAD = 5.0, 4.0


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
    for _ in range(_STEPS):
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
        if float(np.abs(step).max()) < _STAYS:
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
