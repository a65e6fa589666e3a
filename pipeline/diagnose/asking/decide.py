"""One posterior from the evidence of all answers, and what is said by the least expected cost.

The probability that is printed is the one that is computed here; nothing changes it afterwards.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.asking.answer import Answer
from pipeline.types import FloatArray

NONE, UNKNOWN = "none", "unknown"
#: Power of the likelihood: a real model is never quite right, and what it lacks looks like an
#: effect as often as its evidence says, tempered.
EXPONENT = 0.3
#: Prior probability of nothing, of one effect, of two; the rest is what no effect explains.
_NONE, _SINGLE, _PAIR = 0.6, 0.3, 0.05
#: What it costs to name an effect that is not there, to leave the right one out of the answer set,
#: for each further answer in the set, and to abstain where an answer could have been given.
_WRONG, _MISSED, _FURTHER, _ABSTAIN = 1.0, 0.6, 0.04, 0.35
#: Answers that a set may have.
_MOST = 4


@dataclass(frozen=True)
class Posterior:
    """Probabilities of all answers, most probable first, and the answer that stands for each name.

    `shown` lacks `unknown`: nothing stands for it.
    """

    ranking: tuple[tuple[str, float], ...]
    shown: Mapping[str, Answer]

    def of(self, name: str) -> float:
        """Probability of a name; 0 where it was not asked for."""
        return dict(self.ranking).get(name, 0.0)


@dataclass(frozen=True)
class Said:
    """What is said: `names` first, `ambiguous` what the runs cannot tell from it."""

    names: tuple[str, ...]
    ambiguous: tuple[str, ...]


def posterior_of(answers: Sequence[Answer], effect_count: int) -> Posterior:
    """Weigh all answers.

    Parameters
    ----------
    answers : sequence of Answer
        With their log evidence under ordinary forces and under larger ones; `none` among them.
    effect_count : int
        Effects that share the prior of one.
    """
    shown: dict[str, Answer] = {}
    for one in answers:
        if one.name not in shown or one.value > shown[one.name].value:
            shown[one.name] = one
    names = list(shown)
    logs = [EXPONENT * shown[name].value + _log_prior(name, effect_count) for name in names]
    # nothing of the library, under a force that is not ordinary
    names.append(UNKNOWN)
    logs.append(EXPONENT * shown[NONE].strange + float(np.log(1.0 - _NONE - _SINGLE - _PAIR)))
    logs[names.index(NONE)] = EXPONENT * shown[NONE].ordinary + _log_prior(NONE, effect_count)
    value = np.array(logs)
    share: FloatArray = np.exp(value - value.max())
    share /= share.sum()
    ranking = sorted(zip(names, share.tolist(), strict=True), key=lambda row: (-row[1], row[0]))
    return Posterior(tuple(ranking), shown)


def _log_prior(name: str, count: int) -> float:
    if name == NONE:
        return float(np.log(_NONE))
    if "+" in name:
        return float(np.log(_PAIR / max(count * (count - 1) / 2, 1.0)))
    return float(np.log(_SINGLE / max(count, 1)))


def decide(posterior: Posterior) -> Said:
    """Say what costs least, by the posterior.

    One answer alone, or one with others that the runs cannot tell from it. An answer is charged for
    the probability that something else is true, less what its set holds of it; each further member
    of the set costs a little, so that a set grows only where it pays.
    """
    rows = [(name, value) for name, value in posterior.ranking if value > 0.0]
    first, own = rows[0]
    members, cost = [first], _cost(own, 0.0, 1)
    held = 0.0
    for name, value in rows[1:_MOST]:
        wider = _cost(own, held + value, len(members) + 1)
        if wider >= cost:
            break
        members.append(name)
        held += value
        cost = wider
    ambiguous = tuple(
        dict.fromkeys(
            effect
            for name in members[1:]
            for effect in name.split("+")
            if effect not in first.split("+")
        )
    )
    if cost > _ABSTAIN and first not in {NONE, UNKNOWN}:
        beside = tuple(dict.fromkeys([*first.split("+"), *ambiguous]))
        return Said((UNKNOWN,), tuple(name for name in beside if name != UNKNOWN))
    return Said(tuple(first.split("+")), ambiguous)


def _cost(own: float, held: float, members: int) -> float:
    """Return the expected cost of an answer and of a set that holds as much besides."""
    out = max(1.0 - own - held, 0.0)
    return _WRONG * out + (_WRONG - _MISSED) * held * 0.5 + _FURTHER * (members - 1)
