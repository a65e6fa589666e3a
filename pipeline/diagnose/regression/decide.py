"""What is said of the hypotheses: that which costs least by the posterior."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.diagnose.regression.change import Change
from pipeline.records.diagnosis import NONE, UNKNOWN

#: What it costs to name what is not there, to leave the right one out of the set, for each further
#: one in it, and to abstain.
_WRONG, _BESIDE, _FURTHER, _ABSTAIN = 1.0, 0.2, 0.04, 0.35
_MOST_SAID = 4


@dataclass(frozen=True)
class Said:
    """What is said: `first`, and the names of other effects that these runs cannot tell from it."""

    first: Change
    names: tuple[str, ...]
    ambiguous: tuple[str, ...]


def effects_of(name: str) -> tuple[str, ...]:
    """Effects of a hypothesis by its name.

    >>> effects_of("cg_shift+thruster_degraded@upper")
    ('cg_shift', 'thruster_degraded')
    """
    return tuple(dict.fromkeys(part.split("@")[0] for part in name.split("+")))


def decide(ranking: Sequence[Change]) -> Said:
    """Say what costs least by the posterior: one answer, a set, or that it cannot be told."""
    first, held, members = ranking[0], 0.0, 1
    cost = _WRONG * (1.0 - first.probability)
    beside: list[str] = []
    own = effects_of(first.name)
    # the same effect elsewhere is no wider answer: nothing is to be mended at either place
    others = [one for one in ranking[1:] if effects_of(one.name) != own]
    for name, value in ((one.name, one.probability) for one in others[: _MOST_SAID - 1]):
        wider = _WRONG * (1.0 - first.probability - held - value) + _BESIDE * (held + value)
        if wider + _FURTHER * members >= cost:
            break
        cost, held, members = wider + _FURTHER * members, held + value, members + 1
        beside.append(name)
    ambiguous = tuple(
        dict.fromkeys(one for name in beside for one in effects_of(name) if one not in own)
    )
    if cost > _ABSTAIN and first.name not in {NONE, UNKNOWN}:
        told = tuple(one for one in dict.fromkeys((*own, *ambiguous)) if one != UNKNOWN)
        return Said(first, (UNKNOWN,), told)
    return Said(first, own, ambiguous)
