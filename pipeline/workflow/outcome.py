"""What a finished run has to say: problems, and what was left out; read from the results."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Problem, by_severity
from pipeline.ignored_files import ignored_file_problems
from pipeline.journal import Event
from pipeline.language import as_it_is
from pipeline.plan import (
    MISSING,
    POOL,
    RAW_KINDS,
    RECEIPT_STAGES,
    RECORD_STAGES,
    TITLES,
    VehicleFolder,
    processed_file,
    stage_log,
)
from pipeline.provenance import read_envelope, read_raw_envelope
from pipeline.records.base import PageFile
from pipeline.records.trial import PageReceipt
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_plan import PoolPlan
from pipeline.workflow.pool_runs import day_problems, pool_problems, result_file
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


@dataclass(frozen=True)
class Result:
    """How a run ended: `done` counts the stages that ran, `refused` what never became a vehicle.

    `pages` are those of pool runs and trial days that were made, from the output folder.
    `stopped` tells of an engine that ended by itself, with no stage to blame.
    """

    vehicles: tuple[str, ...]
    refused: tuple[Problem, ...]
    outcomes: tuple[Outcome, ...]
    failed: tuple[Event, ...]
    done: int
    complete: bool
    pages: tuple[str, ...] = ()
    stopped: str = ""

    @property
    def code(self) -> int:
        """Exit code: 1 when a file was refused, inputs contradict each other, or a stage failed."""
        bad = self.refused or any(outcome.failed for outcome in self.outcomes)
        return 1 if bad or not self.complete else 0


def outcome_of(
    vehicle: VehicleFolder, out: Path, plan: PoolPlan | None = None, known: KnownFiles | None = None
) -> Outcome:
    """Collect what the vehicle's processed files say; files that are not there say nothing.

    Of its `plan` of pool runs the logs that could not be read; warnings of single runs stay on
    their pages: a season has hundreds. `known` are heads that were read before.
    """
    problems = [] if plan is None else _of_pool(vehicle, plan, out, known or KnownFiles())
    problems += vehicle.misplaced_problems(out)
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
        if body["record"] is None:
            left_out.append((TITLES[stage], body["why_not"]))
        problems += _problems_of(body)
        checks += _failed_checks(stage, body)
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
        found += _problems_of(body)
        checks += _failed_checks(name, body)
    errors = (with_path(one, vehicle, out) for one in found if one.severity == "error")
    return tuple(dict.fromkeys(errors)), tuple(checks)


def _problems_of(body: Mapping[str, Any]) -> Iterator[Problem]:
    return map(Problem.of, (*body["problems"], *(body["record"] or {}).get("problems", ())))


def _failed_checks(stage: str, body: Mapping[str, Any]) -> list[str]:
    checks = (body["record"] or {}).get("checks")
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
    return problem.shown_as(str(out / vehicle.folder / rest))


def _of_pool(vehicle: VehicleFolder, plan: PoolPlan, out: Path, known: KnownFiles) -> list[Problem]:
    found = list(pool_problems(vehicle, out))
    days = {run: day for day, runs in plan.days.items() for run in runs}
    found += day_problems(vehicle.name, plan.logs.values(), days)
    for run in plan.logs:
        for stage in ("pool_run", "run_trial"):
            head = known.head(out / result_file(vehicle.name, stage, run), stage)
            if head is not None:
                found += [one for one in map(Problem.of, head.problems) if one.severity == "error"]
    return found


def new_pages(plan: PoolPlan, out: Path) -> tuple[str, ...]:
    """Return the pages of runs and days that this run has made, days last."""
    made = [
        plan.outputs(stage, item)[1]
        for stage in ("run_page", "trial_page")
        for item in plan.pending.get(stage, ())
    ]
    return tuple(page for page in made if (out / page).is_file())


_MAX_WARNINGS = 12
_MAX_PAGES = 20


def page_lines(result: Result, out: Path) -> Iterator[str]:
    """Yield a line for each new page of a run or day: what it says and where it is."""
    receipts = {page: _receipt(page, out) for page in result.pages}
    # what a day says of its runs is known when it is diagnosed, after their own receipts
    runs = {run.page: run for one in receipts.values() if one is not None for run in one.runs}
    for page, record in receipts.items():
        _, vehicle, kind, file = page.split("/", 3)
        what = "run" if kind == "runs" else "trial day"
        line = "done"
        if record is not None:
            told = runs[page].glance if page in runs else record.glance
            line = record.line if told is None else f"{told.short}; {record.line}"
        own, run = as_it_is(vehicle), as_it_is(file.removesuffix(".html"))
        yield f"{own}: {what} {run}: {line}: {out / page}"
    if result.done and result.complete and not result.pages:
        yield f"{', '.join(result.vehicles)}: up to date: {out / 'reports' / 'index.html'}"


def _receipt(page: str, out: Path) -> PageReceipt | None:
    """Return what a page of a run or a day left of itself; None where that cannot be read."""
    _, vehicle, kind, file = page.split("/", 3)
    stage = "run_page" if kind == "runs" else "trial_page"
    try:
        path = out / result_file(vehicle, stage, file.removesuffix(".html"))
        return read_envelope(path, stage, PageReceipt).record
    except InputError:
        return None


def summary(result: Result, out: Path) -> Iterator[str]:
    """Yield the paragraphs to print of a run, whose results are in `out`; last comes the report."""
    for outcome in result.outcomes:
        yield from _without_data(outcome)
        yield from _warnings(outcome)
        yield from (check_line(outcome.vehicle, check) for check in outcome.failed_checks)
    for problem in result.refused:
        yield f"error: {problem}"
    for outcome in result.outcomes:
        yield from (f"error: {p}" for p in outcome.problems if p.severity == "error")
    for event in result.failed:
        log = out / stage_log(event.vehicle, event.stage, event.item)
        yield f"error: {failure_line(event)}\nIts log: {log}"
    if result.done:
        yield from _results(result, out)
    if result.complete and result.vehicles and result.done == 0:
        yield "Nothing to do: every result is up to date."
    index = out / "reports" / "index.html"
    if result.vehicles and index.exists():
        yield f"Report: {index}"


def _results(result: Result, out: Path) -> Iterator[str]:
    """Say what came out: of each vehicle the first screen and its bench, of each page a line."""
    from pipeline.report.page import glance_text

    for name in result.vehicles:
        try:
            path = out / processed_file(name, "vehicle_page")
            record = read_envelope(path, "vehicle_page", PageFile).record
        except InputError:
            continue
        if record is not None and record.glance is not None:
            yield glance_text(as_it_is(name), record.glance)
        if record is not None and record.bench:
            yield record.bench
    lines = list(page_lines(result, out))
    if result.pages:
        yield "\n".join(lines[:_MAX_PAGES])
    if len(lines) > _MAX_PAGES:
        yield f"and {len(lines) - _MAX_PAGES} more pages."


def failure_line(event: Event) -> str:
    """Say which stage failed, for which vehicle and run or day, and why.

    >>> failure_line(Event("failed", "boat", "run_trial", "the disk is full.", item="dive1"))
    'boat, dive1, pool run against simulation: the disk is full.'
    """
    whose = f"{event.vehicle}, " if event.vehicle else ""
    whose += f"{event.item}, " if event.item else ""
    return f"{whose}{TITLES.get(event.stage, event.stage)}: {event.text}"


def check_line(vehicle: str, check: str) -> str:
    """Tell a failed check: the result is there, and something is odd about it.

    >>> check_line("boat", "drive characteristic: torque falls")
    'check failed: boat, drive characteristic: torque falls'
    """
    return f"check failed: {vehicle}, {check}"


def _without_data(outcome: Outcome) -> Iterator[str]:
    reasons: dict[str, list[str]] = {}
    for title, reason in outcome.left_out:
        reasons.setdefault(_first_gap(reason), []).append(title)
    said = {_first_gap(p.what) for p in outcome.problems if p.severity == "error"}
    for reason, titles in reasons.items():
        why = "The error below says why." if reason in said else reason
        yield f"{as_it_is(outcome.vehicle)}: left out: {', '.join(titles)}.\n  {why}"


def _first_gap(reason: str) -> str:
    """Return the reason of the first gap, for a result that lacks an earlier one."""
    root = reason.partition(": ")[2] if reason.startswith(MISSING) else reason
    first = root.partition(" ")[0]
    # a sentence begins with a capital, the name of a file does not
    return root if "." in first else root[:1].upper() + root[1:]


def _warnings(outcome: Outcome) -> Iterator[str]:
    warnings = [problem for problem in outcome.problems if problem.severity == "warning"]
    yield from (f"warning: {problem}" for problem in warnings[:_MAX_WARNINGS])
    if len(warnings) > _MAX_WARNINGS:
        rest = len(warnings) - _MAX_WARNINGS
        yield f"and {rest} more warnings; the report and rig2sea check {outcome.vehicle} have all."
