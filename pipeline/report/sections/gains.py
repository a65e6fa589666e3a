"""What each thruster gives on each axis: on the pages of a run, a trial day and a vehicle."""

from collections.abc import Mapping

from pipeline.errors import CannotComputeError
from pipeline.language import as_it_is
from pipeline.records.gains import PooledGain, ThrusterGain, ThrusterGains
from pipeline.records.trial import RunTrial
from pipeline.report.bars import gains_figure
from pipeline.report.blocks import Blocks, Table, Text, chapter
from pipeline.report.numbers import fixed
from pipeline.report.results import DayResults, VehicleResults

_gains_chapter = chapter("gains", "What each thruster gives on each axis")
_ALL = "all"
_NOTE = (
    "1: the thruster moves the axis as the vehicle file says, 0: not at all, below 0: the other "
    "way. All: the one gain that fits all axes together. 95 % intervals; –: nothing to tell (no "
    "lever, not commanded, or only together with others)."
)
_DAYS = 6

Row = ThrusterGain | PooledGain


@_gains_chapter
def run_gains_section(trial: RunTrial | None) -> Blocks:
    """Show the gains of one run; None where the log could not be read."""
    if trial is None or trial.gains is None:
        why = "the log could not be read." if trial is None else trial.why_no_gains
        raise CannotComputeError(why)
    own = {(row.thruster, row.axis): row for row in trial.gains.gains if row.judged and row.moves}
    yield from _blocks(trial.gains, own)
    for run in trial.gains.runs:
        if run.delay_s > 0.0:
            late = f"The commands act {fixed(run.delay_s, 2)} s later than the model's lag says."
            yield Text(late, tone="note")


@_gains_chapter
def day_gains_section(results: DayResults) -> Blocks:
    """Show the gains of a day's runs together, against the last sound day where there is one."""
    gains = results.trial.gains
    if gains is None:
        raise CannotComputeError(results.trial.why_no_gains)
    pooled = results.compared or gains.pooled
    yield from _blocks(gains, {(one.thruster, one.axis): one for one in pooled if one.moves})
    cells = {(o.run, o.thruster): o for o in gains.gains if o.axis == _ALL and o.judged}
    if len(gains.runs) > 1 and cells:
        yield Table.of(
            "The same run by run, all axes together",
            gains.runs,
            lambda run: {
                "Run": as_it_is(run.run),
                **{name: _cell(cells.get((run.run, name))) for name in _names(gains)},
            },
        )


@_gains_chapter
def vehicle_gains_section(results: VehicleResults) -> Blocks:
    """Show what each thruster gave on each trial day, the latest last."""
    told = [day for day in results.trials if any(one.axis == _ALL for one in day.gains)]
    days = told[-_DAYS:]
    if not days:
        raise CannotComputeError("no trial day shows them.")
    cells = {(one.thruster, day.name): one for day in days for one in day.gains if one.axis == _ALL}
    names = list(dict.fromkeys(thruster.name for thruster in results.vehicle.thrusters))
    latest = [cells[name, days[-1].name] for name in names if (name, days[-1].name) in cells]
    yield gains_figure(
        "fig-gains",
        [(one.thruster, one.value, one.ci95) for one in latest],
        f"What each thruster gave on {days[-1].name}, the latest trial day, by a simple fit",
    )
    yield Table.of(
        "Gain of each thruster on all axes together, by trial day",
        names,
        lambda name: {
            "Thruster": as_it_is(name),
            **{day.name: _cell(cells.get((name, day.name))) for day in days},
        },
        note=_NOTE,
    )


def gain_warnings(gains: ThrusterGains | None) -> list[str]:
    """Return the findings that a page begins with."""
    return [] if gains is None else [one.text for one in gains.findings]


def _blocks(gains: ThrusterGains, rows: Mapping[tuple[str, str], Row]) -> Blocks:
    if not gains.runs:
        yield Text(f"Not computed: {'; '.join(gains.why_no_run.values())}")
        return
    for one in gains.findings:
        yield Text(one.text, tone="warning")
    if not gains.findings:
        rate = f"{100 * gains.false_alarms:g} %"
        yield Text(f"Nothing out of the ordinary (false alarms: {rate} of such sets).")
    names = _names(gains)
    axes = dict.fromkeys(row.axis for row in gains.gains if row.axis != _ALL)
    shown = [_ALL, *(axis for axis in axes if any((name, axis) in rows for name in names))]
    told = [rows[name, _ALL] for name in names if (name, _ALL) in rows]
    if told:
        given = [(one.thruster, one.value, one.ci95) for one in told]
        lead = "What each thruster gives on all axes together, by a simple fit"
        yield gains_figure("fig-gains", given, lead)
    known = [one.reference for one in told if one.reference is not None]
    against = any(one.ratio is not None for one in known)
    yield Table.of(
        "Gain of each thruster",
        names,
        lambda name: {
            "Thruster": as_it_is(name),
            **{axis: _cell(rows.get((name, axis))) for axis in shown},
            **(
                {f"Of what it gave in {as_it_is(known[0].name)}": _ratio(rows.get((name, _ALL)))}
                if against
                else {}
            ),
        },
        note=_NOTE,
    )
    if gains.not_judged:
        why = "; ".join(f"{as_it_is(name)}: {why}" for name, why in gains.not_judged.items())
        yield Text(f"Not judged: {why}.")


def _names(gains: ThrusterGains) -> list[str]:
    """Thrusters in the order of the vehicle file."""
    return list(dict.fromkeys(row.thruster for row in gains.gains))


def _cell(row: Row | None) -> str:
    return "–" if row is None else _bounded(row.value, row.ci95)


def _ratio(row: Row | None) -> str:
    known = None if row is None else row.reference
    return "–" if known is None else _bounded(known.ratio, known.ratio_ci95)


def _bounded(value: float | None, ends: tuple[float, float] | None) -> str:
    if value is None or ends is None:
        return "–"
    return f"{fixed(value, 2)} ({fixed(ends[0], 2)} to {fixed(ends[1], 2)})"
