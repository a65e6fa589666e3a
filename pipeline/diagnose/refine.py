"""Compare the best answers fairly: each judged at its own best point of the full model.

The linear model is exact where it was taken, so the hypothesis it was taken at has an advantage
over the others. Here every answer is simulated with its own most probable unknowns, and judged by
the readings as they are seen from there.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from pipeline.diagnose.answer import Answers
from pipeline.diagnose.elimination import ForcePrior, Grams, marginal, solve
from pipeline.diagnose.evidence import fit
from pipeline.diagnose.hypotheses import Finding, judge, log_evidence_of, prior_of, with_ordinary
from pipeline.diagnose.linear_model import (
    LinearModel,
    Point,
    readings_from_zero,
    realisable,
    residual_at,
)
from pipeline.diagnose.search import Judged, Search, force_prior, part
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Simulations with which an answer's own point is found.
_STEPS = 3


def refined(found: Search, first: Answers, most: int) -> Search:
    """Search whose strongest hypotheses, and the one with nothing, are judged at their own points.

    Parameters
    ----------
    found : Search
        As it ended.
    first : Answers
        The answers of the linear model; the first `most` of them are taken, and `none`.
    most : int
        How many.
    """
    wanted = [one for one in first.ranking if one.finding is not None][:most]
    changes: dict[tuple[int, ...], float] = {}
    level = first.ranking[0].judged
    nothing = _correction(found, level, None)
    changes[()] = nothing if np.isfinite(nothing) else 0.0
    for one in wanted:
        if one.finding is not None and one.finding.which not in changes:
            changes[one.finding.which] = _correction(found, level, one.finding)
    # what was not judged anew gets what a part of it got
    least = min(value for value in changes.values() if np.isfinite(value))

    def gained(finding: Finding) -> float:
        own = changes.get(finding.which)
        if own is not None:
            return own
        inside = [which for which in changes if which and set(which) <= set(finding.which)]
        return changes[max(inside, key=len)] if inside else least

    judged = tuple(
        replace(
            one,
            nothing=one.nothing + changes[()],
            singles=tuple(
                replace(f, log_evidence=f.log_evidence + gained(f) - changes[()])
                for f in one.singles
            ),
            pairs=tuple(
                replace(f, log_evidence=f.log_evidence + gained(f) - changes[()]) for f in one.pairs
            ),
        )
        for one in found.judged
    )
    return replace(found, judged=judged)


def _correction(found: Search, judged: Judged, finding: Finding | None) -> float:
    """Log evidence of a hypothesis seen from its own point, less that of the linear model."""
    model, normal = found.model, found.grams
    prior = prior_of(found.prior, finding)
    forces = force_prior(found.setting, judged.level)
    before = _log_evidence(found, normal, judged, finding)
    for _ in range(_STEPS):
        left = marginal(part(normal, found.chosen), forces)
        departures = fit(left, prior).mean
        try:
            point, residual = own_point(model, normal, forces, departures)
        except CannotComputeError:
            # no vehicle can have these values
            return -np.inf
        if not np.isfinite(residual).all():
            return -np.inf
        seen = replace(model, readings=readings_from_zero(model, point, residual))
        normal = _with_readings(found.grams, seen)
    return _log_evidence(found, normal, judged, finding) - before


def own_point(
    model: LinearModel, normal: Grams, forces: ForcePrior, departures: FloatArray
) -> tuple[Point, FloatArray]:
    """Most probable point at given departures, and the residual simulated there."""
    possible = realisable(model.setting.coordinates, departures)
    best = solve(normal, forces, possible)
    point = Point(best.starts, best.forces, best.shared, possible)
    return point, residual_at(model.setting, point)


def _with_readings(normal: Grams, model: LinearModel) -> Grams:
    """Renew the normal equations for other readings: only their row and column change."""
    bounds = model.setting.bench.stack.bounds
    columns = np.concatenate([model.local, model.shared, model.extra, model.departures], axis=1)
    cross, rest = normal.cross.copy(), normal.rest.copy()
    local = model.local.shape[1]
    for number, (a, b) in enumerate(pairwise(bounds)):
        own = model.readings[a:b]
        product = columns[a:b].T @ own
        cross[number, :, -1] = product[:local]
        rest[number, :-1, -1] = rest[number, -1, :-1] = product[local:]
        rest[number, -1, -1] = own @ own
    return replace(normal, cross=cross, rest=rest)


def _log_evidence(found: Search, normal: Grams, judged: Judged, finding: Finding | None) -> float:
    forces = force_prior(found.setting, judged.level)
    ground = with_ordinary(marginal(part(normal, found.chosen), forces), found.prior)
    gain = 0.0
    if finding is not None and finding.which:
        gain = judge(ground, found.setting.coordinates, finding.which)[0]
    return log_evidence_of(ground) + gain
