"""A measured withheld effect: a thruster modelled at one supply voltage, measured at another."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pipeline.diagnose.bench.engine import diagnose_bench
from pipeline.diagnose.bench.model import ThrusterAtRest, bench_model
from pipeline.diagnose.bench.table import bench_table
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.diagnosis import BenchDiagnosisRecord
from pipeline.records.measurements import MooringRecord
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

VEHICLE = Path(__file__).parent / "t200"
HIDDEN = ("voltage", "current", "shaft_speed")
LOWER = [(16.0, 10.0), (20.0, 16.0)]


@dataclass(frozen=True)
class Workbook:
    """The measured workbook, read once."""

    vehicle: Vehicle
    record: MooringRecord

    def model(self, volts: float) -> ThrusterAtRest:
        tables = self.vehicle.tables.model_copy(update={"supply_voltage_v": volts})
        return bench_model(self.vehicle.model_copy(update={"tables": tables}), None, self.record)

    def diagnose(
        self, modelled: float, measured: float, *, hidden: tuple[str, ...] = HIDDEN
    ) -> BenchDiagnosisRecord:
        model = self.model(modelled)
        points = [point for point in self.record.points if point.voltage_v == measured]
        table = bench_table(points, model, name="sheet", without=hidden)
        return diagnose_bench(model, table)


@pytest.fixture(scope="module")
def workbook(t200_workbook: Path) -> Workbook:
    folder = t200_workbook.parents[1]
    vehicle = load_vehicle(folder)
    return Workbook(vehicle, read_mooring_tables([t200_workbook], vehicle, folder.parent))


@pytest.mark.parametrize(("modelled", "measured"), LOWER)
def test_a_lower_supply_is_named_from_thrust_alone(
    workbook: Workbook, modelled: float, measured: float
) -> None:
    record = workbook.diagnose(modelled, measured)
    assert "voltage_sag" in {*record.verdict.effects, *record.verdict.ambiguous_with}
    assert set(record.verdict.effects) <= {"voltage_sag", "thruster_degraded"}
    assert record.shrink.gap_closed is not None
    assert record.shrink.gap_closed > 0.8


def test_a_higher_supply_is_named_from_thrust_alone(workbook: Workbook) -> None:
    record = workbook.diagnose(12.0, 14.0)
    assert record.verdict.effects == ("voltage_sag",)
    assert record.ranking[0].parameters["drop"].value < -0.05


def test_with_the_columns_shown_it_is_sure(workbook: Workbook) -> None:
    record = workbook.diagnose(16.0, 12.0, hidden=())
    assert record.verdict.effects == ("voltage_sag",)
    assert record.verdict.probability > 0.95
    assert record.verdict.ambiguous_with == ()


@pytest.mark.parametrize("volts", [10.0, 16.0])
def test_half_of_the_points_agree_with_a_model_of_the_other_half(
    workbook: Workbook, volts: float
) -> None:
    @cache
    def halves() -> tuple[MooringRecord, list[int]]:
        own = [i for i, p in enumerate(workbook.record.points) if p.voltage_v == volts]
        kept = tuple(workbook.record.points[i] for i in own[::2])
        return workbook.record.model_copy(update={"points": kept}), own[1::2]

    record, rest = halves()
    tables = workbook.vehicle.tables.model_copy(update={"supply_voltage_v": volts})
    model = bench_model(workbook.vehicle.model_copy(update={"tables": tables}), None, record)
    points = [workbook.record.points[i] for i in rest]
    found = diagnose_bench(model, bench_table(points, model, name="other", without=HIDDEN))
    assert found.verdict.effects == ("none",)
    assert np.isfinite(found.gap.channels["thrust"].ratio)
    assert found.gap.channels["thrust"].ratio < 1.0
