"""A hypothesis as it is seen from one point, and the way from there to its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.judging.hypotheses import (
    Finding,
    Group,
    groups_of,
    judge_freely,
    total_departures,
)
from pipeline.diagnose.judging.search import Judged, clip_ordinary, judge_all
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import grams
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting, realisable, vector_of
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Effects and pairs that are looked at anew from the best point.
_ANEW = 3
#: A departure that moved by less than this (in units of half the plausible range) has settled.
_SETTLED = 0.02
#: Log evidence that is lost at least on a way that leads nowhere.
_RUN_AWAY = 1000.0
#: Log evidence by which a way is behind the best when it is left.
BEHIND = 100.0
#: Log evidence that a second effect must add.
_SECOND = 10.0
#: Log evidence that is worth no further step.
_NO_MORE = 3.0
#: Log evidence of a step after which a way is gone on with however many steps it has had, and the
#: most it may have.
_CLIMBS, _MOST_STEPS = 50.0, 8
#: Steps to an effect with a place, at least: between those that climb some lead down.
_STEPS_PLACED = 4

Lead = Callable[[Setting, FloatArray], Setting]


@dataclass(frozen=True)
class Trial:
    """A hypothesis as it is seen from one point."""

    departures: FloatArray
    best: Judged
    finding: Finding | None
    far: bool = False
    """What is stated may be anywhere."""
    settled: bool = False
    """Only the parameters that have been found are let go, not all of the effect."""

    @property
    def groups(self) -> tuple[Group, ...]:
        """Effects of the hypothesis at their targets."""
        return () if self.finding is None else self.finding.groups

    @property
    def value(self) -> float:
        """Log evidence of the strongest, with the prior of its level."""
        gain = 0.0 if self.finding is None else self.finding.log_evidence
        if self.finding is not None and len(self.finding.groups) > 1:
            gain -= _SECOND
        return self.best.nothing + gain + float(np.log(self.best.level.weight))

    def goes_to(self, every: Sequence[Coordinate], prior: Prior) -> FloatArray:
        """Most probable departures, where a vehicle can be.

        What is neither stated nor in question stays at neutral: its derivatives are those there.
        """
        finding = self.finding
        if finding is not None and not self.settled:
            finding = _with_all(self.best, every, finding)
        total = total_departures(self.best.found, prior, finding)
        near = clip_ordinary(total, prior, finding)
        stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
        if self.far:
            near[stated] = total[stated]
        kept = [*stated, *(() if finding is None else finding.which)]
        return realisable(every, np.where(np.isin(np.arange(near.size), kept), near, 0.0))


def value_of(one: Trial) -> float:
    """Log evidence by which trials are ordered."""
    return one.value


@dataclass(frozen=True)
class Follower:
    """Follows a hypothesis from the nominal `model` to its own point."""

    setting: Setting
    lead: Lead
    prior: Prior
    every_level: Sequence[Level]
    model: LinearModel
    groups: dict[Group, tuple[int, ...]]

    def steps(self, trial: Trial, most: int, known: float = -np.inf) -> list[Trial]:
        """Go so many steps, and on as long as it climbs; return every point that was reached.

        The way to a payload is long: its place shows more the more there is of it. `known` is the
        log evidence of the best point so far: a way that has found nothing near it after its second
        step is left.
        """
        reached, begun, climbs = [trial], trial.value, False
        most = max(most, _STEPS_PLACED) if self._placed(trial) else most
        for number in range(_MOST_STEPS):
            if number >= most and not climbs:
                break
            before, gone = trial.value, self.step(trial)
            if gone is None:
                break
            trial = gone
            reached.append(trial)
            climbs = trial.value > before + _CLIMBS
            ran_away = trial.value < begun - max(_RUN_AWAY, abs(begun))
            behind = number > 0 and not climbs and trial.value < min(begun, known) - BEHIND
            if ran_away or behind or abs(trial.value - before) < _NO_MORE:
                break
        return reached

    def step(self, trial: Trial) -> Trial | None:
        """Go to where a hypothesis is most probable; None where it is there, or cannot be seen."""
        own, at = trial.groups, trial.goes_to(self.setting.coordinates, self.prior)
        if float(np.abs(at - trial.departures).max()) < _SETTLED:
            return None
        roughly, level = bool(own) and not trial.settled, trial.best.level
        seen = self.seen_from(at, own, level, roughly=roughly)
        if self._placed(trial) and (seen is None or seen.value < trial.value - BEHIND):
            # what a strong payload does is far from straight: half way there
            half = self.seen_from((at + trial.departures) / 2, own, level, roughly=roughly)
            seen = max((one for one in (seen, half) if one), key=value_of, default=None)
        return None if seen is None else replace(seen, far=trial.far, settled=trial.settled)

    def _placed(self, trial: Trial) -> bool:
        """Whether an effect has a place, which shows the more the more there is of it."""
        every = self.setting.coordinates
        return any(every[k].leads for group in trial.groups for k in self.groups[group])

    def best_of(self, best: Trial, trials: Sequence[Trial], most: int) -> Trial:
        """Follow some trials, and return the best point that was reached.

        What a way is promised where it starts does not count where it was gone.
        """
        ways = [partial(self.steps, trial, most, best.value) for trial in trials]
        reached = self.setting.bench.workers.each(ways)
        return max((best, *(one for way in reached for one in way[1:] or way)), key=value_of)

    def probed(
        self, begin: FloatArray, group: Group, members: Sequence[int], sizes: Sequence[float]
    ) -> Trial | None:
        """Judge an effect from where some of its parameters are strong, at the best of some sizes.

        Sizes count towards the plausible side of each parameter.
        """
        every, level = self.setting.coordinates, self.every_level[len(self.every_level) // 2]
        best: Trial | None = None
        for size in sizes:
            at = begin.copy()
            at[list(members)] = size * np.sign([every[k].step for k in members])
            seen = self.seen_from(realisable(every, at), (group,), level, roughly=True)
            if seen is not None:
                level = seen.best.level
                best = seen if best is None or seen.value > best.value else best
        return best

    def seen_from(
        self, at: FloatArray, own: Sequence[Group], level: Level, *, roughly: bool = False
    ) -> Trial | None:
        """Judge some effects at a point; None where the vehicle cannot do what it did.

        `level` is that of the force from which the best is looked for: nearby it is mostly the
        same. `roughly`: what is stated keeps the derivatives that it has around the nominal model.
        """
        every = self.setting.coordinates
        groups = {group: self.groups[group] for group in own}
        stated = [k for k, one in enumerate(every) if one.ordinary > 0.0 and not roughly]
        renew = sorted({*stated, *(k for members in groups.values() for k in members)})
        there = self._linear_at(at, renew)
        if there is None:
            return None
        normal = grams(there)

        def judged(number: int) -> Trial:
            one = judge_all(
                self.setting,
                normal,
                self.prior,
                [self.every_level[number]],
                groups,
                with_pairs=len(groups) > 1,
            )
            return Trial(at, *of_effects(one, own))

        sizes = [one.size for one in self.every_level]
        return climbed(judged, sizes.index(level.size), len(sizes))

    def anew(self, best: Trial) -> list[Trial]:
        """Judge all effects and pairs at the best point, and return the strongest."""
        at = best.departures
        there = self._linear_at(at, range(len(self.setting.coordinates)))
        if there is None:
            return []
        judged = judge_all(
            self.setting, grams(there), self.prior, self.every_level, self.groups, with_pairs=True
        )
        found: dict[tuple[Group, ...], Trial] = {}
        for one in judged:
            for finding in (*one.singles[:1], *one.pairs[:_ANEW]):
                trial = Trial(at, one, finding)
                known = found.get(finding.groups)
                if finding.which and (known is None or known.value < trial.value):
                    found[finding.groups] = trial
        ordered = sorted(found.values(), key=value_of, reverse=True)
        return ordered[:_ANEW]

    def _linear_at(self, at: FloatArray, renew: Sequence[int]) -> LinearModel | None:
        """Lead the windows with the model at a point, and linearise there."""
        try:
            led = self.lead(self.setting, vector_of(self.setting, at))
        except CannotComputeError:
            return None
        point = replace(led.origin(), departures=at)
        there = linear_model(led, point, known=self.model, renew=renew)
        # a vehicle that runs away more often has less to explain
        return there if there.lost <= self.model.lost else None


def climbed(judged: Callable[[int], Trial], begin: int, count: int) -> Trial:
    """Return the best of trials in a row that has one top, from one of them upwards."""
    best, at = judged(begin), begin
    for side in (1, -1):
        while 0 <= at + side < count:
            one = judged(at + side)
            if one.value <= best.value:
                break
            best, at = one, at + side
        if at != begin:
            break
    return best


def _with_all(judged: Judged, every: Sequence[Coordinate], finding: Finding) -> Finding:
    """Return a finding with all parameters of its effects, as wide as they may be.

    From afar a few of them seem to suffice; a payload without its place goes astray.
    """
    groups = groups_of(every)
    members = tuple(sorted(k for group in finding.groups for k in groups[group]))
    index = np.array(members, int)
    wide = np.ones(index.size)
    gain, mean, covariance = judge_freely(judged.ground, index, wide)
    if not np.isfinite(gain):
        return finding
    return Finding(finding.groups, members, gain, mean, covariance, wide)


def of_effects(judged: Sequence[Judged], own: Sequence[Group]) -> tuple[Judged, Finding | None]:
    """Level under which the effects looked at are strongest, and what is found of them."""
    rows: list[tuple[float, Judged, Finding | None]] = []
    for one in judged:
        findings = one.pairs if len(own) > 1 and one.pairs else one.singles
        found = next((f for f in findings if f.which and np.isfinite(f.log_evidence)), None)
        gain = 0.0 if found is None else found.log_evidence
        rows.append((one.nothing + gain + float(np.log(one.level.weight)), one, found))
    _, best, finding = max(rows, key=lambda row: row[0])
    return best, finding
