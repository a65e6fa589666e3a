"""The answer: runs against the sound ones, or against the file, written as a diagnosis."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.coordinates import Added, Coordinate
from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.decide import decide, effects_of
from pipeline.diagnose.regression.disturbance import beside_disturbance
from pipeline.diagnose.regression.gained import Gained
from pipeline.diagnose.regression.grid import GridRun, all_at, on_grids
from pipeline.diagnose.regression.known import Learned, Reference, ToldRun
from pipeline.diagnose.regression.next_run import next_run
from pipeline.diagnose.regression.ordinary import beyond_ordinary
from pipeline.diagnose.regression.shrink import shrink_of
from pipeline.diagnose.regression.sizes import sizes
from pipeline.diagnose.regression.taken import with_sizes
from pipeline.diagnose.regression.weigh import pooled, weighed
from pipeline.diagnose.regression.where import STRETCH_S, gap_and_leftover
from pipeline.diagnose.tell.sentence import sentence
from pipeline.effects.effect import AXES
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import (
    NONE,
    UNKNOWN,
    VELOCITIES,
    ChannelNoiseCheck,
    Detail,
    DiagnosisRecord,
    Evidence,
    ParameterEstimate,
    RankedEffect,
    Verdict,
)
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: Shown of a ranking.
_SHOWN = 20
#: Signatures closer than this are alike. [1]
_ALIKE = 0.9
_AS_FILE = "the vehicle file predicts these runs as well as a healthy vehicle"
_AS_SOUND = "these runs differ from the sound ones no more than those differ from each other"
CALIBRATED = (
    "one posterior of a regression; how far noise is trusted is set so that sound runs, or flights "
    "of the file, scatter as they claim; see docs/methods/diagnosis.md"
)


def against(
    case: Case, known: Reference, gained: Sequence[Gained]
) -> tuple[DiagnosisRecord, tuple[EffectSpec, ...]]:
    """Diagnose the runs of a case against what is known of the vehicle.

    Raises
    ------
    CannotComputeError
        For a run that lacks what the sound runs, or the other ones, measured.
    """
    asked = [_asked(case, known, run) for run in case.runs]
    held = [_asked(case, known, run)[0] for run in case.holdout]
    found = weighed_on_all(known, asked, gained)
    held = all_at(held, found.added)
    known, runs, ranking = found.known, found.runs, found.ranking
    said = decide(ranking)
    named = said.names not in {(NONE,), (UNKNOWN,)}
    judged = _held_out(known, held)
    rows = tuple(_ranked(one, known, judged) for one in ranking[:_SHOWN])
    rows += _never(rows, known.directions)
    gap, left = gap_and_leftover(case, known.best, runs, said.first if named else None)
    carrying = tuple(runs[k].run.name for k in said.first.runs) if named else ()
    text = sentence(said.names, said.first.probability, said.ambiguous, rows, left)
    text = _with_runs(text, case, carrying, rows, named=named, by_file=known.by_file)
    shrink, series = shrink_of(case, known, said, runs, held, named=named)
    first = rows[0]
    record = DiagnosisRecord(
        vehicle=case.name,
        runs=tuple(run.name for run in case.runs),
        holdout=tuple(run.name for run in case.holdout),
        gap=gap,
        verdict=Verdict(
            effects=said.names,
            probability=said.first.probability
            if named or said.names == (said.first.name,)
            else 1.0 - said.first.probability,
            ambiguous_with=said.ambiguous,
            detail=Detail(
                thruster=first.thruster, axes=tuple(VELOCITIES[axis] for axis in first.axes)
            )
            if named
            else Detail(),
            sentence=text,
            since=None if known.by_file else ", ".join(run.name for run in case.healthy),
            runs=carrying or tuple(run.name for run in case.runs),
            text=text,
        ),
        ranking=rows,
        shrink=shrink,
        confusable=_confusable(runs, ranking, known),
        next_run=next_run(case, known, ranking, said, found.added),
        leftover=left,
        evidence=_evidence(case, known, runs, ranking),
        series=series,
        notes=(known.told_against,),
        elapsed_s=0.0,
    )
    return record, _specs(said.first, known) if named else ()


@dataclass(frozen=True)
class Weighed:
    """All changes, weighed on all grids; the most probable first.

    `known` has the changes that are taken at their sizes, `added`, as directions of its own. `runs`
    are the asked ones on the grid that predicts best.
    """

    known: Reference
    added: Sequence[Added]
    runs: Sequence[ToldRun]
    ranking: tuple[Change, ...]


def weighed_on_all(
    known: Reference, asked: Sequence[Sequence[GridRun]], gained: Sequence[Gained]
) -> Weighed:
    """Weigh all changes on all grids, of which none is known to be the right one.

    Parameters
    ----------
    known : Reference
        What the sound runs show.
    asked : sequence of sequence of GridRun
        Each run on all grids of it.
    gained : sequence of Gained
        A thruster that is dead by its gains.
    """
    more, added, settled = with_sizes(known, asked, gained)
    grids = zip(*(all_at(one, added) for one in settled), strict=True)
    runs = [learned.told_runs(on_grid) for learned, on_grid in zip(more.grids, grids, strict=True)]
    rankings = [
        _weighed_on(more.directions, learned, on_grid, gained)
        for learned, on_grid in zip(more.grids, runs, strict=True)
    ]
    return Weighed(more, added, runs[0], pooled(rankings))


def _weighed_on(
    directions: Sequence[Coordinate],
    learned: Learned,
    runs: Sequence[ToldRun],
    gained: Sequence[Gained],
) -> tuple[Change, ...]:
    """Weigh all changes on one grid."""
    told = [one.told for one in runs]
    ranking = weighed(told, directions, learned.ordinary, gained, learned.sound)
    return beside_disturbance(learned, runs, ranking)


def _asked(case: Case, known: Reference, run: RunTable) -> list[GridRun]:
    """Put a run on each grid."""
    periods = [one.response.period_s for one in known.grids]
    found = on_grids(case.packed, run, case.vehicle.sensors, known.directions, periods)
    channels = known.best.response.channels
    if found[0].channels != channels:
        others = "other runs" if known.by_file else "sound runs"
        raise CannotComputeError(
            f"{run.name} has the velocities {', '.join(found[0].channels)}, the {others} "
            f"{', '.join(channels)}: name runs with the same channels."
        )
    return found


def _held_out(known: Reference, held: Sequence[GridRun]) -> tuple[FloatArray, FloatArray] | None:
    """Information and score, beyond what is ordinary, of runs that took no part."""
    if not held:
        return None
    learned = known.best
    every = [
        beyond_ordinary(one.tempered(learned.ordinary.share), learned.ordinary.width)
        for one in learned.told(held)
    ]
    return np.sum([one for one, _ in every], axis=0), np.sum([one for _, one in every], axis=0)


def _ranked(
    one: Change,
    known: Reference,
    judged: tuple[FloatArray, FloatArray] | None,
) -> RankedEffect:
    parameters, axes, thrusters = {}, [], {}
    pair = "+" in one.name
    found = sizes(one, known.directions, known.best.ordinary.inexact)
    for k, (value, low, high) in found.items():
        own = known.directions[k]
        name = own.parameter.name
        parameters[f"{own.effect.id}.{name}" if pair else name] = ParameterEstimate(
            value=value, unit=own.parameter.unit, ci95=(low, high)
        )
        if name in AXES:
            axes.append(name)
        if own.target is not None:
            thrusters[own.effect.id] = own.target
    held = None
    if judged is not None and one.which:
        which = list(one.which)
        information, score = judged[0][np.ix_(which, which)], judged[1][which]
        held = float(score @ one.mean - 0.5 * one.mean @ information @ one.mean)
    return RankedEffect(
        effect="+".join(effects_of(one.name)),
        probability=one.probability,
        parameters=parameters,
        gap_closed=None,
        thruster=next(iter(thrusters.values()), None),
        thrusters=thrusters,
        axes=tuple(axes),
        log_evidence=one.evidence,
        held_out_log_evidence=held,
    )


def _never(
    rows: Sequence[RankedEffect], directions: Sequence[Coordinate]
) -> tuple[RankedEffect, ...]:
    """Effects that are not among the first."""
    every = {NONE, UNKNOWN, *(one.effect.id for one in directions if not one.effect.unstated)} - {
        row.effect for row in rows
    }
    return tuple(
        RankedEffect(effect=name, probability=0.0, parameters={}, gap_closed=None, log_evidence=0.0)
        for name in sorted(every)
    )


def _specs(first: Change, known: Reference) -> tuple[EffectSpec, ...]:
    """Effects of the first answer as they are switched on."""
    values: dict[tuple[str, str | None], dict[str, float]] = {}
    found = sizes(first, known.directions, known.best.ordinary.inexact)
    for k, (value, _, _) in found.items():
        one = known.directions[k]
        values.setdefault((one.effect.id, one.target), {})[one.parameter.name] = value
    return tuple(EffectSpec(id_, own, target) for (id_, target), own in values.items())


def _with_runs(
    text: str,
    case: Case,
    carrying: Sequence[str],
    rows: Sequence[RankedEffect],
    *,
    named: bool,
    by_file: bool,
) -> str:
    """Add which runs carry it, and what to do where nothing fits."""
    if named and len(carrying) < len(case.runs):
        text += f" Only in {', '.join(carrying)}."
    if named:
        return text
    if rows[0].effect == NONE:
        # against sound runs no claim is made of the vehicle file
        return text if by_file else text.replace(_AS_FILE, _AS_SOUND)
    others = "what the vehicle file predicts" if by_file else "the sound ones"
    return (
        f"{text} These runs differ from {others} in a way that the library does not name: "
        "see which channels carry it, repeat a sound run, or identify the vehicle anew."
    )


def _confusable(
    runs: Sequence[ToldRun], ranking: Sequence[Change], known: Reference
) -> tuple[tuple[str, str, float], ...]:
    """Effects whose signatures are nearly parallel, among the most probable."""
    information = np.sum([one.told.information for one in runs], axis=0)
    single = [one for one in ranking if one.which and "+" not in one.name][:_SHOWN]
    found: dict[tuple[str, str], float] = {}
    for n, one in enumerate(single):
        for other in single[n + 1 :]:
            i, j = one.which[0], other.which[0]
            names = tuple(sorted({known.directions[i].effect.id, known.directions[j].effect.id}))
            size = float(np.sqrt(information[i, i] * information[j, j]))
            cosine = abs(float(information[i, j])) / size if size > 0.0 else 0.0
            if len(names) == 2 and cosine > _ALIKE:
                key = (names[0], names[1])
                found[key] = max(found.get(key, 0.0), min(cosine, 1.0))
    return tuple((*names, value) for names, value in sorted(found.items()))


def _evidence(
    case: Case, known: Reference, runs: Sequence[ToldRun], ranking: Sequence[Change]
) -> Evidence:
    noise = {}
    for c, name in enumerate(known.best.response.channels):
        left = known.best.response.whitened_of_sound(c)
        noise[name] = ChannelNoiseCheck(
            variance=float(np.mean(left**2)),
            lag1=float(np.mean(left[1:] * left[:-1]) / max(float(np.mean(left**2)), 1e-12)),
            widened_by=float(known.best.trusted**-0.5),
        )
    seconds = sum(float(one.run.time_s[-1]) for one in runs)
    return Evidence(
        windows=max(round(seconds / STRETCH_S), 1),
        window_s=STRETCH_S,
        readings=sum(one.run.velocity.size for one in runs),
        linearisations=1,
        force_scale=1.0,
        noise=noise,
        stages={
            "kinematics": "dead reckoning beside the regression, where a place was measured",
            "dynamics": "regression on flights of the vehicle file"
            if known.by_file
            else "regression on the sound runs",
        },
        calibrated=CALIBRATED,
        healthy_runs=tuple(run.name for run in case.healthy),
        posterior={one.name: one.probability for one in ranking},
    )
