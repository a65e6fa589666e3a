"""The page of a planned pool day: what to fly, what it promises, what became of the last plan."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from pipeline.language import as_it_is, translate
from pipeline.records.base import Advice, Glance
from pipeline.records.pool_day import FlownOfPlan, PlannedRun, PoolDay
from pipeline.report import plotting
from pipeline.report.blocks import (
    Blocks,
    Bullets,
    Figure,
    Links,
    Section,
    Table,
    Text,
    chapter,
    fold,
)
from pipeline.report.diagnosis_words import said
from pipeline.report.numbers import plural
from pipeline.report.page import Labels, Page
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.simulate.run import Trajectory


def plan_sentence(record: PoolDay) -> str:
    """Say the plan in one sentence."""
    reached = sum(one.reached for one in record.promises)
    times = Counter(said(manoeuvre_words(one.manoeuvre)) for one in record.runs)
    names = ", ".join(name if many == 1 else f"{many} x {name}" for name, many in times.items())
    return (
        f"Fly {plural(len(record.runs), 'run')}, {record.total_s / 60.0:.1f} minutes: {names}. "
        f"{reached} of {len(record.promises)} parameters will be known as well as wanted."
    )


def pool_day_page(
    record: PoolDay, flown: Sequence[FlownOfPlan], tracks: Sequence[Trajectory], *,
    crumbs: Labels = (), assets: str = "",
) -> str:  # fmt: skip
    """Return the page as HTML text; the same plan gives the same text."""
    items = [(f"{one.log}: to play", one.log) for one in record.runs]
    items += [(f"{one.codes}: codes over time", one.codes) for one in record.runs]
    left_out = Section("left-out", "What does not fit", (Bullets(record.left_out),))
    glance = plan_glance(record, flown)
    return Page(
        title=f"The next pool day of {as_it_is(record.vehicle)}",
        under=record.notes,
        sections=(
            _runs(record),
            _promises(record),
            fold(Section("files", "Files", (Links(tuple(items)),))),
            *([fold(left_out)] if record.left_out else []),
        ),
        glance=glance,
        word="Enough" if glance.light == "green" else "Not all",
        picture=_tracks(record, tracks),
        crumbs=crumbs,
        assets=assets,
    ).html()


def plan_glance(record: PoolDay, flown: Sequence[FlownOfPlan]) -> Glance:
    """Say first what is to be flown, what it will tell, and what became of the last plan."""
    vehicle, first = record.vehicle, record.runs[0]
    whole = all(one.reached for one in record.promises)
    put = f"Put what was recorded into raw/{as_it_is(vehicle)}/pool."
    do = [
        Advice(text="Play the logs in their order: the files are named below."),
        Advice(text=put, command=f"rig2sea run {vehicle}"),
    ]
    if not whole:
        more = f"rig2sea plan {vehicle} --minutes {2 * record.minutes:g}"
        do.append(Advice(text="Or fly for longer, to know all of them.", command=more))
    missed = [one for one in flown if one.log is None]
    last = "No plan was made before this one."
    if flown:
        names = ", ".join(said(manoeuvre_words(one.manoeuvre)) for one in missed)
        last = f"Of the last plan were flown {len(flown) - len(missed)} of {len(flown)}."
        last = f"{last} Not flown: {names}." if missed else last
    return Glance(
        light="green" if whole else "amber",
        matter=plan_sentence(record),
        short=f"{plural(len(record.runs), 'run')}, {record.total_s / 60.0:.1f} minutes",
        do=tuple(do),
        fly_next=f"{first.number}. {said(manoeuvre_words(first.manoeuvre))}: "
        f"{first.duration_s:.0f} s in {_room(first)} m (north × east × depth).",
        last_advice=last,
    )


def _room(run: PlannedRun) -> str:
    return " × ".join(f"{side:.1f}" for side in run.room_m)


@chapter("runs", "What to fly")
def _runs(record: PoolDay) -> Blocks:
    yield Table.of(
        "Runs in their order",
        record.runs,
        lambda one: {
            "Number": str(one.number),
            "Manoeuvre": manoeuvre_words(one.manoeuvre),
            "Size": f"{100 * one.amplitude:.0f} %",
            "Duration [s]": f"{one.duration_s:.0f}",
            "Room needed [m]": _room(one),
            "What it is for": ", ".join(name.replace("_", " ") for name in one.what_for)
            or "all together",
        },
        note="Size: of the largest commands. Room: north × east × depth of the simulated track; "
        "turn the vehicle round to fit.",
    )


@chapter("promises", "What it promises")
def _promises(record: PoolDay) -> Blocks:
    shares = f"{100 * record.mean_share:.0f} %", f"{100 * record.usual_mean_share:.0f} %"
    yield Text(
        f"On average an interval shrinks to {shares[0]} of what it is now; the usual set of the "
        f"same length would shrink it to {shares[1]}."
    )
    yield Table.of(
        "95 % intervals now, and after the day",
        record.promises,
        "Parameter: {name:words} | Unit: {unit:unit} | Vehicle file: {value:.3g} | "
        "Today: ± {half_width_before:.2g} | After the day: ± {half_width:.2g} | "
        "As wanted: {reached:yes}",
    )


def _tracks(record: PoolDay, tracks: Sequence[Trajectory]) -> Figure:
    colours = plotting.ordered_colours(len(tracks))
    names = [f"{one.number}. {translate(manoeuvre_words(one.manoeuvre))}" for one in record.runs]
    panels = []
    for label, column in (("north  [m]", 0), ("east  [m]", 1), ("depth  [m]", 2)):
        ways = [(one.time_s[::10], one.position_ned_m[::10, column]) for one in tracks]
        traces = tuple(
            Trace(name, *way, colour)
            for name, way, colour in zip(names, ways, colours, strict=True)
        )
        down = np.concatenate([way for _, way in ways])
        deep = (float(down.max()) + 0.2, float(down.min()) - 0.2) if column == 2 else None
        panels.append(Panel(label, traces, y_range=deep))
    return zoomable_figure(
        "fig-tracks",
        "Where each run goes",
        "As simulated with the vehicle file, from the start of each run.",
        tuple(panels),
        x_label="time  [s]",
    )
