"""The page of a planned pool day: what to fly, what it promises, what became of the last plan."""

from collections.abc import Sequence

from pipeline.language import as_it_is, translate
from pipeline.records.pool_day import FlownOfPlan, PoolDay
from pipeline.report import plotting
from pipeline.report.blocks import Block, Bullets, Details, Links, Section, Table
from pipeline.report.diagnosis_words import unit_text
from pipeline.report.html import render
from pipeline.report.numbers import general, plural
from pipeline.report.panels import Panel, Trace
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.zoomable import zoomable_figure
from pipeline.simulate.run import Trajectory


def plan_sentence(record: PoolDay) -> str:
    """Say the plan in one sentence."""
    reached = sum(one.reached for one in record.promises)
    names = ", ".join(manoeuvre_words(one.manoeuvre) for one in record.runs)
    return (
        f"Fly {plural(len(record.runs), 'run')}, {record.total_s / 60.0:.1f} minutes: {names}. "
        f"{reached} of {len(record.promises)} parameters will be known as well as wanted."
    )


def pool_day_page(
    record: PoolDay, flown: Sequence[FlownOfPlan], tracks: Sequence[Trajectory]
) -> str:
    """Return the page as HTML text; the same plan gives the same text."""
    promises: list[Block] = [_promises(record)]
    sections = [
        Section("runs", "What to fly", (_runs(record), _tracks(record, tracks))),
        Section("promises", "What it promises", tuple(promises)),
    ]
    if flown:
        texts = tuple(one.text for one in flown)
        sections.append(Section("last", "What became of the last plan", (Bullets(texts),)))
    items = [(f"{one.log}: to play", one.log) for one in record.runs]
    items += [(f"{one.codes}: codes over time", one.codes) for one in record.runs]
    sections.append(Section("files", "Files", (Links(tuple(items)),)))
    if record.left_out:
        left = Details("What does not fit", (Bullets(record.left_out),))
        sections.append(Section("left-out", "Left out", (left,)))
    shares = f"{100 * record.mean_share:.0f} %", f"{100 * record.usual_mean_share:.0f} %"
    return render(
        "answer.html.j2",
        title=f"The next pool day of {as_it_is(record.vehicle)}",
        under=(
            f"On average an interval shrinks to {shares[0]} of what it is now; the usual set of "
            f"the same length would shrink it to {shares[1]}."
        ),
        crumbs=(),
        sentence=plan_sentence(record).partition(": "),
        facts=record.notes,
        tone="good" if all(one.reached for one in record.promises) else "warning",
        sections=tuple(sections),
        assets="",
    )


def _runs(record: PoolDay) -> Table:
    rows = tuple(
        (
            str(one.number),
            manoeuvre_words(one.manoeuvre),
            f"{100 * one.amplitude:.0f} %",
            f"{one.duration_s:.0f}",
            " × ".join(f"{side:.1f}" for side in one.room_m),
            ", ".join(name.replace("_", " ") for name in one.what_for) or "all together",
        )
        for one in record.runs
    )
    return Table(
        "Runs in their order",
        ("No.", "Manoeuvre", "Size", "Length [s]", "Room needed [m]", "What it is for"),
        rows,
        text_columns=frozenset({1, 5}),
        note="Size: of the largest commands. Room: north × east × depth of the simulated track; "
        "turn the vehicle round to fit.",
    )


def _promises(record: PoolDay) -> Table:
    rows = tuple(
        (
            one.name.replace("_", " "),
            unit_text(one.unit),
            general(one.value),
            f"± {general(one.half_width_before, 2)}",
            f"± {general(one.half_width, 2)}",
            "yes" if one.reached else "no",
        )
        for one in record.promises
    )
    return Table(
        "95 % intervals now, and after the day",
        ("Parameter", "Unit", "Vehicle file", "Now", "After the day", "As wanted"),
        rows,
        text_columns=frozenset({1}),
    )


def _tracks(record: PoolDay, tracks: Sequence[Trajectory]) -> Block:
    colours = plotting.ordered_colours(len(tracks))
    panels = []
    for label, column in (("north  [m]", 0), ("east  [m]", 1), ("depth  [m]", 2)):
        traces = tuple(
            Trace(
                f"{run.number}. {translate(manoeuvre_words(run.manoeuvre))}",
                track.time_s[::10],
                track.position_ned_m[::10, column],
                colour,
            )
            for run, track, colour in zip(record.runs, tracks, colours, strict=True)
        )
        panels.append(Panel(label, traces))
    return zoomable_figure(
        "fig-tracks",
        "Where each run goes",
        "As simulated with the vehicle file, from the start of each run.",
        tuple(panels),
        x_label="time  [s]",
    )
