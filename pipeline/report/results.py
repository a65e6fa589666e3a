"""What a vehicle's page is made of: the vehicle file and the record of every stage that ran."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from pipeline.errors import Problem
from pipeline.records.allocation import AllocationMap
from pipeline.records.file_change import AppliedChange
from pipeline.records.fits import (
    Check,
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.gains import PooledGain
from pipeline.records.glance import Glance
from pipeline.records.identification import IdentifiedParameter
from pipeline.records.measurements import (
    LoadTestRecord,
    MooringPoint,
    MooringRecord,
    OpenWaterRecord,
)
from pipeline.records.validation import AllocatorValidation
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.supply_voltage import is_at_supply


@dataclass(frozen=True)
class TrialDayLink:
    """A trial day as other pages name it; addresses are relative to the page.

    `runs` are label and address of each; `parameters` are what the day's runs tell, not to be used
    where the fit has not `settled`.
    """

    name: str
    title: str
    line: str
    href: str
    runs: tuple[tuple[str, str], ...] = ()
    parameters: tuple[IdentifiedParameter, ...] = ()
    settled: bool = True
    gains: tuple[PooledGain, ...] = ()
    glance: Glance | None = None
    lights: tuple[str, ...] = ()
    """Of each run: red, amber, green, or nothing."""


@dataclass(frozen=True)
class VehicleResults:
    """Everything the page shows; a record is None where its stage did not run or could not.

    `missing` gives, for a stage without a record, the plain reason ("open_water": "there are no
    open-water files"). `provenance` is shown line by line. `firmware_files` are links relative to
    the page.
    """

    vehicle: Vehicle
    notes: tuple[str, ...] = ()
    load_test: LoadTestRecord | None = None
    mooring: MooringRecord | None = None
    open_water: OpenWaterRecord | None = None
    propeller: PropellerFit | None = None
    drive: DriveFit | None = None
    static: StaticCharacteristic | None = None
    inverse: InverseCharacteristic | None = None
    allocation: AllocationMap | None = None
    validation: AllocatorValidation | None = None
    missing: dict[str, str] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)
    firmware_files: tuple[str, ...] = ()
    trials: tuple[TrialDayLink, ...] = ()
    """Trial days in order of time."""
    changes: tuple[AppliedChange, ...] = ()
    """Of the vehicle file, by `rig2sea apply`, in order."""


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
    return by_severity([one for record in records if record for one in record.problems])


def by_severity(problems: Sequence[Problem]) -> tuple[Problem, ...]:
    """Sort problems: errors first, then warnings, then notes."""
    rank = {"error": 0, "warning": 1, "note": 2}
    return tuple(sorted(problems, key=lambda problem: rank[problem.severity]))


def all_checks(results: VehicleResults) -> tuple[tuple[str, Check], ...]:
    """Collect the checks of all fits, each with the title of its stage."""
    stages = ("propeller", "drive", "static", "inverse")
    fits = ((STAGE_TITLES[name], getattr(results, name)) for name in stages)
    return tuple((title, check) for title, fit in fits if fit is not None for check in fit.checks)


def mooring_points_of_tables(results: VehicleResults) -> tuple[MooringPoint, ...]:
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
    return {
        stage: results.missing.get(stage, "the stage has not run")
        for stage in STAGE_TITLES
        if getattr(results, stage) is None and _due(results, stage)
    }


def _due(results: VehicleResults, stage: str) -> bool:
    """Tell whether a stage's absence is worth a warning: nobody has to describe a model."""
    if stage == "allocation":
        return results.vehicle.allocator is not None or stage in results.missing
    return stage != "validation" or results.vehicle.model is not None
