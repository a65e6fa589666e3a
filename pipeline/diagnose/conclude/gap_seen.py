"""What the runs show before anything is decided: the gap, and what it may depend on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeline.diagnose.case import Case
from pipeline.diagnose.conclude.consequences import Ahead, look_ahead
from pipeline.diagnose.gap.channel_gaps import channel_gaps, worst_gap
from pipeline.diagnose.gap.forecast import AHEAD_S, forecast, healthy_spread, whole_runs
from pipeline.diagnose.gap.regimes import Regressor, regressors
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.infer import HELD_OUT
from pipeline.diagnose.judging.search import Search
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.diagnosis import ChannelGap
from pipeline.records.run_table import RunTable


@dataclass(frozen=True)
class GapSeen:
    """The gap of some runs.

    Attributes
    ----------
    ahead : Ahead
        The windows as they are predicted without any answer.
    every : sequence of Regressor
        What a force may depend on, over the windows.
    channels : mapping
        Gap of every channel, against the vehicle file.
    worst_ratio : float
        Error of the worst channel over its healthy floor, beside known errors: what is decided by.
    worst_since : float
        The same since the healthy runs, where there are any: by it nothing that the vehicle had
        when it was well is a gap, nor hides one.
    """

    ahead: Ahead
    every: Sequence[Regressor]
    channels: Mapping[str, ChannelGap]
    worst_ratio: float
    worst_since: float


def gap_seen(  # noqa: PLR0917 - one caller
    case: Case,
    found: Search,
    answered: Answers,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    seed: int,
) -> GapSeen:
    """Predict the runs by the vehicle file and by healthy vehicles like it, and compare.

    Parameters
    ----------
    case : Case
        Vehicle and runs.
    found, answered
        Where the search ended, and its answers.
    runs : sequence of RunTable
        Those to be explained, then those held out.
    channels : sequence of ChannelNoise
        What is used of them.
    seed : int
        Of the vehicles drawn for the healthy floor.
    """
    told = (
        "runs " + ", ".join(run.name for run in case.holdout)
        if case.holdout
        else f"every {HELD_OUT}th window of the runs"
    )
    shortest = min(window.duration_s for window in found.setting.bench.stack.windows)
    ahead = look_ahead(
        found,
        answered,
        runs,
        channels,
        told,
        seed,
        within_s=AHEAD_S if case.holdout else min(AHEAD_S, shortest),
        healthy_known=bool(case.healthy),
        stated=case.stated.vector,
    )
    whole_look = whole_runs(found.setting, runs, channels, ahead.starts)
    whole = forecast(whole_look, ahead.stated_vector, channels)
    whole_spread = healthy_spread(whole_look, ahead.floors, ahead.healthy, channels, whole, seed)
    return GapSeen(
        ahead,
        regressors(found.setting.bench.stack.packed, found.setting.bench.stack.windows, runs),
        channel_gaps(ahead.stated, ahead.spread, whole, whole_spread),
        worst_gap(ahead.before, ahead.spread),
        worst_gap(ahead.well, ahead.well_spread),
    )
