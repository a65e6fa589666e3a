"""What a finished run has to say: every problem and everything left out, read from the results."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place, Problem, by_severity
from pipeline.ignored_files import ignored_file_problems
from pipeline.plan import (
    POOL,
    RAW_KINDS,
    RECEIPT_STAGES,
    RECORD_STAGES,
    TITLES,
    VehicleFolder,
    processed_file,
)
from pipeline.provenance import read_raw_envelope
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_plan import PoolPlan
from pipeline.workflow.pool_runs import (
    day_problems,
    pool_problems,
    result_file,
)
from pipeline.workflow.vehicle_places import types_of


@dataclass(frozen=True)
class Outcome:
    """Problems of one vehicle's files, the results that it has no data for, checks that failed."""

    vehicle: str
    problems: tuple[Problem, ...]
    left_out: tuple[tuple[str, str], ...]
    """Title of the result and the reason."""
    failed_checks: tuple[str, ...] = ()
    """Of which result and which check; what it found, on a line of its own."""

    @property
    def failed(self) -> bool:
        """Whether a file was refused or inputs contradict each other."""
        return any(problem.severity == "error" for problem in self.problems)


def outcome_of(vehicle: VehicleFolder, out: Path) -> Outcome:
    """Collect what the vehicle's processed files say; files that are not there say nothing."""
    problems = list(vehicle.misplaced_problems(out))
    types = () if vehicle.thruster_type else types_of(out / vehicle.vehicle_file)
    for kind in () if vehicle.thruster_type else (*RAW_KINDS, POOL):
        room = out / vehicle.folder / kind
        problems += ignored_file_problems(room, f"{vehicle.name}/{kind}", types)
    left_out: list[tuple[str, str]] = []
    checks: list[str] = []
    for stage in (*RECORD_STAGES, *RECEIPT_STAGES):
        try:
            body = read_raw_envelope(out / processed_file(vehicle.name, stage), stage)
        except InputError:
            continue  # the stage failed or was not reached; the run has said so
        problems += problems_of(body["problems"])
        if body["record"] is None:
            left_out.append((TITLES[stage], body["why_not"]))
        else:
            problems += problems_of(body["record"].get("problems", ()))
            checks += _failed_checks(stage, body["record"])
    # what several stages met is said once
    shown = by_severity(dict.fromkeys(with_path(one, vehicle, out) for one in problems))
    return Outcome(vehicle.name, shown, tuple(left_out), tuple(checks))


def faults_behind(
    vehicle: VehicleFolder, stage: str, out: Path
) -> tuple[tuple[Problem, ...], tuple[str, ...]]:
    """Return errors and failed checks of all that a result was made from, back to the raw files.

    A result that a refused file is missing from looks like a whole one.
    """
    found: list[Problem] = []
    checks: list[str] = []
    for name, body in _behind(vehicle, stage, out):
        record = body["record"] or {}
        found += problems_of([*body["problems"], *record.get("problems", ())])
        checks += _failed_checks(name, record)
    errors = (with_path(one, vehicle, out) for one in found if one.severity == "error")
    return tuple(dict.fromkeys(errors)), tuple(checks)


def _failed_checks(stage: str, record: Mapping[str, Any]) -> list[str]:
    checks = record.get("checks")
    return [
        f"{TITLES[stage]}: {check['name']}\n  {check['text']}"
        for check in (checks if isinstance(checks, list) else ())
        if not check["passed"]
    ]


def _behind(
    vehicle: VehicleFolder, stage: str, out: Path
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield stage and envelope of a result and of all that it was made from, once each."""
    seen: set[str] = set()
    waiting = [processed_file(vehicle.name, stage)]
    while waiting:
        path = waiting.pop()
        if path in seen or not path.startswith("processed/"):
            continue
        seen.add(path)
        try:
            body = read_raw_envelope(out / path, Path(path).stem)
        except InputError:
            continue  # no envelope, or gone: the stage that needed it has said so
        waiting += reversed(body["inputs"])
        yield Path(path).stem, body


def with_path(problem: Problem, vehicle: VehicleFolder, out: Path) -> Problem:
    """Show a raw file by a path that can be opened; records name it from the raw folder on."""
    folder, _, rest = problem.place.file.partition("/")
    if not rest or f"raw/{folder}/" != vehicle.digest_prefix:
        return problem
    return replace(problem, place=replace(problem.place, file=str(out / vehicle.folder / rest)))


def problems_of(items: Iterable[Mapping[str, Any]]) -> list[Problem]:
    """Turn the problems of a processed file back."""
    return [
        Problem(
            item["severity"],
            Place(**item["place"]),
            item["what"],
            item.get("expected", ""),
            item.get("remedy", ""),
        )
        for item in items
    ]


def with_pool(
    outcome: Outcome, vehicle: VehicleFolder, plan: PoolPlan, out: Path, known: KnownFiles
) -> Outcome:
    """Add to a vehicle's outcome the logs that could not be read, before what the stages say.

    Warnings of single runs stay on their pages: a season has hundreds.
    """
    found = list(pool_problems(vehicle, out))
    days = {run: day for day, runs in plan.days.items() for run in runs}
    found += day_problems(vehicle.name, plan.logs.values(), days)
    for run in plan.logs:
        for stage in ("pool_run", "run_trial"):
            head = known.head(out / result_file(vehicle.name, stage, run), stage)
            if head is not None:
                found += [one for one in problems_of(head.problems) if one.severity == "error"]
    shown = tuple(with_path(problem, vehicle, out) for problem in found)
    return replace(outcome, problems=by_severity(dict.fromkeys(shown + outcome.problems)))


def new_pages(plan: PoolPlan, out: Path) -> tuple[str, ...]:
    """Return the pages of runs and days that this run has made, days last."""
    made = [
        plan.outputs(stage, item)[1]
        for stage in ("run_page", "trial_page")
        for item in plan.pending.get(stage, ())
    ]
    return tuple(page for page in made if (out / page).is_file())
