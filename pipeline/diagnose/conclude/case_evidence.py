"""What a diagnosis weighed, as numbers: with it thresholds are set without diagnosing again."""

from dataclasses import asdict, replace
from typing import Self

from pipeline.diagnose.conclude.consequences import consequence
from pipeline.diagnose.conclude.gap_left import gaps_left
from pipeline.diagnose.conclude.gap_seen import GapSeen
from pipeline.diagnose.inference.answer import Answers, effect_count, equals, evidence_of
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.shares import Left
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN, LevelEvidence
from pipeline.records.base import Record

#: Answers whose consequences are kept.
_MOST = 4


class KeptLevel(Record):
    """One level of the outside force; see `LevelEvidence`."""

    size: float
    even: bool
    ordinary: bool
    weight: float
    nothing: float
    gains: tuple[tuple[str, float], ...]

    def evidence(self) -> LevelEvidence:
        """As it is weighed."""
        return LevelEvidence(
            self.size, self.even, self.ordinary, self.weight, self.nothing, self.gains
        )


class KeptConsequence(Record):
    """What an answer leaves, as in `Left`, but for what is known of the answer elsewhere.

    The log evidence of the held-out windows stands in `CaseEvidence`, for every answer.
    """

    force: float
    before: float
    after: float
    gap_closed: float | None
    alike: tuple[str, ...]
    alone: float = 0.0
    gap_there: float | None = None
    alone_after: float = 0.0
    was_unknown: bool = False
    supply_known: bool = True
    gap_since: float | None = None

    @classmethod
    def of(cls, left: Left) -> Self:
        """Keep what an answer leaves."""
        told = asdict(left)
        del told["held_out"]
        return cls(**told)

    def left(self) -> Left:
        """As it is decided by."""
        return Left(**self.model_dump())


class CaseEvidence(Record):
    """All that the thresholds act on."""

    healthy: bool
    effect_count: int
    interval_factor: float
    worst_ratio: float
    worst_since: float
    levels: tuple[KeptLevel, ...]
    consequences: dict[str, KeptConsequence]
    held_out: dict[str, float]
    """Log evidence of the held-out windows, by answer; see `held_out_gains`."""
    gap_left: dict[str, float]
    """Surprise at the gap that answers leave; see `gap_left`."""


def case_evidence(
    found: Search,
    answered: Answers,
    seen: GapSeen,
    limits: Calibration,
    *,
    healthy_known: bool,
    supply_known: bool,
) -> CaseEvidence:
    """Collect the evidence of a search, and the consequences of its first answers."""
    named = [one for one in answered.ranking if one.name != UNKNOWN]
    wanted = named[:_MOST] + [one for one in named[_MOST:] if one.name == NONE]
    kept = {}
    for one in wanted:
        led_to = consequence(found, seen.ahead, one, one.judged.level.size, seen.every)
        left = replace(led_to.decides(equals(found, one)), supply_known=supply_known)
        kept[one.name] = KeptConsequence.of(left)
    return CaseEvidence(
        healthy=healthy_known,
        effect_count=effect_count(found),
        interval_factor=limits.interval_factor,
        worst_ratio=seen.worst_ratio,
        worst_since=seen.worst_since,
        levels=tuple(
            KeptLevel(
                size=one.size,
                even=one.even,
                ordinary=one.ordinary,
                weight=one.weight,
                nothing=one.nothing,
                gains=one.gains,
            )
            for one in evidence_of(found)
        ),
        consequences=kept,
        held_out=dict(answered.held_out),
        gap_left=gaps_left(found, seen.ahead, answered),
    )
