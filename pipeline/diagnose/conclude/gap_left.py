"""What gap an answer leaves on the runs it was found from, and what that says against it.

The evidence weighs what each half second of the readings shows, and where the runs agree on little
it is worth little: a vehicle whose model is wrong everywhere scatters from run to run, and a moment
that pitches it over for minutes counts no more than a flaw of its drag. What the answers predict
some seconds ahead is another look at the same runs. A healthy vehicle is off by its floor, which is
one standard deviation of what its parameters and disturbances do; an answer that leaves a channel
r floors off says that this vehicle is r deviations from ordinary.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.conclude.consequences import Ahead
from pipeline.diagnose.gap.forecast import forecast, rms
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.verdict import departures_of, effect_alone
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.linear.linear_model import vector_of
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.errors import CannotComputeError

#: Answers below this share of the most probable are not looked at, and so many are at most.
_COUNTS, _MOST = 1e-9, 10
#: Deviations beyond which a channel says no more.
_FARTHEST = 4.0


def gaps_left(found: Search, ahead: Ahead, answered: Answers) -> dict[str, float]:
    """Look at what the effects that count leave unexplained; see `surprise`."""
    effects = [one for one in answered.ranking if one.name not in {NONE, UNKNOWN}]
    most = max((one.probability for one in effects), default=0.0)
    looked_at = [one for one in effects[:_MOST] if one.probability >= _COUNTS * most]
    return {one.name: _surprise_of(found, ahead, one) for one in looked_at}


def _surprise_of(found: Search, ahead: Ahead, one: Candidate) -> float:
    try:
        return surprise(ratios_left(found, ahead, one))
    except CannotComputeError:
        return np.inf


def ratios_left(found: Search, ahead: Ahead, one: Candidate | None) -> dict[str, float]:
    """Error over the healthy floor by channel, on the windows that answers are found from.

    With the effects of an answer alone, without the ordinary departures that go with them; with
    none where there is no answer.

    Raises
    ------
    CannotComputeError
        Where no vehicle can be that.
    """
    after = ahead.before
    if one is not None:
        best = departures_of(found, one, one.finding)
        vector = vector_of(found.setting, effect_alone(found, best, one.finding) + ahead.unstated)
        after = forecast(ahead.near, vector, ahead.channels)
    ratios = {}
    for name in after.errors:
        own = found.chosen[after.window[name]]
        if own.any():
            floor = ahead.before.healthy_floor(name, ahead.spread, own)
            ratios[name] = rms(after.counted(name, own, floor)) / max(floor, 1e-12)
    return ratios


def surprise(ratios: Mapping[str, float]) -> float:
    """Return half the square of the deviations beyond the first, summed over the channels.

    Parameters
    ----------
    ratios : mapping
        Error over the healthy floor, by channel.

    Examples
    --------
    >>> surprise({"u": 0.8, "w": 2.0})
    1.5
    """
    return float(sum(0.5 * max(min(one, _FARTHEST) ** 2 - 1.0, 0.0) for one in ratios.values()))


def by_gap_left(ranking: Sequence[Share], left: Mapping[str, float]) -> tuple[Share, ...]:
    """Weigh effects against each other by the gap that they leave.

    What they have together against `none` and `unknown` stays: of that other rules decide.

    Parameters
    ----------
    ranking : sequence of Share
        Answers, most probable first.
    left : mapping
        `surprise` at what the answers leave, of those that were looked at.
    """
    looked_at = [one for one in ranking if one.name in left]
    least = min((left[one.name] for one in looked_at), default=np.inf)
    if not np.isfinite(least):
        return tuple(ranking)
    worth = {one.name: one.probability * np.exp(least - left[one.name]) for one in looked_at}
    whole, before = sum(worth.values()), sum(one.probability for one in looked_at)
    if whole <= 0.0:
        return tuple(ranking)
    shares = [
        replace(one, probability=float(worth[one.name] / whole * before))
        if one.name in worth
        else one
        for one in ranking
    ]
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))
