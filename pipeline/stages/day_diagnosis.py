"""What a day's runs show alone -> what they show together, and which run carries which finding."""

from pipeline.errors import CannotComputeError, is_of_the_machine
from pipeline.ingest.same_run import repeated_runs
from pipeline.records.day_findings import DayDiagnosis, RunDiagnosis, agree, day_findings
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.records.trial import StoredRun
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.run_diagnosis import (
    diagnosed,
    measured,
    sound_beside,
    to_diagnose,
    told_against,
)

#: Seconds of each run that the diagnosis of all together takes.
TOGETHER_S = 40.0
_APART = "the runs do not agree, so no answer holds for all of them."


@leaves_record
def run(job: Job) -> DayDiagnosis:
    """Combine the answers of the runs; diagnose them together where they agree."""
    own = [
        (name, envelope.record, envelope.why_not or "")
        for name, envelope in job.all_in("run_diagnoses", "run_diagnosis", RunDiagnosis)
    ]
    alone = {name: one.record for name, one, _ in own if one is not None and one.record is not None}
    without = {
        name: one.why_not if one is not None else why for name, one, why in own if name not in alone
    }
    together, why_not, against = _together(job, alone)
    told = [one.against for _, one, _ in own if one is not None and one.record is not None]
    next_run = together.next_run if together is not None else None
    findings = day_findings(alone, together)
    if next_run is None and findings:
        next_run = alone[findings[0].runs[0]].next_run
    return DayDiagnosis(
        vehicle=job.vehicle_name,
        day=job.output.stem,
        against=against or next(iter(dict.fromkeys(told)), ""),
        findings=findings,
        together=together,
        why_not_together=why_not,
        without=without,
        next_run=next_run,
        why_not="" if alone else next(iter(without.values()), "the day has no runs."),
    )


def _together(
    job: Job, alone: dict[str, DiagnosisRecord]
) -> tuple[DiagnosisRecord | None, str, str]:
    """Diagnose all runs as one; else say why not. The last is what it is told against."""
    if len(alone) < 2:
        return None, "there is one run.", ""
    if not agree(alone):
        return None, _APART, ""
    stored = {
        name: one.record
        for name, one in job.all_in("pool", "pool_run", StoredRun)
        if one.record is not None
    }
    copies = repeated_runs({name: stored[name] for name in alone})
    try:
        vehicle = to_diagnose(job)
        healthy = sound_beside(job, vehicle, [*alone])
        tables = [measured(stored[name], vehicle) for name in alone if name not in copies]
        record, _ = diagnosed(vehicle, tables, healthy, TOGETHER_S)
    except CannotComputeError as error:
        if is_of_the_machine(error):
            raise
        return None, str(error), ""
    return record, "", told_against(record)
