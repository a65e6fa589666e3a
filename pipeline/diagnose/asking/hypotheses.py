"""The hypotheses about one set of runs, and how strongly the readings speak for each.

A hypothesis is a set of departures that may be wide. Of an effect with several parameters the best
subset is sought step by step; each step must pay for itself, and a subset pays for being one of
many (as does the one thruster among all).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import comb, log

import numpy as np

from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import Marginal
from pipeline.diagnose.linear.evidence import Prior, fit, log_inside, widened
from pipeline.types import FloatArray, IntArray

#: One effect at one target.
Group = tuple[str, str | None]
#: Variances that a departure may have that is an effect, in units of half the plausible range, and
#: the log of what a larger one costs: most effects are within the plausible range, not all.
WIDTHS = ((1.0, 0.0), (10.0, 1.5))
#: A departure beyond this is tried with larger variances as well.
_FAR = 2.0
#: Times that the size of a product is taken from its lead.
_LEAD_ROUNDS = 2
#: A departure that is this many standard deviations outside of what can be refutes its hypothesis.
IMPOSSIBLE = 4.0
#: Log evidence that a further parameter of the same effect costs: the more there are, the better
#: they make what is a flaw of the model.
_FURTHER = 10.0
#: Parameters of an effect that are few: all of them are looked at together, too.
_FEW = 3


@dataclass(frozen=True)
class Finding:
    """A hypothesis as the readings leave it: its departures and their log evidence.

    `log_evidence` is against no departure beyond the ordinary ones; `mean`, `std` (k,) are those of
    the departures `which` (k,) beyond the ordinary ones.
    """

    groups: tuple[Group, ...]
    which: tuple[int, ...]
    log_evidence: float
    mean: FloatArray
    covariance: FloatArray
    variance: FloatArray
    """(k,) of each of its departures before the readings were seen."""

    @property
    def std(self) -> FloatArray:
        """Standard deviations (k,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the hypothesis, in alphabetical order."""
        return tuple(sorted({effect for effect, _ in self.groups}))


def groups_of(all_coordinates: Sequence[Coordinate]) -> dict[Group, tuple[int, ...]]:
    """Coordinates of each effect at each target; what no vehicle file states is no hypothesis."""
    found: dict[Group, list[int]] = {}
    for index, one in enumerate(all_coordinates):
        if one.effect.unstated:
            continue
        found.setdefault((one.effect.id, one.target), []).append(index)
    return {group: tuple(members) for group, members in found.items()}


def with_ordinary(found: Marginal, prior: Prior) -> Marginal:
    """Integrate out the ordinary departures: what is left speaks for or against wide ones."""
    values, vectors = np.linalg.eigh(prior.covariance)
    keep = values > 1e-14 * max(float(values.max(initial=0.0)), 1e-300)
    root = vectors[:, keep] * np.sqrt(values[keep])
    at_mean = found.score - found.information @ prior.mean
    misfit = found.misfit - 2 * found.score @ prior.mean
    misfit += prior.mean @ found.information @ prior.mean
    return _absorbed(
        Marginal(found.information, at_mean, float(misfit), found.log_determinant), root
    )


def with_wide(found: Marginal, which: Sequence[int], variance: FloatArray) -> Marginal:
    """Integrate out wide departures (k,) as well: the ground on which a second effect stands."""
    root = np.zeros((found.score.size, len(which)))
    root[list(which), np.arange(len(which))] = np.sqrt(variance)
    return _absorbed(found, root)


def _absorbed(found: Marginal, root: FloatArray) -> Marginal:
    """Marginal with further unknowns G root z, z ~ N(0, 1), integrated out."""
    side = found.information @ root
    inner = np.eye(root.shape[1]) + root.T @ side
    solved = np.linalg.solve(inner, np.column_stack([side.T, root.T @ found.score]))
    information = found.information - side @ solved[:, :-1]
    return Marginal(
        (information + information.T) / 2,
        found.score - side @ solved[:, -1],
        found.misfit - float((root.T @ found.score) @ solved[:, -1]),
        found.log_determinant + float(np.linalg.slogdet(inner)[1]),
    )


def log_evidence_of(ground: Marginal) -> float:
    """Log evidence of the readings with nothing wide beyond what was integrated out."""
    return -0.5 * (ground.misfit + ground.log_determinant)


def judge(
    ground: Marginal, all_coordinates: Sequence[Coordinate], which: Sequence[int]
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Gain in log evidence, mean (k,), covariance (k, k) and variance (k,) of wide departures."""
    index = np.array(which, int)
    found = _judge_width(ground, all_coordinates, index, *WIDTHS[0])
    if float(np.abs(found[1]).max()) > _FAR:
        others = (_judge_width(ground, all_coordinates, index, *width) for width in WIDTHS[1:])
        found = max(found, *others, key=lambda one: one[0])
    return found


def judge_freely(
    ground: Marginal, index: IntArray, variance: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Gain, mean (k,) and covariance (k, k) of departures of these variances, without bounds."""
    precision = ground.information[np.ix_(index, index)] + np.diag(1.0 / variance)
    try:
        root = np.linalg.inv(np.linalg.cholesky(precision))
    except np.linalg.LinAlgError:
        # information that is lost in rounding
        return -np.inf, np.zeros(index.size), np.eye(index.size)
    covariance, score = root.T @ root, ground.score[index]
    mean = covariance @ score
    gain = 0.5 * float(score @ mean)
    gain += float(np.log(np.diag(root)).sum() - 0.5 * np.log(variance).sum())
    return gain, mean, covariance


def _judge_width(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    index: IntArray,
    width: float,
    price: float,
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Judge under one variance of what acts by itself.

    A product, the moment of a payload, is no larger than its lead makes it: next to no mass has
    next to no moment, wherever it sits.
    """
    variance = np.full(index.size, width)
    found = _judge_one(ground, all_coordinates, index, variance, price)
    leads = [np.flatnonzero(np.isin(index, all_coordinates[one].leads)) for one in index]
    if not any(own.size for own in leads):
        return found
    for _ in range(_LEAD_ROUNDS):
        for place, own in enumerate(leads):
            if own.size:
                variance[place] = width * (found[1][own] ** 2 + np.diag(found[2])[own]).sum()
        found = _judge_one(ground, all_coordinates, index, variance.copy(), price)
    return found


def _judge_one(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    index: IntArray,
    variance: FloatArray,
    price: float,
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    gain, mean, covariance = judge_freely(ground, index, variance)
    gain -= price
    before = np.sqrt(variance)
    for place, one in enumerate(index):
        low, high = all_coordinates[one].bounds
        value, std = float(mean[place]), float(np.sqrt(covariance[place, place]))
        if value < low - IMPOSSIBLE * std or value > high + IMPOSSIBLE * std:
            gain = -np.inf
            break
        gain += log_inside(value, std, low, high) - log_inside(0.0, float(before[place]), low, high)
    return gain, mean, covariance, variance


def best_subset(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    group: Group,
    members: Sequence[int],
    targets: int,
) -> Finding:
    """Best subset of an effect's parameters, found by adding one at a time."""
    chosen: list[int] = []
    best: tuple[float, FloatArray, FloatArray, FloatArray] | None = None
    while len(chosen) < len(members):
        trials = []
        for one in members:
            leads = all_coordinates[one].leads
            if one in chosen or (leads and not set(leads) & set(chosen)):
                continue
            which = sorted([*chosen, one])
            gain, mean, covariance, variance = judge(ground, all_coordinates, which)
            gain -= log(len(members) * comb(len(members), len(which))) + log(targets)
            gain -= _FURTHER * (len(which) - 1)
            trials.append((gain, one, mean, covariance, variance))
        if not trials or not np.isfinite(max(trial[0] for trial in trials)):
            break
        gain, one, mean, covariance, variance = max(trials, key=lambda trial: trial[0])
        if best is not None and gain <= best[0]:
            break
        chosen.append(one)
        best = (gain, mean, covariance, variance)
    if best is None:
        return Finding((group,), (), 0.0, np.zeros(0), np.zeros((0, 0)), np.zeros(0))
    return Finding((group,), tuple(sorted(chosen)), *best)


def with_all_parameters(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
    one: Finding,
) -> Finding | None:
    """Return a finding with all parameters of its effect; None where it has them, or no such.

    Seen from afar one of a few seems to suffice. An effect with a place, or with an axis each, is
    not meant: there one parameter without the others is an effect by itself.
    """
    members = groups[one.groups[0]]
    several = len(one.which) < len(members) <= _FEW and len(one.groups) == 1
    if not several or any(all_coordinates[k].leads for k in members):
        return None
    found = judge(ground, all_coordinates, members)
    if not np.isfinite(found[0]):
        return None
    whole = Finding(one.groups, tuple(members), *found)
    return replace(whole, log_evidence=found[0] + subset_price(groups, one.groups[0], len(members)))


def screen(
    ground: Marginal,
    all_coordinates: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
) -> list[Finding]:
    """Every effect at every target on a ground, the strongest first."""
    targets = {effect: sum(other == effect for other, _ in groups) for effect, _ in groups}
    found = [
        best_subset(ground, all_coordinates, group, members, targets[group[0]])
        for group, members in groups.items()
    ]
    return sorted(found, key=lambda one: (-one.log_evidence, one.groups))


def subset_price(groups: Mapping[Group, tuple[int, ...]], group: Group, taken: int) -> float:
    """Log evidence that an effect pays for which of its parameters, and which target, it has."""
    members = len(groups[group])
    targets = sum(effect == group[0] for effect, _ in groups)
    price = log(members * comb(members, taken)) + log(targets)
    return -price - _FURTHER * (taken - 1)


def prior_of(prior: Prior, finding: Finding | None) -> Prior:
    """Prior of all departures under a hypothesis."""
    if finding is None:
        return prior
    which = np.array(finding.which, int)
    return widened(prior, which, finding.variance)


def total_departures(found: Marginal, prior: Prior, finding: Finding | None) -> FloatArray:
    """Most probable departures (g,), ordinary and wide together."""
    return fit(found, prior_of(prior, finding)).mean
