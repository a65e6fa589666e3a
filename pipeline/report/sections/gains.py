"""What each thruster gives on each axis: on the pages of a run, a trial day and a vehicle."""

from collections.abc import Mapping, Sequence

from pipeline.language import as_it_is
from pipeline.records.gains import PooledGain, ThrusterGain, ThrusterGains
from pipeline.records.trial import RunTrial
from pipeline.report.bars import gains_figure
from pipeline.report.blocks import Block, Paragraph, Section, Table, not_computed
from pipeline.report.numbers import fixed
from pipeline.report.results import DayResults, VehicleResults

TITLE, ANCHOR = "What each thruster gives on each axis", "gains"
_ALL = "all"
_NOTE = (
    "1: the thruster moves the axis as the vehicle file says, 0: not at all, below 0: the other "
    "way. All: the one gain that fits all axes together. 95 % intervals; –: nothing to tell (no "
    "lever, not commanded, or only together with others)."
)
_DAYS = 6

Row = ThrusterGain | PooledGain


def run_gains_section(trial: RunTrial | None) -> Section:
    """Show the gains of one run.

    Parameters
    ----------
    trial : RunTrial or None
        The run against the model; None where the log could not be read.
    """
    if trial is None or trial.gains is None:
        why = "the log could not be read." if trial is None else trial.why_no_gains
        return not_computed(ANCHOR, TITLE, why)
    gains = trial.gains
    rows = {(row.thruster, row.axis): row for row in gains.gains if row.judged and row.moves}
    return Section(ANCHOR, TITLE, (*_blocks(gains, rows), *_delays(gains)))


def day_gains_section(results: DayResults) -> Section:
    """Show the gains of a day's runs together, against the last sound day where there is one."""
    gains = results.trial.gains
    if gains is None:
        return not_computed(ANCHOR, TITLE, results.trial.why_no_gains)
    pooled = results.compared or gains.pooled
    rows: dict[tuple[str, str], Row] = {
        (one.thruster, one.axis): one for one in pooled if one.moves
    }
    blocks = [*_blocks(gains, rows)]
    told = [one for one in gains.gains if one.axis == _ALL and one.judged]
    if len(gains.runs) > 1 and told:
        blocks.append(_by_run(gains, told))
    return Section(ANCHOR, TITLE, tuple(blocks))


def vehicle_gains_section(results: VehicleResults) -> Section:
    """Show what each thruster gave on each trial day, the latest last."""
    days = [day for day in results.trials if day.gains][-_DAYS:]
    if not days:
        return not_computed(ANCHOR, TITLE, "no trial day shows them.")
    cells = {(one.thruster, day.name): one for day in days for one in day.gains if one.axis == _ALL}
    names = list(dict.fromkeys(thruster.name for thruster in results.vehicle.thrusters))
    rows = [
        {"Thruster": as_it_is(name)} | {d.name: _cell(cells.get((name, d.name))) for d in days}
        for name in names
    ]
    caption = "Gain of each thruster on all axes together, by trial day"
    table = Table.of(caption, rows, note=_NOTE)
    latest = [cells[name, days[-1].name] for name in names if (name, days[-1].name) in cells]
    figure = gains_figure(
        "fig-gains",
        [(one.thruster, one.value, one.ci95) for one in latest],
        f"What each thruster gave on {days[-1].name}, the latest trial day, by a simple fit",
    )
    return Section(ANCHOR, TITLE, (figure, table))


def gain_warnings(gains: ThrusterGains | None) -> list[str]:
    """Return the findings that a page begins with.

    Parameters
    ----------
    gains : ThrusterGains or None
        Of a run or a day.
    """
    return [] if gains is None else [one.text for one in gains.findings]


def _blocks(gains: ThrusterGains, rows: Mapping[tuple[str, str], Row]) -> list[Block]:
    if not gains.runs:
        return [Paragraph(f"Not computed: {'; '.join(gains.why_no_run.values())}")]
    blocks: list[Block] = [Paragraph(one.text, tone="warning") for one in gains.findings]
    if not blocks:
        rate = f"{100 * gains.false_alarms:g} %"
        blocks.append(
            Paragraph(f"Nothing out of the ordinary (false alarms: {rate} of such sets).")
        )
    names = list(gains.runs[0].thrust_std_n)
    axes = dict.fromkeys(row.axis for row in gains.gains if row.axis != _ALL)
    shown = [_ALL, *(axis for axis in axes if any((name, axis) in rows for name in names))]
    told = [rows[name, _ALL] for name in names if (name, _ALL) in rows]
    if told:
        given = [(one.thruster, one.value, one.ci95) for one in told]
        lead = "What each thruster gives on all axes together, by a simple fit"
        blocks.append(gains_figure("fig-gains", given, lead))
    known = [one.reference for one in told if one.reference is not None]
    against = any(one.ratio is not None for one in known)
    cells = [
        {"Thruster": as_it_is(name)}
        | {axis: _cell(rows.get((name, axis))) for axis in shown}
        | ({f"Of what it gave in {as_it_is(known[0].name)}": _ratio(rows, name)} if against else {})
        for name in names
    ]
    blocks.append(Table.of("Gain of each thruster", cells, note=_NOTE))
    if gains.not_judged:
        why = "; ".join(f"{as_it_is(name)}: {why}" for name, why in gains.not_judged.items())
        blocks.append(Paragraph(f"Not judged: {why}."))
    return blocks


def _delays(gains: ThrusterGains) -> list[Block]:
    return [
        Paragraph(
            f"The commands act {fixed(run.delay_s, 2)} s later than the model's lag says.",
            tone="note",
        )
        for run in gains.runs
        if run.delay_s > 0.0
    ]


def _by_run(gains: ThrusterGains, told: Sequence[ThrusterGain]) -> Table:
    cells = {(one.run, one.thruster): one for one in told}
    rows = [
        {"Run": as_it_is(run.run)}
        | {name: _cell(cells.get((run.run, name))) for name in gains.runs[0].thrust_std_n}
        for run in gains.runs
    ]
    return Table.of("The same run by run, all axes together", rows)


def _cell(row: Row | None) -> str:
    return "–" if row is None else _bounded(row.value, row.ci95)


def _ratio(rows: Mapping[tuple[str, str], Row], name: str) -> str:
    row = rows.get((name, _ALL))
    known = None if row is None else row.reference
    return "–" if known is None else _bounded(known.ratio, known.ratio_ci95)


def _bounded(value: float | None, ends: tuple[float, float] | None) -> str:
    if value is None or ends is None:
        return "–"
    return f"{fixed(value, 2)} ({fixed(ends[0], 2)} to {fixed(ends[1], 2)})"
