"""Trial days of a vehicle: their pages, and what was identified from one to the next."""

import textwrap
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
from markupsafe import Markup

from pipeline.language import as_it_is, translate
from pipeline.records.base import DayLine
from pipeline.records.identification import IdentifiedParameter, StraightLineIdentification
from pipeline.records.trial import PageReceipt, RunLine
from pipeline.report import plotting
from pipeline.report.blocks import Block, Blocks, Details, Figure, Heading, Links, Text, chapter
from pipeline.report.html import address_from
from pipeline.report.numbers import plural
from pipeline.report.page import SIGNS
from pipeline.report.results import VehicleResults
from pipeline.report.zoomable import Axis, Panel, Trace, zoomable_figure

#: Trial days shown in the open; older ones are folded away.
DAYS_SHOWN = 5


@chapter("trials", "Pool trials")
def trials_section(results: VehicleResults) -> Blocks:
    """List the trial days, the latest first, each with its runs."""
    if not results.trials:
        yield Text(
            "No pool run yet: put a log (*.mcap) into pool/ of the vehicle's raw folder. "
            "rig2sea watch writes its page as soon as the log is there whole."
        )
        return
    unsettled = [day.name for day in results.trials if not day.settled]
    days = {day.name: {one.name: one for one in day.parameters} for day in results.trials}
    trend = trend_blocks(days, unsettled)
    yield from (Heading(TREND_TITLE, "trend"), *trend) if trend else unsettled_days(unsettled)
    latest_first = [
        block for day in results.trials[::-1] for block in _day(day_line(day, results.page))
    ]
    yield from latest_first[: 2 * DAYS_SHOWN]
    older = tuple(latest_first[2 * DAYS_SHOWN :])
    yield Details(plural(len(older) // 2, "earlier trial day"), older) if older else None


def day_line(day: PageReceipt, page: Path) -> DayLine:
    """Name a trial day on a page, whose path is from the output folder."""

    def label(run: RunLine) -> str:
        said = run.line if run.glance is None else f"{run.glance.short}; {run.line}"
        return f"{as_it_is(run.name)}: {said}"

    return DayLine(
        name=day.name,
        title=day.title,
        line=day.line,
        href=address_from(page, day.address),
        runs=tuple((label(run), address_from(page, run.page)) for run in day.runs),
        glance=day.glance,
        lights=tuple("" if run.glance is None else run.glance.light for run in day.runs),
    )


def _day(day: DayLine) -> tuple[Heading, Links]:
    # piece by piece: the whole has too many parts to be found again for translation
    signs: dict[str, str] = {light: f"{sign} " for light, (sign, _) in SIGNS.items()}
    parts = [day.line] if day.glance is None else [day.glance.short, day.line]
    sign = signs.get(day.glance.light if day.glance else "", "")
    said = as_it_is(f"{sign}{translate(day.title)}: {'; '.join(map(translate, parts))}")
    runs = (
        (f"{signs.get(light, '')}{label}", address)
        for (label, address), light in zip(day.runs, day.lights, strict=True)
    )
    return Heading(day.title, f"day-{day.name}"), Links(((said, day.href), *runs))


def has_trend(results: VehicleResults) -> bool:
    """Whether two trial days or more have a fit that settled, so that the page shows a trend."""
    return sum(day.settled and bool(day.parameters) for day in results.trials) > 1


#: A longer line, or more of them, does not stand beside its panel.
LONGEST_LABEL, MOST_LINES = 14, 2

#: Names of days that stand side by side.
_MOST_NAMES = 12
#: The figure shows at most so many parameters; the tables of the days have all.
MOST_DRAWN = 24
TREND_TITLE = "Trend over the trial days"

Days = Mapping[str, Mapping[str, IdentifiedParameter]]


def trend_blocks(days: Days, unsettled: Collection[str] = ()) -> tuple[Block, ...]:
    """Return the figure of the latest day's parameters, nothing where no two days have a fit.

    `days` are in order of time; those without a fit are passed over. Those whose fit did not settle
    are named and take no part.
    """
    fitted = {day: own for day, own in days.items() if own and day not in unsettled}
    if len(fitted) < 2:
        return ()
    latest = list(next(reversed(fitted.values())))
    drawn = tuple(latest[:MOST_DRAWN])
    blocks: list[Block] = [_figure(fitted, drawn)]
    if len(latest) > len(drawn):
        blocks.append(Text(f"Not drawn: {', '.join(latest[MOST_DRAWN:])}."))
    return (*blocks, *unsettled_days(unsettled))


def unsettled_days(days: Collection[str]) -> tuple[Block, ...]:
    """Name the days that take no part in a trend; nothing where there are none."""
    if not days:
        return ()
    names = ", ".join(days)
    text = f"Of these trial days the fit did not come to an end, so no trend is shown: {names}."
    return (Text(text, tone="warning"),)


def _figure(days: Days, names: tuple[str, ...]) -> Figure:
    # an older day that tells the parameter is not the trial day before
    before, now = list(days.values())[-2:]
    moved = [o for o in names if o in before and o in now and apart(before[o], now[o])]
    lead = (
        f"Since the trial day before, {', '.join(moved)} moved out of the intervals."
        if moved
        else "No parameter's interval lies wholly outside that of the trial day before."
    )
    # names that could not be read side by side are left out; the last one stays
    step, last = -(-len(days) // _MOST_NAMES), len(days) - 1
    shown = tuple(day if (last - at) % step == 0 else "" for at, day in enumerate(days))
    return zoomable_figure(
        "fig-trend",
        lead,
        f"From above to below: {', '.join(name.replace('_', ' ') for name in names)}. Points and "
        "bars: value and 95 % interval of the day's fit. Grey line and band: the vehicle file's "
        "value and its 95 % range, as far as the axis reaches.",
        tuple(_panel(days, name) for name in names),
        x_label="trial day",
        x_axis=Axis(ends=(-0.4, len(days) - 0.6), names=shown),
    )


def _panel(days: Days, name: str) -> Panel:
    found = {float(at): own[name] for at, own in enumerate(days.values()) if name in own}
    ends = np.array([one.ci95 for one in found.values()]).T
    latest = list(found.values())[-1]
    # the axis is that of the values: the vehicle file's range may be far wider
    low = min(latest.prior_value, float(ends.min()))
    high = max(latest.prior_value, float(ends.max()))
    room = 0.12 * (high - low) or 1.0
    values, at = np.array([one.value for one in found.values()]), np.array(list(found))
    return Panel(
        f"{_in_lines(translate(name.replace('_', ' ')))}\n[{latest.unit.replace('^2', '²')}]",
        (Trace("value of the day", at, values, plotting.BLUE, "points", bars=ends),),
        height=0.9,
        band=1.96 * latest.prior_std,
        middle=latest.prior_value,
        y_range=(low - room, high + room),
    )


def _in_lines(words: str) -> str:
    r"""Break a name into lines; what does not fit is left out at its end.

    >>> _in_lines("linear damping heave")
    'linear damping\nheave'
    """
    return "\n".join(textwrap.wrap(words, LONGEST_LABEL, max_lines=MOST_LINES, placeholder="…"))


def apart(before: IdentifiedParameter, now: IdentifiedParameter) -> bool:
    """Whether the intervals of two days have nothing in common."""
    return before.ci95[1] < now.ci95[0] or now.ci95[1] < before.ci95[0]


def slope_figure(found: StraightLineIdentification) -> Markup:
    """Draw the points, the fitted slopes that stand, and that of the dry mass alone."""
    thrust, acceleration = np.array(found.points).reshape(-1, 2).T
    ends = np.array([thrust.min(), thrust.max()])
    lines = [("dry mass", found.dry_mass_kg, plotting.ORANGE)]
    lines += [
        (one.estimator, one.total_mass_kg, colour)
        for one, colour in (
            (found.plain[0], plotting.VERMILLION), (found.with_terms, plotting.BLUE),
        )
        if one is not None and not one.refused
    ]  # fmt: skip
    traces = [Trace("measured", thrust, acceleration, plotting.SOFT, "points")]
    for label, mass, colour in lines:
        level = acceleration.mean() + (ends - thrust.mean()) / mass
        traces.append(Trace(label, ends, level, colour))
    said = f"acceleration against thrust, {found.axis}, {len(found.segments)} straight stretches"
    panel = Panel("acceleration  [m/s²]", traces, height=2.0)
    return zoomable_figure("slope", "", said, [panel], x_label="thrust along the axis  [N]").svg
