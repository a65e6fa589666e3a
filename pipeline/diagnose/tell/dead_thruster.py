"""A thruster that does nothing, by its gains, beside an answer that does not name it."""

import numpy as np

from pipeline.diagnose.regression.gained import Gained
from pipeline.diagnose.regression.weigh import odds_of_test
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.effects.specification import EffectSpec
from pipeline.records.diagnosis import Detail, DiagnosisRecord, ParameterEstimate, RankedEffect

_DEAD = "thruster_degraded"


def with_dead_thruster(
    record: DiagnosisRecord, gained: Gained
) -> tuple[DiagnosisRecord, tuple[EffectSpec, ...]]:
    """Put a dead thruster first where the answer names nothing; `unknown` stays beside it.

    A model that is wrong otherwise drowns what one thruster lacks; the regression of the motion on
    what was commanded asks for that alone. The odds are those of its test, which counts all
    comparisons.
    """
    verdict = record.verdict
    if verdict.effects not in {(NONE,), (UNKNOWN,)}:
        return record, ()
    odds = odds_of_test(gained.p_value)
    sure = odds / (1.0 + odds)
    if sure < verdict.probability and verdict.effects == (NONE,):
        return record, ()
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
    besides = verdict.effects == (UNKNOWN,)
    text = (
        f"{gained.thruster} does nothing: {value:.2f} of its thrust [{low:.2f}, {high:.2f}] by the "
        f"motion in {', '.join(runs)} (probability {sure:.2f})."
    )
    if besides:
        text += f" Besides: {verdict.sentence}"
    told = verdict.model_copy(
        update={
            "effects": (_DEAD, UNKNOWN) if besides else (_DEAD,),
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
