"""A diagnosis beside errors of the instruments: what is left once they are known, and its answer.

What moves the vehicle is asked with the DVL as it is known to read. What is told of the gap stays
that of the vehicle file, and the errors are part of every answer.
"""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.diagnose.case import Case
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.kinematics.instruments import InstrumentErrors, instrument_errors
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.effects.library import apply_effects
from pipeline.records.diagnosis import ParameterEstimate, RankedEffect
from pipeline.records.run_table import RunTable


def errors_of(case: Case, found: Search) -> InstrumentErrors | None:
    """Find the errors of a case's instruments, from the windows that took part."""
    return instrument_errors(
        case.vehicle, case.packed, case.candidates, _taking_part(case.runs, found), case.healthy
    )


def _taking_part(runs: Sequence[RunTable], found: Search) -> tuple[RunTable, ...]:
    """Leave the velocity out of the windows that are held out."""
    told = []
    for number, run in enumerate(runs):
        valid = run.valid.get("velocity")
        if valid is None:
            continue
        valid = valid.copy()
        for window, chosen in zip(found.setting.bench.stack.windows, found.chosen, strict=True):
            if window.run == number and not chosen:
                end_s = window.begin_s + window.duration_s
                valid &= (run.time_s < window.begin_s) | (run.time_s > end_s)
        told.append(replace(run, valid=run.valid | {"velocity": valid}))
    return tuple(told)


def case_beside(case: Case, errors: InstrumentErrors) -> Case:
    """Ask what else there is: the model has the errors, and they are no candidates any more."""
    packed = case.packed
    vector = apply_effects(packed.vector, errors.specs, packed.context)
    others = {name: one for name, one in case.candidates.items() if name not in errors.effects}
    return replace(
        case,
        packed=replace(packed, vector=vector),
        effects=others,
        errors=errors,
        as_stated=packed,
    )


def names_beside(names: Sequence[str], errors: InstrumentErrors | None) -> tuple[str, ...]:
    """Return what is at work, the errors included; `unknown` stands last.

    >>> names_beside(("none",), None)
    ('none',)
    """
    if errors is None:
        return tuple(names)
    known = {*errors.effects, *names} - {NONE, UNKNOWN}
    return (*sorted(known), *(name for name in names if name == UNKNOWN))


def alike_beside(ambiguous: Sequence[str], errors: InstrumentErrors | None) -> tuple[str, ...]:
    """Return what cannot be told from the answer: with errors there is always an effect."""
    if errors is None:
        return tuple(ambiguous)
    told = (*errors.alike, *ambiguous)
    return tuple(one for one in dict.fromkeys(told) if one not in {NONE, *errors.effects})


def ranking_beside(
    ranking: Sequence[RankedEffect], errors: InstrumentErrors | None
) -> tuple[RankedEffect, ...]:
    """Answers with the errors in each; without them each has probability 0."""
    if errors is None:
        return tuple(ranking)
    told = [_beside(row, errors) for row in ranking if row.probability > 0.0 or row.parameters]
    named = {row.effect for row in told}
    nothing = RankedEffect(
        effect=NONE, probability=0.0, parameters={}, gap_closed=None, log_evidence=0.0
    )
    alone = {row.effect for row in ranking if "+" not in row.effect}
    others = sorted({*alone, NONE, UNKNOWN, *errors.effects} - named)
    return (*told, *(nothing.model_copy(update={"effect": name}) for name in others))


def _beside(row: RankedEffect, errors: InstrumentErrors) -> RankedEffect:
    names = names_beside(row.effect.split("+"), errors)
    several = len(set(names) - {UNKNOWN}) > 1
    parameters: dict[str, ParameterEstimate] = {}
    for effect, values in errors.parameters.items():
        for name, value in values.items():
            parameters[f"{effect}.{name}" if several else name] = value
    for name, value in row.parameters.items():
        parameters[name if "." in name else f"{row.effect}.{name}"] = value
    return row.model_copy(
        update={
            "effect": "+".join(names),
            "parameters": parameters,
            "log_evidence": row.log_evidence + errors.log_evidence,
        }
    )
