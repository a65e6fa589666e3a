"""From log evidence to probabilities and a set of answers, with thresholds from generated cases."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.calibration import Calibration
from pipeline.diagnose.hypotheses import Finding
from pipeline.diagnose.nil import matters
from pipeline.diagnose.search import Judged, Search
from pipeline.types import FloatArray

NONE, UNKNOWN = "none", "unknown"


@dataclass(frozen=True)
class Candidate:
    """One answer: its effects, how probable, and the strongest finding with its level."""

    name: str
    probability: float
    log_evidence: float
    finding: Finding | None
    judged: Judged


@dataclass(frozen=True)
class Answers:
    """All answers, most probable first; `level` is the most probable outside force."""

    ranking: tuple[Candidate, ...]
    force_scale: float

    def of(self, name: str) -> Candidate | None:
        """One answer by its name."""
        return next((one for one in self.ranking if one.name == name), None)


def answers(found: Search, calibration: Calibration) -> Answers:
    """Weigh every hypothesis under every level of the outside force.

    The evidence is tempered: its exponent is below 1, because models are never quite right. Mass
    under a force that no healthy vehicle has goes to `unknown`, unless the effect takes away most
    of the force that would be needed without it.
    """
    weights = _weights(found, calibration)
    best: dict[str, tuple[float, Finding | None, Judged]] = {}
    totals: dict[str, float] = {}
    needed = _needed_force(found.judged, None)
    for judged in found.judged:
        for name, finding, gain in _hypotheses(found, judged):
            log_evidence = calibration.exponent * (judged.nothing + gain)
            log_evidence += weights[name.count("+")] if name != NONE else np.log(calibration.none)
            log_evidence += float(np.log(judged.level.weight))
            goes_to = name
            if not judged.level.ordinary:
                left = judged.level.size / max(needed, 1e-9)
                if name == NONE or left > calibration.left_over:
                    goes_to = UNKNOWN
            totals[goes_to] = float(np.logaddexp(totals.get(goes_to, -np.inf), log_evidence))
            if goes_to not in best or log_evidence > best[goes_to][0]:
                best[goes_to] = (log_evidence, finding, judged)
    highest = max(totals.values())
    shares = {name: float(np.exp(value - highest)) for name, value in totals.items()}
    whole = sum(shares.values())
    nothing = max(one.nothing for one in found.judged if one.level.ordinary)
    ranking = []
    for name, share in shares.items():
        _, finding, judged = best[name]
        gain = 0.0 if finding is None else finding.log_evidence
        ranking.append(
            Candidate(name, share / whole, judged.nothing + gain - nothing, finding, judged)
        )
    ranking.sort(key=lambda one: (-one.probability, -one.log_evidence, one.name))
    return Answers(tuple(ranking), ranking[0].judged.level.size)


def _hypotheses(found: Search, judged: Judged) -> list[tuple[str, Finding | None, float]]:
    """Names, findings and gains under one level; the best target stands for an effect."""
    named: dict[str, tuple[Finding | None, float]] = {NONE: (None, 0.0)}
    for finding in (*judged.singles, *judged.pairs):
        name, gain = "+".join(finding.effects), finding.log_evidence
        if not finding.which or not np.isfinite(gain):
            continue
        if not matters(finding, found.reach, found.setting.coordinates):
            continue
        if name not in named or named[name][1] < gain:
            named[name] = (finding, gain)
    return [(name, finding, gain) for name, (finding, gain) in named.items()]


def _weights(found: Search, calibration: Calibration) -> FloatArray:
    """Log prior of one single effect, and of one pair."""
    count = len({effect for effect, _ in found.groups})
    pair_count = max(count * (count - 1) / 2, 1)
    return np.asarray(
        np.log(np.array([calibration.single / max(count, 1), calibration.pair / pair_count]))
    )


def _needed_force(judged: Sequence[Judged], finding: Finding | None) -> float:
    """Outside force that the readings want where no effect is at work."""
    even = [one for one in judged if np.ptp(one.level.factor) == 0.0]
    return max(even, key=lambda one: one.nothing).level.size if finding is None else 1.0


def answer_set(found: Answers, calibration: Calibration) -> tuple[str, ...]:
    """Smallest set of answers that holds the truth as often as was calibrated."""
    chosen: list[str] = []
    total = 0.0
    for one in found.ranking:
        chosen.append(one.name)
        total += one.probability
        if total >= calibration.set_level:
            break
    return tuple(chosen)


def angles(found: Search, first: Finding, judged: Judged) -> Mapping[str, float]:
    """Angle of what a finding explains to every other effect, the smallest over targets. [deg]."""
    from pipeline.diagnose.confusability import angle_to

    smallest: dict[str, float] = {}
    for group, members in found.groups.items():
        if group[0] in first.effects:
            continue
        value = angle_to(judged.ground, first, members)
        smallest[group[0]] = min(smallest.get(group[0], 90.0), value)
    return smallest
