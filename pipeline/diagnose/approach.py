"""Find what explains the runs: linearise, judge every hypothesis, go there, linearise again."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.elimination import grams
from pipeline.diagnose.evidence import Prior
from pipeline.diagnose.hypotheses import Finding, Group, groups_of, judge_freely, total_departures
from pipeline.diagnose.linear_model import LinearModel, Setting, realisable, vector_of
from pipeline.diagnose.nil import reach, with_small
from pipeline.diagnose.predictions import over_threads
from pipeline.diagnose.scales import Level
from pipeline.diagnose.search import Judged, Near, judge_all, sober, strongest
from pipeline.diagnose.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Effects whose own points are gone to from the nominal model: as they are estimated under an
#: outside force of at most `_QUIET`, and under any.
_TRIED, _TRIED_LOUD, _QUIET = 4, 1, 4.0
#: Sizes of the departures to which the first secants are taken: of the weak and of the strong.
_WEAK, _STRONG = 0.1, 1.0
#: Linearisations on the way to an effect's own point, and further ones for the best.
_STEPS, _STEPS_ANEW, _FURTHER = 2, 3, 3
#: Effects and pairs that are looked at anew from the best point.
_ANEW = 3
#: A departure that moved by less than this (in units of half the plausible range) has settled.
_SETTLED = 0.02
#: Log evidence that is lost at least on a way that leads nowhere.
_RUN_AWAY = 1000.0
#: Log evidence by which a way is behind the best when it is left.
_BEHIND = 100.0
#: Share by which a signature changes between weak and strong when the strong is tried by itself,
#: and where.
_BENT, _PROBED = 0.3, (1.0, 2.0, 4.0)
#: Log evidence that a second effect must add.
_SECOND = 10.0
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
    settled: bool = False
    """Only the parameters that have been found are let go, not all of the effect."""

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
        near = sober(total, prior, finding)
        stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
        if self.far:
            near[stated] = total[stated]
        kept = [*stated, *(() if finding is None else finding.which)]
        return realisable(every, np.where(np.isin(np.arange(near.size), kept), near, 0.0))


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
    model = linear_model(setting, setting.origin(), wide=_WEAK)
    unstated = [k for k, one in enumerate(every) if one.ordinary == 0.0 and one.lead is None]
    strong = linear_model(setting, setting.origin(), wide=_STRONG, known=model, renew=unstated)
    moved_by = reach(model, prior)
    prior = prior if healthy_known else with_small(prior, moved_by, setting)
    judged, far = (
        judge_all(setting, grams(one), prior, even, groups, with_pairs=False)
        for one in (model, strong)
    )
    best = _Trial(np.zeros(len(every)), *strongest(judged))
    follow = _Follower(setting, lead, prior, even, model, groups)
    # nothing but what is stated, which may be far out; then the same, kept ordinary
    wanted: list[tuple[Judged, Finding | None]] = [(best.best, None), (best.best, None)]
    # under a small force an effect must explain the readings by itself, as a true one does
    loud = [*judged, *far]
    quiet = [one for one in loud if one.level.size <= _QUIET]
    for some, most in ((quiet, _TRIED), (loud, _TRIED_LOUD)):
        found = _strongest_effects(some, most)
        wanted += [row for row in found if all(row[1] is not known for _, known in wanted)]
    trials = [
        _Trial(np.zeros(len(every)), under, finding, far=number == 0)
        for number, (under, finding) in enumerate(wanted)
    ]
    best = follow.best_of(best, trials, _STEPS)
    bent = _bent(every, groups, model, strong)
    begin = best.departures if best.finding is None else np.zeros(len(every))
    probed = over_threads(setting.bench, [partial(follow.probed, begin, *one) for one in bent])
    for probe in probed:
        if probe is not None and probe.value > best.value:
            best = max(follow.steps(probe, _STEPS), key=lambda one: one.value)
    best = follow.best_of(best, follow.anew(best), _STEPS_ANEW)
    best = replace(best, settled=True)
    last = follow.steps(best, _FURTHER)[-1]
    # its own point is where it is fairly judged; from afar it may look a little better
    best = last if last.value > best.value - _BEHIND else best
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

    def steps(self, trial: _Trial, most: int, known: float = -np.inf) -> list[_Trial]:
        """Go at most so many steps, and return every point that was reached.

        `known` is the log evidence of the best point so far: a way that has found nothing near it
        after its second step is left.
        """
        every = self.setting.coordinates
        own = () if trial.finding is None else trial.finding.groups
        reached, begun = [trial], trial.value
        for number in range(most):
            at = trial.goes_to(every, self.prior)
            moved = float(np.abs(at - trial.departures).max())
            if moved < _SETTLED:
                break
            seen = self.seen_from(at, own, roughly=bool(own) and not trial.settled)
            if seen is None:
                break
            before = trial.value
            trial = replace(seen, far=trial.far, settled=trial.settled)
            reached.append(trial)
            ran_away = trial.value < begun - max(_RUN_AWAY, abs(begun))
            behind = number > 0 and trial.value < min(begun, known) - _BEHIND
            if ran_away or behind or abs(trial.value - before) < _NO_MORE:
                break
        return reached

    def best_of(self, best: _Trial, trials: Sequence[_Trial], most: int) -> _Trial:
        """Follow some trials, and return the best point that was reached."""
        ways = [partial(self.steps, trial, most, best.value) for trial in trials]
        reached = over_threads(self.setting.bench, ways)
        return max((best, *(one for way in reached for one in way)), key=lambda one: one.value)

    def probed(self, begin: FloatArray, group: Group, index: int) -> _Trial | None:
        """Judge an effect of one parameter from where it is strong, at the best of some sizes."""
        found = []
        for size in _PROBED:
            at = begin.copy()
            at[index] = size * np.sign(self.setting.coordinates[index].step)
            found.append(
                self.seen_from(realisable(self.setting.coordinates, at), (group,), roughly=True)
            )
        return max((one for one in found if one), key=lambda one: one.value, default=None)

    def seen_from(
        self, at: FloatArray, own: Sequence[Group], *, roughly: bool = False
    ) -> _Trial | None:
        """Judge some effects at a point; None where the vehicle cannot do what it did.

        `roughly`: what is stated keeps the derivatives that it has around the nominal model.
        """
        every = self.setting.coordinates
        groups = {group: self.groups[group] for group in own}
        stated = [k for k, one in enumerate(every) if one.ordinary > 0.0 and not roughly]
        renew = sorted({*stated, *(k for members in groups.values() for k in members)})
        there = self._linear_at(at, renew)
        if there is None:
            return None
        judged = judge_all(
            self.setting,
            grams(there),
            self.prior,
            self.every_level,
            groups,
            with_pairs=len(groups) > 1,
        )
        return _Trial(at, *_of_effects(judged, own))

    def anew(self, best: _Trial) -> list[_Trial]:
        """Judge all effects and pairs at the best point, and return the strongest."""
        at = best.departures
        there = self._linear_at(at, range(len(self.setting.coordinates)))
        if there is None:
            return []
        judged = judge_all(
            self.setting, grams(there), self.prior, self.every_level, self.groups, with_pairs=True
        )
        found: dict[tuple[Group, ...], _Trial] = {}
        for one in judged:
            for finding in (*one.singles[:1], *one.pairs[:_ANEW]):
                trial = _Trial(at, one, finding)
                known = found.get(finding.groups)
                if finding.which and (known is None or known.value < trial.value):
                    found[finding.groups] = trial
        ordered = sorted(found.values(), key=lambda one: -one.value)
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


def _bent(
    every: Sequence[Coordinate],
    groups: dict[Group, tuple[int, ...]],
    weak: LinearModel,
    strong: LinearModel,
) -> list[tuple[Group, int]]:
    """Effects of one parameter that act otherwise when they are strong, and that parameter.

    A dead zone takes away all of a small code: beyond that it takes no more.
    """
    found = []
    for group, members in groups.items():
        if len(members) != 1 or group[1] is not None or every[members[0]].ordinary > 0.0:
            continue
        near, far = (one.departures[:, members[0]] for one in (weak, strong))
        if float(np.linalg.norm(far - near)) > _BENT * float(np.linalg.norm(far)):
            found.append((group, members[0]))
    return found


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


def _of_effects(judged: Sequence[Judged], own: Sequence[Group]) -> tuple[Judged, Finding | None]:
    """Level under which the effects looked at are strongest, and what is found of them."""
    rows: list[tuple[float, Judged, Finding | None]] = []
    for one in judged:
        findings = one.pairs if len(own) > 1 and one.pairs else one.singles
        found = next((f for f in findings if f.which and np.isfinite(f.log_evidence)), None)
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
