"""The measured blind check: effects put into runs that were flown, diagnosed, opened, scored."""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from pipeline.blind.label import CaseLabel, TrueEffect, seal
from pipeline.blind.rates import Goal, Rate, at_least, at_most, between, rate
from pipeline.blind.score import Score, confusion
from pipeline.blind.truth.faults import AXES
from pipeline.blind.verdict_score import CaseScore, score_case
from pipeline.campaign.campaign import (
    CampaignRequest,
    CampaignResult,
    Said,
    diagnosed,
    judged,
    run_cases,
)
from pipeline.campaign.measured_cases import MeasuredCase, measured_case
from pipeline.campaign.measured_subjects import MeasuredSubject, load_subjects
from pipeline.effects.library import module_names
from pipeline.errors import CannotComputeError
from pipeline.provenance import code_digest, file_digest
from pipeline.records.base import Record

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
    effects = tuple(
        TrueEffect(
            effect=spec.id,
            parameters=dict(spec.values),
            thruster=spec.target,
            axes=tuple(name for name in spec.values if name in AXES),
        )
        for spec in ([] if one is None else [one])
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


#: From so many floors an effect is to be named. [1]
CLEAR = 3.0
#: A thrust that differs alike for all thrusters may be told of a run as it is: it does differ.
COMMON_THRUST = frozenset({"thrust_deduction", "voltage_sag"})


class MeasuredLine(Record):
    """A case that is over: what was done, and how the answer was.

    `size` and `channel_sizes` are in measured floors, `share` is the part of the effect that stands
    in the logs.
    """

    number: int
    subject: str
    kind: str
    runs: tuple[str, ...]
    healthy: tuple[str, ...]
    effect: str | None
    thruster: str | None
    parameters: dict[str, float]
    size: float
    wanted: float
    channel_sizes: dict[str, float]
    share: float
    told_thruster: str | None
    score: CaseScore

    @property
    def first(self) -> bool:
        """Whether effect and thruster are named, with a probability of a half or more."""
        return bool(
            self.score.verdict == self.score.truth
            and self.score.probability >= 0.5
            and self.told_thruster == self.thruster
        )

    @property
    def named(self) -> bool:
        """Whether effect and thruster are named, perhaps beside what nothing explains."""
        truth, verdict = set(self.score.truth), set(self.score.verdict)
        there = truth <= verdict <= {*truth, "unknown"}
        return there and self.score.probability >= 0.5 and self.told_thruster == self.thruster

    @property
    def in_set(self) -> bool:
        """Whether the answer holds the effect, first or beside it."""
        alone = len(self.score.verdict) == 1 and not self.score.ambiguous_with
        other = alone and self.told_thruster != self.thruster and self.thruster is not None
        return self.score.in_set and not other

    @property
    def surely_wrong(self) -> bool:
        """Whether another effect, another thruster, or too many are named without a doubt."""
        sure = not self.score.abstained and self.score.verdict != ("unknown",)
        wrong = self.score.confidently_wrong or not self.in_set
        return sure and wrong and not self.named

    @property
    def sure_effect(self) -> bool:
        """Whether an effect is named without a doubt that is no common scale of the thrust."""
        named = set(self.score.verdict) - {"none", "unknown", "refused"}
        sure = not self.score.abstained and "unknown" not in self.score.verdict
        return sure and bool(named - COMMON_THRUST)


def measured_lines(lines: Iterable[Mapping[str, Any]]) -> list[MeasuredLine]:
    """Read the lines of a campaign's file that have a score."""
    return [MeasuredLine.model_validate_json(json.dumps(line)) for line in lines]


def score_measured(lines: Sequence[MeasuredLine]) -> Score:
    """Put the lines of a campaign together."""
    put = [line for line in lines if line.kind != "none"]
    calm = [line for line in lines if line.kind == "none"]
    dead = [line for line in put if line.kind == "dead" and line.size == 0.0]
    weak = [line for line in put if line.effect == "thruster_degraded" and line.size >= CLEAR]
    other = [line for line in put if line.effect != "thruster_degraded" and line.size >= CLEAR]
    covered = [one.inside for line in put for one in line.score.intervals]
    of_weak, of_other = (
        f"{what}, {CLEAR:g} floors or more" for what in ("a thruster weak", "another effect")
    )
    in_set, wrong, as_flown = "truth in the answer set", "surely wrong", "runs as they are"
    answered = "answered, neither refused nor a fault of the program"
    calm_goal, whole = Goal("0", high=0.0), Goal("100 %", low=1.0)
    asked = (
        ("thruster first, 0.5 or more", of_weak, (one.first for one in weak), at_least(0.90)),
        (in_set, of_weak, (one.in_set for one in weak), at_least(0.98)),
        ("effect first, 0.5 or more", of_other, (one.first for one in other), at_least(0.70)),
        (in_set, of_other, (one.in_set for one in other), at_least(0.95)),
        (wrong, "all effects put in", (one.surely_wrong for one in put), at_most(0.02)),
        ("a sure effect", as_flown, (one.sure_effect for one in calm), calm_goal),
        ("95 % intervals cover the size", "right answers", covered, between(0.90, 0.98)),
        (answered, "all cases", (not one.score.refused for one in lines), whole),
        ("named", "a thruster commanded and without effect", (one.named for one in dead), whole),
    )
    return Score(
        cases=len(lines),
        refused=sum(bool(line.score.refused) for line in lines),
        goals=tuple(rate(*question) for question in asked),
        rates=tuple(_rates(put, calm)),
        confusion=confusion([line.score for line in lines], lambda one: "+".join(one.verdict)),
    )


def _rates(put: Sequence[MeasuredLine], calm: Sequence[MeasuredLine]) -> Iterable[Rate]:
    for name, low, high in (
        ("below 1.5", 0.0, 1.5),
        ("1.5 to 3", 1.5, 3.0),
        ("3 or more", 3.0, 1e9),
    ):
        part = [line for line in put if low <= line.size < high and line.kind != "dead"]
        for word, own in (
            ("a thruster weak", [one for one in part if one.effect == "thruster_degraded"]),
            ("another effect", [one for one in part if one.effect != "thruster_degraded"]),
        ):
            stratum = f"{word}, {name} floors"
            yield rate("first, 0.5 or more", stratum, (line.first for line in own))
            yield rate("truth in the answer set", stratum, (line.in_set for line in own))
            yield rate("surely wrong", stratum, (line.surely_wrong for line in own))
    for subject in sorted({line.subject for line in (*put, *calm)}):
        own = [line for line in put if line.subject == subject]
        yield rate("first, 0.5 or more", subject, (line.first for line in own))
        yield rate("truth in the answer set", subject, (line.in_set for line in own))
    yield rate("none", "runs as they are", (one.score.verdict == ("none",) for one in calm))
    yield rate("unknown", "runs as they are", ("unknown" in one.score.verdict for one in calm))
