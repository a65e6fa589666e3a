"""The page of one trial day: warnings, runs, identified parameters and their trend, the tables."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from pipeline.errors import CannotComputeError
from pipeline.language import as_it_is
from pipeline.records.identification import IdentifiedParameter
from pipeline.records.trial import ALIKE_CODES, TrialDay, table_changes
from pipeline.report.blocks import (
    Blocks,
    Bullets,
    Details,
    Figure,
    Links,
    Table,
    Text,
    chapter,
    fold,
)
from pipeline.report.glance import rank
from pipeline.report.numbers import fixed, general, plural, speed, unit_text, with_interval
from pipeline.report.page import SIGNS, Labels, Page
from pipeline.report.results import DayResults
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.sections.gains import day_gains_section, gain_warnings
from pipeline.report.sections.tables import data_section
from pipeline.report.sections.trials import TREND_TITLE, apart, trend_blocks, unsettled_days

#: Said instead of any comparison of such a fit.
_UNSETTLED = "The fit did not come to an end: do not use its values."


def day_page(results: DayResults, crumbs: Labels, assets: str = "") -> str:
    """Return the page as HTML text; `crumbs`, `assets` as of `Page`."""
    findings = results.diagnosis.findings if results.diagnosis is not None else ()
    picture = finding_figure(findings[0]) if findings else None
    gains = day_gains_section(results)
    if picture is None:
        picture = next((one for one in gains.blocks if isinstance(one, Figure)), None)
        gains = replace(gains, blocks=tuple(one for one in gains.blocks if one is not picture))
    warnings = _warnings(results)
    return Page(
        title=f"Trial day {results.day}",
        under=(f"{as_it_is(results.vehicle.title)}: {plural(len(results.runs), 'pool run')}",),
        data_note=results.vehicle.data_note,
        crumbs=crumbs,
        glance=results.glance,
        picture=picture,
        sections=(
            _runs(results),
            warnings if sum(day_counts(results)) else fold(warnings),
            _trend(results),
            fold(gains),
            fold(_fit(results)),
            fold(_quality(results)),
            fold(_tables(results)),
            fold(data_section(results)),
        ),
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
    moved = _named(one for one in _identified(trial) if _moved(old, one))
    if moved:
        found.append(
            f"{moved}: outside the intervals of {day}. Was something changed "
            "on the vehicle (ballast, payload, propeller)?"
        )
    off = _named(one for one in _identified(trial) if _against_file(one))
    if off:
        found.append(f"By this day's fit the vehicle file is off in: {off}.")
    return tuple(found)


def _named(found: Iterable[IdentifiedParameter]) -> str:
    return ", ".join(one.name.replace("_", " ") for one in found)


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


@chapter("warnings", "Warnings")
def _warnings(results: DayResults) -> Blocks:
    texts = day_warnings(results)
    errors = ", ".join(as_it_is(run.name) for run in results.runs if run.errors)
    warned = [f"{as_it_is(run.name)} ({run.warnings})" for run in results.runs if run.warnings]
    if errors:
        yield Text(f"Runs with errors: {errors}. See their pages.", tone="error")
    for text in texts:
        yield Text(text, tone="warning")
    if warned:
        yield Text(f"Warnings on the pages of single runs: {', '.join(warned)}.")
    if not (errors or texts or warned):
        yield Text("No warnings.")


@chapter("runs", "Runs of the day")
def _runs(results: DayResults) -> Blocks:
    links = []
    for run in sorted(results.runs, key=lambda one: rank(one.glance)):
        label = f"{as_it_is(run.name)}: {run.line}"
        if run.glance is not None:
            sign = SIGNS[run.glance.light][0]
            label = f"{sign} {as_it_is(run.name)}: {run.glance.short}; {run.line}"
        links += [(label, results.links[run.name])] if results.links.get(run.name) else []
    yield Links(tuple(links))


@chapter("identified", "Mass, damping and buoyancy from these runs")
def _fit(results: DayResults) -> Blocks:
    trial, fit = results.trial, results.trial.identification
    if fit is not None and not fit.converged:
        yield Text(_UNSETTLED, tone="warning")
    elif fit is not None:
        none = Text("These runs determine none of the parameters.")
        yield _parameters(results, *_latest(results)) if _identified(trial) else none
        if fit.cannot_identify:
            silent = f"{plural(len(fit.cannot_identify), 'value')} of which these runs say nothing"
            yield Details(silent, (Bullets(fit.cannot_identify),))
        if fit.notes or trial.notes:
            yield Bullets((*fit.notes, *trial.notes))
    if trial.used:
        yield Table.of(
            "What the fit was made from",
            trial.used,
            "Run: {run:name} | From [s]: {from_s:.0f} | To [s]: {to_s:.0f} | "
            "Change of the commands: {excitation:.2g}",
            note="The stretches whose commands change most are taken, up to a total that "
            "keeps the report quick. Change: root mean square over the thrusters, share of "
            "the range. rig2sea identify takes whole runs.",
        )
    if trial.passed_over:
        yield Details("Runs that were not used", (Bullets(trial.passed_over),))
    if fit is None:
        raise CannotComputeError(trial.why_not or "no fit was made.")


def _parameters(results: DayResults, day: str, old: Mapping[str, IdentifiedParameter]) -> Table:
    def cells(one: IdentifiedParameter) -> dict[str, str]:
        value, interval = with_interval(one.value, one.ci95)
        before = {day: general(old[one.name].value if one.name in old else None, 3)}
        return {
            "What it is": one.meaning,
            "Unit": unit_text(one.unit),
            "Value": value,
            "95 % interval": interval,
            "Vehicle file": general(one.prior_value, 3),
            **(before if day else {}),
        }

    return Table.of(
        "What the day's runs say of the vehicle",
        _identified(results.trial),
        cells,
        lambda one: _moved(old, one) or _against_file(one),
        note="Marked: the interval does not hold the vehicle file's value, or has nothing in "
        "common with that of the trial day before.",
    )


@chapter("trend", TREND_TITLE)
def _trend(results: DayResults) -> Blocks:
    every = {**results.earlier, results.day: results.trial}
    days = {day: {one.name: one for one in _identified(trial)} for day, trial in every.items()}
    unsettled = [day for day, trial in every.items() if not trial.settled]
    blocks = trend_blocks(days, unsettled)
    yield from blocks or unsettled_days(unsettled)
    if not blocks:
        raise CannotComputeError(
            "A trend needs two trial days with a fit; there is one so far."
            if any(own for day, own in days.items() if day not in unsettled)
            else "A trend needs two trial days with a fit; there is none so far."
        )


@chapter("quality", "Prediction of data that were not used for the fit")
def _quality(results: DayResults) -> Blocks:
    fit = results.trial.identification
    if fit is None:
        raise CannotComputeError("there is no fit to judge.")
    if not fit.converged:
        raise CannotComputeError(_UNSETTLED)
    if not fit.quality:
        raise CannotComputeError("nothing was left to judge the fit by.")
    yield Table.of(
        f"Root mean square errors over {general(fit.quality[0].horizon_s, 2)} s",
        fit.quality,
        "Channel: {channel:words} | Unit: {unit} | Readings: {readings} | "
        "Sensor noise: {sensor_noise:.2g} | Fit: {rmse_identified:.3g} | "
        "Corrected file: {rmse_corrected_file:.3g} | Vehicle file: {rmse_vehicle_file:.3g} | "
        "Last value kept: {rmse_last_value:.3g} | Plain linear model: {rmse_black_box:.3g}",
        note="A model earns its place where it beats both baselines on the right. The corrected "
        "file has the parameters found, but not the thrust that was fitted beside them. Sensor "
        "noise: of one reading, without the sensor's offset.",
    )


@chapter("tables", "Thruster tables since the trial day before")
def _tables(results: DayResults) -> Blocks:
    now, before = results.tables, results.tables_before
    if now is None or now.why_not:
        reason = now.why_not if now is not None else "they were not kept."
        raise CannotComputeError(f"there are no tables: {reason}")
    if before is None or before.why_not:
        yield Text(
            "No tables of an earlier trial day are on record; the history begins with these."
        )
        return
    if before.tables_sha256 == now.tables_sha256:
        yield Text(f"The tables are those of {before.day}: not one code differs.")
        return
    changes = table_changes(before, now)
    if not changes:
        text = f"The tables of {before.day} and of this day have no thrust in common."
        yield Text(text, tone="warning")
        return
    worst = max(changes, key=lambda one: one.largest_codes)
    yield Text(
        f"Since {before.day} codes changed by up to {general(worst.largest_codes, 2)}, at "
        f"{fixed(worst.at_thrust_n, 1)} N and {speed(worst.speed_mps)} m/s."
        if worst.largest_codes >= ALIKE_CODES
        else f"Since {before.day} no code changed by more than {ALIKE_CODES:g}."
    )
    yield Table.of(
        "Change of the code for a thrust",
        changes,
        "Speed [m/s]: {speed_mps:speed} | Largest [codes]: {largest_codes:.2g} | "
        "At [N]: {at_thrust_n:.1f} | Mean [codes]: {mean_codes:.2g} | Thrusts compared: {thrusts}",
    )
