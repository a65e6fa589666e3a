"""Find what explains the runs: linearise, judge every hypothesis, go there, linearise again."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.diagnose.inference.trials import BEHIND, Follower, Lead, Trial, value_of
from pipeline.diagnose.judging.hypotheses import Finding, Group, groups_of
from pipeline.diagnose.judging.nil import reach, with_small
from pipeline.diagnose.judging.search import Judged, Near, judge_all
from pipeline.diagnose.kinematics.dead_reckoning import MEASUREMENT
from pipeline.diagnose.linear.coordinates import Coordinate, counted_by_size, may_bend, recounted
from pipeline.diagnose.linear.elimination import grams
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model

#: Effects whose own points are gone to from the nominal model: as they are estimated under an
#: outside force of at most `_QUIET`, and under any.
_TRIED, _TRIED_LOUD, _QUIET = 4, 1, 4.0
#: Where none of these explains the runs all others are seen from where they lead to; so many of
#: them are followed.
_TRIED_LATER = 2
#: Log evidence that an effect must promise before any is gone to, where an ordinary force explains
#: the readings: what is less shows around the nominal model as well.
_PROMISED = 3.0
#: Sizes of the departures to which the first secants are taken: of the weak and of the strong.
_WEAK, _STRONG = 0.1, 1.0
#: Linearisations on the way to an effect's own point, and further ones for the best.
_STEPS, _STEPS_ANEW, _FURTHER = 2, 3, 3
#: Share by which a signature changes between weak and strong when the strong is tried by itself,
#: and where: towards the plausible side, or to both. A dead zone of 84 codes shows from 60 and 90,
#: and from 120 no more: by then it took other codes away, too.
_BENT, _PROBED, _TWO_SIDED = 0.3, (1.0, 1.4, 2.0, 2.8, 4.0), (1.0, -1.0)
#: Size of a payload that neither sinks nor floats, on board or missing, from which its place shows.
_LADEN = (0.1, -0.1)
#: Log evidence by which such a start may be behind the best point and still be followed.
_LADEN_BEHIND = 1000.0


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
    by_weight = setting.coordinates
    setting = replace(setting, coordinates=counted_by_size(by_weight))
    every, groups = setting.coordinates, groups_of(setting.coordinates)
    even = [one for one in every_level if np.ptp(one.factor) == 0.0]
    model = linear_model(setting, setting.origin(), wide=_WEAK)
    bending = sorted(may_bend(every))
    strong = linear_model(setting, setting.origin(), wide=_STRONG, known=model, renew=bending)
    moved_by = reach(model, prior)
    prior = prior if healthy_known else with_small(prior, moved_by, setting)
    judged, far = (
        judge_all(setting, grams(one), prior, even, groups, with_pairs=False)
        for one in (model, strong)
    )
    neutral = np.zeros(len(every))
    # what an effect is promised from here is not what it will be found to explain
    alone = max(judged, key=lambda one: one.nothing + float(np.log(one.level.weight)))
    best = Trial(neutral, alone, None)
    follow = Follower(setting, lead, prior, even, model, groups)
    # nothing but what is stated, which may be far out; then the same, kept ordinary
    wanted: list[tuple[Judged, Finding | None]] = [(alone, None), (alone, None)]
    # under a small force an effect must explain the readings by itself, as a true one does
    loud = [*judged, *far]
    promised = [value_of(Trial(neutral, *row)) for row in _strongest_effects(loud, 1)]
    if alone.level.ordinary and max(promised, default=-np.inf) < best.value + _PROMISED:
        stated = [Trial(neutral, alone, None, far=True), Trial(neutral, alone, None)]
        best = follow.best_of(best, stated, _STEPS)
        departures = recounted(every, by_weight, best.departures)
        return Near(departures, best.best.level, prior, moved_by, _STEPS)
    quiet = [one for one in loud if one.level.size <= _QUIET]
    for some, most in ((quiet, _TRIED), (loud, _TRIED_LOUD)):
        found = _strongest_effects(some, most)
        wanted += [row for row in found if all(row[1] is not known for _, known in wanted)]
    trials = [
        Trial(neutral, under, finding, far=number == 0)
        for number, (under, finding) in enumerate(wanted)
    ]
    best = follow.best_of(best, trials, _STEPS)
    laden = _laden(follow, best)
    best = follow.best_of(best, laden, _STEPS)
    if not best.best.level.ordinary:
        # none of them explains the runs; a current that no DVL shows is weak at nominal
        others = _best_others(follow, loud, [*trials, *laden])
        best = follow.best_of(max((best, *others), key=value_of), others, _STEPS)
    begins = [neutral]
    if best.finding is None and best.departures.any():
        # what is stated may be far out, or may have been driven there by what is strong
        begins.append(best.departures)
    bent = [
        partial(follow.probed, begin, group, [index], _TWO_SIDED if two_sided else _PROBED)
        for group, index, two_sided in _bent(every, groups, model, strong)
        for begin in begins
    ]
    seen = [one for one in setting.bench.workers.each(bent) if one is not None]
    if best.best.level.ordinary:
        seen = [one for one in seen if one.value > best.value]
    # where an effect was tried at its size, what is seen there counts, too
    begun = max((best, *seen), key=value_of)
    best = follow.best_of(begun, sorted(seen, key=value_of)[-_TRIED_LATER:], _STEPS)
    best = follow.best_of(best, follow.anew(best), _STEPS_ANEW)
    if not best.best.level.ordinary:
        best = follow.best_of(best, _misled(follow, best), _STEPS_ANEW)
    best = replace(best, settled=True)
    last = follow.steps(best, _FURTHER)[-1]
    # its own point is where it is fairly judged; from afar it may look a little better
    best = last if last.value > best.value - BEHIND else best
    departures = recounted(every, by_weight, best.departures)
    return Near(departures, best.best.level, prior, moved_by, _STEPS)


def _laden(follow: Follower, best: Trial) -> list[Trial]:
    """Payloads from where they are on board, or missing, if not too far behind the best point."""
    every = follow.setting.coordinates
    placed = {group: _leads_of(every, members) for group, members in follow.groups.items()}
    starts = [
        partial(follow.probed, np.zeros(len(every)), group, members, (size,))
        for group, members in placed.items()
        for size in _LADEN
        if members
    ]
    probes = follow.setting.bench.workers.each(starts)
    return [one for one in probes if one is not None and one.value > best.value - _LADEN_BEHIND]


def _best_others(
    follow: Follower, judged: Sequence[Judged], trials: Sequence[Trial]
) -> list[Trial]:
    """Take effects that were not tried one step from nominal, and return the best of them."""
    neutral = np.zeros(len(follow.setting.coordinates))
    tried = {name for one in trials if one.finding for name in one.finding.effects}
    others = [
        partial(follow.step, Trial(neutral, under, finding))
        for under, finding in _strongest_effects(judged, len(follow.groups))
        if not tried & set(finding.effects)
    ]
    seen = [one for one in follow.setting.bench.workers.each(others) if one is not None]
    return sorted(seen, key=value_of)[-_TRIED_LATER:]


def _misled(follow: Follower, best: Trial) -> list[Trial]:
    """Take the best effect beside each error of measurement by which the motion was led astray.

    The force that leads the model along a wrong velocity hides in part what is wrong with it.
    """
    if len(best.groups) != 1:
        return []
    errors = [group for group in follow.groups if group[0] in MEASUREMENT]
    beside = [
        partial(follow.seen_from, best.departures, (*best.groups, group), best.best.level)
        for group in errors
        if group not in best.groups
    ]
    seen = [one for one in follow.setting.bench.workers.each(beside) if one is not None]
    return [one for one in seen if len(one.groups) > 1]


def _bent(
    every: Sequence[Coordinate],
    groups: dict[Group, tuple[int, ...]],
    weak: LinearModel,
    strong: LinearModel,
) -> list[tuple[Group, int, bool]]:
    """Parameters that act otherwise when they are strong, with their effect, and if to both sides.

    A dead zone takes away all of a small code: beyond that it takes no more. The drag of a vehicle
    that hardly moves grows with the square of a current, in the current's direction.
    """
    found = []
    bending = may_bend(every)
    for group, members in groups.items():
        for index in members:
            if index not in bending or group[1] is not None:
                continue
            low, high = every[index].bounds
            if len(members) > 1 and not low < 0.0 < high:
                continue
            near, far = (one.departures[:, index] for one in (weak, strong))
            if float(np.linalg.norm(far - near)) > _BENT * float(np.linalg.norm(far)):
                found.append((group, index, len(members) > 1))
    return found


def _leads_of(every: Sequence[Coordinate], members: Sequence[int]) -> list[int]:
    """Parameters of an effect without which its place has no meaning: mass and volume."""
    return sorted({lead for index in members for lead in every[index].leads})


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
