"""The measured blind check: effects put into runs that were flown, diagnosed, opened, scored.

As in the generated one (`blind_campaign`), ``cases.jsonl`` has a line for each case that is done,
labels are sealed until the verdict is on disk, and a campaign that was stopped goes on.
"""

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from pipeline.blind.label import CaseLabel, TrueEffect, open_label, seal
from pipeline.blind.verdict_score import score_case
from pipeline.campaign.campaign_folder import claim_folder
from pipeline.campaign.many_cases import lines_of_cases
from pipeline.campaign.measured_cases import MeasuredCase, measured_case
from pipeline.campaign.measured_score import MeasuredLine, MeasuredScore, score_measured
from pipeline.campaign.measured_subjects import MeasuredSubject, load_subjects
from pipeline.effects.discovery import module_names
from pipeline.errors import CannotComputeError
from pipeline.provenance import code_digest, file_digest, write_atomically

SCHEMA = "rig2sea/blind_measured/1"
CASES_FILE = "cases.jsonl"
#: From what an engineer would have to the content of ``diagnosis.json``.
Diagnose = Callable[[MeasuredCase], Mapping[str, Any]]


@dataclass(frozen=True)
class MeasuredRequest:
    """What is asked for: `data` holds the measured vehicles, `to` is the campaign's folder."""

    data: Path
    to: Path
    cases: int = 60
    seed: int = 0
    resume: bool = False
    processes: int = 1
    only: tuple[int, ...] = ()

    @property
    def numbers(self) -> Sequence[int]:
        """Numbers of the cases that are asked for."""
        return sorted(set(self.only)) or range(self.cases)


@dataclass(frozen=True)
class MeasuredResult:
    """A campaign, finished or stopped."""

    score: MeasuredScore
    lines: tuple[MeasuredLine, ...]
    wanted: int
    not_made: int
    to: Path
    code: str

    @property
    def done(self) -> int:
        """Cases that are over, those that could not be made included."""
        return len(self.lines) + self.not_made

    def to_json(self) -> dict[str, Any]:
        """Return what ``rig2sea blind --measured --json`` prints."""
        return {
            "schema": SCHEMA,
            "cases": self.done,
            "wanted": self.wanted,
            "not_made": self.not_made,
            "to": str(self.to),
            "code": self.code,
            "score": self.score.model_dump(mode="json"),
        }


@cache
def subjects_of(data: Path, to: Path) -> tuple[MeasuredSubject, ...]:
    """Measured vehicles of a folder, read once a process."""
    return tuple(load_subjects(data, to / "logs"))


def diagnose_measured(case: MeasuredCase) -> Mapping[str, Any]:
    """Diagnose the runs of a case; runs that are called hopeless give ``{"refused": reason}``."""
    from pipeline.diagnose.case import Case
    from pipeline.diagnose.engine import diagnose

    subject = case.subject
    try:
        record = diagnose(
            Case(
                subject.vehicle.name, subject.vehicle, subject.packed, case.runs, (), case.healthy
            ),
            threads=1,
        )
    except CannotComputeError as error:
        return {"refused": str(error)}
    content: dict[str, Any] = record.model_dump(mode="json", exclude={"series"})
    return content


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
    sealed, verdict = (
        request.to / "sealed" / f"{name}.json",
        request.to / "verdicts" / name / "diagnosis.json",
    )
    seal(_label(case, request.seed), sealed)
    began = time.perf_counter()
    try:
        content = diagnose(case)
    except Exception as error:  # noqa: BLE001 - a fault of the program is no right answer, and told
        content = {"refused": f"fault of the program: {type(error).__name__}: {error}"[:500]}
    elapsed_s = time.perf_counter() - began
    write_atomically(verdict, json.dumps(content))
    label = open_label(sealed, verdict)
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
    said: Callable[[int, int, str], None] = lambda *_: None,
    diagnose: Diagnose = diagnose_measured,
) -> MeasuredResult:
    """Run the cases that are not done yet, and score all that are.

    Parameters
    ----------
    request : MeasuredRequest
        The campaign.
    said : callable
        Told of every case: how many are done, how many there are, one line.
    diagnose : callable
        What is judged.

    Raises
    ------
    InputError
        When the data cannot be read, or the folder holds a campaign and `resume` is not set, or
        another campaign.
    """
    subjects = subjects_of(request.data, request.to)
    lines_file = request.to / CASES_FILE
    code = code_digest("pipeline.campaign.measured_campaign", *module_names())
    header = {
        "schema": SCHEMA,
        "seed": request.seed,
        "vehicles": {one.name: len(one.runs) for one in subjects},
        "data": _data_digest(request.data),
        "code": code,
    }
    claim_folder(lines_file, header, resume=request.resume)
    run = partial(run_case, request=request, diagnose=diagnose)
    lines = lines_of_cases(
        lines_file, request.numbers, run, said, _line_text, processes=request.processes
    )
    told = tuple(
        MeasuredLine.model_validate_json(json.dumps(line))
        for line in sorted(lines, key=lambda one: one["number"])
        if "score" in line
    )
    return MeasuredResult(
        score_measured(told),
        told,
        len(request.numbers),
        len(lines) - len(told),
        request.to,
        code,
    )


def _data_digest(data: Path) -> str:
    """Digest of every file of the data, by the name that it has there."""
    digest = hashlib.sha256()
    for path in sorted(data.glob("*/**/*")):
        if path.suffix in {".mcap", ".npz", ".yaml"}:
            digest.update(f"{path.relative_to(data).as_posix()} {file_digest(path)}\n".encode())
    return digest.hexdigest()[:16]


def _line_text(line: Mapping[str, Any]) -> str:
    """One line for a person; the truth is told, since the case is over."""
    if "not_made" in line:
        return f"case {line['number']}: not made: {line['not_made']}"
    score = line["score"]
    told = "+".join(score["verdict"])
    if line["told_thruster"]:
        told += f" {line['told_thruster']}"
    if score["ambiguous_with"]:
        told += f" (or {', '.join(score['ambiguous_with'])})"
    truth = "+".join(score["truth"]) + (f" {line['thruster']}" if line["thruster"] else "")
    return (
        f"case {line['number']}: {line['subject']}, {truth} at {line['size']:.1f} floors: "
        f"{told}, {score['probability']:.2f}, {score['elapsed_s']:.0f} s"
    )
