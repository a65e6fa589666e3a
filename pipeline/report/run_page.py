"""The page of one pool run: warnings first, then the run, its data, its comparison."""

from pathlib import Path

from pipeline.language import as_it_is
from pipeline.records.trial import ChannelError
from pipeline.report.assets import placed
from pipeline.report.blocks import Section
from pipeline.report.html import render, write_page
from pipeline.report.numbers import fixed, general, plural
from pipeline.report.run_results import RunResults
from pipeline.report.sections.gains import run_gains_section
from pipeline.report.sections.run_comparison import commands_figure, comparison_section
from pipeline.report.sections.run_health import (
    manoeuvres_section,
    run_facts_section,
    run_health_section,
    run_warnings_section,
)
from pipeline.report.sections.tables import provenance_table


def run_page(results: RunResults, crumbs: tuple[tuple[str, str], ...], assets: str = "") -> str:
    """Return the page as HTML text; the same results give the same text.

    Parameters
    ----------
    results : RunResults
        What is known of the run.
    crumbs : tuple of (label, address)
        The way back, relative to the page.
    assets : str
        Address of the folder with the scripts, relative to the page; none without.
    """
    manoeuvres = manoeuvres_section(results)
    figure = commands_figure(results)
    if figure is not None:
        manoeuvres = Section(
            manoeuvres.anchor, manoeuvres.title, (*manoeuvres.blocks, figure), manoeuvres.available
        )
    sections = (
        run_warnings_section(results),
        run_facts_section(results),
        run_health_section(results),
        manoeuvres,
        comparison_section(results),
        run_gains_section(results.trial),
        Section("provenance", "Provenance", (provenance_table(results.provenance),)),
    )
    return render(
        "trial.html.j2",
        title=f"Run {as_it_is(results.run)}",
        under=(f"{as_it_is(results.vehicle.title)}: a pool run",),
        data_note=results.vehicle.data_note,
        crumbs=crumbs,
        status=status_text(results.errors, results.warnings),
        tone=tone(results.errors, results.warnings),
        sections=sections,
        assets=assets,
    )


def write_run_page(
    results: RunResults,
    path: Path,
    crumbs: tuple[tuple[str, str], ...],
    assets: Path | None = None,
) -> None:
    """Write the page, whole or not at all, and the scripts in `assets`; raises `InputError`."""
    write_page(run_page(results, crumbs, placed(assets, path)), path)


def status_text(errors: int, warnings: int) -> str:
    """Say how a page stands.

    >>> status_text(0, 2), status_text(0, 0)
    ('2 warnings', 'no warnings')
    """
    parts = [plural(errors, "error")] if errors else []
    parts += [plural(warnings, "warning")] if warnings else []
    return ", ".join(parts) or "no warnings"


def tone(errors: int, warnings: int) -> str:
    """Return the colour class of a page's status."""
    return "error" if errors else "warning" if warnings else "good"


def run_line(results: RunResults) -> str:
    """Say in one line what other pages say of the run."""
    stored, trial = results.stored, results.trial
    if stored is None:
        return "the log could not be read"
    parts = [f"{fixed(stored.duration_s, 0)} s"]
    if stored.notes is not None and stored.notes.what:
        parts.insert(0, as_it_is(stored.notes.what[:120]))
    if trial is not None and trial.manoeuvres:
        names = dict.fromkeys(stretch.name.replace("_", " ") for stretch in trial.manoeuvres)
        parts.append(", ".join(names))
    if trial is not None and trial.channels:
        ratios = [(one.over_noise, _channel(one)) for one in trial.channels if one.over_noise]
        if ratios:
            worst, channel = max(ratios)
            parts.append(f"largest error {general(worst, 2)} times the noise ({channel})")
    elif trial is not None:
        parts.append("not simulated")
    parts.append(status_text(results.errors, results.warnings))
    return "; ".join(parts)


def _channel(one: ChannelError) -> str:
    """Name a channel where nothing else says which quantity it is of."""
    return f"shaft speed {one.channel}" if one.quantity == "shaft_speed" else one.channel
