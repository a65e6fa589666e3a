"""The page of one pool run: warnings first, then the run, its data, its comparison."""

from dataclasses import replace

from pipeline.language import as_it_is
from pipeline.records.glance import Glance
from pipeline.report.blocks import Figure, Gallery, Paragraph, Section, fold
from pipeline.report.numbers import fixed
from pipeline.report.page import Page
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.results import DayResults, RunResults, VehicleResults
from pipeline.report.sections.gains import run_gains_section
from pipeline.report.sections.run_comparison import (
    comparison_section,
    with_worst_apart,
)
from pipeline.report.sections.run_health import (
    commands_figure,
    manoeuvres_section,
    run_facts_section,
    run_health_section,
    run_warnings_section,
)
from pipeline.report.sections.tables import provenance_table
from pipeline.report.site import Status
from pipeline.report.track import track_figure


def run_page(
    results: RunResults,
    crumbs: tuple[tuple[str, str], ...],
    assets: str = "",
    glance: Glance | None = None,
) -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    manoeuvres, comparison = manoeuvres_section(results), comparison_section(results)
    shown, picture = commands_figure(results), track_figure(results)
    comparison, worst = with_worst_apart(comparison, results)
    beside = tuple(one for one in (shown, worst) if one is not None)
    if beside:
        blocks = (*manoeuvres.blocks, Gallery(beside, level=False))
        manoeuvres = replace(manoeuvres, blocks=blocks)
    sections = (
        *_if_serious(results),
        manoeuvres,
        fold(comparison),
        fold(run_gains_section(results.trial)),
        fold(run_facts_section(results)),
        fold(run_health_section(results)),
        *(() if _if_serious(results) else (fold(run_warnings_section(results)),)),
        fold(data_section(results)),
    )
    return Page(
        title=f"Run {as_it_is(results.run)}",
        under=(f"{as_it_is(results.vehicle.title)}: a pool run",),
        data_note=results.vehicle.data_note,
        crumbs=crumbs,
        glance=glance,
        picture=picture,
        sections=sections,
        assets=assets,
    ).html()


def _if_serious(results: RunResults) -> tuple[Section, ...]:
    """Return the warnings in the open where there are any."""
    return (run_warnings_section(results),) if results.errors or results.warnings else ()


def first_figure(section: Section) -> Figure | None:
    """Return the first picture of a section."""
    return next((one for one in section.blocks if isinstance(one, Figure)), None)


def data_section(results: RunResults | DayResults | VehicleResults) -> Section:
    """Say what a page was made from."""
    none = Paragraph("No provenance was recorded.")
    shown = provenance_table(results.provenance) if results.provenance else none
    return Section("provenance", "Provenance", (shown,))


def status_text(errors: int, warnings: int) -> str:
    """Say how a page stands.

    >>> status_text(0, 2), status_text(0, 0)
    ('2 warnings', 'no warnings')
    """
    return Status(errors, warnings).text


def run_line(results: RunResults) -> str:
    """Say in one line what other pages say of the run."""
    stored, trial = results.stored, results.trial
    if stored is None:
        return "the log could not be read"
    parts = [f"{fixed(stored.duration_s, 0)} s"]
    if stored.notes is not None and stored.notes.what:
        parts.insert(0, as_it_is(stored.notes.what[:120]))
    if trial is not None and trial.manoeuvres:
        names = dict.fromkeys(manoeuvre_words(stretch.name) for stretch in trial.manoeuvres)
        parts.append(", ".join(names))
    if trial is not None and not trial.channels:
        parts.append("not simulated")
    parts.append(status_text(results.errors, results.warnings))
    return "; ".join(parts)
