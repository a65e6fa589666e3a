"""The diagnosis of one case: the five parts of the answer, from runs to a record."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.answer import NONE, UNKNOWN, Answers, answers
from pipeline.diagnose.calibration import Calibration, calibration
from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.confusability import confusable
from pipeline.diagnose.elimination import solve
from pipeline.diagnose.forecast import (
    forecast,
    healthy_spread,
    outlook,
    smoothed_starts,
    whole_runs,
)
from pipeline.diagnose.gap import channel_gaps, gap_channels
from pipeline.diagnose.healthy import learn
from pipeline.diagnose.hopeless import refuse_hopeless
from pipeline.diagnose.leftover import leftover
from pipeline.diagnose.linear_model import vector_of
from pipeline.diagnose.next_run import next_run
from pipeline.diagnose.notes import notes_on
from pipeline.diagnose.refine import refined
from pipeline.diagnose.regime_gaps import regime_gaps
from pipeline.diagnose.regimes import excess, regime_shares, regressors, time_shares
from pipeline.diagnose.scales import Level, levels
from pipeline.diagnose.search import Search, force_prior, ordinary_prior, search
from pipeline.diagnose.sentence import sentence
from pipeline.diagnose.series import series_of
from pipeline.diagnose.shrink import shrink
from pipeline.diagnose.stages import stages_told
from pipeline.diagnose.unexplained import leaves_too_much
from pipeline.diagnose.verdict import (
    departures_of,
    effect_alone,
    ranking_of,
    specs_of,
    verdict_of,
)
from pipeline.effects.specification import EffectSpec
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_derivatives import moved_starts
from pipeline.identify.windows import Window
from pipeline.records.diagnosis import (
    ChannelNoiseCheck,
    Detail,
    DiagnosisRecord,
    Evidence,
    Gap,
    Verdict,
    Where,
)
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray

#: Answers that are judged at their own points.
_REFINED = 6
#: Every how manyth window is held out where no run is.
_HELD_OUT = 4
#: How far ahead the gap is looked at. [s]
_AHEAD_S = 10.0


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


def diagnose_fully(case: Case, threads: int = 2, seed: int = 0) -> Diagnosis:
    """Diagnose a case and keep what write-back needs; see `diagnose`."""
    began = time.monotonic()
    refuse_hopeless(case)
    # the order in which runs are given must not matter
    case = replace(case, runs=_sorted(case.runs), holdout=_sorted(case.holdout))
    thresholds = calibration()
    runs = (*case.runs, *case.holdout)
    channels = channels_of(case.vehicle, runs)
    healthy = learn(case, threads) if case.healthy else None
    setting = setting_of(
        case,
        runs,
        channels,
        force_unit=None if healthy is None else healthy.force_unit,
        threads=threads,
    )
    chosen = _chosen(case, setting.bench.stack.windows)
    every_level = levels(healthy_known=healthy is not None)
    prior = ordinary_prior(setting) if healthy is None else healthy.prior
    found = search(
        setting,
        runs,
        channels,
        prior,
        every_level,
        chosen,
        None if healthy is None else dict(healthy.widen),
    )
    found = refined(found, answers(found, thresholds), _REFINED)
    answered = answers(found, thresholds)
    return _told(
        case, found, answered, thresholds, channels, runs, seed, began, healthy is not None
    )


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


def _chosen(case: Case, windows: Sequence[Window]) -> BoolArray:
    """Windows that may speak: those of the runs, less every fourth where no run is held out."""
    if case.holdout:
        return np.array([window.run < len(case.runs) for window in windows])
    place: dict[int, int] = {}
    chosen = []
    for window in windows:
        count = place.get(window.run, 0)
        place[window.run] = count + 1
        chosen.append(count % _HELD_OUT != _HELD_OUT - 2)
    return np.array(chosen)


def _told(  # noqa: PLR0917 - one caller
    case: Case,
    found: Search,
    answered: Answers,
    thresholds: Calibration,
    channels: Sequence[ChannelNoise],
    runs: Sequence[RunTable],
    seed: int,
    began: float,
    healthy_known: bool,
) -> Diagnosis:
    """Put the answer together."""
    setting, top = found.setting, answered.ranking[0]
    finding = top.finding if top.name not in {NONE, UNKNOWN} else None
    best = departures_of(found, top, top.finding)
    added = effect_alone(found, best, finding)
    # starts from all readings, with forces free enough to follow whatever happened
    wide = Level(np.full(6, max(4.0, 2.0 * answered.force_scale)), 1.0, False)
    state = solve(found.grams, force_prior(setting, wide), best)
    starts = smoothed_starts(
        setting.bench.stack.windows,
        moved_starts(setting.bench.stack.starts, state.starts * setting.problem.start_scales),
    )
    near_look = outlook(setting, runs, channels, starts, _AHEAD_S)
    packed = case.packed
    before = forecast(near_look, packed.vector, channels)
    after = forecast(near_look, vector_of(setting, added), channels) if added.any() else before
    ordinary = min((j.level.size for j in found.judged if j.level.ordinary), default=1.0)
    ordinary = float(np.clip(answered.force_scale, ordinary, 1.0 if healthy_known else 2.0))
    floors = replace(setting, force_unit=setting.force_unit * ordinary)
    spread = healthy_spread(near_look, floors, found.prior, channels, before, seed)
    whole_look = whole_runs(setting, runs, channels, starts)
    whole = forecast(whole_look, packed.vector, channels)
    whole_spread = healthy_spread(whole_look, floors, found.prior, channels, whole, seed)
    gaps = channel_gaps(before, spread, whole, whole_spread)
    carried = excess(before, spread, setting.bench.window_count, _AHEAD_S)
    every = regressors(setting, runs)
    held = ~found.chosen
    told = (
        "runs " + ", ".join(run.name for run in case.holdout)
        if case.holdout
        else f"every {_HELD_OUT}th window of the runs"
    )
    closed = shrink(before, after, spread, held, told, seed)
    left = leftover(found, found.grams, best, runs, every, answered.force_scale)
    # with the ordinary departures that go with the answer: a turning rate that is off by what is
    # ordinary is off by more at the end of a long lever arm, and that is no gap
    fitted = forecast(near_look, vector_of(setting, best), channels)
    judged = shrink(before, fitted, spread, held, told, seed)
    answered = leaves_too_much(answered, left, judged, thresholds, healthy_known=healthy_known)
    names, ambiguous = verdict_of(found, answered, thresholds)
    ranking = ranking_of(found, answered, closed, top)
    first = ranking[0]
    ground = top.judged.ground
    record = DiagnosisRecord(
        vehicle=case.name,
        runs=tuple(run.name for run in case.runs),
        holdout=tuple(run.name for run in case.holdout),
        gap=Gap(
            channels=gaps,
            where=Where(
                channels=gap_channels(gaps),
                regimes=regime_shares(every, carried),
                times=time_shares(setting, runs, carried),
            ),
            by_regime=regime_gaps(every, before, spread, _AHEAD_S),
        ),
        verdict=Verdict(
            effects=names,
            probability=answered.ranking[0].probability,
            ambiguous_with=ambiguous,
            detail=Detail(
                thruster=None if names == (UNKNOWN,) else first.thruster,
                axes=() if names == (UNKNOWN,) else first.axes,
            ),
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
            stages=stages_told(case, runs, found, answered),
            calibrated=thresholds.source,
            healthy_runs=tuple(run.name for run in case.healthy),
        ),
        series=series_of(near_look, runs, before, after, held, gap_channels(gaps)),
        notes=notes_on(case, found),
        elapsed_s=time.monotonic() - began,
    )
    known = names != (UNKNOWN,)
    return Diagnosis(record, specs_of(found, added) if known else ())
