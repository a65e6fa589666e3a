"""Thresholds from generated cases: what mistakes cost, and the search for the least cost."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from pipeline.diagnose.conclude.case_evidence import CaseEvidence
from pipeline.diagnose.conclude.gap_left import by_gap_left
from pipeline.diagnose.inference.held_out import with_held_out
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.decision import Decided, decide, for_the_gap, with_gap
from pipeline.diagnose.rules.helping import demote_without_heldout_gain
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.sureness import with_sure_second
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN, weigh

#: Values that are tried, one threshold after the other. `verdict` is not: what stands alone is to
#: be 95 % probable, whatever that costs in further members of the set.
TRIED: dict[str, tuple[float, ...]] = {
    "exponent": (0.15, 0.25, 0.35, 0.5, 0.7, 0.85, 1.0),
    "none": (0.3, 0.45, 0.6, 0.75, 0.9, 0.97),
    "pair": (0.001, 0.005, 0.02, 0.05, 0.1),
    "pair_share": (0.0, 0.02, 0.05, 0.1, 0.2, 0.4),
    "held_out": (0.0, 0.5, 1.0, 2.0, 4.0),
    "left_over": (0.1, 0.2, 0.3, 0.45, 0.6, 0.8),
    "set_level": (0.9, 0.95, 0.99, 0.999),
    "most_force": (1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 9.0),
    "most_force_healthy": (1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 9.0),
    "most_level": (2.0, 4.0, 8.0, 16.0),
    "most_level_healthy": (2.0, 3.0, 6.0, 12.0),
    "least_gap": (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7),
    "most_none_gap": (2.0, 2.5, 3.0, 4.0, 6.0),
    "most_none_gap_healthy": (1.5, 2.0, 2.5, 3.0, 4.0),
    "most_gap": (1.2, 1.35, 1.5, 1.75, 2.0, 3.0),
}
#: Cost of each mistake; a wrong confident answer is worse than none.
FALSE_ALARM, FALSE_ALARM_SHARED = 12.0, 5.0
CONFIDENTLY_WRONG, CALLED_UNKNOWN, NEEDLESSLY_UNKNOWN = 10.0, 7.0, 5.0
WRONG_FIRST, MISSED = 3.0, 2.0
FURTHER_MEMBER = 0.25
#: A gap below this is no mistake when missed. In healthy floors.
HARDLY_A_GAP = 1.15
#: A threshold is moved where that saves at least as much: less is the chance of a single case.
WORTH_MOVING = 2.0
_ROUNDS = 3


@dataclass(frozen=True)
class Known:
    """A generated case: what was weighed, and what was true.

    Attributes
    ----------
    evidence : CaseEvidence
        Of the diagnosis.
    truth : tuple of str
        Right answer: `none`, effects, or `unknown`.
    gap_ratio : float
        Gap over the healthy floor that the fault opens.
    overlaps : tuple of str
        Effects that are a right answer as well.
    """

    evidence: CaseEvidence
    truth: tuple[str, ...]
    gap_ratio: float
    overlaps: tuple[str, ...] = ()


def decided(one: CaseEvidence, limits: Calibration) -> Decided:
    """Decide on a case as its diagnosis would with other thresholds.

    But for what closes the gap after all where the first answer is `unknown`: that is no number.
    """
    weighed = weigh(one.levels, one.effect_count, limits, healthy_known=one.healthy)
    shares: Sequence[Share] = [Share(w.name, w.probability) for w in weighed]
    shares = with_sure_second(with_held_out(shares, one.held_out, limits), limits)
    shares = with_sure_second(by_gap_left(shares, one.gap_left), limits)
    grown = with_gap(shares, one.worst_ratio, one.effect_count, limits, healthy_known=one.healthy)
    shares = for_the_gap(shares, grown, _left(one, grown))
    shares = demote_without_heldout_gain(
        shares, partial(_left, one), one.worst_ratio, limits, healthy_known=one.healthy
    )
    return decide(
        shares,
        _left(one, shares),
        one.worst_ratio,
        limits,
        healthy_known=one.healthy,
        worst_since=one.worst_since,
    )


def _left(one: CaseEvidence, shares: Sequence[Share]) -> Left | None:
    """Return what the first answer leaves, where that was kept."""
    return one.consequences.get(shares[0].name)


def cost(one: Known, limits: Calibration) -> float:
    """Cost of a verdict; 0 for the right one, alone."""
    said = decided(one.evidence, limits)
    told = {*said.names, *said.ambiguous}
    return _mistake(one, said.names, told) + FURTHER_MEMBER * len(said.ambiguous)


def _mistake(one: Known, names: tuple[str, ...], told: set[str]) -> float:
    inside = set(one.truth) <= told or bool(set(one.overlaps) & told)
    if names == tuple(sorted(one.truth)) or set(one.overlaps) & set(names):
        return 0.0
    if one.truth == (NONE,):
        return FALSE_ALARM_SHARED if NONE in told else FALSE_ALARM
    if names == (NONE,):
        missed = MISSED if inside else MISSED + WRONG_FIRST
        return 0.0 if one.gap_ratio < HARDLY_A_GAP else missed
    if UNKNOWN in names:
        return NEEDLESSLY_UNKNOWN if inside or len(one.truth) > 1 else CALLED_UNKNOWN
    if inside:
        return WRONG_FIRST
    return CONFIDENTLY_WRONG if len(told) == len(names) else CONFIDENTLY_WRONG - MISSED


def total_cost(cases: Sequence[Known], limits: Calibration) -> float:
    """Cost of all cases."""
    return float(np.sum([cost(one, limits) for one in cases]))


def _with(limits: Calibration, name: str, value: float) -> Calibration:
    changed: dict[str, Any] = {name: value}
    return replace(limits, **changed)


def interval_factor(misses: Sequence[float]) -> float:
    """Factor by which intervals must be widened to hold 95 % of the truths.

    Parameters
    ----------
    misses : sequence of float
        Error over the half-width of the interval, of each.

    Examples
    --------
    >>> interval_factor([0.1 * k for k in range(1, 41)])
    3.8
    """
    if not misses:
        return 1.0
    return float(np.round(np.quantile(misses, 0.95), 2))


def search_thresholds(cases: Sequence[Known], first: Calibration) -> tuple[Calibration, float]:
    """Thresholds of least cost, by trying one after the other until none is worth moving.

    Among equals the value next to the middle of those as good is taken: far from where it matters.
    """
    best, least = first, total_cost(cases, first)
    for _ in range(_ROUNDS):
        before = least
        for name, values in TRIED.items():
            trials = [_with(best, name, value) for value in values]
            costs = np.array([total_cost(cases, one) for one in trials])
            good = np.flatnonzero(costs <= costs.min() + 1e-9)
            if costs.min() <= least - WORTH_MOVING:
                best, least = trials[int(good[len(good) // 2])], float(costs.min())
        if least >= before - 1e-9:
            break
    # what a threshold was moved for may be mended by another that was moved later
    for name in TRIED:
        back = _with(best, name, getattr(first, name))
        if total_cost(cases, back) < least + WORTH_MOVING:
            best, least = back, total_cost(cases, back)
    return best, least
