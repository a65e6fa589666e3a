"""From runs to weighed answers: where the model is linear, what all say there, and at their own."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.diagnose.case import Case, led_by, setting_of, thinned
from pipeline.diagnose.inference.answer import Answers, Candidate, answers
from pipeline.diagnose.inference.approach import approach
from pipeline.diagnose.inference.healthy import learn
from pipeline.diagnose.inference.held_out import checked
from pipeline.diagnose.inference.margins import cautious
from pipeline.diagnose.inference.own_point import with_own_values
from pipeline.diagnose.inference.refine import Refined, possible_alone, refined, that_depart
from pipeline.diagnose.judging.search import Near, Search, ordinary_prior, search
from pipeline.diagnose.linear.linear_model import Setting, vector_of
from pipeline.diagnose.linear.scales import levels
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.windows import Window
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Answers that are judged at their own points.
_REFINED = 6
#: Departure (in units of half the plausible range) by which the first answer's own point differs
#: from where all was judged, when all is judged anew from there.
_ELSEWHERE = 0.3
#: Windows that suffice for finding the point of linearisation.
_ENOUGH = 16
#: Every how manyth window is held out where no run is.
HELD_OUT = 4


def infer(
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    limits: Calibration,
    threads: int,
) -> tuple[Search, Answers]:
    """Weigh all answers on the runs of a case.

    Parameters
    ----------
    case : Case
        Vehicle, candidates and healthy runs.
    runs : sequence of RunTable
        Those to be explained, then those held out.
    channels : sequence of ChannelNoise
        What to use of them.
    limits : Calibration
        Thresholds.
    threads : int
        Simulations side by side.

    Returns
    -------
    tuple of Search and Answers
        Everything around the point of linearisation, and the answers in order.

    Raises
    ------
    CannotComputeError
        Where no diagnosis can be given; the text says why.
    """
    healthy = learn(case, threads) if case.healthy else None
    known_well = healthy is not None
    every_level = levels(healthy_known=known_well)
    force_unit = None if healthy is None else healthy.force_unit
    widen = None if healthy is None else dict(healthy.widen)
    scatter = None if healthy is None else healthy.scatter

    def few(windows: Sequence[Window]) -> BoolArray:
        return thinned(held_in(case, windows), _ENOUGH)

    def lead(setting: Setting, vector: FloatArray) -> Setting:
        return led_by(setting, case.packed, runs, channels, vector)

    rough = setting_of(case, runs, channels, force_unit=force_unit, threads=threads, taken=few)
    prior = ordinary_prior(rough) if healthy is None else healthy.prior

    def around(near: Near) -> tuple[Search, Answers]:
        """Judge all hypotheses around a point."""
        vector = vector_of(rough, near.departures)
        setting = setting_of(
            case, runs, channels, force_unit=force_unit, threads=threads, vector=vector
        )
        chosen = held_in(case, setting.bench.stack.windows)
        found = search(setting, near, every_level, chosen, widen, scatter)
        return found, answers(found, limits, healthy_known=known_well)

    def at_own_points(
        found: Search, first: Answers, elsewhere: float = np.inf
    ) -> tuple[Refined, Candidate]:
        """Judge the strongest hypotheses at their own points."""
        own = refined(found, first, lead, _REFINED, elsewhere)
        return own, answers(own.search, limits, healthy_known=known_well).ranking[0]

    near = approach(rough, lead, prior, every_level, healthy_known=known_well)
    found, first = around(near)
    own, top = at_own_points(found, first, _ELSEWHERE)
    for further in (_ELSEWHERE, _ELSEWHERE, np.inf):
        there = own.seen_from(top)
        here = found.model.point.departures
        if there is None or float(np.abs(there[0] - here).max()) <= _ELSEWHERE:
            break
        try:
            again = around(replace(near, departures=there[0], level=there[1]))
            own, top = at_own_points(*again, further)
        except CannotComputeError:
            # no vehicle can follow from that point: what all say from here counts
            own, top = at_own_points(found, first)
            break
        found, first = again
    found = cautious(found, own.search, top, own.sure)
    if healthy is not None:
        found = replace(found, floor_scatter=healthy.floor_scatter)
    answered = possible_alone(found, answers(found, limits, healthy_known=known_well))
    answered = that_depart(found, answered, limits.interval_factor)
    return found, with_own_values(found, checked(found, answered, limits))


def held_in(case: Case, windows: Sequence[Window]) -> BoolArray:
    """Windows that may speak: those of the runs, less every fourth where no run is held out."""
    if case.holdout:
        return np.array([window.run < len(case.runs) for window in windows])
    place: dict[int, int] = {}
    chosen = []
    for window in windows:
        count = place.get(window.run, 0)
        place[window.run] = count + 1
        chosen.append(count % HELD_OUT != HELD_OUT - 2)
    return np.array(chosen)
