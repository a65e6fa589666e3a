"""Runs as they are seen from one point: a linear model, and what it says under each force level."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pipeline.diagnose.asking.beliefs import Beliefs
from pipeline.diagnose.asking.held import held_within, limits_of
from pipeline.diagnose.asking.levels import force_prior
from pipeline.diagnose.asking.run_marginals import (
    Factored,
    RunGrams,
    factored,
    grams,
    marginals,
    point_at,
    solve,
    together,
    with_other_readings,
    with_readings,
    without_scatter,
)
from pipeline.diagnose.judging.hypotheses import with_ordinary
from pipeline.diagnose.linear.elimination import Marginal
from pipeline.diagnose.linear.evidence import posterior
from pipeline.diagnose.linear.linear_model import LinearModel, Point, Setting
from pipeline.diagnose.linear.most_probable import readings_there
from pipeline.diagnose.linear.scales import Level
from pipeline.types import BoolArray, FloatArray


@dataclass(frozen=True)
class Told:
    """What the runs say under one level: of the departures, and with the ordinary integrated out.

    `parts` are the runs apart, `whole` all together, `ground` without what is ordinary; `nothing`
    is the log evidence with nothing wide.
    """

    level: Level
    parts: tuple[Marginal, ...]
    whole: Marginal
    ground: Marginal
    nothing: float


@dataclass(frozen=True)
class View:
    """All windows around one point.

    Attributes
    ----------
    model : LinearModel
        Linear there.
    beliefs : Beliefs
        What is ordinary.
    chosen : ndarray of bool, shape (windows,)
        Windows from which values are taken; the others only judge.
    """

    model: LinearModel
    beliefs: Beliefs
    chosen: BoolArray
    normal: RunGrams
    factors: dict[float, Factored] = field(default_factory=dict)
    known: dict[tuple[bytes, bool], Told] = field(default_factory=dict)

    @classmethod
    def of(cls, model: LinearModel, beliefs: Beliefs, chosen: BoolArray) -> "View":
        """See the windows of a model."""
        return cls(model, beliefs, chosen, grams(model))

    @property
    def setting(self) -> Setting:
        """What stays the same over a diagnosis."""
        return self.model.setting

    @cached_property
    def even(self) -> tuple[Level, ...]:
        """Levels that are alike along all axes."""
        return tuple(one for one in self.beliefs.levels if np.ptp(one.factor) == 0.0)

    def told(self, level: Level, *, held_out: bool) -> Told:
        """Return what the chosen windows say, or all of them with those `held_out`."""
        key = (level.factor.tobytes(), held_out or bool(self.chosen.all()))
        if key not in self.known:
            kept = None if key[1] else self.chosen
            parts = marginals(self.normal, self.factor(level), kept)
            whole = together([without_scatter(one, self.beliefs.scatter) for one in parts])
            ground = with_ordinary(whole, self.beliefs.prior)
            nothing = -0.5 * (ground.misfit + ground.log_determinant)
            self.known[key] = Told(level, parts, whole, ground, nothing)
        return self.known[key]

    def factor(self, level: Level) -> Factored:
        """Windows' own equations under a level."""
        key = hash(level.factor.tobytes())
        if key not in self.factors:
            self.factors[key] = factored(self.normal, force_prior(self.setting, level))
        return self.factors[key]

    def motion(self, level: Level, departures: FloatArray) -> Point:
        """Most probable motion at departures (d,)."""
        best = solve(self.normal, self.factor(level), departures)
        return point_at(self.setting, best, departures)

    def at(self, point: Point) -> "View | None":
        """See the readings as they are at a point, with the derivatives of this one.

        None where the simulation runs away there, or no vehicle can be that.
        """
        readings = readings_there(self.model, point)
        if readings is None:
            return None
        model = replace(self.model, readings=readings, point=point)
        normal = with_readings(self.normal, model)
        return replace(
            self,
            model=model,
            normal=normal,
            factors={key: with_other_readings(one, normal) for key, one in self.factors.items()},
            known={},
        )

    def estimate(
        self, level: Level, which: Sequence[int], variance: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Estimate departures (d,), some of them wide, by the chosen windows; with deviations."""
        covariance = self.beliefs.prior.covariance.copy()
        index = np.array(which, int)
        covariance[index, index] += variance
        found = posterior(
            self.told(level, held_out=False).whole,
            replace(self.beliefs.prior, covariance=covariance),
        )
        found = held_within(found, limits_of(self.setting.coordinates))
        return found.mean, np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
