"""The answers of a search: each with its probability and the finding that stands for it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.diagnose.judging.confusability import alike
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.nil import matters
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN, LevelEvidence, weigh


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
    """All answers, most probable first.

    `held_out` is the log evidence of the windows that took no part, for an answer over the best
    simpler one, by name; see `held_out_gains`.
    """

    ranking: tuple[Candidate, ...]
    held_out: Mapping[str, float] = field(default_factory=dict)

    @property
    def force_scale(self) -> float:
        """Level of the outside force under the first answer."""
        return self.ranking[0].judged.level.size

    def of(self, name: str) -> Candidate | None:
        """One answer by its name."""
        return next((one for one in self.ranking if one.name == name), None)

    def reweighed(self, shares: Sequence[Share]) -> "Answers":
        """Put the answers in the order of `shares`, with their probabilities.

        An answer that is new among them has no finding.
        """
        new = replace(self.ranking[0], finding=None)
        ranking = tuple(
            replace(self.of(one.name) or new, name=one.name, probability=one.probability)
            for one in shares
        )
        return replace(self, ranking=ranking)


def answers(found: Search, limits: Calibration, *, healthy_known: bool) -> Answers:
    """Weigh every hypothesis under every level of the outside force; see `weigh`."""
    evidence = evidence_of(found)
    findings = [[finding for _, finding, _ in hypotheses(found, one)] for one in found.judged]
    nothing = max(one.nothing for one in found.judged if one.level.ordinary)
    ranking = tuple(
        Candidate(
            one.name,
            one.probability,
            evidence[one.level].nothing + evidence[one.level].gains[one.hypothesis][1] - nothing,
            findings[one.level][one.hypothesis],
            found.judged[one.level],
        )
        for one in weigh(evidence, effect_count(found), limits, healthy_known=healthy_known)
    )
    return Answers(ranking)


def evidence_of(found: Search) -> tuple[LevelEvidence, ...]:
    """Return the numbers that are weighed."""
    return tuple(
        LevelEvidence(
            one.level.size,
            float(np.ptp(one.level.factor)) == 0.0,
            one.level.ordinary,
            one.level.weight,
            one.nothing,
            tuple((name, gain) for name, _, gain in hypotheses(found, one)),
        )
        for one in found.judged
    )


def effect_count(found: Search) -> int:
    """Candidates that share the prior probability of a single effect."""
    return len({effect for effect, _ in found.groups})


def hypotheses(found: Search, judged: Judged) -> list[tuple[str, Finding | None, float]]:
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


def equals(found: Search, one: Candidate) -> tuple[str, ...]:
    """Effects whose signature lies too close to what an answer explains to be told from it."""
    if one.finding is None or one.name in {NONE, UNKNOWN}:
        return ()
    return alike(one.judged.ground, one.finding, found.setting.coordinates, found.groups)
