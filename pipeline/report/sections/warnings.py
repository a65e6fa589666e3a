"""Warnings first: what went wrong, where, and what to do about it."""

from collections.abc import Iterable, Sequence

from pipeline.errors import Problem
from pipeline.records.fits import Check
from pipeline.report.blocks import Block, Bullets, Details, Paragraph, Section, Table
from pipeline.report.numbers import plural
from pipeline.report.results import (
    STAGE_TITLES,
    VehicleResults,
    all_checks,
    all_problems,
    missing_reasons,
)

#: More places than this with the same message are counted instead of listed in the first table.
PLACES_SHOWN = 4


def warnings_section(results: VehicleResults) -> Section:
    """List problems by severity, failed checks and missing results; notes are folded away."""
    problems = all_problems(results)
    serious = [problem for problem in problems if problem.severity != "note"]
    notes = [problem for problem in problems if problem.severity == "note"]
    checks = all_checks(results)
    failed = [(stage, check) for stage, check in checks if not check.passed]
    missing = missing_reasons(results)
    blocks: list[Block] = (
        problem_blocks("Problems in the raw files", serious)
        if serious
        else [Paragraph("No errors or warnings in the raw files.")]
    )
    if failed:
        blocks.append(_checks("Checks that failed", failed, "warning"))
    elif checks:
        blocks.append(Paragraph(f"All {len(checks)} physical and numerical checks passed."))
    if missing:
        rows = [{"Result": STAGE_TITLES[stage], "Why": why} for stage, why in missing.items()]
        marked = ("warning",) * len(rows)
        table = Table.of("Results that could not be computed", rows, row_classes=marked)
        blocks.append(table)
    if results.notes:
        blocks.append(Bullets(results.notes))
    blocks += note_blocks(notes)
    passed = [(stage, check) for stage, check in checks if check.passed]
    if passed:
        table = _checks("Checks that passed", passed)
        blocks.append(Details(f"{plural(len(passed), 'check')} passed", (table,)))
    return Section("warnings", "Warnings", tuple(blocks))


def _checks(caption: str, checks: Sequence[tuple[str, Check]], mark: str = "") -> Table:
    rows = [{"Result": of, "Check": one.name, "What was found": one.text} for of, one in checks]
    return Table.of(caption, rows, row_classes=(mark,) * len(rows))


def problem_blocks(caption: str, problems: Sequence[Problem]) -> list[Block]:
    """Tabulate errors and warnings, and list the places that the table counts."""
    return [problem_table(caption, problems), *_all_places(problems)]


def note_blocks(notes: Sequence[Problem]) -> list[Block]:
    """Fold away what was assumed; nothing where there is nothing."""
    if not notes:
        return []
    table = problem_table("Notes", notes, every_place=True)
    return [Details(f"{plural(len(notes), 'note')}: what was assumed", (table,))]


def problem_table(caption: str, problems: Iterable[Problem], *, every_place: bool = False) -> Table:
    """Group problems with the same message; places beyond a few are counted."""
    groups = _grouped(problems)
    rows = [
        {
            "Severity": severity,
            "Where": _places(places, len(places) if every_place else PLACES_SHOWN),
            "What": what,
            "Expected": expected or "–",
            "What to do": remedy or "–",
        }
        for (severity, what, expected, remedy), places in groups.items()
    ]
    return Table.of(caption, rows, row_classes=tuple(severity for severity, *_ in groups))


def _grouped(problems: Iterable[Problem]) -> dict[tuple[str, str, str, str], list[str]]:
    groups: dict[tuple[str, str, str, str], list[str]] = {}
    for problem in problems:
        key = (problem.severity, problem.what, problem.expected, problem.remedy)
        groups.setdefault(key, []).append(str(problem.place))
    return groups


def _places(places: list[str], shown: int) -> str:
    if len(places) == 1:
        return places[0]
    if len(places) <= shown:
        return f"each of {'; '.join(places)}"
    return f"each of {'; '.join(places[:shown])}; and {len(places) - shown} more, listed below"


def _all_places(problems: Iterable[Problem]) -> list[Block]:
    """List, folded away, the places that `problem_table` counts instead of naming."""
    long = {key: places for key, places in _grouped(problems).items() if len(places) > PLACES_SHOWN}
    return [
        Details(f"All {len(places)} places: {what}", (Bullets(tuple(places)),))
        for (_, what, _, _), places in long.items()
    ]
