"""The page of one trial day: warnings, runs, identified parameters and their trend, the tables."""

from dataclasses import replace

from pipeline.language import as_it_is
from pipeline.records.identification import IdentifiedParameter
from pipeline.records.trial import PageReceipt, TrialDay
from pipeline.report.blocks import (
    Block,
    Bullets,
    Details,
    Links,
    Paragraph,
    Section,
    Table,
    fold,
)
from pipeline.report.day_results import ALIKE_CODES, DayResults, table_changes
from pipeline.report.diagnosis_words import unit_text
from pipeline.report.first_screen import SIGNS
from pipeline.report.glance import rank
from pipeline.report.numbers import fixed, general, plural, speed, with_interval
from pipeline.report.page import Page
from pipeline.report.run_page import data_section, first_figure
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.sections.gains import day_gains_section, gain_warnings
from pipeline.report.sections.trend import TREND_TITLE, apart, trend_blocks, unsettled_days

#: Said instead of any comparison of such a fit.
_UNSETTLED = "The fit did not come to an end: do not use its values."


def day_page(results: DayResults, crumbs: tuple[tuple[str, str], ...], assets: str = "") -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    faults = results.diagnosis.findings[:1] if results.diagnosis is not None else ()
    picture = finding_figure(faults[0]) if faults else None
    gains = day_gains_section(results)
    if picture is None:
        picture = first_figure(gains)
        gains = replace(gains, blocks=tuple(one for one in gains.blocks if one is not picture))
    serious = bool(sum(day_counts(results)))
    warnings = _warnings(results)
    sections = (
        _runs(results),
        warnings if serious else fold(warnings),
        _trend(results),
        fold(gains),
        fold(_identified(results)),
        fold(_quality(results)),
        fold(_tables(results)),
        fold(data_section(results)),
    )
    return Page(
        title=f"Trial day {results.day}",
        under=(f"{as_it_is(results.vehicle.title)}: {plural(len(results.runs), 'pool run')}",),
        data_note=results.vehicle.data_note,
        crumbs=crumbs,
        glance=results.glance,
        picture=picture,
        sections=sections,
        assets=assets,
    ).html()


def day_counts(results: DayResults) -> tuple[int, int]:
    """Count errors (of the runs) and warnings (of the runs and of the day)."""
    errors = sum(run.errors for run in results.runs)
    return errors, sum(run.warnings for run in results.runs) + len(day_warnings(results))


def day_warnings(results: DayResults) -> tuple[str, ...]:
    """Return what must be known of the day before anything else."""
    found = []
    trial = results.trial
    if trial.broken:
        found.append(f"Not read: {', '.join(trial.broken)}. The pages of the runs say why.")
    if trial.why_not and results.vehicle.model is not None:
        found.append(f"No parameters were identified: {trial.why_not}")
    found += gain_warnings(trial.gains)
    fit = trial.identification
    if fit is not None and not fit.converged:
        found.append(_UNSETTLED)
    elif fit is not None:
        before = _latest(results)
        if before is not None:
            day, parameters = before
            moved = [
                _words(one)
                for one in fit.parameters
                if one.identified and one.name in parameters and apart(parameters[one.name], one)
            ]
            if moved:
                found.append(
                    f"{', '.join(moved)}: outside the intervals of {day}. Was something changed "
                    "on the vehicle (ballast, payload, propeller)?"
                )
        off = [_words(one) for one in fit.parameters if one.identified and _against_file(one)]
        if off:
            found.append(f"By this day's fit the vehicle file is off in: {', '.join(off)}.")
    return tuple(found)


def _words(one: IdentifiedParameter) -> str:
    return one.name.replace("_", " ")


def _against_file(one: IdentifiedParameter) -> bool:
    low, high = one.ci95
    return not low <= one.prior_value <= high


def _latest(results: DayResults) -> tuple[str, dict[str, IdentifiedParameter]] | None:
    """Return the latest day before that the day can be compared with; None where it cannot be."""
    if not results.trial.settled:
        return None
    for day, trial in reversed(list(results.earlier.items())):
        if trial.identification is not None and trial.settled:
            return day, _parameters(trial)
    return None


def _parameters(trial: TrialDay) -> dict[str, IdentifiedParameter]:
    fit = trial.identification
    return {} if fit is None else {one.name: one for one in fit.parameters if one.identified}


def _warnings(results: DayResults) -> Section:
    texts = day_warnings(results)
    blocks: list[Block] = [Paragraph(text, tone="warning") for text in texts]
    errors = [as_it_is(run.name) for run in results.runs if run.errors]
    if errors:
        blocks.insert(
            0, Paragraph(f"Runs with errors: {', '.join(errors)}. See their pages.", tone="error")
        )
    warned = [f"{as_it_is(run.name)} ({run.warnings})" for run in results.runs if run.warnings]
    if warned:
        blocks.append(Paragraph(f"Warnings on the pages of single runs: {', '.join(warned)}."))
    if not blocks:
        blocks.append(Paragraph("No warnings."))
    return Section("warnings", "Warnings", tuple(blocks))


def _runs(results: DayResults) -> Section:
    items = tuple(
        (_run_label(run), results.links[run.name])
        for run in sorted(results.runs, key=lambda one: rank(one.glance))
        if run.name in results.links
    )
    return Section("runs", "Runs of the day", (Links(items),))


def _run_label(run: PageReceipt) -> str:
    if run.glance is None:
        return f"{as_it_is(run.name)}: {run.line}"
    sign, _ = SIGNS[run.glance.light]
    return f"{sign} {as_it_is(run.name)}: {run.glance.short}; {run.line}"


def _identified(results: DayResults) -> Section:
    title = "Mass, damping and buoyancy from these runs"
    trial, fit = results.trial, results.trial.identification
    used: list[Block] = []
    if trial.used:
        used.append(
            Table(
                "What the fit was made from",
                ("Run", "From [s]", "To [s]", "Change of the commands"),
                tuple(
                    (one.run, fixed(one.from_s, 0), fixed(one.to_s, 0), general(one.excitation, 2))
                    for one in trial.used
                ),
                verbatim_columns=frozenset({0}),
                note="The stretches whose commands change most are taken, up to a total that "
                "keeps the report quick. Change: root mean square over the thrusters, share of "
                "the range. rig2sea identify takes whole runs.",
            )
        )
    if trial.passed_over:
        used.append(Details("Runs that were not used", (Bullets(trial.passed_over),)))
    if fit is None:
        reason = trial.why_not or "no fit was made."
        blocks: tuple[Block, ...] = (Paragraph(f"Not computed: {reason}", tone="warning"), *used)
        return Section("identified", title, blocks, available=False)
    before = _latest(results)
    day, old = before if before is not None else ("", {})
    rows, classes = [], []
    for one in fit.parameters:
        if not one.identified:
            continue
        value, interval = with_interval(one.value, one.ci95)
        row = [one.meaning, unit_text(one.unit), value, interval, general(one.prior_value, 3)]
        if before is not None:
            row.append(general(old[one.name].value, 3) if one.name in old else "–")
        rows.append(tuple(row))
        moved = one.name in old and apart(old[one.name], one)
        classes.append("warning" if fit.converged and (moved or _against_file(one)) else "")
    header = ("What it is", "Unit", "Value", "95 % interval", "Vehicle file")
    table = Table(
        "What the day's runs say of the vehicle",
        (*header, day) if before is not None else header,
        tuple(rows),
        row_classes=tuple(classes),
        note="Marked: the interval does not hold the vehicle file's value, or has nothing in "
        "common with that of the trial day before."
        if fit.converged
        else "",
    )
    none = Paragraph("These runs determine none of the parameters.")
    more: list[Block] = [] if fit.converged else [Paragraph(_UNSETTLED, tone="warning")]
    more.append(table if rows else none)
    if fit.cannot_identify:
        more.append(
            Details(
                f"{plural(len(fit.cannot_identify), 'value')} of which these runs say nothing",
                (Bullets(fit.cannot_identify),),
            )
        )
    if fit.notes or trial.notes:
        more.append(Bullets((*fit.notes, *trial.notes)))
    return Section("identified", title, (*more, *used))


def _trend(results: DayResults) -> Section:
    days = {day: _parameters(trial) for day, trial in results.earlier.items()}
    days[results.day] = _parameters(results.trial)
    every = {**results.earlier, results.day: results.trial}
    unsettled = [day for day, trial in every.items() if not trial.settled]
    blocks = trend_blocks(days, unsettled)
    if not blocks:
        text = (
            "A trend needs two trial days with a fit; there is one so far."
            if any(own for day, own in days.items() if day not in unsettled)
            else "A trend needs two trial days with a fit; there is none so far."
        )
        left_out = unsettled_days(unsettled)
        return Section("trend", TREND_TITLE, (Paragraph(text), *left_out), available=False)
    return Section("trend", TREND_TITLE, blocks)


def _quality(results: DayResults) -> Section:
    title = "Prediction of data that were not used for the fit"
    fit = results.trial.identification
    if fit is None or not fit.quality:
        text = (
            "Not computed: there is no fit to judge."
            if fit is None
            else "Not computed: nothing was left to judge the fit by."
        )
        return Section("quality", title, (Paragraph(text, tone="warning"),), available=False)

    def number(value: float | None) -> str:
        return "–" if value is None else general(value, 3)

    return Section(
        "quality",
        title,
        (
            Table.of(
                f"Root mean square errors over {general(fit.quality[0].horizon_s, 2)} s",
                [
                    {
                        "Channel": one.channel.replace("_", " "),
                        "Unit": one.unit,
                        "Readings": str(one.readings),
                        "Sensor noise": general(one.sensor_noise, 2),
                        "Fit": number(one.rmse_identified),
                        "Corrected file": number(one.rmse_corrected_file),
                        "Vehicle file": number(one.rmse_vehicle_file),
                        "Last value kept": number(one.rmse_last_value),
                        "Plain linear model": number(one.rmse_black_box),
                    }
                    for one in fit.quality
                ],
                note="A model earns its place where it beats both baselines on the right. The "
                "corrected file has the parameters found, but not the thrust that was fitted "
                "beside them. Sensor noise: of one reading, without the sensor's offset, which "
                "was estimated and taken off; pages of runs show both together.",
            ),
        ),
    )


def _tables(results: DayResults) -> Section:
    title = "Thruster tables since the trial day before"
    now, before = results.tables, results.tables_before
    if now is None or now.why_not:
        reason = now.why_not if now is not None else "they were not kept."
        text = f"There are no tables: {reason}"
        return Section("tables", title, (Paragraph(text, tone="warning"),), available=False)
    if before is None or before.why_not:
        text = "No tables of an earlier trial day are on record; the history begins with these."
        return Section("tables", title, (Paragraph(text),))
    if before.tables_sha256 == now.tables_sha256:
        text = f"The tables are those of {before.day}: not one code differs."
        return Section("tables", title, (Paragraph(text),))
    changes = table_changes(before, now)
    worst = max(changes, key=lambda one: one.largest_codes, default=None)
    if worst is None:
        text = f"The tables of {before.day} and of this day have no thrust in common."
        return Section("tables", title, (Paragraph(text, tone="warning"),))
    lead = (
        f"Since {before.day} codes changed by up to {general(worst.largest_codes, 2)}, at "
        f"{fixed(worst.at_thrust_n, 1)} N and {speed(worst.speed_mps)} m/s."
        if worst.largest_codes >= ALIKE_CODES
        else f"Since {before.day} no code changed by more than {ALIKE_CODES:g}."
    )
    return Section(
        "tables",
        title,
        (
            Paragraph(lead),
            Table(
                "Change of the code for a thrust",
                ("Speed [m/s]", "Largest [codes]", "At [N]", "Mean [codes]", "Thrusts compared"),
                tuple(
                    (
                        speed(one.speed_mps),
                        general(one.largest_codes, 2),
                        fixed(one.at_thrust_n, 1),
                        general(one.mean_codes, 2),
                        str(one.thrusts),
                    )
                    for one in changes
                ),
            ),
        ),
    )
