"""A thruster that the test of the gains calls dead: evidence beside that of the regression."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.gain_tests import FALSE_ALARMS
from pipeline.records.gains import ThrusterGains

#: The finding of the gains that counts: a weak thruster is weighed among all else that it may be.
_DEAD, _LEAST_P = "dead", 1e-12


@dataclass(frozen=True)
class Gained:
    """A thruster that is dead by the test of its gains; `p_value` counts all comparisons."""

    thruster: str
    runs: tuple[int, ...]
    value: float
    ci95: tuple[float, float]
    p_value: float


def gained_of(gains: ThrusterGains, names: Sequence[str]) -> tuple[Gained, ...]:
    """Return the thruster that the test of the gains calls dead, if that is what they find.

    Findings have a cause in common, which is no thruster's, as likely as not: the chance of this
    one is divided by those of all others.
    """
    if not gains.findings:
        return ()
    one, *others = gains.findings
    own = tuple(names.index(name) for name in one.runs if name in names)
    chance = max(one.p_value, _LEAST_P)
    chance /= float(np.prod([max(other.p_value, _LEAST_P) for other in others]))
    if one.kind != _DEAD or one.value is None or one.ci95 is None or not own:
        return ()
    if chance > FALSE_ALARMS:
        return ()
    return (Gained(one.thrusters[0], own, one.value, one.ci95, chance),)
