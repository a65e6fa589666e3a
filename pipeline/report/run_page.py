"""The page of one pool run: warnings first, then the run, its data, its comparison."""

from dataclasses import replace

from pipeline.language import as_it_is
from pipeline.records.base import Glance
from pipeline.report.blocks import Gallery, fold
from pipeline.report.numbers import fixed
from pipeline.report.page import Labels, Page, counted
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.results import RunResults
from pipeline.report.sections.gains import run_gains_section
from pipeline.report.sections.run_comparison import comparison_section, with_worst_apart
from pipeline.report.sections.run_health import (
    commands_figure,
    manoeuvres_section,
    run_facts_section,
    run_health_section,
    run_warnings_section,
)
from pipeline.report.sections.tables import data_section
from pipeline.report.track import track_figure


def run_page(
    results: RunResults, crumbs: Labels, assets: str = "", glance: Glance | None = None
) -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    manoeuvres = manoeuvres_section(results)
    comparison, worst = with_worst_apart(comparison_section(results), results)
    beside = tuple(one for one in (commands_figure(results), worst) if one is not None)
    if beside:
        blocks = (*manoeuvres.blocks, Gallery(beside, level=False))
        manoeuvres = replace(manoeuvres, blocks=blocks)
    # in the open where there are any
    serious, warnings = results.errors or results.warnings, run_warnings_section(results)
    return Page(
        title=f"Run {as_it_is(results.run)}",
        under=(f"{as_it_is(results.vehicle.title)}: a pool run",),
        data_note=results.vehicle.data_note,
        crumbs=crumbs,
        glance=glance,
        picture=track_figure(results),
        sections=(
            *((warnings,) if serious else ()),
            manoeuvres,
            fold(comparison),
            fold(run_gains_section(results.trial)),
            fold(run_facts_section(results)),
            fold(run_health_section(results)),
            *(() if serious else (fold(warnings),)),
            fold(data_section(results)),
        ),
        assets=assets,
    ).html()


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
    return "; ".join([*parts, counted(results.errors, results.warnings)])
