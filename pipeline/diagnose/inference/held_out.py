r"""What the windows that took no part say of an answer.

An effect that is there explains other windows, too. The log evidence of the held-out windows y'
when the chosen ones y are known,

.. math:: \log p(y' | y, H) = \log p(y, y' | H) - \log p(y | H),

is compared with that of the best simpler answer: of none for one effect, of the better of its
effects alone for two (cumulative evidence as cross-validation: Fong and Holmes 2020, "On the
marginal likelihood and cross-validation"). It is clearly negative where the chosen windows made the
effect up. It is about zero where the effect does nothing, but also where a stated parameter that is
far off would do the same: what the chosen windows say of it is known by then. So it can speak
against an answer only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import judge, log_evidence_of, with_ordinary
from pipeline.diagnose.judging.search import Judged, Search, force_prior
from pipeline.diagnose.linear.elimination import Marginal, marginal
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.sureness import with_sure_second
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN

#: Log evidence of what the held-out windows make impossible.
_IMPOSSIBLE = -1e6
#: Log evidence of the held-out windows that chance alone can make negative.
_CHANCE = 3.0
#: Log evidence of held-out windows, by what is wide.
_Predicted = Callable[[Sequence[int]], float]


def checked(found: Search, answered: Answers, limits: Calibration) -> Answers:
    """Lower answers that the held-out windows speak against, and second effects not sure.

    See `with_held_out` and `with_sure_second`.
    """
    gains = held_out_gains(found, answered)
    shares = with_held_out(
        [Share(one.name, one.probability) for one in answered.ranking], gains, limits
    )
    return replace(answered, held_out=gains).reweighed(with_sure_second(shares, limits))


def with_held_out(
    ranking: Sequence[Share], gains: Mapping[str, float], limits: Calibration
) -> tuple[Share, ...]:
    """Lower answers that the windows that took no part speak against.

    Those windows never raise an answer: they are there to check it.

    Parameters
    ----------
    ranking, limits
        As of `decision.without_gap`.
    gains : mapping
        Log evidence of the held-out windows for an answer over the best simpler one, by name.
    """
    worth = {
        one.name: one.probability
        * float(np.exp(limits.held_out * min(gains.get(one.name, 0.0) + _CHANCE, 0.0)))
        for one in ranking
    }
    whole = sum(worth.values())
    if whole <= 0.0:
        return tuple(ranking)
    shares = [replace(one, probability=worth[one.name] / whole) for one in ranking]
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def held_out_gains(found: Search, answered: Answers) -> dict[str, float]:
    """Log evidence by which each answer predicts the held-out windows better than a simpler one.

    Parameters
    ----------
    found : Search
        As it ended, judged on the chosen windows.
    answered : Answers
        Answers that are looked at, each under its own level of the outside force.

    Returns
    -------
    dict
        By the answer's name; empty where no window was held out.
    """
    if found.chosen.all():
        return {}
    levels: dict[int, _Predicted] = {}

    def under(judged: Judged) -> _Predicted:
        return levels.setdefault(id(judged.level), _predicted(found, judged))

    nothing = answered.of(NONE) or answered.ranking[0]
    without = under(nothing.judged)(())
    gains = {}
    for one in answered.ranking:
        # a force from nowhere predicts nothing, and is no worse an answer for that
        if one.finding is None or one.name == UNKNOWN:
            continue
        predicted = under(one.judged)
        simpler = [without, *(predicted(which) for which in _alone(found, one))]
        gains[one.name] = predicted(one.finding.which) - max(simpler)
    return gains


def _alone(found: Search, pair: Candidate) -> list[tuple[int, ...]]:
    """Departures of each effect of a pair by itself: as within the pair, and as found alone."""
    if pair.finding is None or len(pair.finding.effects) == 1:
        return []
    every = found.setting.coordinates
    own = [
        tuple(k for k in pair.finding.which if every[k].effect.id == effect)
        for effect in pair.finding.effects
    ]
    alone = [
        one.which
        for one in pair.judged.singles
        if one.which and set(one.groups) <= set(pair.finding.groups)
    ]
    return [*own, *alone]


def _predicted(found: Search, judged: Judged) -> _Predicted:
    """Log evidence of the held-out windows under one level, by what is wide."""
    whole = with_ordinary(
        marginal(found.grams, force_prior(found.setting, judged.level)), found.prior
    )

    def total(ground: Marginal, which: Sequence[int]) -> float:
        gain = judge(ground, found.setting.coordinates, which)[0] if which else 0.0
        return log_evidence_of(ground) + gain

    def predicted(which: Sequence[int]) -> float:
        now, before = total(whole, which), total(judged.ground, which)
        return now - before if np.isfinite([now, before]).all() else _IMPOSSIBLE

    return predicted
