"""Rates with exact bounds, and figures, of a campaign.

Bounds are those of Clopper and Pearson 1934, Biometrika 26(4), 404-413, at 95 %.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from pipeline.records.base import Record


class Rate(Record):
    """A share with its bounds; `share` is None where no case asks the question."""

    question: str
    stratum: str
    yes: int
    cases: int
    share: float | None
    low: float | None
    high: float | None
    goal: str = ""
    met: bool | None = None


class QuantileFigure(Record):
    """A figure that is no share: median, 90th percentile, mean."""

    question: str
    stratum: str
    cases: int
    median: float | None
    p90: float | None
    goal: str = ""
    met: bool | None = None
    mean: float | None = None


def clopper_pearson(yes: int, cases: int) -> tuple[float, float]:
    """Exact 95 % bounds of a share.

    >>> low, high = clopper_pearson(0, 300)
    >>> low, round(high, 4)
    (0.0, 0.0122)
    """
    from scipy.stats import binomtest

    low, high = binomtest(yes, cases).proportion_ci(method="exact")
    return float(low), float(high)


@dataclass(frozen=True)
class Goal:
    """The range that a share is to lie in, and how a table words it."""

    text: str
    low: float = 0.0
    high: float = 1.0


def at_least(share: float) -> Goal:
    """Return the goal that a share reaches a limit.

    >>> at_least(0.95).text
    '>= 95 %'
    """
    return Goal(f">= {100.0 * share:g} %", low=share)


def at_most(share: float) -> Goal:
    """Return the goal that a share keeps below a limit."""
    return Goal(f"<= {100.0 * share:g} %", high=share)


def between(low: float, high: float) -> Goal:
    """Return the goal that a share lies in a range."""
    return Goal(f"{100.0 * low:g}-{100.0 * high:g} %", low, high)


def rate(
    question: str, stratum: str, answers: Iterable[bool | None], goal: Goal | None = None
) -> Rate:
    """Count the cases that answer a question; None does not count."""
    asked = [answer for answer in answers if answer is not None]
    yes = sum(asked)
    share = yes / len(asked) if asked else None
    low, high = (None, None) if share is None else clopper_pearson(yes, len(asked))
    return Rate(
        question=question,
        stratum=stratum,
        yes=yes,
        cases=len(asked),
        share=share,
        low=low,
        high=high,
        goal="" if goal is None else goal.text,
        met=None if goal is None or share is None else goal.low <= share <= goal.high,
    )


def figure(
    question: str,
    stratum: str,
    values: Iterable[float | None],
    goal: str = "",
    met: Callable[[float, float, float], bool] | None = None,
) -> QuantileFigure:
    """Median, 90th percentile and mean of what is known; `met` is asked with the three."""
    known = np.array([value for value in values if value is not None], float)
    if not known.size:
        return QuantileFigure(
            question=question, stratum=stratum, cases=0, median=None, p90=None, goal=goal
        )
    median, p90, mean = (
        float(value) for value in (np.median(known), np.percentile(known, 90), known.mean())
    )
    return QuantileFigure(
        question=question,
        stratum=stratum,
        cases=known.size,
        median=median,
        p90=p90,
        goal=goal,
        met=None if met is None else met(median, p90, mean),
        mean=mean,
    )
