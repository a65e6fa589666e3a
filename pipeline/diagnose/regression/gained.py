"""A thruster that the test of the gains calls dead: evidence beside that of the regression."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.effects.specification import EffectSpec
from pipeline.identify.gain_tests import FALSE_ALARMS
from pipeline.records.diagnosis import (
    UNKNOWN,
    Detail,
    DiagnosisRecord,
    ParameterEstimate,
    RankedEffect,
)
from pipeline.records.gains import ThrusterGains

#: The finding of the gains that counts: a weak thruster is weighed among all else that it may be.
_FOUND, _LEAST_P = "dead", 1e-12
#: Prior probability of one change.
PRIOR_OF_ONE = 0.3
_DEAD = "thruster_degraded"


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
    if one.kind != _FOUND or one.value is None or one.ci95 is None or not own:
        return ()
    if chance > FALSE_ALARMS:
        return ()
    return (Gained(one.thrusters[0], own, one.value, one.ci95, chance),)


def odds_of_test(p_value: float) -> float:
    """Odds that what a test found is there, with the prior of one change."""
    return PRIOR_OF_ONE / (1.0 - PRIOR_OF_ONE) * float(np.exp(log_bound(p_value)))


def log_bound(p_value: float) -> float:
    """Log evidence of a test: no more than -1 / (e p ln p) to one (Sellke and others 2001)."""
    p = float(np.clip(p_value, 1e-12, 0.3))
    return -1.0 - float(np.log(-p * np.log(p)))


def with_dead_thruster(
    record: DiagnosisRecord, gained: Gained
) -> tuple[DiagnosisRecord, tuple[EffectSpec, ...]]:
    """Put a dead thruster before an answer that names nothing; `unknown` stays beside it.

    A model that is wrong otherwise drowns what one thruster lacks; the regression of the motion on
    what was commanded asks for that alone. The odds are those of its test, which counts all
    comparisons.
    """
    verdict, odds = record.verdict, odds_of_test(gained.p_value)
    sure = odds / (1.0 + odds)
    value = float(np.clip(gained.value, 0.0, 1.0))
    low, high = (float(np.clip(end, 0.0, 1.0)) for end in gained.ci95)
    size = ParameterEstimate(value=value, unit="1", ci95=(low, high))
    first = RankedEffect(
        effect=_DEAD,
        probability=sure,
        parameters={"thrust_fraction": size},
        gap_closed=None,
        thruster=gained.thruster,
        thrusters={_DEAD: gained.thruster},
        log_evidence=float(np.log(odds)),
    )
    others = tuple(
        one.model_copy(update={"probability": (1.0 - sure) * one.probability})
        for one in record.ranking
        if one.effect != _DEAD
    )
    runs = [record.runs[k] for k in gained.runs]
    text = (
        f"{gained.thruster} does nothing: {value:.2f} of its thrust [{low:.2f}, {high:.2f}] by the "
        f"motion in {', '.join(runs)} (probability {sure:.2f}). Besides: {verdict.sentence}"
    )
    told = verdict.model_copy(
        update={
            "effects": (_DEAD, UNKNOWN),
            "probability": sure,
            "ambiguous_with": (),
            "detail": Detail(thruster=gained.thruster),
            "sentence": text,
            "text": text,
            "runs": tuple(runs),
        }
    )
    found = record.model_copy(update={"verdict": told, "ranking": (first, *others)})
    return found, (EffectSpec(_DEAD, {"thrust_fraction": value}, gained.thruster),)
