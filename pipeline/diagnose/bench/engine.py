"""Diagnosis of a mooring table against the thruster model: from readings to the whole answer."""

import time
from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.bench.answer import (
    LEFT_OVER,
    PRIOR,
    SET_LEVEL,
    Ranked,
    confusable,
    group_of,
    left_over,
    rank,
)
from pipeline.diagnose.bench.effects import predict, priors
from pipeline.diagnose.bench.fit import BenchComparison, BenchFit
from pipeline.diagnose.bench.model import UNITS, ThrusterAtRest
from pipeline.diagnose.bench.shrink import gap_channels, held_out_codes, shrink, where
from pipeline.diagnose.bench.table import BenchTable
from pipeline.diagnose.bench.words import next_step, sentence
from pipeline.diagnose.gap.regimes import rank_correlation
from pipeline.records.diagnosis import (
    BenchDiagnosisRecord,
    ChannelNoiseCheck,
    CodeSeries,
    Detail,
    Evidence,
    Gap,
    Interval,
    Leftover,
    ParameterEstimate,
    RankedEffect,
    Verdict,
)
from pipeline.types import BoolArray

_EVERY_THIRD = "every third code of each sign"


def diagnose_bench(
    model: ThrusterAtRest,
    table: BenchTable,
    holdout: BenchTable | None = None,
    *,
    notes: Sequence[str] = (),
    seed: int = 0,
) -> BenchDiagnosisRecord:
    """Say where a mooring table departs from the model, why, and how far that goes away.

    Parameters
    ----------
    model : ThrusterAtRest
        The thruster at rest.
    table : BenchTable
        The new table.
    holdout : BenchTable, optional
        A table that takes no part; else every third code of each sign is held out.
    notes : sequence of str
        What the reader of the answer should know beside it.
    seed : int
        Of the bootstrap.

    Returns
    -------
    BenchDiagnosisRecord
        Same form as the diagnosis of pool runs; curves are by code.
    """
    start = time.monotonic()
    marked = held_out_codes(table.code) if holdout is None else np.zeros(table.code.size, bool)
    problem = BenchComparison(model, table.part(~marked))
    judged = BenchComparison(model, table.part(marked) if holdout is None else holdout)
    whole = BenchComparison(model, table)
    ranking, evaluations = rank(problem)
    members, probability = group_of(problem, ranking)
    best = ranking[0]
    values = best.fit.values
    gap = gap_channels(whole)
    thruster = model.thrusters[0] if len(model.thrusters) == 1 else None
    held_out = _EVERY_THIRD if holdout is None else f"the table {holdout.name}"
    shrunk = shrink(judged, values, held_out, seed=seed)
    twins = confusable(problem)
    verdict = Verdict(
        effects=tuple(sorted(best.fit.effects)),
        probability=probability,
        ambiguous_with=members,
        detail=Detail(thruster=thruster if "thruster_degraded" in best.fit.effects else None),
        sentence=sentence(model, best, members, probability, shrunk),
    )
    return BenchDiagnosisRecord(
        vehicle=model.name,
        runs=(table.name,),
        holdout=() if holdout is None else (holdout.name,),
        gap=Gap(channels=gap, where=where(whole, gap)),
        verdict=verdict,
        ranking=tuple(_ranked(one, judged, model, thruster, seed) for one in ranking),
        shrink=shrunk,
        confusable=tuple(twins),
        next_run=next_step(table, ranking, members),
        leftover=_leftover(problem, best.fit),
        evidence=_evidence(problem, best.fit, evaluations),
        series=(),
        notes=(*notes, *_notes(model, table, holdout)),
        elapsed_s=time.monotonic() - start,
        by_code=_series(whole, best.fit, marked),
    )


def _ranked(
    one: Ranked,
    judged: BenchComparison,
    model: ThrusterAtRest,
    thruster: str | None,
    seed: int,
) -> RankedEffect:
    weak = thruster is not None and "thruster_degraded" in one.fit.effects
    return RankedEffect(
        effect=one.name,
        probability=one.probability,
        parameters=_parameters(one.fit, model),
        gap_closed=shrink(judged, one.fit.values, "", seed=seed).gap_closed
        if one.fit.values
        else None,
        thruster=thruster if weak else None,
        thrusters={"thruster_degraded": thruster} if weak else {},
        log_evidence=float(one.log_evidence),
    )


def _parameters(found: BenchFit, model: ThrusterAtRest) -> dict[str, ParameterEstimate]:
    estimates: dict[str, ParameterEstimate] = {}
    for effect in found.effects if found.values else ():
        for one in priors(effect, model.code_max):
            key = (one.effect, one.parameter)
            value, spread = found.values[key], 1.96 * found.std[key]
            low, high = (float(np.clip(value + s * spread, *one.bounds)) for s in (-1.0, 1.0))
            interval: Interval = (low, high)
            name = ".".join(key) if len(found.effects) > 1 else one.parameter
            estimates[name] = ParameterEstimate(value=value, unit=one.unit, ci95=interval)
    return estimates


def _leftover(problem: BenchComparison, found: BenchFit) -> Leftover:
    """Thrust that the answer leaves, over what it may leave, and what it goes with."""
    code = problem.table.code
    after = predict(problem.model, found.values, code, ("thrust",))["thrust"]
    residual = problem.table.mean["thrust"] - after
    ratio = left_over(problem, found)
    with_code = rank_correlation(residual, code)
    with_size = rank_correlation(residual, np.abs(code))
    name, value = ("code", with_code) if abs(with_code) > abs(with_size) else ("|code|", with_size)
    worst = int(np.argmax(np.abs(residual)))
    return Leftover(
        axes={"thrust": ratio},
        worst_axis="thrust",
        time_course=(
            f"no time in a mooring table; largest at code {code[worst]:g}: {residual[worst]:+.3g} N"
        ),
        depends_on=name if ratio > LEFT_OVER else None,
        correlation=float(value) if ratio > LEFT_OVER else None,
    )


def _evidence(problem: BenchComparison, found: BenchFit, evaluations: int) -> Evidence:
    after = predict(problem.model, found.values, problem.table.code, problem.stack.channels)
    noise = {}
    for channel in problem.stack.channels:
        covariance = problem.covariances(found.values, after)[channel]
        residual = problem.table.mean[channel] - after[channel]
        white = np.linalg.solve(np.linalg.cholesky(covariance), residual)
        centred = white - white.mean()
        lag1 = float(centred[1:] @ centred[:-1] / max(float(centred @ centred), 1e-12))
        noise[channel] = ChannelNoiseCheck(
            variance=float(np.mean(white**2)), lag1=lag1, widened_by=1.0
        )
    return Evidence(
        windows=0,
        window_s=0.0,
        readings=problem.stack.measured.size,
        linearisations=evaluations,
        force_scale=1.0,
        noise=noise,
        stages={
            "kinematics": "skipped: nothing moves in a mooring test.",
            "actuators": f"channels {', '.join(problem.stack.channels)} at "
            f"{problem.table.code.size} codes, against {problem.model.source}.",
            "dynamics": "skipped: nothing moves in a mooring test.",
        },
        calibrated=(
            f"prior probabilities none {PRIOR['none']:g}, unknown {PRIOR['unknown']:g}, one effect "
            f"{PRIOR['single']:g}, two {PRIOR['pair']:g}; answer set of {SET_LEVEL:g}; unknown and "
            f"pairs only where one effect leaves more than {LEFT_OVER:g} x the ordinary"
        ),
        healthy_runs=(),
    )


def _notes(model: ThrusterAtRest, table: BenchTable, holdout: BenchTable | None) -> list[str]:
    notes = []
    if model.mirrored:
        notes.append(
            "The drive was tested in one direction; the model mirrors it. Thrust astern that "
            "always was weaker than ahead shows as reverse_thrust."
        )
    tables = (table,) if holdout is None else (table, holdout)
    notes += [
        f"In {one.name} {channel} was read at {read} of {one.code.size} codes alone, so it is not "
        "used. Fill it in at the other codes, or mark their rows to be left out."
        for one in tables
        for channel, read in one.partly.items()
    ]
    partly = {channel for one in tables for channel in one.partly}
    missing = [one for one in UNITS if one not in {*table.channels, *partly}]
    if missing:
        notes.append(
            f"Not in the table, or not in the model: {', '.join(missing)}. Supply voltage tells "
            "voltage_sag from a weak thruster; shaft speed helps."
        )
    notes.append(
        "thrust_deduction is a matter of a thruster in its hull; of a thruster alone it is the "
        "same as thruster_degraded, and no mooring table separates them."
    )
    return notes


def _series(whole: BenchComparison, found: BenchFit, marked: BoolArray) -> tuple[CodeSeries, ...]:
    after = predict(whole.model, found.values, whole.table.code, whole.stack.channels)
    return tuple(
        CodeSeries(
            channel=channel,
            unit=UNITS[channel],
            code=tuple(whole.table.code.tolist()),
            measured=tuple(whole.table.mean[channel].tolist()),
            before=tuple(whole.nominal[channel].tolist()),
            after=tuple(after[channel].tolist()),
            held_out=tuple(marked.tolist()),
        )
        for channel in whole.stack.channels
    )
