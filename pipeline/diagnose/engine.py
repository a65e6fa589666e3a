"""The diagnosis of one case: the five parts of the answer, from runs to a record."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from pipeline.diagnose.after_all import explained_after_all
from pipeline.diagnose.answer import Answers, effect_count, equals
from pipeline.diagnose.beside_errors import (
    alike_beside,
    case_beside,
    errors_of,
    names_beside,
    ranking_beside,
)
from pipeline.diagnose.calibration import Calibration, calibration
from pipeline.diagnose.case import Case, channels_of
from pipeline.diagnose.case_evidence import CaseEvidence, case_evidence
from pipeline.diagnose.confusability import confusable
from pipeline.diagnose.consequences import Ahead, Consequence, consequence, look_ahead
from pipeline.diagnose.decision import Left, Share, decide, for_the_gap, with_gap
from pipeline.diagnose.forecast import (
    AHEAD_S,
    forecast,
    healthy_spread,
    whole_runs,
)
from pipeline.diagnose.gap import channel_gaps, gap_channels, worst_gap
from pipeline.diagnose.gap_left import by_gap_left, gaps_left
from pipeline.diagnose.helping import that_help
from pipeline.diagnose.hopeless import refuse_hopeless
from pipeline.diagnose.inference import HELD_OUT, infer
from pipeline.diagnose.next_run import next_run
from pipeline.diagnose.notes import notes_on
from pipeline.diagnose.regime_gaps import regime_gaps
from pipeline.diagnose.regimes import Regressor, regressors
from pipeline.diagnose.search import Search
from pipeline.diagnose.sentence import sentence
from pipeline.diagnose.series import series_of
from pipeline.diagnose.shaft_speeds import ShaftsSeen, by_shaft_speeds, shafts_seen
from pipeline.diagnose.stages import stages_told
from pipeline.diagnose.verdict import (
    ranking_of,
    specs_of,
)
from pipeline.diagnose.weighing import UNKNOWN
from pipeline.diagnose.where import where_told
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.diagnosis import (
    ChannelNoiseCheck,
    Detail,
    DiagnosisRecord,
    Evidence,
    Gap,
    Verdict,
)
from pipeline.records.run_table import RunTable


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
        Of the vehicles drawn for the healthy floor, and of the bootstrap; the verdict does not
        depend on it.

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
            return _beside_errors(case, threads, seed, keep)
    except np.linalg.LinAlgError as error:
        raise CannotComputeError(
            f"the runs of {case.name} and its model are so far apart that the equations of the "
            f"diagnosis have no solution ({error}). Check that the vehicle file belongs to these "
            "runs: positions and signs of the thrusters, masses, sensor noise."
        ) from None


def _beside_errors(
    case: Case, threads: int, seed: int, keep: Callable[[CaseEvidence], None] | None
) -> Diagnosis:
    """Diagnose, and anew where the answer lacks what the instruments show of each other."""
    began = time.monotonic()
    case = _in_order(case)
    answer, found = _diagnosed(case, threads, seed, began, keep)
    # what cannot be solved there takes nothing from the answer that there is
    with suppress(CannotComputeError, np.linalg.LinAlgError):
        errors = errors_of(case, found)
        if errors is not None and not set(errors.effects) <= set(answer.record.verdict.effects):
            answer, _ = _diagnosed(case_beside(case, errors), threads, seed, began)
    return answer


def _diagnosed(
    case: Case,
    threads: int,
    seed: int,
    began: float,
    keep: Callable[[CaseEvidence], None] | None = None,
) -> tuple[Diagnosis, Search]:
    refuse_hopeless(case)
    thresholds = calibration()
    runs = (*case.runs, *case.holdout)
    channels = channels_of(case.vehicle, runs)
    found, answered = infer(case, runs, channels, thresholds, threads)
    shafts = shafts_seen(case)
    answered = by_shaft_speeds(found, answered, shafts)
    told = _told(case, found, answered, thresholds, channels, runs, seed, began, shafts, keep)
    return told, found


def _led_to(
    found: Search,
    answered: Answers,
    ahead: Ahead,
    shares: Sequence[Share],
    every: Sequence[Regressor],
) -> tuple[Consequence, Left]:
    """See what the first of the answers in the order of their shares leads to."""
    ordered = answered.reweighed(shares)
    top = ordered.ranking[0]
    led_to = consequence(found, ahead, top, ordered.force_scale, every)
    return led_to, led_to.decides(equals(found, top))


def _in_order(case: Case) -> Case:
    """Put the runs in an order of their own: that in which they are given must not matter."""
    return replace(case, runs=_sorted(case.runs), holdout=_sorted(case.holdout))


def _sorted(runs: Sequence[RunTable]) -> tuple[RunTable, ...]:
    """Put runs in an order of their own: by their commands, not by name or place."""
    return tuple(
        sorted(
            runs,
            key=lambda run: (
                run.time_s.size,
                float(np.nansum(np.abs(run.values.get("command", np.zeros(1))))),
            ),
        )
    )


def _told(  # noqa: PLR0917 - one caller
    case: Case,
    found: Search,
    answered: Answers,
    thresholds: Calibration,
    channels: Sequence[ChannelNoise],
    runs: Sequence[RunTable],
    seed: int,
    began: float,
    shafts: ShaftsSeen | None,
    keep: Callable[[CaseEvidence], None] | None,
) -> Diagnosis:
    """Put the answer together."""
    setting, healthy_known = found.setting, bool(case.healthy)
    told = (
        "runs " + ", ".join(run.name for run in case.holdout)
        if case.holdout
        else f"every {HELD_OUT}th window of the runs"
    )
    stated = case.stated.vector
    ahead = look_ahead(
        found, answered, runs, channels, told, seed, healthy_known=healthy_known, stated=stated
    )
    every = regressors(setting, runs)
    whole_look = whole_runs(setting, runs, channels, ahead.starts)
    whole = forecast(whole_look, ahead.stated_vector, channels)
    whole_spread = healthy_spread(whole_look, ahead.floors, ahead.healthy, channels, whole, seed)
    gaps = channel_gaps(ahead.stated, ahead.spread, whole, whole_spread)
    # what is decided is what there is beside known errors
    worst_ratio = worst_gap(ahead.before, ahead.spread)
    if keep is not None:
        seen = case_evidence(
            found,
            answered,
            ahead,
            every,
            thresholds,
            worst_ratio,
            healthy_known=healthy_known,
        )
        keep(seen)
    was_first, answered = answered.ranking[0].name, explained_after_all(found, ahead, answered)
    after_all = answered.ranking[0].name if answered.ranking[0].name != was_first else ""
    weighed = by_gap_left(
        [Share(one.name, one.probability) for one in answered.ranking],
        gaps_left(found, ahead, answered),
    )
    count = effect_count(found)
    grown = with_gap(weighed, worst_ratio, count, thresholds, healthy_known=healthy_known)
    seen_of: dict[str, tuple[Consequence, Left]] = {}

    def led_to_by(shares: Sequence[Share]) -> tuple[Consequence, Left]:
        name = shares[0].name
        if name not in seen_of:
            seen_of[name] = _led_to(found, answered, ahead, shares, every)
        return seen_of[name]

    def left_of(shares: Sequence[Share]) -> Left:
        return led_to_by(shares)[1]

    shares = for_the_gap(weighed, grown, left_of(grown))
    shares = that_help(shares, left_of, worst_ratio, thresholds, healthy_known=healthy_known)
    led_to, decisive = led_to_by(shares)
    decisive = replace(decisive, was_unknown=shares[0].name == after_all)
    answered = answered.reweighed(shares)
    top, closed, left = answered.ranking[0], led_to.closed, led_to.left
    said = decide(shares, decisive, worst_ratio, thresholds, healthy_known=healthy_known)
    names = names_beside(said.names, case.errors)
    ambiguous = alike_beside(said.ambiguous, case.errors)
    answered = answered.reweighed(said.ranking)
    ranking = ranking_of(found, answered, closed, top, thresholds)
    ranking = ranking_beside(ranking, case.errors)
    first = ranking[0]
    ground = top.judged.ground
    record = DiagnosisRecord(
        vehicle=case.name,
        runs=tuple(run.name for run in case.runs),
        holdout=tuple(run.name for run in case.holdout),
        gap=Gap(
            channels=gaps,
            where=where_told(
                gaps,
                ahead,
                led_to,
                setting,
                runs,
                every,
                names,
            ),
            by_regime=regime_gaps(every, ahead.stated, ahead.spread, AHEAD_S),
        ),
        verdict=Verdict(
            effects=names,
            probability=answered.ranking[0].probability,
            ambiguous_with=ambiguous,
            detail=Detail(thruster=first.thruster, axes=first.axes),
            sentence=sentence(names, answered.ranking[0].probability, ambiguous, first, left),
        ),
        ranking=ranking,
        shrink=closed,
        confusable=tuple(confusable(ground, found.groups)),
        next_run=next_run(case, found, answered, ambiguous) if ambiguous else None,
        leftover=left,
        evidence=Evidence(
            windows=int(found.chosen.sum()),
            window_s=max(w.duration_s for w in setting.bench.stack.windows),
            readings=len(found.model.readings),
            linearisations=found.rounds,
            force_scale=answered.force_scale,
            noise={
                name: ChannelNoiseCheck(variance=one.variance, lag1=one.lag1, widened_by=one.widen)
                for name, one in found.noise.items()
            },
            stages=stages_told(case, runs, found, answered, shafts),
            calibrated=thresholds.source,
            healthy_runs=tuple(run.name for run in case.healthy),
        ),
        series=series_of(
            ahead.near, runs, ahead.stated, led_to.after, ahead.held, gap_channels(gaps)
        ),
        notes=notes_on(case, found, top),
        elapsed_s=time.monotonic() - began,
    )
    specs = specs_of(found, led_to.added) if said.names != (UNKNOWN,) else ()
    return Diagnosis(record, (*case.known_specs, *specs))
