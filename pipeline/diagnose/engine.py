"""The diagnosis of one case: the five parts of the answer, from runs to a record."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from pipeline.diagnose.case import Case
from pipeline.diagnose.events.event import with_events
from pipeline.diagnose.events.told import with_events as told_events
from pipeline.diagnose.preconditions import check_preconditions
from pipeline.diagnose.regression.answer import against
from pipeline.diagnose.regression.gained import gained_of, with_dead_thruster
from pipeline.diagnose.regression.known import reference_of
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.identify.thruster_gains import gains_of
from pipeline.records.diagnosis import UNKNOWN, DiagnosisRecord, Gain
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


def diagnose(case: Case) -> DiagnosisRecord:
    """Diagnose a case.

    Parameters
    ----------
    case : Case
        Vehicle and runs.

    Raises
    ------
    CannotComputeError
        Where no diagnosis can be given; the text says why.
    """
    return diagnose_fully(case).record


def diagnose_fully(case: Case) -> Diagnosis:
    """Diagnose a case and keep what write-back needs; see `diagnose`."""
    try:
        # the matrices are small: threads of BLAS only wait for each other
        with threadpool_limits(1, user_api="blas"):
            return _with_events(case)
    except np.linalg.LinAlgError as error:
        raise CannotComputeError(
            f"the runs of {case.name} and its model are so far apart that the equations of the "
            f"diagnosis have no solution ({error}). Check that the vehicle file belongs to these "
            "runs: positions and signs of the thrusters, masses, sensor noise."
        ) from None


def _with_events(case: Case) -> Diagnosis:
    """Diagnose with what happened during the runs known, where that leaves nothing unknown."""
    case = _in_order(case)
    check_preconditions(case)
    knowing, events = with_events(case)
    if events:
        found = _answered(knowing)
        if UNKNOWN not in found.record.verdict.effects:
            return replace(found, record=told_events(found.record, events))
    return _answered(case)


def _answered(case: Case) -> Diagnosis:
    """Diagnose against sound runs, or the file where there are too few."""
    began = time.monotonic()
    known, gains = reference_of(case), _gains(case)
    gained = gained_of(gains, [run.name for run in case.runs])
    record, specs = against(case, known, gained)
    if record.verdict.effects == (UNKNOWN,):
        # what the test of one thruster shows stands beside what nothing explains
        for one in gained:
            record, more = with_dead_thruster(record, one)
            specs = more or specs
    update = {"gains": told_gains(gains), "elapsed_s": time.monotonic() - began}
    return Diagnosis(record.model_copy(update=update), specs)


def _gains(case: Case) -> ThrusterGains:
    return gains_of(
        case.packed,
        case.vehicle.sensors or Sensors(),
        case.runs,
        uncertainty=model_of(case.vehicle).uncertainty,
        reference=case.healthy,
    )


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
