"""A measured mooring workbook that nobody here wrote, with nothing but a vehicle.yaml."""

from pathlib import Path

import numpy as np
import pytest
from openpyxl import load_workbook

from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import MooringRecord
from pipeline.vehicle.load import load_vehicle, vehicle_notes

VEHICLE = Path(__file__).parent / "t200"
KGF_N = 9.80665


@pytest.fixture(scope="module")
def record(t200_workbook: Path) -> MooringRecord:
    folder = t200_workbook.parents[1]
    return read_mooring_tables([t200_workbook], load_vehicle(folder), folder.parent)


def test_the_vehicle_file_agrees_with_itself() -> None:
    vehicle = load_vehicle(VEHICLE)
    assert vehicle_notes(vehicle) == ()
    assert vehicle.tables.supply_voltage_v == 16.0


def test_six_sheets_of_201_points_and_no_complaint(record: MooringRecord) -> None:
    assert [sheet.sheet for sheet in record.sheets] == [f"{v} V" for v in range(10, 22, 2)]
    assert [sheet.rows for sheet in record.sheets] == [201] * 6
    voltages = np.array([point.voltage_v for point in record.points])
    for voltage_v in range(10, 22, 2):
        assert np.sum(voltages == voltage_v) == 201
    assert {problem.severity for problem in record.problems} == {"note"}
    assert {point.source.file for point in record.points} == {"t200/mooring/t200.xlsx"}


def test_columns_and_units_as_the_sheet_states_them(record: MooringRecord) -> None:
    for sheet in record.sheets:
        columns = {column.quantity: column for column in sheet.columns}
        assert {name: column.column for name, column in columns.items()} == {
            "pwm": "A",
            "shaft_speed": "B",
            "current": "C",
            "voltage": "D",
            "input_power": "E",
            "thrust": "F",
        }
        assert columns["thrust"].unit == "Kg f"


def test_every_number_is_that_of_the_sheet(record: MooringRecord, t200_workbook: Path) -> None:
    """Read again with another library, cell by cell."""
    book = load_workbook(t200_workbook, read_only=True, data_only=True)
    points = {(point.source.sheet, point.source.row): point for point in record.points}
    checked = 0
    for voltage_v in range(10, 22, 2):
        sheet = book[f"{voltage_v} V"]
        for number, cells in enumerate(sheet.iter_rows(values_only=True), start=1):
            if number == 1 or cells[0] is None:
                continue
            pwm, rpm, current, voltage, _, force = (float(str(cell)) for cell in cells[:6])
            point = points[f"{voltage_v} V", number]
            assert point.code == pwm - 1500.0
            assert point.thrust_n == pytest.approx(force * KGF_N, rel=1e-12, abs=1e-12)
            assert point.shaft_speed_rpm == pytest.approx(rpm * np.sign(point.code), abs=1e-9)
            assert (point.voltage_v, point.current_a) == (voltage, current)
            checked += 1
    assert checked == 6 * 201


def test_largest_thrust_at_16_v(record: MooringRecord) -> None:
    at_16 = [point for point in record.points if point.voltage_v == 16.0]
    most = max(at_16, key=lambda point: point.thrust_n)
    least = min(at_16, key=lambda point: point.thrust_n)
    assert most.thrust_n == pytest.approx(5.245035493333333 * KGF_N)
    assert (most.code, most.source.sheet, most.source.row) == (400.0, "16 V", 202)
    assert least.thrust_n == pytest.approx(-4.069476226666667 * KGF_N)
    assert least.code == -400.0


def test_tare_and_sweeps(record: MooringRecord) -> None:
    """One pass from full reverse to full ahead: the reading at neutral is zero, no hysteresis."""
    assert record.hysteresis_n is None
    assert all(point.tare_n == 0.0 for point in record.points)
    assert all(point.sweep == ("down" if point.code <= 0.0 else "up") for point in record.points)
    assert {point.marks for point in record.points if point.code != 0.0} == {()}
