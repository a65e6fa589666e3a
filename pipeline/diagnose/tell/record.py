"""The record of a diagnosis: the five parts of the answer, and what they rest on."""

from collections.abc import Sequence

from pipeline.diagnose.case import Case
from pipeline.diagnose.conclude.beside_errors import alike_beside, names_beside, ranking_beside
from pipeline.diagnose.conclude.conclusion import Conclusion
from pipeline.diagnose.conclude.consequences import nothing_added
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.conclude.shaft_speeds import ShaftsSeen
from pipeline.diagnose.conclude.where import where_told
from pipeline.diagnose.gap.channel_gaps import shown_channels
from pipeline.diagnose.gap.forecast import AHEAD_S
from pipeline.diagnose.gap.regimes import ratios_of, regime_gaps
from pipeline.diagnose.gap.series import series_of
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.verdict import ranking_of
from pipeline.diagnose.judging.confusability import confusable
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.diagnose.tell.next_run import next_run
from pipeline.diagnose.tell.notes import notes_on, stages_told
from pipeline.diagnose.tell.sentence import sentence
from pipeline.records.diagnosis import (
    VELOCITIES,
    ChannelNoiseCheck,
    Detail,
    DiagnosisRecord,
    Evidence,
    Gap,
    Verdict,
)
from pipeline.records.run_table import RunTable


def record_of(  # noqa: PLR0917 - one caller
    case: Case,
    runs: Sequence[RunTable],
    found: Search,
    seen: GapSeen,
    concluded: Conclusion,
    shafts: ShaftsSeen | None,
    limits: Calibration,
) -> DiagnosisRecord:
    """Write down a diagnosis; how long it took is told by who made it.

    Parameters
    ----------
    case : Case
        Vehicle and runs.
    runs : sequence of RunTable
        Those that were explained, then those held out.
    found, seen, concluded
        Where the search ended, the gap, and what is said.
    shafts : ShaftsSeen or None
        What the shaft speeds tell, where they are asked.
    limits : Calibration
        Thresholds.
    """
    answered, led_to, ahead = concluded.answered, concluded.led_to, seen.ahead
    names = names_beside(concluded.said.names, case.errors)
    ambiguous = alike_beside(concluded.said.ambiguous, case.errors)
    ranking = ranking_beside(
        ranking_of(found, answered, led_to.closed, concluded.top, limits), case.errors
    )
    first, probability = ranking[0], answered.ranking[0].probability
    if concluded.names_effects:
        after, closed = led_to.after, led_to.closed
    else:
        # what was looked at and is not named goes into no model
        after, closed = ahead.before, nothing_added(ahead)
    acts_with = ahead.before if case.errors else None
    if concluded.acting is not None:
        acts_with = concluded.acting.after
    return DiagnosisRecord(
        vehicle=case.name,
        runs=tuple(run.name for run in case.runs),
        holdout=tuple(run.name for run in case.holdout),
        gap=Gap(
            channels=dict(seen.channels),
            where=where_told(
                seen,
                led_to,
                found.setting,
                runs,
                after=acts_with,
                unknown=UNKNOWN in names,
            ),
            by_regime=regime_gaps(seen.every, ratios_of(ahead.stated, ahead.spread, AHEAD_S)),
        ),
        verdict=Verdict(
            effects=names,
            probability=probability,
            ambiguous_with=ambiguous,
            detail=Detail(
                thruster=first.thruster, axes=tuple(VELOCITIES[axis] for axis in first.axes)
            ),
            sentence=sentence(
                names,
                probability,
                ambiguous,
                ranking,
                led_to.left,
                concluded.said.too_small,
                limits.least_gap,
            ),
        ),
        ranking=ranking,
        shrink=closed,
        confusable=tuple(confusable(concluded.top.judged.ground, found.groups)),
        next_run=next_run(case, found, answered, ambiguous) if ambiguous else None,
        leftover=led_to.left,
        evidence=_evidence(case, runs, found, answered, shafts, limits),
        series=series_of(
            ahead.near,
            runs,
            ahead.stated,
            after,
            ahead.held,
            ahead.within_s,
            shown_channels(seen.channels),
        ),
        notes=notes_on(case, found, concluded.top),
        elapsed_s=0.0,
    )


def _evidence(  # noqa: PLR0917 - one caller
    case: Case,
    runs: Sequence[RunTable],
    found: Search,
    answered: Answers,
    shafts: ShaftsSeen | None,
    limits: Calibration,
) -> Evidence:
    """Say what the answer rests on, for the sceptic."""
    return Evidence(
        windows=int(found.chosen.sum()),
        window_s=max(w.duration_s for w in found.setting.bench.stack.windows),
        readings=len(found.model.readings),
        linearisations=found.rounds,
        force_scale=answered.force_scale,
        noise={
            name: ChannelNoiseCheck(variance=one.variance, lag1=one.lag1, widened_by=one.widen)
            for name, one in found.noise.items()
        },
        stages=stages_told(case, runs, found, answered, shafts),
        calibrated=limits.source,
        healthy_runs=tuple(run.name for run in case.healthy),
    )
