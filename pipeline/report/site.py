"""``reports/index.html``: the way to every page."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.records.glance import Glance
from pipeline.report.bench_results import vehicle_glance
from pipeline.report.glance import rank
from pipeline.report.html import FILTER, placed, render, safe_link, write_page
from pipeline.report.numbers import plural
from pipeline.report.page import SIGNS
from pipeline.report.results import (
    TrialDayLink,
    VehicleResults,
    all_checks,
    all_problems,
    missing_reasons,
)


@dataclass(frozen=True)
class Status:
    """How a vehicle's page stands, in counts."""

    errors: int
    warnings: int
    failed_checks: int = 0
    not_computed: int = 0

    @property
    def text(self) -> str:
        """One line for a person, e.g. ``2 warnings, 1 failed check``."""
        parts = [
            (self.errors, plural(self.errors, "error")),
            (self.warnings, plural(self.warnings, "warning")),
            (self.failed_checks, plural(self.failed_checks, "failed check")),
            (self.not_computed, f"{plural(self.not_computed, 'result')} not computed"),
        ]
        return ", ".join(text for count, text in parts if count) or "no warnings"

    @property
    def tone(self) -> str:
        """Colour class: error, warning or good."""
        if self.errors or self.failed_checks:
            return "error"
        return "warning" if self.warnings or self.not_computed else "good"


@dataclass(frozen=True)
class IndexEntry:
    """One line of the index; `href` is relative to the index."""

    title: str
    name: str
    href: str
    status: Status
    data_note: str = ""
    glance: Glance | None = None
    days: tuple[TrialDayLink, ...] = ()
    """Trial days, the latest first."""
    trend_href: str = ""
    """Address of the trends over the trial days; none where there are none."""
    diagnoses: tuple[tuple[str, str], ...] = ()
    """Label and address of the diagnoses, the latest first."""


def status_of(results: VehicleResults) -> Status:
    """Count what stands in the warnings of a vehicle's page."""
    problems = all_problems(results)
    return Status(
        errors=sum(problem.severity == "error" for problem in problems),
        warnings=sum(problem.severity == "warning" for problem in problems),
        failed_checks=sum(not check.passed for _, check in all_checks(results)),
        not_computed=len(missing_reasons(results)),
    )


def index_entry(results: VehicleResults, href: str) -> IndexEntry:
    """Make the line that leads to a vehicle's page; `href` from the index, not yet quoted."""
    return IndexEntry(
        title=results.vehicle.title,
        name=results.vehicle.name,
        href=safe_link(href),
        status=status_of(results),
        data_note=results.vehicle.data_note,
        glance=vehicle_glance(results),
    )


def worst_first(entries: Sequence[IndexEntry]) -> list[IndexEntry]:
    """Put the vehicles, and the days of each, in the order in which they ask for attention."""
    return [
        replace(entry, days=tuple(sorted(entry.days, key=lambda day: rank(day.glance))))
        for entry in sorted(entries, key=lambda entry: rank(entry.glance))
    ]


def write_index(
    pages: Sequence[IndexEntry],
    path: Path,
    diagnosed: Sequence[tuple[str, tuple[tuple[str, str], ...]]] = (),
    *,
    designs: Sequence[tuple[str, str]] = (),
    earlier: Sequence[tuple[str, str]] = (),
    assets: Path | None = None,
) -> None:
    """Write the index, with the vehicles that ask for attention first.

    `diagnosed` are vehicles that have diagnoses and no page of their own; `earlier` those that are
    gone or could not be run: their pages are left as they were. Without `assets`, the folder of the
    scripts, the list cannot be filtered. Raises as `write_page`.
    """
    text = render(
        "index.html.j2",
        pages=worst_first(pages),
        signs=SIGNS,
        diagnosed=diagnosed,
        designs=designs,
        earlier=earlier,
        assets=placed(assets, path),
        scripts=(FILTER,),
    )
    write_page(text, path)
