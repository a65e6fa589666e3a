"""What a trial day's runs show, each alone and together, and which run carries which finding."""

from typing import Literal

from pydantic import Field

from pipeline.records.base import Record
from pipeline.records.diagnosis import DiagnosisRecord, FoundEvent, NextRun, RankedEffect, Series


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
