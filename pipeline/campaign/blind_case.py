"""One case of the blind check from end to end: made, sealed, diagnosed, opened, scored."""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.blind.cases import RUN_S, Numbered, case_of, write_case
from pipeline.blind.generate import GeneratedCase, generate
from pipeline.blind.label import open_label, seal
from pipeline.blind.subject import BlindSubject
from pipeline.blind.verdict_score import CaseScore, score_case
from pipeline.campaign.blind_subjects import load_subject
from pipeline.effects.library import candidates
from pipeline.errors import CannotComputeError
from pipeline.provenance import write_atomically
from pipeline.simulate.bench_model import BenchModel
from pipeline.simulate.pack import PackedVehicle, pack_vehicle

if TYPE_CHECKING:
    from pipeline.diagnose.conclude.case_evidence import CaseEvidence

#: From a case, as an engineer would have it, and the effects that are left out of the library, to
#: the content of ``diagnosis.json``.
Diagnose = Callable[[GeneratedCase, PackedVehicle, tuple[str, ...]], Mapping[str, Any]]


@dataclass(frozen=True)
class BlindPlace:
    """Where a campaign's vehicles come from and where its files go."""

    raw: Path
    out: Path
    to: Path
    vehicles: tuple[str, ...]
    seed: int
    baselines: bool = True
    keep_logs: bool = False
    calibration: bool = False
    run_s: float = RUN_S


@cache
def subjects_of(place: BlindPlace) -> dict[str, BlindSubject]:
    """Vehicles of a campaign by name, read once a process."""
    return {
        subject.name: subject
        for subject in (load_subject(name, place.raw, place.out) for name in place.vehicles)
    }


def packed_of(subject: BlindSubject) -> PackedVehicle:
    """Pack a case's vehicle file for the simulation that the diagnosis fits."""
    return pack_vehicle(
        subject.vehicle, BenchModel(subject.static) if subject.static is not None else None
    )


def diagnose_in_memory(
    case: GeneratedCase,
    packed: PackedVehicle,
    without: tuple[str, ...],
    keep: "Callable[[CaseEvidence], None] | None" = None,
) -> Mapping[str, Any]:
    """Diagnose a case's tables; data that are called hopeless give ``{"refused": reason}``.

    `keep` is given the evidence that was weighed.
    """
    from pipeline.diagnose.case import Case
    from pipeline.diagnose.engine import diagnose_fully

    library = {
        name: effect for name, effect in candidates(packed.context).items() if name not in without
    }
    try:
        found = diagnose_fully(
            Case(
                name=case.subject.name,
                vehicle=case.subject.vehicle,
                packed=packed,
                runs=case.runs,
                holdout=case.holdout,
                healthy=case.healthy,
                effects=library,
            ),
            threads=1,
            seed=0,
            keep=keep,
        )
    except CannotComputeError as error:
        return {"refused": str(error)}
    content: dict[str, Any] = found.record.model_dump(mode="json", exclude={"series"})
    return content


def run_case(
    number: int, place: BlindPlace, diagnose: Diagnose = diagnose_in_memory
) -> dict[str, Any]:
    """Run one case and return its line: the score, or why there is none.

    The label is sealed before the diagnosis begins and opened when the verdict is on disk.

    Parameters
    ----------
    number : int
        Of the case.
    place : BlindPlace
        The campaign.
    diagnose : callable
        The diagnosis.

    Returns
    -------
    dict
        ``number`` and either ``score`` or ``not_made``.
    """
    subjects = subjects_of(place)
    numbered = case_of(
        number, subjects, place.seed, calibration=place.calibration, run_s=place.run_s
    )
    try:
        case = generate(subjects[numbered.vehicle], numbered.spec)
    except CannotComputeError as error:
        return {"number": number, "not_made": str(error), "what": list(numbered.spec.what)}
    sealed = place.to / "sealed"
    if place.keep_logs:
        write_case(case, numbered.name, place.to / "cases", sealed)
    else:
        seal(case.label, sealed / f"{numbered.name}.json")
    score = _judge(numbered, case, place, diagnose)
    return {"number": number, "score": score.model_dump(mode="json")}


def _judge(
    numbered: Numbered, case: GeneratedCase, place: BlindPlace, diagnose: Diagnose
) -> CaseScore:
    packed = packed_of(case.subject)
    without = numbered.spec.what if numbered.spec.kind == "leave_one_out" else ()
    begin = time.perf_counter()
    try:
        content = diagnose(case, packed, without)
    except Exception as error:  # noqa: BLE001 - a fault of the program is no right answer, and told
        content = {"refused": f"fault of the program: {type(error).__name__}: {error}"[:500]}
    elapsed_s = time.perf_counter() - begin
    verdict = place.to / "verdicts" / numbered.name / "diagnosis.json"
    write_atomically(verdict, json.dumps(content))
    answers: dict[str, str] = {}
    if place.baselines and not without:
        from pipeline.diagnose.baselines import bic_baseline, sparse_baseline

        answers = {
            "BIC on raw residuals": bic_baseline(case.subject.vehicle, packed, case.runs),
            "sparse regression": sparse_baseline(case.subject.vehicle, packed, case.runs),
        }
    label = open_label(place.to / "sealed" / f"{numbered.name}.json", verdict)
    return score_case(numbered.name, label, content, elapsed_s=elapsed_s, baselines=answers)
