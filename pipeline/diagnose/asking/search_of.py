"""What was asked in the form that the gap, the pictures and the record are made from."""

from dataclasses import replace

import numpy as np

from pipeline.diagnose.asking.answer import Answer
from pipeline.diagnose.asking.ask import Asked
from pipeline.diagnose.asking.decide import Posterior
from pipeline.diagnose.asking.view import View
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import log_evidence_of, with_ordinary
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.linear.elimination import Marginal, grams
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.scales import Level

#: Log evidence of what the readings exclude: no logarithm of zero is written down.
_NO_EVIDENCE = -1e6


def search_of(asked: Asked) -> Search:
    """Say of the first answer's view what a search says, of the coordinates alone."""
    first = asked.answers[0]
    view = first.view
    count = len(view.setting.coordinates)
    departures = first.within()
    setting = replace(view.setting, scatter=view.beliefs.scatter[:count])
    model = replace(
        view.model,
        setting=setting,
        readings=view.model.readings - view.model.rest @ departures[count : count + _rest(view)],
    )
    prior = view.beliefs.prior
    return Search(
        model,
        grams(model),
        Prior(prior.mean[:count], prior.covariance[:count, :count]),
        (judged_of(first),),
        asked.groups,
        asked.noise,
        asked.linearisations,
        view.chosen,
        asked.reach,
        view.beliefs.scatter[:count],
    )


def answers_of(asked: Asked, posterior: Posterior) -> Answers:
    """All answers in their order, with their probabilities."""
    none = next(one.value for one in asked.answers if not one.groups)
    rows = []
    for name, probability in posterior.ranking:
        one = posterior.shown.get(name)
        if one is None:
            one = asked.answers[0]
            strange = max(one.strange - none, _NO_EVIDENCE)
            rows.append(Candidate(name, probability, strange, None, judged_of(one)))
            continue
        rows.append(Candidate(name, probability, one.value - none, one.finding, judged_of(one)))
    return Answers(tuple(rows))


def judged_of(answer: Answer) -> Judged:
    """Return what the chosen windows say where an answer was seen, of the coordinates alone."""
    view = answer.view
    told = view.told(answer.level, held_out=False)
    count = len(view.setting.coordinates)
    found = _coordinates_alone(told.whole, view.beliefs.prior, count)
    prior = Prior(view.beliefs.prior.mean[:count], view.beliefs.prior.covariance[:count, :count])
    ground = with_ordinary(found, prior)
    level = Level(answer.level.factor, answer.level.weight, answer.level.ordinary)
    return Judged(level, found, ground, log_evidence_of(ground), (), ())


def _coordinates_alone(whole: Marginal, prior: Prior, count: int) -> Marginal:
    """Integrate out the forces of the rest and the errors of curves, as they are believed."""
    others = slice(count, None)
    spread = prior.covariance[others, others]
    values, vectors = np.linalg.eigh(spread)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    mean = np.concatenate([np.zeros(count), prior.mean[others]])
    at_mean = whole.score - whole.information @ mean
    side = whole.information[:, others] @ root
    inner = np.eye(root.shape[1]) + root.T @ side[others]
    solved = np.linalg.solve(inner, np.column_stack([side.T, root.T @ at_mean[others]]))
    information = whole.information - side @ solved[:, :-1]
    score = at_mean - side @ solved[:, -1]
    misfit = whole.misfit - float(2 * whole.score @ mean - mean @ whole.information @ mean)
    misfit -= float((root.T @ at_mean[others]) @ solved[:, -1])
    determinant = whole.log_determinant + float(np.linalg.slogdet(inner)[1])
    return Marginal(information[:count, :count], score[:count], misfit, determinant)


def _rest(view: View) -> int:
    return view.setting.rest.size
