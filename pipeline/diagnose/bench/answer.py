"""From the fits of a mooring table to probabilities, the group that cannot be told apart, words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pipeline.diagnose.bench.effects import CANDIDATES, TWIN, predict, priors
from pipeline.diagnose.bench.fit import BenchComparison, BenchFit, fit_effects, fit_nothing
from pipeline.diagnose.bench.noise import law_share

#: Below this angle two effects are one answer. [deg]
ONE_ANSWER_DEG = 10.0
#: Prior probabilities: nothing, unknown, all single effects, all pairs.
PRIOR = {"none": 0.5, "unknown": 0.05, "single": 0.4, "pair": 0.05}
#: A table is usually of a thruster alone, with no hull to take thrust back.
_ON_THE_HULL = 0.1
#: Probability that the answer set holds.
SET_LEVEL = 0.95
#: An effect must be better than nothing by this much (natural logarithm) to be fitted in a pair.
_WORTH = 3.0
#: Left over above this, one effect is not enough: pairs and `unknown` are in question.
LEFT_OVER = 1.5
#: A second effect must cut what the first leaves to this share.
_SECOND = 0.6
#: By how much `unknown` stands behind an effect that leaves nothing (natural logarithm).
_NOT_NEEDED = 3.0
#: Beside `unknown` an effect is named that leaves less than this share of the gap.
_MOST_GONE = 1.0 / 3.0
#: A share of missing voltage at full code that takes thrust away for certain.
_LOAD = 0.03


@dataclass(frozen=True)
class Ranked:
    """One answer: name, probability, its fit, evidence against the nominal thruster."""

    name: str
    probability: float
    log_evidence: float
    fit: BenchFit


def rank(problem: BenchComparison) -> tuple[tuple[Ranked, ...], int]:
    """Weigh nothing, every effect, pairs, and a departure of any shape; most probable first.

    Returns
    -------
    ranking : tuple of Ranked
    evaluations : int
        How often the model was evaluated.
    """
    nothing = fit_nothing(problem)
    singles = [fit_effects(problem, (effect,)) for effect in CANDIDATES]
    unknown = [fit_nothing(problem, unknown=True)]
    if "voltage" in problem.stack.channels:
        sag = next(one for one in singles if one.effects == ("voltage_sag",))
        unknown.append(fit_nothing(problem, unknown=True, beside=sag))
    fits = [nothing, *unknown, *singles]
    alone = {one.effects[0]: one for one in singles if one.effects[0] != "thrust_deduction"}
    best = max(singles, key=lambda one: one.log_evidence)
    left = left_over(problem, best)
    if left > LEFT_OVER:
        fits += _pairs(problem, alone, nothing.log_evidence, rms_left_n(problem, best))
    count = len(CANDIDATES) - 1
    pairs = count * (count - 1) / 2

    def weight(one: BenchFit) -> float:
        if one.effects[0] == "none":
            return PRIOR["none"]
        if one.effects[0] == "unknown":
            return PRIOR["unknown"] / len(unknown)
        if len(one.effects) > 1:
            return PRIOR["pair"] / pairs
        share = {"thrust_deduction": _ON_THE_HULL, "thruster_degraded": 1.0 - _ON_THE_HULL}
        return PRIOR["single"] / count * share.get(one.effects[0], 1.0)

    by_name: dict[str, tuple[float, BenchFit]] = {}
    for one in fits:
        name, evidence = "+".join(one.effects), one.log_evidence
        if name == "unknown" and left <= LEFT_OVER:
            # what is left is within the ordinary: a shape of any kind is not needed
            evidence = min(evidence, max(best.log_evidence, nothing.log_evidence) - _NOT_NEEDED)
        total = evidence + float(np.log(weight(one)))
        shown = one
        if name in by_name:  # two ways of being unknown: the likelier one is shown
            before, way = by_name[name]
            total, shown = float(np.logaddexp(total, before)), max(way, one, key=_evidence)
        by_name[name] = (total, shown)
    top = max(total for total, _ in by_name.values())
    shares = {name: float(np.exp(total - top)) for name, (total, _) in by_name.items()}
    whole = sum(shares.values())
    ranking = [
        Ranked(name, shares[name] / whole, one.log_evidence - nothing.log_evidence, one)
        for name, (_, one) in by_name.items()
    ]
    ranking.sort(key=lambda one: (-one.probability, -one.log_evidence, one.name))
    return tuple(ranking), sum(one.linearisations for one in fits)


def _evidence(one: BenchFit) -> float:
    return one.log_evidence


def rms_left_n(problem: BenchComparison, found: BenchFit) -> float:
    """Root mean square of measured less predicted thrust [N]."""
    table = problem.table
    after = predict(problem.model, found.values, table.code, ("thrust",))["thrust"]
    return float(np.sqrt(np.mean((table.mean["thrust"] - after) ** 2)))


def left_over(problem: BenchComparison, found: BenchFit) -> float:
    """Thrust that an effect leaves unexplained, over what it may leave.

    That is the healthy floor and the share by which the effect's law is wrong, together.
    """
    after = predict(problem.model, found.values, problem.table.code, ("thrust",))["thrust"]
    moved = law_share(found.values) * float(
        np.sqrt(np.mean((after - problem.nominal["thrust"]) ** 2))
    )
    floor = float(np.sqrt(np.mean(np.diag(problem.healthy["thrust"]))))
    return rms_left_n(problem, found) / float(np.hypot(floor, moved))


def _pairs(
    problem: BenchComparison, alone: Mapping[str, BenchFit], nothing: float, single_left_n: float
) -> list[BenchFit]:
    """Pairs that leave clearly less than the best single effect does."""
    fits = []
    for pair in combinations(sorted(alone), 2):
        first, second = (alone[one] for one in pair)
        if max(first.log_evidence, second.log_evidence) - nothing < _WORTH:
            continue
        found = fit_effects(problem, pair, first.values | second.values)
        if rms_left_n(problem, found) < _SECOND * single_left_n:
            fits.append(found)
    return fits


def angle_deg(
    problem: BenchComparison, values: Mapping[tuple[str, str], float], other: str
) -> float:
    """Angle between what a set of parameters does to this table and the nearest that `other` can.

    Both as departures from the nominal thruster, whitened by the healthy covariance; the
    parameters of `other` run over their whole range, so a factor that would have to exceed 1 is
    no twin of a higher supply. [deg]
    """
    from scipy.optimize import minimize

    chosen = priors(other, problem.model.code_max)
    base = problem.stack.join(problem.nominal)
    code, channels = problem.table.code, problem.table.channels

    def departure(values: Mapping[tuple[str, str], float]) -> np.ndarray:
        moved = problem.stack.join(predict(problem.model, values, code, channels)) - base
        return problem.whitened(covariance, moved[:, None])[0][:, 0]

    covariance = problem.healthy
    wanted = departure(values)
    size = float(np.linalg.norm(wanted))
    if size < 1e-6:
        return 90.0
    ends = [one.bounds for one in chosen]
    names = [(one.effect, one.parameter) for one in chosen]

    def left(theta: np.ndarray) -> float:
        held = np.clip(theta, *np.array(ends).T)
        return float(
            np.linalg.norm(wanted - departure(dict(zip(names, map(float, held), strict=True))))
        )

    trials = [
        np.clip([one.mean + share * one.std for one in chosen], *np.array(ends).T)
        for share in (-2.0, -1.0, -0.4, 0.4, 1.0, 2.0)
    ]
    start = min(trials, key=left)
    found = minimize(
        left,
        start,
        method="Nelder-Mead",
        bounds=ends,
        options={"maxfev": 120, "fatol": 1e-4 * size},
    )
    return float(np.degrees(np.arcsin(min(float(found.fun) / size, 1.0))))


def confusable(problem: BenchComparison, least: float = 0.9) -> list[tuple[str, str, float]]:
    """Pairs of effects this table cannot tell apart whatever it reads: cosine of the angle.

    Each effect stands at a fair size: one prior standard deviation from neutral.
    """
    found: dict[tuple[str, str], float] = {}
    for effect in CANDIDATES:
        if effect == "thrust_deduction":
            continue
        one = priors(effect, problem.model.code_max)[0]
        sign = 1.0 if one.mean + one.std <= one.bounds[1] and one.mean == 0.0 else -1.0
        values = {(effect, one.parameter): one.mean + sign * one.std}
        for other in CANDIDATES:
            if other in {effect, "thrust_deduction"}:
                continue
            cosine = float(np.cos(np.radians(angle_deg(problem, values, other))))
            pair = (min(effect, other), max(effect, other))
            found[pair] = max(found.get(pair, 0.0), cosine)
    rows = [(a, b, round(c, 6)) for (a, b), c in found.items() if c >= least]
    rows.append((*TWIN, 1.0))
    return sorted(rows, key=lambda row: (-row[2], row))


def group_of(problem: BenchComparison, ranking: Sequence[Ranked]) -> tuple[tuple[str, ...], float]:
    """Answers that the data cannot tell from the first, and the probability of them all.

    Those whose best imitation of the first lies within 10 degrees, whatever their probability, and
    the next most probable until the set holds; beside `unknown` the effects that explain most of
    the gap. Without a voltage, missing supply and a weak thruster are always one answer: a drive
    whose dead zone stays where it is when the supply falls loses the same share at all codes. Of a
    pair that holds for the one of its two that is meant.
    """
    own = set(ranking[0].fit.effects)
    named = _with_twin(set(_look_alikes(problem, ranking)), own)

    def held() -> list[Ranked]:
        return [one for one in ranking if own | named >= set(one.fit.effects)]

    for one in ranking:
        if sum(other.probability for other in held()) >= SET_LEVEL:
            break
        named = _with_twin(named | (set(one.fit.effects) - own), own)
    # one effect of a pair without the other is held as well, but is not the verdict
    total = ranking[0].probability
    total += sum(one.probability for one in held() if named & set(one.fit.effects))
    return tuple(sorted(named)), min(total, 1.0)


def _with_twin(named: set[str], own: set[str]) -> set[str]:
    """Name beside one of the two effects that nothing separates the other one."""
    return named | (set(TWIN) - own) if (named | own) & set(TWIN) else named


def _look_alikes(problem: BenchComparison, ranking: Sequence[Ranked]) -> list[str]:
    """Effects that the first answer cannot be told from, whatever their probability."""
    first = ranking[0]
    if first.name == "unknown":
        # An effect that explains most is what to look at, even if it does not explain all.
        before = rms_left_n(problem, fit_nothing(problem))
        return [
            one.name
            for one in ranking
            if one.name in CANDIDATES and rms_left_n(problem, one.fit) < _MOST_GONE * before
        ]
    members: list[str] = []
    if first.name in CANDIDATES:
        members = [
            other
            for other in CANDIDATES
            if other != first.name and angle_deg(problem, first.fit.values, other) <= ONE_ANSWER_DEG
        ]
    if "voltage" not in problem.stack.channels:
        drop = first.fit.values.get(("voltage_sag", "drop"), 0.0)
        load = first.fit.values.get(("voltage_sag", "load_drop"), 0.0)
        if drop + load > _LOAD:
            members.append("thruster_degraded")
        elif set(first.fit.effects) & set(TWIN):
            members.append("voltage_sag")
    return members
