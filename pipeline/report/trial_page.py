"""The page of one trial day: warnings, runs, identified parameters and their trend, the tables."""

from collections.abc import Mapping
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
    not_computed,
)
from pipeline.report.diagnosis_words import unit_text
from pipeline.report.glance import rank
from pipeline.report.numbers import fixed, general, plural, speed, with_interval
from pipeline.report.page import SIGNS, Page
from pipeline.report.results import ALIKE_CODES, DayResults, table_changes
from pipeline.report.run_page import data_section, first_figure
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.sections.gains import day_gains_section, gain_warnings
from pipeline.report.sections.trials import TREND_TITLE, apart, trend_blocks, unsettled_days

#: Said instead of any comparison of such a fit.
_UNSETTLED = "The fit did not come to an end: do not use its values."


def day_page(results: DayResults, crumbs: tuple[tuple[str, str], ...], assets: str = "") -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    findings = results.diagnosis.findings if results.diagnosis is not None else ()
    picture = finding_figure(findings[0]) if findings else None
    gains = day_gains_section(results)
    if picture is None:
        picture = first_figure(gains)
        gains = replace(gains, blocks=tuple(one for one in gains.blocks if one is not picture))
    warnings = _warnings(results)
    sections = (
        _runs(results),
        warnings if sum(day_counts(results)) else fold(warnings),
        _trend(results),
        fold(gains),
        fold(_fit(results)),
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
    trial, fit = results.trial, results.trial.identification
    if trial.broken:
        found.append(f"Not read: {', '.join(trial.broken)}. The pages of the runs say why.")
    if trial.why_not and results.vehicle.model is not None:
        found.append(f"No parameters were identified: {trial.why_not}")
    found += gain_warnings(trial.gains)
    if fit is None:
        return tuple(found)
    if not fit.converged:
        return (*found, _UNSETTLED)
    day, old = _latest(results)
    moved = ", ".join(_words(one.name) for one in _identified(trial) if _moved(old, one))
    if moved:
        found.append(
            f"{moved}: outside the intervals of {day}. Was something changed "
            "on the vehicle (ballast, payload, propeller)?"
        )
    off = ", ".join(_words(one.name) for one in _identified(trial) if _against_file(one))
    if off:
        found.append(f"By this day's fit the vehicle file is off in: {off}.")
    return tuple(found)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _identified(trial: TrialDay) -> list[IdentifiedParameter]:
    fitted = trial.identification.parameters if trial.identification is not None else ()
    return [one for one in fitted if one.identified]


def _against_file(one: IdentifiedParameter) -> bool:
    return not one.ci95[0] <= one.prior_value <= one.ci95[1]


def _moved(old: Mapping[str, IdentifiedParameter], one: IdentifiedParameter) -> bool:
    return one.name in old and apart(old[one.name], one)


def _latest(results: DayResults) -> tuple[str, dict[str, IdentifiedParameter]]:
    """Return the latest day before that the day can be compared with; nothing where there is none.

    A fit that did not come to an end is compared with none.
    """
    for day, trial in reversed(list(results.earlier.items()) if results.trial.settled else []):
        if trial.identification is not None and trial.settled:
            return day, {one.name: one for one in _identified(trial)}
    return "", {}


def _warnings(results: DayResults) -> Section:
    blocks: list[Block] = [Paragraph(text, tone="warning") for text in day_warnings(results)]
    errors = ", ".join(as_it_is(run.name) for run in results.runs if run.errors)
    if errors:
        blocks.insert(0, Paragraph(f"Runs with errors: {errors}. See their pages.", tone="error"))
    warned = [f"{as_it_is(run.name)} ({run.warnings})" for run in results.runs if run.warnings]
    if warned:
        blocks.append(Paragraph(f"Warnings on the pages of single runs: {', '.join(warned)}."))
    return Section("warnings", "Warnings", tuple(blocks) or (Paragraph("No warnings."),))


def _runs(results: DayResults) -> Section:
    runs = sorted(results.runs, key=lambda one: rank(one.glance))
    links = tuple((_run_label(one), to) for one in runs if (to := results.links.get(one.name)))
    return Section("runs", "Runs of the day", (Links(links),))


def _run_label(run: PageReceipt) -> str:
    if run.glance is None:
        return f"{as_it_is(run.name)}: {run.line}"
    sign = SIGNS[run.glance.light][0]
    return f"{sign} {as_it_is(run.name)}: {run.glance.short}; {run.line}"


def _fit(results: DayResults) -> Section:
    anchor, title = "identified", "Mass, damping and buoyancy from these runs"
    trial, fit = results.trial, results.trial.identification
    used = _used(trial)
    if fit is None:
        return not_computed(anchor, title, trial.why_not or "no fit was made.", *used)
    if not fit.converged:
        return Section(anchor, title, (Paragraph(_UNSETTLED, tone="warning"), *used))
    none = Paragraph("These runs determine none of the parameters.")
    blocks: list[Block] = [_parameters(results, *_latest(results)) if _identified(trial) else none]
    if fit.cannot_identify:
        silent = f"{plural(len(fit.cannot_identify), 'value')} of which these runs say nothing"
        blocks.append(Details(silent, (Bullets(fit.cannot_identify),)))
    if fit.notes or trial.notes:
        blocks.append(Bullets((*fit.notes, *trial.notes)))
    return Section(anchor, title, (*blocks, *used))


def _used(trial: TrialDay) -> list[Block]:
    blocks: list[Block] = []
    if trial.used:
        table = Table.of(
            "What the fit was made from",
            [
                {
                    "Run": as_it_is(one.run),
                    "From [s]": fixed(one.from_s, 0),
                    "To [s]": fixed(one.to_s, 0),
                    "Change of the commands": general(one.excitation, 2),
                }
                for one in trial.used
            ],
            note="The stretches whose commands change most are taken, up to a total that "
            "keeps the report quick. Change: root mean square over the thrusters, share of "
            "the range. rig2sea identify takes whole runs.",
        )
        blocks.append(table)
    if trial.passed_over:
        blocks.append(Details("Runs that were not used", (Bullets(trial.passed_over),)))
    return blocks


def _parameters(results: DayResults, day: str, old: Mapping[str, IdentifiedParameter]) -> Table:
    rows, classes = [], []
    for one in _identified(results.trial):
        value, interval = with_interval(one.value, one.ci95)
        row = {"What it is": one.meaning, "Unit": unit_text(one.unit), "Value": value}
        row |= {"95 % interval": interval, "Vehicle file": general(one.prior_value, 3)}
        if day:
            row[day] = general(old[one.name].value, 3) if one.name in old else "–"
        rows.append(row)
        classes.append("warning" if _moved(old, one) or _against_file(one) else "")
    return Table.of(
        "What the day's runs say of the vehicle",
        rows,
        row_classes=tuple(classes),
        note="Marked: the interval does not hold the vehicle file's value, or has nothing in "
        "common with that of the trial day before.",
    )


def _trend(results: DayResults) -> Section:
    every = {**results.earlier, results.day: results.trial}
    days = {day: {one.name: one for one in _identified(trial)} for day, trial in every.items()}
    unsettled = [day for day, trial in every.items() if not trial.settled]
    blocks = trend_blocks(days, unsettled)
    if blocks:
        return Section("trend", TREND_TITLE, blocks)
    text = (
        "A trend needs two trial days with a fit; there is one so far."
        if any(own for day, own in days.items() if day not in unsettled)
        else "A trend needs two trial days with a fit; there is none so far."
    )
    left_out = (Paragraph(text), *unsettled_days(unsettled))
    return Section("trend", TREND_TITLE, left_out, available=False)


def _quality(results: DayResults) -> Section:
    anchor, title = "quality", "Prediction of data that were not used for the fit"
    fit = results.trial.identification
    if fit is None:
        return not_computed(anchor, title, "there is no fit to judge.")
    if not fit.converged:
        return not_computed(anchor, title, _UNSETTLED)
    if not fit.quality:
        return not_computed(anchor, title, "nothing was left to judge the fit by.")

    def number(value: float | None) -> str:
        return "–" if value is None else general(value, 3)

    table = Table.of(
        f"Root mean square errors over {general(fit.quality[0].horizon_s, 2)} s",
        [
            {
                "Channel": _words(one.channel),
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
        note="A model earns its place where it beats both baselines on the right. The corrected "
        "file has the parameters found, but not the thrust that was fitted beside them. Sensor "
        "noise: of one reading, without the sensor's offset.",
    )
    return Section(anchor, title, (table,))


def _tables(results: DayResults) -> Section:
    anchor, title = "tables", "Thruster tables since the trial day before"
    now, before = results.tables, results.tables_before
    if now is None or now.why_not:
        reason = now.why_not if now is not None else "they were not kept."
        return not_computed(anchor, title, f"there are no tables: {reason}")
    if before is None or before.why_not:
        text = "No tables of an earlier trial day are on record; the history begins with these."
        return Section(anchor, title, (Paragraph(text),))
    if before.tables_sha256 == now.tables_sha256:
        text = f"The tables are those of {before.day}: not one code differs."
        return Section(anchor, title, (Paragraph(text),))
    changes = table_changes(before, now)
    if not changes:
        text = f"The tables of {before.day} and of this day have no thrust in common."
        return Section(anchor, title, (Paragraph(text, tone="warning"),))
    worst = max(changes, key=lambda one: one.largest_codes)
    lead = (
        f"Since {before.day} codes changed by up to {general(worst.largest_codes, 2)}, at "
        f"{fixed(worst.at_thrust_n, 1)} N and {speed(worst.speed_mps)} m/s."
        if worst.largest_codes >= ALIKE_CODES
        else f"Since {before.day} no code changed by more than {ALIKE_CODES:g}."
    )
    table = Table.of(
        "Change of the code for a thrust",
        [
            {
                "Speed [m/s]": speed(one.speed_mps),
                "Largest [codes]": general(one.largest_codes, 2),
                "At [N]": fixed(one.at_thrust_n, 1),
                "Mean [codes]": general(one.mean_codes, 2),
                "Thrusts compared": str(one.thrusts),
            }
            for one in changes
        ],
    )
    return Section(anchor, title, (Paragraph(lead), table))
