"""A hypothesis linear around its own point: its most probable departures."""

from dataclasses import replace

import numpy as np

from pipeline.diagnose.elimination import Grams, grams, marginal
from pipeline.diagnose.evidence import Fit, fit
from pipeline.diagnose.hypotheses import (
    IMPOSSIBLE,
    Finding,
    judge,
    log_evidence_of,
    prior_of,
    with_ordinary,
)
from pipeline.diagnose.linear_model import BEYOND, realisable, vector_of
from pipeline.diagnose.search import Judged, Search, force_prior, part
from pipeline.diagnose.tangent import linear_model
from pipeline.diagnose.trials import Lead
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray


def judged_anew(
    found: Search, lead: Lead, judged: Judged, finding: Finding | None
) -> tuple[float, FloatArray]:
    """Log evidence of a hypothesis linear around its own point, less that of the linear model.

    With the departures (g,) of that point.

    What the derivatives of another point promise may be nothing that a vehicle does: one that
    nearly capsizes there. So the way begins at what is ordinary, with the effect as it was found.
    """
    every = found.setting.coordinates
    prior, forces = prior_of(found.prior, finding), force_prior(found.setting, judged.level)
    which = () if finding is None else finding.which
    at = found.prior.mean.copy()
    if finding is not None:
        at[list(which)] = finding.mean
    free = tuple(k for k, one in enumerate(every) if one.ordinary > 0.0 or k in which)
    reached, own = -np.inf, at
    # on the way what is stated keeps its derivatives; where all is judged it has its own
    for renew in (which, free):
        at = realisable(every, at)
        try:
            led = lead(found.setting, vector_of(found.setting, at))
        except CannotComputeError:
            # no vehicle can have these values
            break
        point = replace(led.origin(), departures=at)
        there = linear_model(led, point, known=found.model, renew=renew)
        if there.lost > found.model.lost:
            break
        normal = grams(there)
        reached, own = log_evidence_at(found, normal, judged, finding), at
        best = fit(marginal(part(normal, found.chosen), forces), prior)
        if finding is not None and cannot_be(found, finding, best):
            return -np.inf, own
        at = np.where(np.isin(np.arange(at.size), free), best.mean, 0.0)
    return reached - log_evidence_at(found, found.grams, judged, finding), own


def log_evidence_at(found: Search, normal: Grams, judged: Judged, finding: Finding | None) -> float:
    """Log evidence of a hypothesis by the normal equations of some point."""
    forces = force_prior(found.setting, judged.level)
    ground = with_ordinary(marginal(part(normal, found.chosen), forces), found.prior)
    gain = 0.0
    if finding is not None and finding.which:
        gain = judge(ground, found.setting.coordinates, finding.which)[0]
    return log_evidence_of(ground) + gain


def cannot_be(found: Search, finding: Finding, best: Fit) -> bool:
    """Whether a departure of a hypothesis, the ordinary part included, is beyond what can be."""
    for index in finding.which:
        one = found.setting.coordinates[index]
        if one.leads:
            continue
        low, high = one.bounds
        far = IMPOSSIBLE * float(best.std[index]) + BEYOND
        if not low - far <= best.mean[index] <= high + far:
            return True
    return False
