"""The answers of a day's runs, each alone and all together -> which run carries which finding.

What the runs say together counts only where they agree alone: a fault that is there in one run and
not in the others fits none of the answers to all of them, and comes out as an unknown cause.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

from pydantic import Field

from pipeline.records.base import Record
from pipeline.records.diagnosis import (
    DiagnosisRecord,
    FoundEvent,
    NextRun,
    RankedEffect,
    Series,
    ShrinkFigures,
)

_Key = tuple[frozenset[str], str | None]
_SOUND: _Key = (frozenset({"none"}), None)


class RunDiagnosis(Record):
    """The diagnosis of one run by itself; `record` None where none could be made."""

    vehicle: str
    run: str
    day: str
    against: str
    """What it is told against: the vehicle file, or the sound runs by name."""
    stretches: tuple[tuple[float, float], ...] = ()
    """Parts of the run that were taken: from and to. [s]"""
    record: DiagnosisRecord | None = None
    why_not: str = ""


class DayFinding(Record):
    """One answer and the runs that carry it."""

    effects: tuple[str, ...]
    thruster: str | None
    runs: tuple[str, ...]
    by: Literal["run", "together"]
    """Whether each of the runs said so by itself, or all of them together."""
    probability: float
    ambiguous_with: tuple[str, ...] = ()
    ranked: RankedEffect | None = None
    """Values and intervals, of the run that is surest."""
    worst_axis: str = ""
    """Of an unknown cause: the axis along which most force is left."""
    event: FoundEvent | None = None
    """Where the answer is what happened at a time of the run."""
    shown: tuple[Series, ...] = ()
    """What shows it: the channel that is off most, of the run that is surest."""
    shown_floor: float | None = None
    """What a sound vehicle leaves of that channel, in its unit."""

    @property
    def is_sound(self) -> bool:
        """Whether nothing was found."""
        return self.effects == ("none",)


class DayDiagnosis(Record):
    """The answer of a day: its findings, faults first; of what nothing could be told, and why."""

    vehicle: str
    day: str
    against: str
    findings: tuple[DayFinding, ...] = ()
    together: DiagnosisRecord | None = None
    why_not_together: str = ""
    without: dict[str, str] = Field(default_factory=dict)
    """Run -> why it has no answer."""
    next_run: NextRun | None = None
    why_not: str = ""


def agree(alone: Mapping[str, DiagnosisRecord]) -> bool:
    """Tell whether one answer holds for all runs: none rules it out by itself, `alone`."""
    possible = [{_key(record)} | _others(record) for record in alone.values()]
    return bool(set.intersection(*possible)) if possible else False


def day_findings(
    alone: Mapping[str, DiagnosisRecord], together: DiagnosisRecord | None = None
) -> tuple[DayFinding, ...]:
    """Combine the answers of each run by itself, in order of time, and to all of them together.

    Named causes come first, then what is unknown, then runs in which nothing is wrong.
    """
    if together is not None and agree(alone):
        return (_finding([*alone], together, "together"),)
    sound = any(_key(record) == _SOUND for record in alone.values())
    groups: dict[_Key, list[str]] = {}
    for run, record in alone.items():
        # what may be nothing at all is taken for that beside runs that are sound
        faint = sound and _SOUND in _others(record)
        groups.setdefault(_SOUND if faint else _key(record), []).append(run)
    found = []
    for key, runs in groups.items():
        own = [run for run in runs if _key(alone[run]) == key]
        surest = max(own, key=lambda run: alone[run].verdict.probability)
        found.append(_finding(runs, alone[surest], "run"))
    return tuple(sorted(found, key=_rank))


def _key(record: DiagnosisRecord) -> _Key:
    return frozenset(record.verdict.effects), record.verdict.detail.thruster


def _others(record: DiagnosisRecord) -> set[_Key]:
    """Return what a run cannot tell its answer from; at which thruster is not said of these."""
    return {(frozenset(name.split("+")), None) for name in record.verdict.ambiguous_with}


def _finding(runs: Sequence[str], record: DiagnosisRecord, by: str) -> DayFinding:
    verdict = record.verdict
    name = "+".join(verdict.effects)
    ranked = next((one for one in record.ranking if one.effect == name), None)
    if ranked is None:  # the parts of a pair may be named the other way round
        wanted = set(verdict.effects)
        ranked = next((one for one in record.ranking if set(one.effect.split("+")) == wanted), None)
    unknown = "unknown" in verdict.effects
    return DayFinding.model_validate(
        {
            "effects": verdict.effects,
            "thruster": verdict.detail.thruster,
            "runs": tuple(runs),
            "by": by,
            "probability": verdict.probability,
            "ambiguous_with": verdict.ambiguous_with,
            "ranked": ranked,
            "worst_axis": record.leftover.worst_axis if unknown else "",
            "event": verdict.events[0] if verdict.from_s is not None else None,
            **_shown(record),
        }
    )


def _shown(record: DiagnosisRecord) -> dict[str, object]:
    """Return the readings in which it is to be seen best: the channel that is off most.

    Of the runs those first that carry the verdict.
    """
    there = {one.channel for one in record.series}

    def size(figures: ShrinkFigures) -> float:
        return figures.before / max(figures.noise_floor, 1e-12)

    able = {name: size(one) for name, one in record.shrink.channels.items() if name in there}
    if not able:
        return {}
    worst = max(able, key=lambda name: able[name])
    shown = [one for one in record.series if one.channel == worst]
    return {
        "shown": tuple(sorted(shown, key=lambda one: one.run not in record.verdict.runs)),
        "shown_floor": record.shrink.channels[worst].noise_floor,
    }


def _rank(one: DayFinding) -> tuple[int, float]:
    order = 2 if one.is_sound else 1 if one.effects == ("unknown",) else 0
    return order, -one.probability
