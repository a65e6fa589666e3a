"""Find what explains the runs: linearise, judge every hypothesis, go there, linearise again."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.elimination import grams
from pipeline.diagnose.evidence import Prior
from pipeline.diagnose.hypotheses import Finding, groups_of, total_departures
from pipeline.diagnose.linear_model import Setting, realisable, vector_of
from pipeline.diagnose.nil import reach, with_small
from pipeline.diagnose.scales import Level
from pipeline.diagnose.search import Judged, Near, judge_all, sober, strongest
from pipeline.diagnose.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

#: Effects whose own points are gone to from the nominal model: as they are estimated under an
#: outside force of at most `_QUIET`, and under any.
_TRIED, _TRIED_LOUD, _QUIET = 4, 1, 4.0
#: Linearisations on the way to an effect's own point.
_STEPS = 3
#: A departure that moved by less than this (in units of half the plausible range) has settled.
_SETTLED = 0.02

Lead = Callable[[Setting, FloatArray], Setting]


@dataclass(frozen=True)
class _Trial:
    """A hypothesis as it is seen from one point."""

    departures: FloatArray
    best: Judged
    finding: Finding | None

    @property
    def value(self) -> float:
        """Log evidence of the strongest, with the prior of its level."""
        gain = 0.0 if self.finding is None else self.finding.log_evidence
        return self.best.nothing + gain + float(np.log(self.best.level.weight))

    def goes_to(self, every: Sequence[Coordinate], prior: Prior) -> FloatArray:
        """Most probable departures, where a vehicle can be."""
        total = total_departures(self.best.found, prior, self.finding)
        return realisable(every, sober(total, prior, self.finding))


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
    stated = [k for k, one in enumerate(every) if one.ordinary > 0.0]
    wanted: list[tuple[Judged, Finding | None]] = [(best.best, None)]
    # under a small force an effect must explain the readings by itself, as a true one does
    quiet = [one for one in judged if one.level.size <= _QUIET]
    for some, most in ((quiet, _TRIED), (judged, _TRIED_LOUD)):
        wanted += _strongest_effects(some, most)
    for under, finding in wanted:
        own = {} if finding is None else {finding.groups[0]: groups[finding.groups[0]]}
        renew = sorted({*stated, *(k for members in own.values() for k in members)})
        trial = _Trial(np.zeros(len(every)), under, finding)
        for _ in range(_STEPS):
            at = trial.goes_to(every, prior)
            try:
                led = lead(setting, vector_of(setting, at))
            except CannotComputeError:
                break
            point = replace(led.origin(), departures=at)
            there = linear_model(led, point, known=model, renew=renew)
            if there.lost > model.lost:
                # a vehicle that cannot do what was seen, and less to explain
                break
            alone = judge_all(setting, grams(there), prior, even, own, with_pairs=False)
            moved = float(np.abs(at - trial.departures).max())
            trial = _Trial(at, *_of_effect(alone))
            if trial.value > best.value:
                best = trial
            if moved < _SETTLED:
                break
    return Near(best.departures, prior, moved_by, _STEPS)


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
