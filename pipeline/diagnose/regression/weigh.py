"""Which change explains runs best, against what is ordinary: one posterior.

Under `none` each run differs by its ordinary widths; or what was learned is off, and the sound
runs, predicted from each other, share the departure that a change would be. Under a change of one
direction its size is the same in every run that carries it, with half the plausible range as prior
width, on the side where it is plausible; the runs that carry it are all, or those that speak for it
most. An effect of several parameters may change two of them: a current has north and east. Pairs
are built of the strongest effects. Under `unknown` a run differs by more than is ordinary in all
directions at once.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.change import Change, Shared, carried
from pipeline.diagnose.regression.gained import PRIOR_OF_ONE, Gained, log_bound
from pipeline.diagnose.regression.ordinary import Ordinary
from pipeline.diagnose.regression.told import Told
from pipeline.records.diagnosis import NONE, UNKNOWN

#: Prior probability of nothing, of one change, of two; the rest is none of the library.
_NOTHING, _TWO = 0.6, 0.05
#: Of a force that comes and goes, as probable beside any change as alone.
_COMES_AND_GOES = 0.025
#: That what was learned is off along some change, where there is none, or beside another one.
_LEARNED_OFF = 0.05
#: What is asked may scatter more than the few sound runs show: times their widths, and the
#: probability of each. Under `unknown` it is more.
_SPREADS, _STRANGE = ((1.0, 0.8), (2.0, 0.2)), 6.0
_NO_SIZE = np.zeros(0)
#: Changes less probable than the first by so much (log) are no sign of what was learned.
_HARDLY = 12.0
#: Single changes from which pairs are built; parameters of an effect that change at once.
_FROM, _MOST_PARAMETERS = 4, 3


def weighed(
    told: Sequence[Told],
    directions: Sequence[Coordinate],
    ordinary: Ordinary,
    gained: Sequence[Gained] = (),
    sound: Sequence[Told] = (),
) -> tuple[Change, ...]:
    """Weigh all hypotheses; the most probable first.

    Of an effect that may be one of several parameters, or two, the most probable is shown, with the
    probability of all.

    Parameters
    ----------
    told : sequence of Told
        Of each run that is asked.
    directions : sequence of Coordinate
        The directions.
    ordinary : Ordinary
        What sound runs differ by.
    gained : sequence of Gained
        Thrusters whose gains show it; that evidence counts where it is the larger one.
    sound : sequence of Told
        Of each sound run, predicted from the others.
    """
    every: list[tuple[Shared | None, Change]] = []
    for times, prior in _SPREADS:
        width = times * ordinary.width
        runs = Shared(told, directions, replace(ordinary, width=width))
        spread = runs.over(ordinary.width) + float(np.log(prior))
        own = _hypotheses(runs, told, directions, gained)
        if sound:
            all_runs = Shared([*sound, *told], directions, replace(ordinary, width=width))
            least = max(one.probability for one in own) - _HARDLY
            likely = [one for one in own if one.which and one.probability > least]
            own += [_alike(all_runs, one, len(sound)) for one in likely]
            own += [
                part
                for one in likely
                for part in _beside_learned(all_runs, one, directions, len(sound))
            ]
        every += [(runs, replace(one, probability=one.probability + spread)) for one in own]
    strange = Shared(told, directions, replace(ordinary, width=_STRANGE * ordinary.width)).over(
        ordinary.width
    )
    rest = float(np.log(1.0 - _NOTHING - PRIOR_OF_ONE - _TWO - _COMES_AND_GOES))
    every.append((None, Change(UNKNOWN, (), (), strange, strange + rest, _NO_SIZE, _NO_SIZE)))
    logs = np.array([one.probability for _, one in every])
    shares = np.exp(logs - logs.max())
    shares /= shares.sum()
    shown: dict[str, tuple[Shared | None, Change]] = {}
    whole: dict[str, float] = {}
    for (runs_of, one), share in sorted(zip(every, shares, strict=True), key=lambda row: -row[1]):
        shown.setdefault(one.name, (runs_of, one))
        whole[one.name] = whole.get(one.name, 0.0) + float(share)
    merged = [_whole(runs_of, one, whole[name]) for name, (runs_of, one) in shown.items()]
    return tuple(sorted(merged, key=_worth, reverse=True))


def with_disturbance(ranking: Sequence[Change], odds: Mapping[str, float]) -> tuple[Change, ...]:
    """Weigh a force that comes and goes, alone and beside changes: it is `unknown`.

    Parameters
    ----------
    ranking : sequence of Change
        All hypotheses, with `unknown`.
    odds : mapping
        By name of a hypothesis, the log evidence that such a force is there beside it.
    """
    share = _COMES_AND_GOES / _NOTHING
    beside = share * float(
        sum(one.probability * np.exp(odds[one.name]) for one in ranking if one.name in odds)
    )
    found = []
    for one in ranking:
        own = one
        if one.name == UNKNOWN:
            more = 1.0 + beside / max(one.probability, 1e-300)
            own = replace(
                one,
                probability=one.probability + beside,
                evidence=one.evidence + float(np.log(more)),
            )
        found.append(replace(own, probability=own.probability / (1.0 + beside)))
    return tuple(sorted(found, key=_worth, reverse=True))


def pooled(rankings: Sequence[Sequence[Change]]) -> tuple[Change, ...]:
    """Average what several models of the same runs say; none of them is known to be the right one.

    Of each name the change is shown that is the most probable of any, its size over all of them
    that mean the same parameters.
    """
    every: dict[str, list[Change]] = {}
    for ranking in rankings:
        for one in ranking:
            every.setdefault(one.name, []).append(one)
    found = []
    for own in every.values():
        first = max(own, key=_worth)
        same = [one for one in own if one.which == first.which]
        share = np.array([one.probability + 1e-12 for one in same])[:, None]
        share /= share.sum()
        mean = np.sum(share * [one.mean for one in same], axis=0)
        spread = [one.std**2 + (one.mean - mean) ** 2 for one in same]
        std = np.sqrt(np.sum(share * spread, axis=0))
        probability = sum(one.probability for one in own) / len(rankings)
        found.append(replace(first, probability=probability, mean=mean, std=std))
    return tuple(sorted(found, key=_worth, reverse=True))


def _hypotheses(
    runs: "Shared",
    told: Sequence[Told],
    directions: Sequence[Coordinate],
    gained: Sequence[Gained],
) -> list[Change]:
    """Nothing, single changes and pairs; `probability` is the log of evidence times prior."""
    found = [Change(NONE, (), (), 0.0, float(np.log(_NOTHING)), _NO_SIZE, _NO_SIZE)]
    singles, best = [], []
    for members, share in _groups(directions):
        seen = [k for k in members if any(one.information[k, k] > 0.0 for one in told)]
        every, parts = _parts(members, directions), _parts(seen, directions)
        # what acts only beside others is no change alone
        alone = [part for part in parts if not directions[part[0]].beside]
        if not alone:
            continue
        prior = float(np.log(PRIOR_OF_ONE * share))
        most = _MOST_PARAMETERS + sum(bool(directions[part[0]].beside) for part in every)
        own = [
            _change(runs, part, directions, prior + _prior_of(1, len(every), most))
            for part in alone
        ]
        own += _by_gains(runs, directions[members[0]], members[0], prior, gained)
        # those that are told best, one after the other
        first = max(own, key=_value)
        for count in range(2, min(len(parts), most) + 1):
            more = [
                _change(
                    runs,
                    tuple(sorted((*first.which, *part))),
                    directions,
                    prior + _prior_of(count, len(every), most),
                )
                for part in parts
                if part[0] not in first.which
            ]
            first = max(more, key=_value)
            own += more
        singles += own
        best.append(max(own, key=_worth))
    best.sort(key=_worth, reverse=True)
    # one that shows only beside the strongest is among the strongest of nothing
    both = [*combinations(best[:_FROM], 2), *((best[0], one) for one in best[_FROM:])]
    return [*found, *singles, *(_pair(runs, first, second) for first, second in both)]


def _parts(members: Sequence[int], directions: Sequence[Coordinate]) -> list[tuple[int, ...]]:
    """Parameters of an effect, those together that are never one without the other."""
    names = {directions[k].parameter.name: k for k in members}
    found: dict[int, tuple[int, ...]] = {}
    for k in members:
        first = names.get(directions[k].parameter.together_with, k)
        found[first] = (*found.get(first, ()), k)
    return list(found.values())


def _prior_of(count: int, members: int, most: int) -> float:
    """Log prior that so many parameters of an effect are changed, and just these.

    Each further one is half as probable, and any choice of them as probable as another.
    """
    most = min(members, most)
    share = 0.5 ** (count - 1) / (2.0 - 0.5 ** (most - 1))
    return float(np.log(share / math.comb(members, count)))


def _whole(runs: Shared | None, one: Change, probability: float) -> Change:
    """Give a change the probability of all that bear its name, and the thrust of its runs."""
    if runs is None or not one.which:
        return replace(one, probability=probability)
    thrust = runs.thrust_of(one.which, one.runs, one.mean)
    return replace(one, probability=probability, thrust=thrust)


def _value(one: Change) -> float:
    return one.evidence


def _worth(one: Change) -> float:
    return one.probability


def _by_gains(
    runs: Shared, direction: Coordinate, k: int, prior: float, gained: Sequence[Gained]
) -> list[Change]:
    """Evidence of a test; its p-value counts all comparisons, and so does the prior (log).

    A lag makes a gain look small, too. Where the motion speaks of that thruster it has to agree.
    """
    found = []
    for one in gained:
        if direction.effect.id != "thruster_degraded" or direction.target != one.thruster:
            continue
        value = log_bound(one.p_value) - prior + float(np.log(PRIOR_OF_ONE))
        mean = (one.value - direction.parameter.neutral) / direction.unit_size
        half = (one.ci95[1] - one.ci95[0]) / 2.0 / 1.96 / direction.unit_size
        value += runs.agrees(k, one.runs, mean, half)
        size = np.array([mean]), np.array([half])
        found.append(Change(_name(direction), (k,), one.runs, value, value + prior, *size))
    return found


def _groups(directions: Sequence[Coordinate]) -> list[tuple[tuple[int, ...], float]]:
    """Directions of each effect at each target, and its share.

    Half of the probability goes to each part alike, half to each effect, whose targets share it.
    Of several parameters one alone has half, two the other half.
    """
    found: dict[tuple[str, str | None], dict[str, int]] = {}
    for k, one in enumerate(directions):
        if not one.effect.unstated and one.within is None:
            # the last of a name is taken at the size of a change
            found.setdefault((one.effect.id, one.target), {})[one.parameter.name] = k
    targets = Counter(effect for effect, _ in found)
    return [
        (tuple(members.values()), 0.5 / len(found) + 0.5 / (len(targets) * targets[effect]))
        for (effect, _), members in found.items()
    ]


def _name(one: Coordinate) -> str:
    return one.effect.id + (f"@{one.target}" if one.target is not None else "")


def _change(
    runs: Shared, which: tuple[int, ...], directions: Sequence[Coordinate], prior: float
) -> Change:
    """One effect, carried by all runs or by those that speak for it most."""
    shares = carried(runs, which)
    own, mean, std = max(shares, key=lambda one: one[0])[1:]
    total = float(np.logaddexp.reduce([one[0] for one in shares]))
    return Change(_name(directions[which[0]]), which, own, total, total + prior, mean, std)


def _pair(runs: Shared, first: Change, second: Change) -> Change:
    """Two effects at once, in the runs that carry either."""
    prior = float(np.log(_TWO / PRIOR_OF_ONE**2))
    prior += sum(one.probability - one.evidence for one in (first, second))
    which = (*first.which, *second.which)
    own = tuple(sorted({*first.runs, *second.runs}))
    value, mean, std = runs.shared(which, own)
    name = "+".join(sorted((first.name, second.name)))
    return Change(name, which, own, value, value + prior, mean, std)


def _alike(runs: Shared, one: Change, sound: int) -> Change:
    """No change: the sound runs, which come first, or some of them have it as well.

    A manoeuvre that shows what the response has not learned shows it in both.
    """
    prior = float(np.log(_NOTHING * _LEARNED_OFF / PRIOR_OF_ONE)) + one.probability - one.evidence
    shares = [value for value, own, _, _ in carried(runs, one.which) if own[0] < sound <= own[-1]]
    value = float(np.logaddexp.reduce(shares)) if shares else -np.inf
    return Change(NONE, (), (), 0.0, value + prior, _NO_SIZE, _NO_SIZE)


def _beside_learned(
    runs: Shared, one: Change, directions: Sequence[Coordinate], sound: int
) -> list[Change]:
    """One change of a pair, and the other is what was learned: the sound runs have it as well."""
    parts: dict[str, list[int]] = {}
    for place, k in enumerate(one.which):
        parts.setdefault(_name(directions[k]), []).append(place)
    if len(parts) == 1:
        return []
    prior = float(np.log(_LEARNED_OFF * PRIOR_OF_ONE / _TWO)) + one.probability - one.evidence
    every = (*range(sound), *(sound + run for run in one.runs))
    found = []
    for name, own in parts.items():
        value, mean, std = runs.shared(one.which, every, (sound, own))
        which = tuple(one.which[place] for place in own)
        found.append(Change(name, which, one.runs, value, value + prior, mean[own], std[own]))
    return found
