"""Judge every hypothesis on all windows, linear around one point."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.judging.hypotheses import (
    Finding,
    Group,
    groups_of,
    log_evidence_of,
    screen,
    total_departures,
    with_ordinary,
)
from pipeline.diagnose.judging.pairs import pairs, pairs_under
from pipeline.diagnose.judging.scatter import scatter_between_runs
from pipeline.diagnose.linear.elimination import ForcePrior, Grams, Marginal, grams, marginal, solve
from pipeline.diagnose.linear.evidence import Prior, held_at
from pipeline.diagnose.linear.linear_model import (
    LinearModel,
    Setting,
    realisable,
)
from pipeline.diagnose.linear.most_probable import linear_near
from pipeline.diagnose.linear.noise_check import NoiseFound, noise_found, residual_with, widened
from pipeline.diagnose.linear.scales import Level
from pipeline.errors import CannotComputeError
from pipeline.types import BoolArray, FloatArray

#: Ordinary departures go no further than this from one linearisation to the next, in deviations.
_MOST_ORDINARY = 4.0
#: Single effects from which pairs are built.
_FIRST_EFFECTS = 4
#: Effects judged under forces along one axis: the strongest of the others.
_STRONG = 6
#: Share of the time in which the simulation may run away.
_MOST_LOST = 0.3
#: Levels of the force under which pairs are built.
_LEVELS_WITH_PAIRS = 2


@dataclass(frozen=True)
class Judged:
    """All hypotheses under one level of the outside force."""

    level: Level
    found: Marginal
    ground: Marginal
    nothing: float
    """Log evidence with nothing wide."""
    singles: tuple[Finding, ...]
    pairs: tuple[Finding, ...]


@dataclass(frozen=True)
class Search:
    """Where the search ended."""

    model: LinearModel
    grams: Grams
    prior: Prior
    judged: tuple[Judged, ...]
    groups: dict[Group, tuple[int, ...]]
    noise: dict[str, NoiseFound]
    rounds: int
    chosen: BoolArray
    """(windows,) those that took part; the others were held out."""
    reach: FloatArray
    """(g,) what a unit of each departure moves the worst channel by, over its healthy floor."""
    floor_scatter: FloatArray | None = None
    """(g,) as of `Healthy`; None where no healthy runs showed it."""

    @property
    def setting(self) -> Setting:
        """What stayed the same."""
        return self.model.setting


@dataclass(frozen=True)
class Near:
    """Point near which the search goes on: departures (g,), and what goes with it."""

    departures: FloatArray
    level: Level
    """Of the outside force under which it was found."""
    prior: Prior
    reach: FloatArray
    """As of `Search`."""
    rounds: int


def ordinary_prior(setting: Setting) -> Prior:
    """Return what the vehicle file states of the departures."""
    stated = np.array([one.ordinary for one in setting.coordinates])
    return Prior(np.zeros(stated.size), np.diag(stated**2))


def force_prior(setting: Setting, level: Level) -> ForcePrior:
    """Prior of the outside forces under a level."""
    window = max(w.duration_s for w in setting.bench.stack.windows)
    return level.prior(setting.bench.pieces, window / setting.bench.pieces)


def part(found: Grams, chosen: BoolArray) -> Grams:
    """Keep some of the windows."""
    return replace(
        found,
        own=found.own[chosen],
        cross=found.cross[chosen],
        rest=found.rest[chosen],
        index=found.index[chosen],
        run=found.run[chosen],
    )


def judge_all(
    setting: Setting,
    normal: Grams,
    prior: Prior,
    every_level: Sequence[Level],
    groups: dict[Group, tuple[int, ...]],
    *,
    with_pairs: bool,
) -> tuple[Judged, ...]:
    """Judge the hypotheses under every level."""
    bench, every = setting.bench, setting.coordinates

    def alone(level: Level, some: dict[Group, tuple[int, ...]]) -> Judged:
        found = marginal(normal, force_prior(setting, level))
        ground = with_ordinary(found, prior)
        singles = tuple(screen(ground, every, some))
        return Judged(level, found, ground, log_evidence_of(ground), singles, ())

    def paired(one: Judged) -> Judged:
        found = pairs(one.ground, every, groups, one.singles, _FIRST_EFFECTS)
        return replace(one, pairs=tuple(found))

    even = [level for level in every_level if np.ptp(level.factor) == 0.0]
    judged = bench.workers.each([partial(alone, level, groups) for level in even])
    best = max(judged, key=lambda one: one.nothing)
    strong = {one.groups[0]: groups[one.groups[0]] for one in best.singles[:_STRONG]}
    uneven = [level for level in every_level if np.ptp(level.factor) > 0.0]
    by_axis = bench.workers.each([partial(alone, level, strong) for level in uneven])
    if with_pairs:
        # where they can matter: under the levels that the readings prefer
        judged.sort(
            key=lambda one: -(one.nothing + max((f.log_evidence for f in one.singles), default=0.0))
        )
        first = bench.workers.each([partial(paired, one) for one in judged[:_LEVELS_WITH_PAIRS]])
        found = [pair for one in first for pair in one.pairs]

        def with_all(one: Judged) -> Judged:
            return replace(one, pairs=tuple(pairs_under(one.ground, every, groups, found)))

        # a single effect of two needs a larger force than both do
        return tuple(bench.workers.each([partial(with_all, one) for one in (*judged, *by_axis)]))
    return (*judged, *by_axis)


def strongest(judged: Sequence[Judged]) -> tuple[Judged, Finding | None]:
    """Level and hypothesis with the largest log evidence and prior of the level."""

    def value(one: Judged) -> tuple[float, Finding | None]:
        first = next(iter(one.singles), None)
        second = next(iter(one.pairs), None)
        best, gain = None, 0.0
        # each effect must earn its place
        if first is not None and first.log_evidence > 3.0:
            best, gain = first, first.log_evidence
        if second is not None and second.log_evidence > gain + 10.0 + 0.02 * gain:
            best, gain = second, second.log_evidence
        return one.nothing + gain + float(np.log(one.level.weight)), best

    best = max(judged, key=lambda one: value(one)[0])
    return best, value(best)[1]


def clip_ordinary(departures: FloatArray, prior: Prior, finding: Finding | None) -> FloatArray:
    """Keep ordinary departures ordinary: the next linearisation is not to be led astray."""
    most = _MOST_ORDINARY * np.sqrt(np.diag(prior.covariance))
    kept = prior.mean + np.clip(departures - prior.mean, -most, most)
    if finding is not None:
        kept[list(finding.which)] = departures[list(finding.which)]
    return np.asarray(kept)


def _within_forms(setting: Setting, prior: Prior, departures: FloatArray) -> Prior:
    """Hold what no file states where it has a meaning, if the readings want it beyond.

    Else the linear model promises there what no vehicle has, and each answer goes to look for it.
    """
    for index, one in enumerate(setting.coordinates):
        inside = float(np.clip(departures[index], *one.limits))
        if one.effect.unstated and inside != departures[index]:
            prior = held_at(prior, index, inside)
    return prior


def search(  # noqa: PLR0917 - one caller
    setting: Setting,
    near: Near,
    every_level: Sequence[Level],
    chosen: BoolArray,
    widen: dict[str, float] | None = None,
    scatter: FloatArray | None = None,
) -> Search:
    """Judge all hypotheses on all windows, linear around the most probable motion near a point.

    Parameters
    ----------
    setting : Setting
        Windows of all runs, those held out among them, following with the model at the point.
    near : Near
        The point.
    every_level : sequence of Level
        Levels of the outside force.
    chosen : ndarray of bool, shape (windows,)
        Windows that may speak.
    widen : dict, optional
        Factors on the channels' noise learned from healthy runs; found here otherwise.
    scatter : ndarray, shape (g,), optional
        By how much the departures of a run differ from the vehicle's, likewise.
    """
    groups = groups_of(setting.coordinates)
    ordinary = [one for one in every_level if one.ordinary or np.ptp(one.factor) == 0.0]
    model = linear_near(setting, force_prior(setting, near.level), near.departures)
    if model.lost > _MOST_LOST:
        raise CannotComputeError(
            f"the simulation runs away in {model.lost:.0%} of the time, whatever the effect. Check "
            "that the vehicle file belongs to these runs: masses, thruster positions and signs."
        )
    normal = grams(model)
    judged = judge_all(setting, part(normal, chosen), near.prior, ordinary, groups, with_pairs=True)
    best, finding = strongest(judged)
    departures = total_departures(best.found, near.prior, finding)
    prior = _within_forms(setting, near.prior, departures)
    departures = realisable(setting.coordinates, clip_ordinary(departures, prior, finding))
    # the noise is judged where the outside force may explain everything that is slow
    high = replace(best.level, factor=np.maximum(best.level.factor, 2.0))
    best_values = solve(normal, force_prior(setting, high), departures)
    residual = residual_with(model, best_values, departures)
    noise = noise_found(model, residual)
    factors = {q: n.widen for q, n in noise.items()} if widen is None else widen
    model = widened(model, residual, factors)
    normal = grams(model)
    if scatter is None:
        scatter = scatter_between_runs(
            setting,
            part(normal, chosen),
            force_prior(setting, best.level),
            prior,
            near.reach,
            groups,
            () if finding is None else (finding,),
        )
    model = replace(model, setting=replace(model.setting, scatter=scatter))
    normal = replace(normal, scatter=scatter)
    judged = judge_all(setting, part(normal, chosen), prior, every_level, groups, with_pairs=True)
    return Search(model, normal, prior, judged, groups, noise, near.rounds, chosen, near.reach)
