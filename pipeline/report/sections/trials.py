"""The vehicle's page: where the pages of its trial days and pool runs are."""

from pipeline.language import as_it_is, translate
from pipeline.report.blocks import Block, Details, Heading, Links, Paragraph, Section
from pipeline.report.first_screen import SIGNS
from pipeline.report.numbers import plural
from pipeline.report.results import TrialDayLink, VehicleResults
from pipeline.report.sections.trend import TREND_TITLE, trend_blocks, unsettled_days

#: Trial days shown in the open; older ones are folded away.
DAYS_SHOWN = 5


def trials_section(results: VehicleResults) -> Section:
    """List the trial days, the latest first, each with its runs."""
    title = "Pool trials"
    if not results.trials:
        text = (
            "No pool run yet: put a log (*.mcap) into pool/ of the vehicle's raw folder. "
            "rig2sea watch writes its page as soon as the log is there whole."
        )
        return Section("trials", title, (Paragraph(text),))
    blocks: list[Block] = []
    unsettled = [day.name for day in results.trials if not day.settled]
    trend = trend_blocks(
        {day.name: {one.name: one for one in day.parameters} for day in results.trials}, unsettled
    )
    if trend:
        blocks += [Heading(TREND_TITLE, "trend"), *trend]
    else:
        blocks += unsettled_days(unsettled)
    latest_first = results.trials[::-1]
    for day in latest_first[:DAYS_SHOWN]:
        blocks += _day(day)
    older = latest_first[DAYS_SHOWN:]
    if older:
        blocks.append(
            Details(
                plural(len(older), "earlier trial day"),
                tuple(block for day in older for block in _day(day)),
            )
        )
    return Section("trials", title, tuple(blocks))


def _day(day: TrialDayLink) -> list[Block]:
    return [
        Heading(day.title, f"day-{day.name}"),
        Links(((_said(day), day.href), *_runs(day))),
    ]


def _said(day: TrialDayLink) -> str:
    # piece by piece: the whole has too many parts to be found again for translation
    sign = "" if day.glance is None else f"{SIGNS[day.glance.light][0]} "
    parts = [day.line] if day.glance is None else [day.glance.short, day.line]
    return as_it_is(f"{sign}{translate(day.title)}: {'; '.join(map(translate, parts))}")


def _runs(day: TrialDayLink) -> list[tuple[str, str]]:
    """Set the sign of each run before it, where it is known."""
    lights = [*day.lights, *([""] * len(day.runs))]
    signs: dict[str, str] = {light: f"{sign} " for light, (sign, _) in SIGNS.items()}
    return [
        (f"{signs.get(light, '')}{label}", address)
        for (label, address), light in zip(day.runs, lights, strict=False)
    ]


def has_trend(results: VehicleResults) -> bool:
    """Whether two trial days or more have a fit that settled, so that the page shows a trend."""
    return sum(day.settled and bool(day.parameters) for day in results.trials) > 1
