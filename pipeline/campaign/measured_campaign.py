"""The measured blind check: effects put into runs that were flown, diagnosed, opened, scored."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from pipeline.blind.label import CaseLabel, TrueEffect, seal
from pipeline.blind.score import Score
from pipeline.blind.verdict_score import score_case
from pipeline.campaign.campaign import (
    CampaignRequest,
    CampaignResult,
    Said,
    diagnosed,
    judged,
    run_cases,
)
from pipeline.campaign.measured_cases import MeasuredCase, measured_case
from pipeline.campaign.measured_score import MeasuredLine, measured_lines, score_measured
from pipeline.campaign.measured_subjects import MeasuredSubject, load_subjects
from pipeline.effects.library import module_names
from pipeline.errors import CannotComputeError
from pipeline.provenance import code_digest, file_digest

SCHEMA = "rig2sea/blind_measured/1"
#: From what an engineer would have to the content of ``diagnosis.json``.
Diagnose = Callable[[MeasuredCase], Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class MeasuredRequest(CampaignRequest):
    """A campaign on the measured vehicles of a folder, `data`."""

    data: Path


@cache
def subjects_of(data: Path, to: Path) -> tuple[MeasuredSubject, ...]:
    """Measured vehicles of a folder, read once a process."""
    return tuple(load_subjects(data, to / "logs"))


def diagnose_measured(case: MeasuredCase) -> Mapping[str, Any]:
    """Diagnose the runs of a case."""
    from pipeline.diagnose.case import Case

    one = case.subject
    return diagnosed(Case(one.vehicle.name, one.vehicle, one.packed, case.runs, (), case.healthy))


def run_case(
    number: int, request: MeasuredRequest, diagnose: Diagnose = diagnose_measured
) -> dict[str, Any]:
    """Run one case and return its line; one that cannot be made says why."""
    subjects = subjects_of(request.data, request.to)
    try:
        case = measured_case(number, request.seed, subjects)
    except CannotComputeError as error:
        return {"number": number, "not_made": str(error)}
    name = f"case_{number:05d}"
    sealed = request.to / "sealed" / f"{name}.json"
    seal(_label(case, request.seed), sealed)
    label, content, elapsed_s = judged(sealed, lambda: diagnose(case))
    line = MeasuredLine(
        number=number,
        subject=case.subject.name,
        kind=case.kind,
        runs=tuple(run.name for run in case.runs),
        healthy=tuple(run.name for run in case.healthy),
        effect=None if case.spec is None else case.spec.id,
        thruster=None if case.spec is None else case.spec.target,
        parameters={} if case.spec is None else dict(case.spec.values),
        size=case.size,
        wanted=case.wanted,
        channel_sizes=case.sizes,
        share=case.share,
        told_thruster=content.get("verdict", {}).get("detail", {}).get("thruster"),
        score=score_case(name, label, content, elapsed_s=elapsed_s),
    )
    return line.model_dump(mode="json")


def _label(case: MeasuredCase, seed: int) -> CaseLabel:
    """Say what was done, as the labels of generated cases do."""
    one = case.spec
    effects = (
        ()
        if one is None
        else (
            TrueEffect(
                effect=one.id,
                parameters=dict(one.values),
                thruster=one.target,
                axes=tuple(name for name in one.values if name in _AXES),
            ),
        )
    )
    return CaseLabel(
        vehicle=case.subject.name,
        kind="none" if one is None else "single",
        effects=effects,
        wanted_ratio=case.wanted,
        gap_ratio=case.size,
        channel_ratios=case.sizes,
        healthy_floor={},
        manoeuvres=", ".join(run.name for run in case.runs),
        healthy_runs=len(case.healthy),
        seed=seed,
    )


_AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def run_measured(
    request: MeasuredRequest,
    said: Said = lambda *_: None,
    diagnose: Diagnose = diagnose_measured,
) -> CampaignResult[Score]:
    """Run the cases that are not done yet, and score all that are; raises as `run_cases`.

    Also where the data cannot be read. `diagnose` is what is judged.
    """
    header = {
        "schema": SCHEMA,
        "vehicles": {one.name: len(one.runs) for one in subjects_of(request.data, request.to)},
        "data": _data_digest(request.data),
        "code": code_digest(__name__, *module_names()),
    }
    return run_cases(
        request, header, partial(run_case, request=request, diagnose=diagnose), scored, said
    )


def scored(lines: Sequence[Mapping[str, Any]]) -> Score:
    """Score the lines of a campaign."""
    return score_measured(measured_lines(lines))


def _data_digest(data: Path) -> str:
    """Digest of every file of the data, by the name that it has there."""
    digest = hashlib.sha256()
    for path in sorted(data.glob("*/**/*")):
        if path.suffix in {".mcap", ".npz", ".yaml"}:
            digest.update(f"{path.relative_to(data).as_posix()} {file_digest(path)}\n".encode())
    return digest.hexdigest()[:16]
