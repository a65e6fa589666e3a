"""The page of one pool run: warnings first, then the run, its data, its comparison."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import PurePath

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.language import as_it_is
from pipeline.records.base import Glance
from pipeline.records.pool_run import ChannelSummary
from pipeline.records.run_arrays import MARKS
from pipeline.report import plotting
from pipeline.report.blocks import (
    Blocks,
    Bullets,
    Details,
    Figure,
    Gallery,
    Links,
    Table,
    Text,
    chapter,
    fold,
)
from pipeline.report.numbers import code, fixed, general, percent, plural
from pipeline.report.page import Labels, Page, counted
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.results import RunResults
from pipeline.report.sections.gains import run_gains_section
from pipeline.report.sections.inputs import note_block, problem_blocks
from pipeline.report.sections.run_comparison import (
    TIME_LABEL,
    comparison_section,
    resolution_of,
    with_worst_apart,
)
from pipeline.report.sections.tables import data_section
from pipeline.report.track import track_figure
from pipeline.report.zoomable import Axis, Panel, Span, Trace, zoomable_figure
from pipeline.vehicle.run_notes import run_of


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


#: A longer name does not stand beside a thruster's panel.
LONGEST_LABEL = 12

CLOCK_WORDS = {"header": "header stamp", "log": "log time", "field": "field of the message"}


@chapter("warnings", "Warnings")
def run_warnings_section(results: RunResults) -> Blocks:
    """Begin with what must be known before anything else is read."""
    if results.stored is None:
        reason = results.why_not_read or "the log could not be read."
        yield Text(f"Nothing could be read: {reason}", tone="error")
    trial = results.trial
    if trial is not None:
        for text in trial.warnings:
            yield Text(text, tone="warning")
        if trial.why_not:
            yield Text(f"Nothing was simulated: {trial.why_not}", tone="warning")
    if results.stored is not None:
        none = "No errors or warnings in the log."
        yield from problem_blocks("Problems in the log", results.all_problems, none)
    yield note_block(results.all_problems)


@chapter("run", "What the run was")
def run_facts_section(results: RunResults) -> Blocks:
    """Say what the run was: log, time, length, notes of those who were there."""
    stored = results.stored
    rows = [("Log", results.shown_path)]
    if stored is not None:
        start = datetime.fromtimestamp(stored.start_time_ns / 1e9, UTC)
        rows += [
            ("Start", f"{start:%Y-%m-%d %H:%M:%S} UTC"),
            ("Length", f"{fixed(stored.duration_s, 1)} s"),
            ("Size", f"{general(stored.size_bytes / 1e6, 3)} MB"),
            ("Recorder", stored.writer or "not stated"),
            ("Closed by the recorder", "yes" if stored.complete else "no: read as far as it goes"),
        ]
        # as they were written; what was left open is left out
        notes = (
            {} if stored.notes is None else stored.notes.model_dump(mode="json", exclude={"file"})
        )
        rows += [
            (f"Notes: {name.replace('_', ' ')}", text if value is True else as_it_is(text))
            for name, value in notes.items()
            if (text := _plain(value))
        ]
        rows += [
            (f"Log says: {name}", ", ".join(f"{k} {v}" for k, v in entries.items() if v)[:400])
            for name, entries in stored.metadata.items()
            if any(entries.values())
        ]
    yield Table("The run", ("What", "Value"), tuple(rows))
    if stored is not None and stored.notes is None:
        yield Text(
            f"No notes: write {run_of(PurePath(results.shown_path))}.yaml beside the log "
            "(ballast, water, tether, who, what) and they stand here.",
            tone="note",
        )
    yield Links(results.files) if results.files else None


def _plain(value: object) -> str:
    if value is None or value in ("", [], {}):
        return ""
    if isinstance(value, dict):
        return ", ".join(f"{k} {_plain(v)}" for k, v in value.items() if _plain(v))
    if isinstance(value, list):
        return "; ".join(_plain(one) for one in value)
    return ("no", "yes")[value] if isinstance(value, bool) else str(value)


@chapter("health", "Data health")
def run_health_section(results: RunResults) -> Blocks:
    """Show every channel with its rate, clock, gaps and marked readings, and every topic."""
    stored = results.stored
    if stored is None:
        raise CannotComputeError("the log could not be read.")

    def cells(channel: ChannelSummary) -> dict[str, str]:
        latency, marks = channel.clock.latency_s, sorted(channel.marks.items())
        return {
            "Channel": channel.name.replace("_", " "),
            "Topic": channel.read.topic,
            "Readings": str(channel.readings),
            "Rate [Hz]": general(channel.rate_hz, 3),
            "Longest gap [s]": general(channel.longest_gap_s, 3),
            "From [s]": fixed(channel.first_s, 1),
            "To [s]": fixed(channel.last_s, 1),
            "Clock": CLOCK_WORDS[channel.clock.used],
            "Latency [ms]": fixed(None if latency is None else 1e3 * latency, 1),
            "Marked": ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in marks) or "none",
        }

    yield Table.of(
        "Channels",
        stored.channels,
        cells,
        lambda one: max(one.marks.values(), default=0) > 0.01 * one.readings,
        note="Marked readings stay in the log as they are; those that cannot be trusted are not "
        "used in what follows, and nothing is filled in for them.",
    )
    seen = sorted({mark for channel in stored.channels for mark in channel.marks})
    remarks = [f"{mark.replace('_', ' ')}: {MARKS.get(mark, mark)}" for mark in seen]
    texts = (*remarks, *stored.notes_of_table)
    yield Bullets(texts) if texts else None
    topics = Table.of(
        "Topics",
        stored.topics,
        lambda topic: {
            "Topic": topic.topic,
            "Message": topic.message_type,
            "Encoding": topic.encoding,
            "Messages": str(topic.messages),
            "Used for": ", ".join(name.replace("_", " ") for name in topic.used_for)
            or topic.why_not
            or "not used",
        },
    )
    yield Details(f"{plural(len(stored.topics), 'topic')} in the log", (topics,))


@chapter("manoeuvres", "Commands and manoeuvres")
def manoeuvres_section(results: RunResults) -> Blocks:
    """List the manoeuvres found, and how long each thruster was at its limit."""
    limits = results.trial.commands_at_limit if results.trial is not None else {}
    found = Table.of(
        "Manoeuvres",
        results.manoeuvres,
        lambda one: {
            "Manoeuvre": manoeuvre_words(one.name),
            "From [s]": fixed(one.from_s, 1),
            "To [s]": fixed(one.to_s, 1),
            "What was seen": one.sentence,
        },
    )
    yield found if found.rows else Text("No manoeuvre was recognised.")
    if limits:
        shares = ", ".join(f"{name} {percent(share)}" for name, share in limits.items())
        yield Text(f"Share of the time at the end of the range of codes: {shares}.")


def commands_figure(results: RunResults) -> Figure | None:
    """Draw the commands, None where the log has none."""
    table = results.measured
    if table is None or "command" not in table.values or not table.valid["command"].any():
        return None
    thrusters = results.vehicle.thrusters
    command = np.where(table.valid["command"][:, None], table.values["command"], np.nan)
    names = table.thrusters or tuple(one.name for one in thrusters)
    drives = {one.name: results.vehicle.drives[one.drive] for one in thrusters}
    ends = {name: (float(one.code_min), float(one.code_max)) for name, one in drives.items()}
    # without thrusters in the vehicle file the names are those of the log
    time_s = table.time_s
    duration = float(time_s[-1]) if time_s.size else 1.0
    spans = tuple(
        Span(stretch.from_s, stretch.to_s, (plotting.BLUE, plotting.GREEN)[number % 2])
        for number, stretch in enumerate(results.manoeuvres)
    )
    panels = tuple(
        Panel(
            name if len(name) <= LONGEST_LABEL else f"{name[: LONGEST_LABEL - 1]}…",
            (Trace("commanded code", time_s, own, plotting.INK, "steps"),),
            height=0.62,
            y_range=(1.08 * ends[name][0], 1.08 * ends[name][1]) if name in ends else None,
            limits=ends.get(name, ()),
            spans=spans,
        )
        for name, own in zip(names, command.T, strict=True)
    )
    furthest = int(np.nanargmax(np.abs(command)))
    return zoomable_figure(
        "fig-commands",
        f"Commanded codes over {general(duration, 3)} s; {names[furthest % len(names)]} went "
        f"furthest, to {code(float(command.flat[furthest]))}.",
        "Commanded codes [–], one panel a thruster. Dotted: ends of the range, where the vehicle "
        "file gives it. Shaded: the manoeuvres of the table.",
        panels,
        x_label=TIME_LABEL,
        x_axis=Axis(ends=(0.0, duration)),
        resolution=resolution_of(results),
    )
