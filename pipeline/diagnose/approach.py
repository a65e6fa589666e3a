"""Find what explains the runs: linearise, judge every hypothesis, go there, linearise again."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.elimination import grams
from pipeline.diagnose.evidence import Prior
from pipeline.diagnose.hypotheses import Finding, Group, groups_of, judge_freely, total_departures
from pipeline.diagnose.linear_model import LinearModel, Setting, realisable, vector_of
from pipeline.diagnose.nil import reach, with_small
from pipeline.diagnose.scales import Level
from pipeline.diagnose.search import Judged, Near, judge_all, sober, strongest
from pipeline.diagnose.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Effects whose own points are gone to from the nominal model: as they are estimated under an
#: outside force of at most `_QUIET`, and under any.
_TRIED, _TRIED_LOUD, _QUIET = 4, 1, 4.0
#: Linearisations on the way to an effect's own point, and further ones for the best.
_STEPS, _FURTHER = 3, 5
#: A departure that moved by less than this (in units of half the plausible range) has settled.
_SETTLED = 0.02
#: Log evidence that is lost at least on a way that leads nowhere.
_RUN_AWAY = 1000.0
#: Log evidence that is worth no further step.
_NO_MORE = 3.0

Lead = Callable[[Setting, FloatArray], Setting]


@dataclass(frozen=True)
class _Trial:
    """A hypothesis as it is seen from one point."""

    departures: FloatArray
    best: Judged
    finding: Finding | None
    far: bool = False
    """What is stated may be anywhere."""

    @property
    def value(self) -> float:
        """Log evidence of the strongest, with the prior of its level."""
        gain = 0.0 if self.finding is None else self.finding.log_evidence
        return self.best.nothing + gain + float(np.log(self.best.level.weight))

    def goes_to(self, every: Sequence[Coordinate], prior: Prior) -> FloatArray:
        """Most probable departures, where a vehicle can be."""
        finding = self.finding
        if finding is not None:
            finding = _with_all(self.best, every, finding)
        total = total_departures(self.best.found, prior, finding)
        near = sober(total, prior, finding)
        if self.far:
            stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
            near[stated] = total[stated]
        return realisable(every, near)


def approach(
    setting: Setting,
    lead: Lead,
    prior: Prior,
    every_level: Sequence[Level],
    *,
    healthy_known: bool,
) -> Near:
    """Find the point around which the hypotheses are best judged.

    Around the nominal model a strong fault is seen badly: the linear model favours effects that can
    bend to anything, or no effect and a large force. So the strongest few effects are each followed
    to their own points, on a part of the windows, and the one with the largest evidence is kept.

    Parameters
    ----------
    setting : Setting
        Windows that suffice for finding the way; all of them speak.
    lead : callable
        Leads the windows of a setting along the measured motion with the model at a vector.
    prior : Prior
        Of the ordinary departures; with nothing better known, departures too small to matter are
        ordinary, too.
    every_level : sequence of Level
        Levels of the outside force.
    healthy_known : bool
        The prior was learned from healthy runs.
    """
    every, groups = setting.coordinates, groups_of(setting.coordinates)
    even = [one for one in every_level if np.ptp(one.factor) == 0.0]
    model = linear_model(setting, setting.origin(), wide=True)
    moved_by = reach(model, prior)
    prior = prior if healthy_known else with_small(prior, moved_by, setting)
    judged = judge_all(setting, grams(model), prior, even, groups, with_pairs=False)
    best = _Trial(np.zeros(len(every)), *strongest(judged))
    follow = _Follower(setting, lead, prior, even, model, groups)
    # nothing but what is stated, which may be far out; then the same, kept ordinary
    wanted: list[tuple[Judged, Finding | None]] = [(best.best, None), (best.best, None)]
    # under a small force an effect must explain the readings by itself, as a true one does
    quiet = [one for one in judged if one.level.size <= _QUIET]
    for some, most in ((quiet, _TRIED), (judged, _TRIED_LOUD)):
        found = _strongest_effects(some, most)
        wanted += [row for row in found if all(row[1] is not known for _, known in wanted)]
    for number, (under, finding) in enumerate(wanted):
        trial = _Trial(np.zeros(len(every)), under, finding, far=number == 0)
        best = max(best, *follow.steps(trial, _STEPS), key=lambda one: one.value)
    best = max(best, *follow.steps(best, _FURTHER), key=lambda one: one.value)
    return Near(best.departures, prior, moved_by, _STEPS)


@dataclass(frozen=True)
class _Follower:
    """Follows a hypothesis from the nominal `model` to its own point."""

    setting: Setting
    lead: Lead
    prior: Prior
    every_level: Sequence[Level]
    model: LinearModel
    groups: dict[Group, tuple[int, ...]]

    def steps(self, trial: _Trial, most: int) -> list[_Trial]:
        """Go at most so many steps, and return every point that was reached."""
        setting, every = self.setting, self.setting.coordinates
        own: dict[Group, tuple[int, ...]] = {}
        if trial.finding is not None:
            own = {trial.finding.groups[0]: self.groups[trial.finding.groups[0]]}
        stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
        renew = sorted({*stated, *(k for members in own.values() for k in members)})
        reached, begun = [trial], trial.value
        for _ in range(most):
            at = trial.goes_to(every, self.prior)
            moved = float(np.abs(at - trial.departures).max())
            if moved < _SETTLED:
                break
            try:
                led = self.lead(setting, vector_of(setting, at))
            except CannotComputeError:
                break
            point = replace(led.origin(), departures=at)
            there = linear_model(led, point, known=self.model, renew=renew)
            if there.lost > self.model.lost:
                # a vehicle that cannot do what was seen, and less to explain
                break
            levels = self.every_level
            alone = judge_all(setting, grams(there), self.prior, levels, own, with_pairs=False)
            before, trial = trial.value, _Trial(at, *_of_effect(alone), far=trial.far)
            reached.append(trial)
            ran_away = trial.value < begun - max(_RUN_AWAY, abs(begun))
            if ran_away or abs(trial.value - before) < _NO_MORE:
                break
        return reached


def _with_all(judged: Judged, every: Sequence[Coordinate], finding: Finding) -> Finding:
    """Return a finding with all parameters of its effect, as wide as they may be.

    From afar a few of them seem to suffice; a payload without its place goes astray.
    """
    members = groups_of(every)[finding.groups[0]]
    index = np.array(members, int)
    wide = np.ones(index.size)
    gain, mean, covariance = judge_freely(judged.ground, index, wide)
    if not np.isfinite(gain):
        return finding
    return Finding(finding.groups, members, gain, mean, covariance, wide)


def _of_effect(judged: Sequence[Judged]) -> tuple[Judged, Finding | None]:
    """Level under which the one effect that was looked at is strongest, and what is found of it."""
    rows: list[tuple[float, Judged, Finding | None]] = []
    for one in judged:
        found = next((f for f in one.singles if f.which and np.isfinite(f.log_evidence)), None)
        gain = 0.0 if found is None else found.log_evidence
        rows.append((one.nothing + gain + float(np.log(one.level.weight)), one, found))
    _, best, finding = max(rows, key=lambda row: row[0])
    return best, finding


def _strongest_effects(judged: Sequence[Judged], most: int) -> list[tuple[Judged, Finding]]:
    """Single effects that gain most under any level, each once."""
    found: dict[str, tuple[float, Judged, Finding]] = {}
    for one in judged:
        for finding in one.singles:
            if not finding.which or not np.isfinite(finding.log_evidence):
                continue
            value = one.nothing + finding.log_evidence + float(np.log(one.level.weight))
            name = finding.groups[0][0]
            if name not in found or found[name][0] < value:
                found[name] = (value, one, finding)
    ordered = sorted(found.values(), key=lambda row: (-row[0], row[2].groups))
    return [(one, finding) for _, one, finding in ordered[:most]]
