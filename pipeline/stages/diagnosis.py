"""What is the matter: with a pool run by itself, and with the runs of a day together."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.errors import CannotComputeError, InputError, is_of_the_machine
from pipeline.ingest.same_run import repeated_runs
from pipeline.provenance import read_envelope
from pipeline.records.day_findings import DayDiagnosis, RunDiagnosis, agree, day_findings
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.records.reference import ReferenceRecord
from pipeline.records.run_table import RunTable
from pipeline.records.trial import StoredRun
from pipeline.report.plain_words import short_finding
from pipeline.simulate.context import model_of
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.run_table_file import stored_table
from pipeline.types import FloatArray

if TYPE_CHECKING:
    from pipeline.inputs.simulated_vehicle import SimulatedVehicle


#: Seconds of run that a diagnosis takes in this workflow; `rig2sea diagnose` takes whole runs.
BUDGET_S = 80.0
#: Sound runs without which there is no reference.
_LEAST_SOUND = 2
SWITCHED_OFF = "vehicle.yaml says `diagnose: false`."
#: Share of its range by which a command has moved.
_MOVES = 0.02
FILE = "the vehicle file"


@leaves_record
def run(job: Job) -> RunDiagnosis | DayDiagnosis | tuple[RunDiagnosis, str]:
    """Diagnose the run or the day that the stage is made for."""
    return _of_run(job) if job.stage == "run_diagnosis" else _of_day(job)


def _of_run(job: Job) -> RunDiagnosis | tuple[RunDiagnosis, str]:
    """Diagnose the run; where that cannot be, leave why."""
    stored = job.needed_at(f"pool/{job.output.name}", "pool_run", StoredRun)
    found = RunDiagnosis(vehicle=job.vehicle_name, run=stored.run, day=stored.day, against=FILE)
    try:
        one = to_diagnose(job)
        healthy = sound_beside(job, one, (stored.run,))
        record, used = diagnosed(one, [measured(stored, one)], healthy)
    except CannotComputeError as error:
        if is_of_the_machine(error):
            raise
        return found.model_copy(update={"why_not": str(error)})
    told = short_finding(day_findings({stored.run: record})[0])
    whole = {"against": told_against(record), "stretches": used, "record": record}
    return found.model_copy(update=whole), told


def to_diagnose(job: Job) -> "SimulatedVehicle":
    """Load the vehicle."""
    vehicle = job.vehicle()
    if not vehicle.diagnose:
        raise CannotComputeError(SWITCHED_OFF)
    model_of(vehicle)
    # the compiled kernel takes two seconds to load: only for vehicles that are flown
    from pipeline.inputs.simulated_vehicle import load_simulated

    return load_simulated(str(job.vehicle_file.parent), job.raw_root, Path())


def measured(stored: StoredRun, one: "SimulatedVehicle") -> RunTable:
    """Return the table of a run that was read, with what is known of it."""
    from pipeline.inputs.simulated_vehicle import with_known

    return with_known(stored_table(stored), stored.notes, one)


def sound_beside(job: Job, one: "SimulatedVehicle", asked: Sequence[str]) -> tuple[RunTable, ...]:
    """Return the sound runs of the reference, but for those that are asked.

    None where there is no reference, or too few of its runs are left.
    """
    path = next((path for path in job.inputs if path.name == "reference.json"), None)
    if path is None:
        return ()
    try:
        record = read_envelope(path, "reference", ReferenceRecord).record
    except InputError:
        return ()
    if record is None or record.vehicle_file_sha256 != one.file_digest:
        return ()
    names = {sound.name for sound in record.runs} - set(asked)
    stored = [one.record for _, one in job.all_of("pool_run", StoredRun)]
    sound = [run for run in stored if run is not None and run.run in names]
    if len(sound) < _LEAST_SOUND:
        return ()
    return tuple(measured(run, one) for run in sound)


def told_against(record: DiagnosisRecord) -> str:
    """Say what a diagnosis is told against."""
    since = record.verdict.since
    return f"the sound runs {since}" if since else FILE


def diagnosed(
    one: "SimulatedVehicle",
    tables: Sequence[RunTable],
    healthy: tuple[RunTable, ...],
    each_s: float = BUDGET_S,
) -> tuple[DiagnosisRecord, tuple[tuple[float, float], ...]]:
    """Diagnose the beginnings of runs, so many seconds of each; return what was taken too."""
    from pipeline.diagnose.case import Case
    from pipeline.diagnose.engine import diagnose_fully

    code_max = np.abs(one.packed.code_limits).max(axis=1)
    chosen = tuple(beginning(table, code_max, each_s) for table in tables)
    # the jobs of the workflow share the cores
    case = Case(one.name, one.vehicle, one.packed, chosen, (), healthy)
    return diagnose_fully(case).record, tuple(
        (float(part.time_s[0]), float(part.time_s[-1])) for part in chosen
    )


def beginning(table: RunTable, code_max: FloatArray, seconds: float) -> RunTable:
    """Return a run up to so many seconds after its commands begin to change.

    It is taken from its start: a stretch that begins under way begins in a state nobody knows.
    """
    command = table.values.get("command")
    first_s = 0.0
    if command is not None:
        moves = np.abs(command - np.nan_to_num(command[:1])) > _MOVES * code_max
        there = np.flatnonzero(moves.any(axis=1))
        first_s = float(table.time_s[there[0]]) if there.size else 0.0
    end = int(np.searchsorted(table.time_s, first_s + seconds))
    return table.rows(0, end)


#: Seconds of each run that the diagnosis of all together takes.
TOGETHER_S = 40.0
_APART = "the runs do not agree, so no answer holds for all of them."


def _of_day(job: Job) -> DayDiagnosis:
    """Combine the answers of the runs; diagnose them together where they agree."""
    own = [
        (name, envelope.record, envelope.why_not or "")
        for name, envelope in job.all_of("run_diagnosis", RunDiagnosis)
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
        for name, one in job.all_of("pool_run", StoredRun)
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
