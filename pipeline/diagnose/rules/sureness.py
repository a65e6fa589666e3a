"""What is not sure does not lead: an effect goes before a pair, and `none` before an effect.

Nor does a supply that nobody measured, where there is hardly a gap.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN

#: The effect of the supply.
_SUPPLY = "voltage_sag"
#: Share of their probability that answers keep which stand beside `none`.
BESIDE_NONE = 0.2


def with_sure_second(ranking: Sequence[Share], limits: Calibration) -> tuple[Share, ...]:
    """Let an effect alone go before itself with a second one that is not sure.

    Where the first answer is a pair less probable than `verdict`, and one of the two alone is
    within what is left, they change places. The second is then named as what cannot be told.
    """
    top = ranking[0]
    alone = next((one for one in ranking if one.name in top.name.split("+")), top)
    doubtful = top.probability < limits.verdict and alone.probability >= 1.0 - limits.verdict
    if alone is top or not doubtful:
        return tuple(ranking)
    others = [one for one in ranking if one not in {top, alone}]
    shares = [Share(alone.name, top.probability), Share(top.name, alone.probability), *others]
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def with_sure_effect(
    ranking: Sequence[Share],
    held_out: float,
    worst_ratio: float,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> tuple[Share, ...]:
    """Let `none` go before effects that are less probable than `verdict`, if it is what is left.

    They change places, and the effects are named as what cannot be told from it; but not where what
    took no part makes up for it, or the gap is one that no healthy vehicle has.

    Parameters
    ----------
    held_out : float
        Log evidence of what took no part for the first answer; see `Left`.
    ranking, worst_ratio, limits, healthy_known
        As of `with_gap`.
    """
    top = ranking[0]
    none = next((one for one in ranking if one.name == NONE), top)
    most = limits.most_none_gap_healthy if healthy_known else limits.most_none_gap
    doubtful = top.probability < limits.verdict and none.probability >= 1.0 - limits.verdict
    # with all windows: what speaks against the first answer has been counted
    against = none.probability * math.exp(-max(held_out, 0.0))
    doubtful = doubtful and top.probability < limits.verdict * (top.probability + against)
    if top.name in {NONE, UNKNOWN} or not doubtful or worst_ratio > most:
        return tuple(ranking)
    others = (one for one in ranking if one not in {top, none})
    shares = (Share(NONE, top.probability), Share(top.name, none.probability), *others)
    return tuple(sorted(shares, key=lambda one: (-one.probability, one.name)))


def with_measured_supply(
    ranking: Sequence[Share], worst_ratio: float, limits: Calibration, *, healthy_known: bool
) -> tuple[Share, ...]:
    """Let `none` go before a supply that neither a voltage nor a shaft showed.

    What the supply changes of all thrust, stated uncertainties take up. What is left is the shape
    of the thrust, and that shows as well what a vehicle file does not say of a thruster's shaft: a
    vehicle exactly as stated, whose shafts take some hundredths of a second more at small codes,
    had a supply 10 % too high with thrust deduction, by 27 nats. Where the gap is one that no
    healthy vehicle has, the supply counts all the same.

    Parameters
    ----------
    ranking, worst_ratio, limits, healthy_known
        As of `with_sure_effect`.
    """
    most = limits.most_none_gap_healthy if healthy_known else limits.most_none_gap
    if _SUPPLY not in ranking[0].name.split("+") or worst_ratio > most:
        return tuple(ranking)
    return none_first(ranking)


def none_first(ranking: Sequence[Share]) -> tuple[Share, ...]:
    """Put `none` first; all others keep a share of their probability, and their order.

    >>> [(one.name, round(one.probability, 3)) for one in none_first([Share("lift", 1.0)])]
    [('none', 0.8), ('lift', 0.2)]
    """
    beside = tuple(
        replace(one, probability=one.probability * BESIDE_NONE)
        for one in ranking
        if one.name != NONE
    )
    return Share(NONE, 1.0 - sum(one.probability for one in beside)), *beside
