"""What the page of a pool run is made of."""

from dataclasses import dataclass, field

from pipeline.errors import Problem
from pipeline.records.manoeuvre import ManoeuvreFound
from pipeline.records.run_table import RunTable
from pipeline.records.trial import RunTrial, StoredRun
from pipeline.report.results import by_severity
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class RunResults:
    """A run as far as it got: a log that cannot be read has problems alone.

    `files` are label and address of files beside the page; `shown_path` names the log in messages,
    `run` among the results, where it may be another name that is safe in paths and addresses.
    """

    vehicle: Vehicle
    vehicle_name: str
    run: str
    shown_path: str
    stored: StoredRun | None = None
    why_not_read: str = ""
    problems: tuple[Problem, ...] = ()
    trial: RunTrial | None = None
    measured: RunTable | None = None
    windows: RunTable | None = None
    free: RunTable | None = None
    files: tuple[tuple[str, str], ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)

    @property
    def manoeuvres(self) -> tuple[ManoeuvreFound, ...]:
        """What was flown."""
        return () if self.trial is None else self.trial.manoeuvres

    @property
    def all_problems(self) -> tuple[Problem, ...]:
        """Problems of the log, errors first."""
        return by_severity((*self.problems, *(self.stored.problems if self.stored else ())))

    @property
    def errors(self) -> int:
        """Number of errors."""
        return sum(problem.severity == "error" for problem in self.all_problems)

    @property
    def warnings(self) -> int:
        """Number of warnings: of the log, and of the comparison with the simulation."""
        of_log = sum(problem.severity == "warning" for problem in self.all_problems)
        return of_log + (len(self.trial.warnings) if self.trial is not None else 0)
