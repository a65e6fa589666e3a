"""What a run says at its end: errors in full, some warnings, failed checks, what has no data."""

from collections.abc import Iterator
from pathlib import Path

from pipeline.errors import InputError
from pipeline.journal import Event
from pipeline.plan import MISSING, TITLES, processed_file, stage_log
from pipeline.provenance import read_envelope
from pipeline.records.base import PageFile
from pipeline.records.trial import PageReceipt
from pipeline.report.page import glance_text
from pipeline.workflow.outcome import Outcome
from pipeline.workflow.pool_runs import result_file
from pipeline.workflow.run import Result

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
        yield f"{vehicle}: {what} {file.removesuffix('.html')}: {line}: {out / page}"
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
    for name in result.vehicles:
        try:
            path = out / processed_file(name, "vehicle_page")
            record = read_envelope(path, "vehicle_page", PageFile).record
        except InputError:
            continue
        if record is not None and record.glance is not None:
            yield glance_text(name, record.glance)
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
        yield f"{outcome.vehicle}: left out: {', '.join(titles)}.\n  {why}"


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
