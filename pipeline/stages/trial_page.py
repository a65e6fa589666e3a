"""A trial day's fit, runs and tables, and the days before -> its page and a receipt."""

from collections.abc import Mapping
from pathlib import Path

from pipeline.plan import report_file
from pipeline.provenance import file_digest
from pipeline.records.base import Glance
from pipeline.records.day_findings import DayDiagnosis
from pipeline.records.gains import PooledGain
from pipeline.records.trial import DayTables, PageReceipt, RunLine, TrialDay
from pipeline.report.glance import FOLLOWS, Flown, day_glance, rank, run_glance
from pipeline.report.html import address_from, crumbs, placed, write_page
from pipeline.report.numbers import plural
from pipeline.report.page import counted, with_glance
from pipeline.report.results import DayResults
from pipeline.report.sections.diagnosis_curves import finding_figure
from pipeline.report.trial_page import day_counts, day_page
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.page_provenance import page_provenance


@leaves_record
def run(job: Job) -> tuple[PageReceipt, str]:
    """Write the page."""
    page, day = job.more_outputs[0], job.output.stem
    days = job.all_of("trial_day", TrialDay)
    trials = {name: one.record for name, one in days if one.record is not None}
    tables = dict(job.all_of("day_tables", DayTables))
    now = tables.pop(day, None)
    before = next(iter(tables.values()), None)
    pages = job.all_of("run_page", PageReceipt)
    runs = tuple(one.record for _, one in pages if one.record is not None)
    told = {name: one.record for name, one in job.all_of("day_diagnosis", DayDiagnosis)}
    flown = Flown(
        {one.name: one.manoeuvres for one in runs}, tuple(one.name for one in runs if one.errors)
    )
    last = next((told[name] for name in sorted(told, reverse=True) if name < day), None)
    glance = day_glance(job.vehicle_name, day, told.get(day), flown, last)
    runs = tuple(_completed(job, one, told.get(day), glance) for one in runs)
    results = DayResults(
        vehicle=job.vehicle(),
        day=day,
        trial=trials.get(day) or TrialDay(vehicle=job.vehicle_name, day=day, runs=()),
        earlier={name: one for name, one in trials.items() if name < day},
        runs=runs,
        links={one.name: address_from(page, one.address) for one in runs},
        glance=glance,
        diagnosis=told.get(day),
        compared=_compared(trials, day),
        tables=None if now is None else now.record,
        tables_before=None if before is None else before.record,
        provenance={
            **page_provenance((one for name, one in days if name == day), results=True),
            "code of trial_page": job.code,
        },
    )
    trail = crumbs(page, (job.vehicle_name, report_file(job.vehicle_name)))
    write_page(day_page(results, trail, placed(page.parents[2] / "assets", page)), page)
    errors, warnings = day_counts(results)
    fit = results.trial.identification
    receipt = PageReceipt(
        kind="day",
        name=day,
        files={
            path.as_posix(): file_digest(path)
            for path in (page, *(Path(one.address) for one in runs))
        },
        page=page.as_posix(),
        glance=glance,
        title=f"Trial day {day}",
        errors=errors,
        warnings=warnings,
        line=_line(results, errors, warnings),
        runs=tuple(
            RunLine(name=one.name, line=one.line, page=one.address, glance=one.glance)
            for one in sorted(runs, key=lambda one: rank(one.glance))
        ),
        parameters=() if fit is None else tuple(one for one in fit.parameters if one.identified),
        gains=() if results.trial.gains is None else results.trial.gains.pooled,
        settled=results.trial.settled,
    )
    return receipt, glance.short


def _completed(job: Job, run: PageReceipt, told: DayDiagnosis | None, day: Glance) -> PageReceipt:
    """Write the page of a run anew with what its day's diagnosis says of it."""
    text = Path(next(iter(run.files))).read_text(encoding="utf-8")
    if run.glance is None or told is None or run.errors:
        write_page(text, Path(run.address))
        return run
    glance = run_glance(
        job.vehicle_name, run.name, told, Flown({run.name: run.manoeuvres}), last=day.last_advice
    )
    if all(run.name not in one.runs for one in told.findings):
        why = told.without.get(run.name, told.why_not)
        matter = run.glance.matter.replace(FOLLOWS, f"No diagnosis: {why}" if why else "").strip()
        glance = run.glance.model_copy(update={"matter": matter, "last_advice": day.last_advice})
    mine = next((one for one in told.findings if run.name in one.runs), None)
    picture = None if mine is None else finding_figure(mine, run.name)
    write_page(with_glance(text, glance, picture), Path(run.address))
    return run.model_copy(update={"glance": glance})


def _compared(trials: Mapping[str, TrialDay], day: str) -> tuple[PooledGain, ...]:
    """Compare the day's gains with those of the last day before whose runs were called healthy."""
    mine = trials.get(day)
    before = [name for name, one in sorted(trials.items()) if name < day and one.sound_gains]
    if mine is None or mine.gains is None or not before:
        return ()
    from pipeline.identify.thruster_gains import against_day

    return against_day(mine.gains.pooled, trials[before[-1]].sound_gains, before[-1])


def _line(results: DayResults, errors: int, warnings: int) -> str:
    unsettled = () if results.trial.settled else ("the fit did not come to an end",)
    return "; ".join([plural(len(results.runs), "run"), *unsettled, counted(errors, warnings)])
