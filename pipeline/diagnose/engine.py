"""The diagnosis of one case: the five parts of the answer, from runs to a record."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from pipeline.diagnose.case import Case, channels_of
from pipeline.diagnose.conclude.beside_errors import case_beside, errors_of
from pipeline.diagnose.conclude.case_evidence import CaseEvidence, case_evidence
from pipeline.diagnose.conclude.conclusion import conclude
from pipeline.diagnose.conclude.gap_seen import gap_seen
from pipeline.diagnose.conclude.shaft_speeds import by_shaft_speeds, shafts_seen
from pipeline.diagnose.events.event import with_events
from pipeline.diagnose.events.told import with_events as told_events
from pipeline.diagnose.inference.infer import infer
from pipeline.diagnose.inference.verdict import specs_of
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.preconditions import check_preconditions
from pipeline.diagnose.regression.answer import against_sound
from pipeline.diagnose.regression.gained import gained_of, with_dead_thruster
from pipeline.diagnose.regression.known import LEAST_SOUND, Reference, reference_of
from pipeline.diagnose.rules.calibration import calibration
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.diagnose.tell.record import record_of
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.identify.thruster_gains import gains_of
from pipeline.records.diagnosis import DiagnosisRecord, Gain
from pipeline.records.gains import ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.vehicle.sensor_schema import Sensors


@dataclass(frozen=True)
class Diagnosis:
    """The record, and what write-back and pictures need beside it."""

    record: DiagnosisRecord
    specs: tuple[EffectSpec, ...]
    """Effects of the verdict with their values."""


def diagnose(case: Case, threads: int = 2, seed: int = 0) -> DiagnosisRecord:
    """Diagnose a case.

    Parameters
    ----------
    case : Case
        Vehicle and runs.
    threads : int
        Simulations side by side.
    seed : int
        Of the vehicles drawn for the healthy floor, and of the bootstrap. It is always the same one
        for whoever asks by the command, as a gap near a threshold may fall to either side of it.

    Raises
    ------
    CannotComputeError
        Where no diagnosis can be given; the text says why.
    """
    return diagnose_fully(case, threads, seed).record


def diagnose_fully(
    case: Case,
    threads: int = 2,
    seed: int = 0,
    keep: Callable[[CaseEvidence], None] | None = None,
) -> Diagnosis:
    """Diagnose a case and keep what write-back needs; see `diagnose`.

    `keep` is given the evidence that was weighed, for setting the thresholds.
    """
    try:
        # the matrices are small: threads of BLAS beside our own only wait for each other
        with threadpool_limits(1, user_api="blas"):
            return _with_events(case, threads, seed, keep)
    except np.linalg.LinAlgError as error:
        raise CannotComputeError(
            f"the runs of {case.name} and its model are so far apart that the equations of the "
            f"diagnosis have no solution ({error}). Check that the vehicle file belongs to these "
            "runs: positions and signs of the thrusters, masses, sensor noise."
        ) from None


def _with_events(
    case: Case, threads: int, seed: int, keep: Callable[[CaseEvidence], None] | None
) -> Diagnosis:
    """Diagnose with what happened during the runs known, where that leaves nothing unknown."""
    case = _in_order(case)
    check_preconditions(case)
    knowing, events = with_events(case)
    if events:
        found = _beside_errors(knowing, threads, seed, keep)
        if UNKNOWN not in found.record.verdict.effects:
            return replace(found, record=told_events(found.record, events))
    return _beside_errors(case, threads, seed, keep)


def _beside_errors(
    case: Case, threads: int, seed: int, keep: Callable[[CaseEvidence], None] | None
) -> Diagnosis:
    """Diagnose, and anew where the answer lacks what the instruments show of each other."""
    began = time.monotonic()
    known, note = None, None
    if len(case.healthy) >= LEAST_SOUND:
        known, note = reference_of(case)
    if known is not None:
        return _against_sound(case, known, began)
    answer, found = _diagnosed(case, threads, seed, began, keep)
    # what cannot be solved there takes nothing from the answer that there is
    with suppress(CannotComputeError, np.linalg.LinAlgError):
        errors = errors_of(case, found)
        if errors is not None and not set(errors.effects) <= set(answer.record.verdict.effects):
            answer, _ = _diagnosed(case_beside(case, errors), threads, seed, began)
    if len(case.runs) > 1 and not case.holdout and answer.record.verdict.effects == (UNKNOWN,):
        answer = _run_by_run(case, answer, threads, seed, began)
    if note is not None:
        notes = (*answer.record.notes, f"Told against the vehicle file: {note}")
        answer = replace(answer, record=answer.record.model_copy(update={"notes": notes}))
    return _beside_gains(case, answer)


def _beside_gains(case: Case, answer: Diagnosis) -> Diagnosis:
    """Add the gains of the thrusters, and one that is dead where nothing is named."""
    gains = _gains(case)
    record = answer.record.model_copy(update={"gains": told_gains(gains)})
    for gained in gained_of(gains, [run.name for run in case.runs]):
        record, specs = with_dead_thruster(record, gained)
        answer = replace(answer, specs=specs or answer.specs)
    return replace(answer, record=record)


def _gains(case: Case) -> ThrusterGains:
    return gains_of(
        case.packed,
        case.vehicle.sensors or Sensors(),
        case.runs,
        uncertainty=model_of(case.vehicle).uncertainty,
        reference=case.healthy,
    )


def _run_by_run(
    case: Case, together: Diagnosis, threads: int, seed: int, began: float
) -> Diagnosis:
    """Ask each run alone where all together are unknown; answer by those that one change explains.

    Where others are not sound, or name something else, the answer of all stays.
    """
    alone: list[Diagnosis] = []
    for run in case.runs:
        try:
            alone.append(_diagnosed(replace(case, runs=(run,)), threads, seed, began)[0])
        except (CannotComputeError, np.linalg.LinAlgError):
            return together
    named = [one for one in alone if not {NONE, UNKNOWN} & set(one.record.verdict.effects)]
    calm = [one for one in alone if one.record.verdict.effects == (NONE,)]
    if not named or len(named) + len(calm) < len(alone):
        return together
    first = max(named, key=lambda one: one.record.verdict.probability)
    verdict = first.record.verdict
    if any(
        (one.record.verdict.effects, one.record.verdict.detail) != (verdict.effects, verdict.detail)
        for one in named
    ):
        return together
    names = tuple(name for one in named for name in one.record.runs)
    text = verdict.sentence
    text += f" Only in {', '.join(names)}."
    told = verdict.model_copy(update={"runs": names, "sentence": text, "text": text})
    record = first.record.model_copy(update={"runs": together.record.runs, "verdict": told})
    return replace(first, record=record)


def _against_sound(case: Case, known: Reference, began: float) -> Diagnosis:
    """Diagnose against the vehicle as its sound runs show it."""
    gains = _gains(case)
    dead = gained_of(gains, [run.name for run in case.runs])
    record, specs = against_sound(case, known, dead)
    if record.verdict.effects == (UNKNOWN,):
        # what the test of one thruster shows stands beside what nothing explains
        for one in dead:
            record, more = with_dead_thruster(record, one)
            specs = more or specs
    update = {"gains": told_gains(gains), "elapsed_s": time.monotonic() - began}
    return Diagnosis(record.model_copy(update=update), specs)


def _diagnosed(
    case: Case,
    threads: int,
    seed: int,
    began: float,
    keep: Callable[[CaseEvidence], None] | None = None,
) -> tuple[Diagnosis, Search]:
    """Diagnose once: weigh all answers, see what each leaves, conclude, and write it down."""
    limits, healthy_known = calibration(), bool(case.healthy)
    runs = (*case.runs, *case.holdout)
    channels = channels_of(case.vehicle, runs)
    shafts = shafts_seen(case)
    found, answered = infer(case, runs, channels, limits, threads)
    answered = by_shaft_speeds(found, answered, shafts)
    seen = gap_seen(case, found, answered, runs, channels, seed)
    supply_known = shafts is not None or any(one.quantity == "voltage" for one in channels)
    known = {"healthy_known": healthy_known, "supply_known": supply_known}
    if keep is not None:
        keep(case_evidence(found, answered, seen, limits, **known))
    concluded = conclude(found, answered, seen, limits, **known)
    record = record_of(case, runs, found, seen, concluded, shafts, limits)
    record = _told(record, case, None, began)
    specs = specs_of(found, concluded.led_to.added) if concluded.names_effects else ()
    return Diagnosis(record, (*case.known_specs, *specs)), found


def _told(record: DiagnosisRecord, case: Case, since: str | None, began: float) -> DiagnosisRecord:
    """Add to the verdict what it is told against, and of which runs."""
    verdict = record.verdict.model_copy(
        update={
            "since": since,
            "runs": tuple(run.name for run in case.runs),
            "text": record.verdict.sentence,
        }
    )
    update = {"verdict": verdict, "elapsed_s": time.monotonic() - began}
    return record.model_copy(update=update)


def _in_order(case: Case) -> Case:
    """Put the runs in an order of their own: that in which they are given must not matter."""
    return replace(
        case,
        runs=_sorted(case.runs),
        holdout=_sorted(case.holdout),
        healthy=_sorted(case.healthy),
    )


def _sorted(runs: Sequence[RunTable]) -> tuple[RunTable, ...]:
    """Put runs in an order of their own: by what was commanded and read, not by name or place."""
    return tuple(sorted(runs, key=_size_of))


def _size_of(run: RunTable) -> tuple[float, ...]:
    """Length of a run and sums of its commands and readings: two runs differ in one of them."""
    first = float(np.nansum(np.abs(run.values.get("command", np.zeros(1)))))
    others = (float(np.nansum(np.abs(run.values[name]))) for name in sorted(run.values))
    return float(run.time_s.size), first, *others


def told_gains(gains: ThrusterGains) -> tuple[Gain, ...]:
    """Return the gains that the runs tell, on axes that the thruster moves."""
    return tuple(
        Gain(
            run=one.run,
            thruster=one.thruster,
            axis=one.axis,
            value=one.value,
            ci95=one.ci95,
            reference=None if one.reference is None else one.reference.mean,
        )
        for one in gains.gains
        if one.judged and one.moves and one.value is not None and one.ci95 is not None
    )
