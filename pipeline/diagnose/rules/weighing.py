"""From log evidence under every level of the outside force to probabilities of answers.

Only numbers: the same function weighs a diagnosis, and the stored evidence of generated cases when
the thresholds are set.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.rules.calibration import Calibration

NONE, UNKNOWN = "none", "unknown"


@dataclass(frozen=True)
class LevelEvidence:
    """All hypotheses under one level of the outside force.

    Attributes
    ----------
    size : float
        Largest factor of the level over a healthy vehicle's force.
    even : bool
        Along all axes alike.
    ordinary : bool
        A healthy vehicle has such a force.
    weight : float
        Prior probability of the level.
    nothing : float
        Log evidence with no effect.
    gains : tuple of (str, float)
        Answers and what they add to it; `none` with 0 among them.
    """

    size: float
    even: bool
    ordinary: bool
    weight: float
    nothing: float
    gains: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Weighed:
    """One answer: its probability, and the strongest hypothesis behind it by place."""

    name: str
    probability: float
    level: int
    hypothesis: int


def weigh(
    every_level: Sequence[LevelEvidence],
    effect_count: int,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> tuple[Weighed, ...]:
    """Weigh every hypothesis under every level, the most probable answer first.

    The evidence is tempered: its exponent is below 1, because models are never quite right. Mass
    under a force that no healthy vehicle has goes to `unknown`, unless the effect takes away most
    of the force that would be needed without it.
    """
    pairs = max(effect_count * (effect_count - 1) / 2, 1)
    ordinary = limits.most_level_healthy if healthy_known else limits.most_level
    weights = np.log([limits.single / max(effect_count, 1), limits.pair / pairs])
    needed = max((one for one in every_level if one.even), key=lambda one: one.nothing).size
    second_price = limits.pair_share * _explained_by_one(every_level)
    best: dict[str, tuple[float, int, int]] = {}
    totals: dict[str, float] = {}
    for number, level in enumerate(every_level):
        for place, (name, plain_gain) in enumerate(level.gains):
            gain = plain_gain - (second_price if "+" in name else 0.0)
            value = limits.exponent * (level.nothing + gain) + float(np.log(level.weight))
            value += float(np.log(limits.none) if name == NONE else weights[name.count("+")])
            goes_to = name
            if not level.ordinary and level.size > ordinary:
                left = level.size / max(needed, 1e-9)
                if name == NONE or left > limits.left_over:
                    goes_to = UNKNOWN
            totals[goes_to] = float(np.logaddexp(totals.get(goes_to, -np.inf), value))
            if goes_to not in best or value > best[goes_to][0]:
                best[goes_to] = (value, number, place)
    highest = max(totals.values())
    shares = {name: float(np.exp(value - highest)) for name, value in totals.items()}
    whole = sum(shares.values())
    found = [Weighed(name, share / whole, *best[name][1:]) for name, share in shares.items()]

    def gained(one: Weighed) -> float:
        level = every_level[one.level]
        return level.nothing + level.gains[one.hypothesis][1]

    return tuple(sorted(found, key=lambda one: (-one.probability, -gained(one), one.name)))


def _explained_by_one(every_level: Sequence[LevelEvidence]) -> float:
    """Compute what the best single effect adds to the log evidence of none, over all levels."""
    alone = max(level.nothing for level in every_level)
    singles = [
        level.nothing + gain
        for level in every_level
        for name, gain in level.gains
        if name != NONE and "+" not in name
    ]
    return max(max(singles, default=alone) - alone, 0.0)
