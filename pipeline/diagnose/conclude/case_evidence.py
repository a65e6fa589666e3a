"""What a diagnosis weighed, as numbers: with it thresholds are set without diagnosing again."""

from dataclasses import replace

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


class CaseEvidence(Record):
    """All that the thresholds act on."""

    healthy: bool
    effect_count: int
    interval_factor: float
    worst_ratio: float
    worst_since: float
    levels: tuple[LevelEvidence, ...]
    consequences: dict[str, Left]
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
        left = led_to.decides(equals(found, one), answered.held_out.get(one.name, 0.0))
        kept[one.name] = replace(left, supply_known=supply_known)
    return CaseEvidence(
        healthy=healthy_known,
        effect_count=effect_count(found),
        interval_factor=limits.interval_factor,
        worst_ratio=seen.worst_ratio,
        worst_since=seen.worst_since,
        levels=evidence_of(found),
        consequences=kept,
        held_out=dict(answered.held_out),
        gap_left=gaps_left(found, seen.ahead, answered),
    )
