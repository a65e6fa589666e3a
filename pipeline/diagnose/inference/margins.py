r"""By how much an answer leads a simpler one, where the linear model and the full one disagree.

Every answer is seen twice: by the linear model around the point that was found, and from its own
point (`refine`). A vehicle that tumbles, or whose model is poor, is far from linear, and then what
the two say of the same answer differs by as much as the answers differ. Such a lead is worth what
both agree on, or what is left of the lead when it is known no better than to that difference
(a normal error u of a log ratio of evidence r, averaged out; MacKay 1992, "The evidence framework
applied to classification networks", moderated outputs):

.. math:: \max\left(\min(l, r),\; r / \sqrt{1 + \pi u^2 / 8}\right), \qquad u = r - l
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from pipeline.diagnose.inference.answer import Candidate
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.search import Judged, Search


def trusted_lead(linear: float, full: float) -> float:
    """Return what a lead in log evidence is worth of which the two models say `linear`, `full`.

    >>> trusted_lead(27.9, 27.9)
    27.9
    >>> round(trusted_lead(2.2, 49.0), 1)
    2.2
    """
    if full < 0.0:
        return -trusted_lead(-linear, -full)
    if not np.isfinite(full):
        return full
    off = full - linear
    return max(min(linear, full), full / float(np.sqrt(1.0 + np.pi * off**2 / 8.0)))


def cautious(
    linear: Search, full: Search, top: Candidate, sure: Collection[tuple[int, ...]] = ()
) -> Search:
    """Search in which the first answer leads simpler ones only by what both models can be trusted.

    An effect leads `none` so, and two effects each of them alone.

    Parameters
    ----------
    linear : Search
        As seen by the linear model.
    full : Search
        The same answers, each seen from its own point.
    top : Candidate
        The first answer of `full`; where it is `none`, nothing changes.
    sure : collection of tuple
        What is wide in the hypotheses that were seen where they stay: of two such answers the lead
        is what it is.
    """
    if top.finding is None:
        return full
    top_sure = top.finding.which in sure
    number = next(k for k, one in enumerate(full.judged) if one is top.judged)
    before, after = linear.judged[number], full.judged[number]
    rows = [*after.singles, *after.pairs]
    place = next(k for k, one in enumerate(rows) if one is top.finding)
    first_linear = before.nothing + [*before.singles, *before.pairs][place].log_evidence
    first_full = after.nothing + top.finding.log_evidence
    # the same effects with one of them left out
    simpler = {one for one in top.finding.effects if len(top.finding.effects) > 1}

    def behind(linear_value: float, full_value: float) -> float:
        """Where a simpler answer stands: behind the first by what the lead is worth."""
        return first_full - trusted_lead(first_linear - linear_value, first_full - full_value)

    def kept_near(old: Judged, new: Judged) -> Judged:
        certain = top_sure and () in sure
        nothing = new.nothing if certain else behind(old.nothing, new.nothing)

        def kept(seen: Finding, one: Finding) -> Finding:
            value = new.nothing + one.log_evidence
            doubted = not (top_sure and one.which in sure) and np.isfinite(value)
            if doubted and len(one.effects) == 1 and one.effects[0] in simpler:
                value = behind(old.nothing + seen.log_evidence, value)
            return replace(one, log_evidence=value - nothing)

        return replace(
            new,
            nothing=nothing,
            singles=tuple(map(kept, old.singles, new.singles)),
            pairs=tuple(map(kept, old.pairs, new.pairs)),
        )

    judged = tuple(kept_near(old, new) for old, new in zip(linear.judged, full.judged, strict=True))
    return replace(full, judged=judged)
