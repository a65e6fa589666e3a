"""What a check found: vehicles, raw files, pool runs, and every problem."""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain

from pipeline.errors import Problem
from pipeline.records.gains import ThrusterGains
from pipeline.records.measurements import SheetRead
from pipeline.records.pool_run import PoolRunRecord, RunNotes


@dataclass(frozen=True)
class Quantity:
    """The range of one quantity over the points that a fit would use."""

    name: str
    count: int
    least: float
    most: float


@dataclass(frozen=True)
class FileFinding:
    """One raw file as it was understood."""

    file: str
    kind: str
    kind_from: str
    sheets: tuple[SheetRead, ...]
    points: int
    marks: dict[str, int]
    codes: dict[str, int]
    quantities: tuple[Quantity, ...]
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class VehicleFinding:
    """One vehicle file as it was understood."""

    file: str
    name: str
    notes: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()


@dataclass(frozen=True)
class RunFinding:
    """One pool run as it was understood; without `record` it could not be read."""

    file: str
    kind_from: str
    record: PoolRunRecord | None = None
    problems: tuple[Problem, ...] = ()


@dataclass(frozen=True)
class GainsFinding:
    """Gains of the thrusters in the runs of one vehicle, or why there are none."""

    vehicle_file: str
    gains: ThrusterGains | None = None
    why_not: str = ""


@dataclass(frozen=True)
class NotesFinding:
    """Notes that were asked for without their run."""

    file: str
    notes: RunNotes | None = None
    problems: tuple[Problem, ...] = ()


@dataclass
class Findings:
    """All that a check found, in the order in which it was asked."""

    vehicles: list[VehicleFinding] = field(default_factory=list)
    files: list[FileFinding] = field(default_factory=list)
    runs: list[RunFinding] = field(default_factory=list)
    notes: list[NotesFinding] = field(default_factory=list)
    gains: list[GainsFinding] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    """What belongs to no single file, such as the codes that a folder lacks."""

    @cached_property
    def all_problems(self) -> tuple[Problem, ...]:
        """Every problem once, in the order found."""
        found = [self.problems, *(one.problems for one in self.vehicles)]
        found += [*(one.problems for one in self.files), *(one.problems for one in self.runs)]
        found += [one.problems for one in self.notes]
        return tuple(dict.fromkeys(chain.from_iterable(found)))

    @property
    def failed(self) -> bool:
        """Whether anything was refused."""
        return any(problem.severity == "error" for problem in self.all_problems)
