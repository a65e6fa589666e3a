"""Warnings first: what went wrong, where, and what to do about it."""

from collections.abc import Sequence

from pipeline.errors import Problem
from pipeline.records.fits import Check
from pipeline.report.blocks import Block, Blocks, Bullets, Details, Paragraph, Table, chapter
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


@chapter("warnings", "Warnings")
def warnings_section(results: VehicleResults) -> Blocks:
    """List problems by severity, failed checks and missing results; notes are folded away."""
    problems, checks, missing = all_problems(results), all_checks(results), missing_reasons(results)
    failed, passed = (
        [own for own in checks if own[1].passed is wanted] for wanted in (False, True)
    )
    none = "No errors or warnings in the raw files."
    yield from problem_blocks("Problems in the raw files", problems, none)
    if failed:
        yield _checks("Checks that failed", failed)
    elif checks:
        yield Paragraph(f"All {len(checks)} physical and numerical checks passed.")
    if missing:
        yield Table.of(
            "Results that could not be computed",
            missing.items(),
            lambda own: {"Result": STAGE_TITLES[own[0]], "Why": own[1]},
            lambda _: True,
        )
    if results.notes:
        yield Bullets(results.notes)
    yield note_block(problems)
    if passed:
        table = _checks("Checks that passed", passed)
        yield Details(f"{plural(len(passed), 'check')} passed", (table,))


def _checks(caption: str, checks: Sequence[tuple[str, Check]]) -> Table:
    return Table.of(
        caption,
        checks,
        "Result: {0} | Check: {1.name} | What was found: {1.text}",
        lambda own: not own[1].passed,
    )


def problem_blocks(caption: str, problems: Sequence[Problem], none: str) -> Blocks:
    """Tabulate errors and warnings, and list the places that the table counts."""
    serious = [problem for problem in problems if problem.severity != "note"]
    yield _problem_table(caption, serious, PLACES_SHOWN) if serious else Paragraph(none)
    for (_, what, _, _), places in _grouped(serious).items():
        if len(places) > PLACES_SHOWN:
            yield Details(f"All {len(places)} places: {what}", (Bullets(tuple(places)),))


def note_block(problems: Sequence[Problem]) -> Block | None:
    """Fold away what was assumed; nothing where there is nothing."""
    notes = [problem for problem in problems if problem.severity == "note"]
    table = _problem_table("Notes", notes, len(notes))
    return Details(f"{plural(len(notes), 'note')}: what was assumed", (table,)) if notes else None


def _problem_table(caption: str, problems: Sequence[Problem], shown: int) -> Table:
    """Group problems with the same message; places beyond those shown are counted."""
    return Table.of(
        caption,
        _grouped(problems).items(),
        lambda own: {
            "Severity": own[0][0],
            "Where": _places(own[1], shown),
            "What": own[0][1],
            "Expected": own[0][2] or "–",
            "What to do": own[0][3] or "–",
        },
        lambda own: own[0][0],
    )


def _grouped(problems: Sequence[Problem]) -> dict[tuple[str, str, str, str], list[str]]:
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
