"""What the pages of a vehicle, a pool run and a trial day are made of."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from pipeline.errors import CannotComputeError, Problem, by_severity
from pipeline.records import fits, measurements
from pipeline.records import trial as trial_records
from pipeline.records.base import AppliedChange, Glance
from pipeline.records.day_findings import DayDiagnosis
from pipeline.records.gains import PooledGain
from pipeline.records.run_table import RunTable
from pipeline.records.trial import ManoeuvreFound
from pipeline.records.validation import AllocationMap, AllocatorValidation
from pipeline.vehicle.bench_schema import is_at_supply
from pipeline.vehicle.schema import Vehicle

T = TypeVar("T")


@dataclass(frozen=True)
class VehicleResults:
    """Everything the page shows; a record is None where its stage did not run or could not.

    `missing` gives, for a stage without a record, the plain reason ("open_water": "there are no
    open-water files"). `provenance` is shown line by line. `firmware_files` are links relative to
    the page.
    """

    vehicle: Vehicle
    notes: tuple[str, ...] = ()
    load_test: measurements.LoadTestRecord | None = None
    mooring: measurements.MooringRecord | None = None
    open_water: measurements.OpenWaterRecord | None = None
    propeller: fits.PropellerFit | None = None
    drive: fits.DriveFit | None = None
    static: fits.StaticCharacteristic | None = None
    inverse: fits.InverseCharacteristic | None = None
    allocation: AllocationMap | None = None
    validation: AllocatorValidation | None = None
    missing: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)
    firmware_files: tuple[str, ...] = ()
    page: Path = Path("reports/vehicle/index.html")
    """Where it lies, from the output folder: what its links are relative to."""
    trials: tuple[trial_records.PageReceipt, ...] = ()
    """Pages of the trial days in order of time."""
    changes: tuple[AppliedChange, ...] = ()
    """Of the vehicle file, by `rig2sea apply`, in order."""
    ignored: tuple[Problem, ...] = ()
    """Of what lies in the folders of the tests and is not read."""


#: Stage name in `VehicleResults` and what the page calls its result.
STAGE_TITLES = {
    "load_test": "Load test of the drive",
    "mooring": "Mooring test",
    "open_water": "Open-water curves",
    "propeller": "Propeller fit (Table 1)",
    "drive": "Drive characteristic",
    "static": "Static characteristic (Table 2)",
    "inverse": "Inverse characteristic (Tables 3 and 4)",
    "allocation": "Allocator error map",
    "validation": "Allocator flown in simulation",
}


def all_problems(results: VehicleResults) -> tuple[Problem, ...]:
    """Collect the problems of all raw files, errors first, then warnings, then notes."""
    records = (results.load_test, results.mooring, results.open_water)
    read = [one for record in records if record for one in record.problems]
    return by_severity([*results.ignored, *read])


def all_checks(results: VehicleResults) -> tuple[tuple[str, fits.Check], ...]:
    """Collect the checks of all fits, each with the title of its stage."""
    stages = ("propeller", "drive", "static", "inverse")
    fits = ((STAGE_TITLES[name], getattr(results, name)) for name in stages)
    return tuple((title, check) for title, fit in fits if fit is not None for check in fit.checks)


def mooring_points_of_tables(results: VehicleResults) -> tuple[measurements.MooringPoint, ...]:
    """Usable mooring points at the supply voltage that the tables are for."""
    if results.mooring is None:
        return ()
    wanted = results.vehicle.tables.supply_voltage_v
    return tuple(
        point
        for point in results.mooring.points
        if not point.marks and is_at_supply(point.voltage_v, wanted)
    )


def missing_reasons(results: VehicleResults) -> dict[str, str]:
    """Return the reason for every stage that has no record, stated or generic."""
    # nobody has to describe a model or an allocator
    spared = {"validation"} if results.vehicle.model is None else set()
    if results.vehicle.allocator is None and "allocation" not in results.missing:
        spared.add("allocation")
    return {
        stage: results.missing.get(stage, "the stage has not run")
        for stage in STAGE_TITLES
        if getattr(results, stage) is None and stage not in spared
    }


def needed(results: VehicleResults, stage: str, record: T | None) -> T:
    """Return the record of a stage; `CannotComputeError` with the reason where there is none."""
    if record is None:
        raise CannotComputeError(missing_reasons(results).get(stage, "the stage has not run"))
    return record


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
    stored: trial_records.StoredRun | None = None
    why_not_read: str = ""
    problems: tuple[Problem, ...] = ()
    trial: trial_records.RunTrial | None = None
    measured: RunTable | None = None
    windows: RunTable | None = None
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


@dataclass(frozen=True)
class DayResults:
    """One day: its fit, those of the days before in order of time, its runs, the tables.

    `links` gives the address of each run's page, relative to this one.
    """

    vehicle: Vehicle
    day: str
    trial: trial_records.TrialDay
    earlier: Mapping[str, trial_records.TrialDay] = field(default_factory=dict)
    runs: tuple[trial_records.PageReceipt, ...] = ()
    links: Mapping[str, str] = field(default_factory=dict)
    compared: tuple[PooledGain, ...] = ()
    """The day's gains against those of the last sound day before."""
    tables: trial_records.DayTables | None = None
    tables_before: trial_records.DayTables | None = None
    glance: Glance | None = None
    diagnosis: DayDiagnosis | None = None
    provenance: dict[str, str] = field(default_factory=dict)
