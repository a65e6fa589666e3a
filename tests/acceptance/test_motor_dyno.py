"""A measured motor dynamometer record that nobody here wrote, with nothing but a vehicle.yaml."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import CannotComputeError, Problem
from pipeline.identify.drive import fit_drive
from pipeline.ingest.load_test import read_load_tests
from pipeline.records.measurements import LoadTestRecord
from pipeline.vehicle.bench_schema import Columns
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

CSV = "odrive_data.csv"
WORKBOOK = "Motor_efficiency_data_handler.xlsx"


@pytest.fixture(scope="module")
def folder(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A raw folder with the vehicle file and a copy of the record."""
    raw = tmp_path_factory.mktemp("raw")
    bench = raw / "motor_dyno" / "load_test"
    bench.mkdir(parents=True)
    shutil.copy(Path(__file__).with_name("motor_dyno") / "vehicle.yaml", raw / "motor_dyno")
    for path in (shared_data / "motor_dyno").iterdir():
        if path.suffix != ".md":
            shutil.copy(path, bench)
    return raw


def vehicle_of(folder: Path) -> Vehicle:
    return load_vehicle(folder / "motor_dyno" / "vehicle.yaml")


def read(folder: Path, vehicle: Vehicle, *names: str) -> LoadTestRecord:
    return read_load_tests(
        [folder / "motor_dyno" / "load_test" / name for name in names], vehicle, folder
    )


def said(record: LoadTestRecord, text: str) -> Problem:
    found = [problem for problem in record.problems if text in problem.what]
    assert len(found) == 1, [str(problem) for problem in record.problems]
    return found[0]


@pytest.fixture(scope="module")
def csv_record(folder: Path) -> LoadTestRecord:
    return read(folder, vehicle_of(folder), CSV)


def test_every_row_is_read_in_si_units(csv_record: LoadTestRecord, shared_data: Path) -> None:
    """Compared with numbers taken from the text by hand: N.mm, rad.s and A in their columns."""
    lines = (shared_data / "motor_dyno" / CSV).read_text(encoding="utf-8").splitlines()[3:]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    points = csv_record.points
    assert len(points) == len(rows) == 344
    assert [point.source.row for point in points] == list(range(4, 348))
    assert points[0].source.file == f"motor_dyno/load_test/{CSV}"
    np.testing.assert_allclose([p.torque_nm for p in points], rows[:, 9] / 1000, rtol=1e-12)
    np.testing.assert_allclose(
        [p.shaft_speed_rpm for p in points], rows[:, 10] * 30 / np.pi, rtol=1e-12
    )
    np.testing.assert_allclose([p.current_a or 0.0 for p in points], rows[:, 7], rtol=1e-12)
    np.testing.assert_allclose([p.voltage_v or 0.0 for p in points], rows[:, 0], rtol=1e-12)


def test_the_units_stand_in_the_third_line(csv_record: LoadTestRecord) -> None:
    columns = {column.quantity: column for column in csv_record.sheets[0].columns}
    assert [(columns[n].header, columns[n].unit) for n in ("torque", "shaft_speed")] == [
        ("Output Torque", "N.mm"),
        ("Output Speed", "rad.s"),
    ]
    assert columns["torque"].unit_from == "unit row"
    assert columns["current"].unit_from == "mapping"


def test_reverse_motoring_is_kept_as_measured(csv_record: LoadTestRecord) -> None:
    """Speed and torque are both negative; in the last row the speed is not."""
    fitted = [point for point in csv_record.points if not point.marks]
    assert len(fitted) == 343
    assert all(point.shaft_speed_rpm < 0 for point in fitted)
    assert min(point.torque_nm for point in fitted) == pytest.approx(-1.46, abs=5e-3)
    assert [p.source.row for p in csv_record.points if p.marks == ("negative torque",)] == [347]


def test_the_dead_channel_is_named(folder: Path) -> None:
    plain = vehicle_of(folder).model_copy(update={"columns": Columns()})
    record = read(folder, plain, CSV)
    dead = [one for one in record.sheets[0].not_used if "0 throughout: not connected" in one.reason]
    assert len(dead) == 2
    assert all(point.current_a is None for point in record.points)


def test_without_a_control_code_there_is_no_family(
    folder: Path, csv_record: LoadTestRecord
) -> None:
    assert all(point.code is None for point in csv_record.points)
    assert "M(n, N) cannot be fitted" in said(csv_record, "no control code").what
    with pytest.raises(CannotComputeError, match="no control code"):
        fit_drive(csv_record, vehicle_of(folder))


def test_the_workbook_holds_the_same_points(folder: Path, csv_record: LoadTestRecord) -> None:
    record = read(folder, vehicle_of(folder), WORKBOOK)
    assert [sheet.sheet for sheet in record.sheets] == ["input"]
    numbers = [(p.shaft_speed_rpm, p.torque_nm, p.voltage_v) for p in record.points]
    expected = [(p.shaft_speed_rpm, p.torque_nm, p.voltage_v) for p in csv_record.points]
    np.testing.assert_allclose(np.array(numbers, float), np.array(expected, float), rtol=1e-9)
    assert '"Output", "Torque Constant"' in said(record, "restricts the sheets").what


def test_the_same_points_in_two_files_count_once(folder: Path) -> None:
    record = read(folder, vehicle_of(folder), WORKBOOK, CSV)
    assert sum(not point.marks for point in record.points) == 343
    assert "343 rows again as in " in said(record, "rows again").what


def test_results_beside_the_measurement_count_once(folder: Path) -> None:
    plain = vehicle_of(folder).model_copy(update={"columns": Columns()})
    record = read(folder, plain, WORKBOOK)
    assert {p.source.sheet for p in record.points if not p.marks} == {"input"}
    assert said(record, "again as in motor_dyno").place.sheet == "Output"
    assert said(record, "the sheet was not read").place.sheet == "Torque Constant"


def test_fits_are_not_taken_for_measurements(folder: Path) -> None:
    plain = vehicle_of(folder).model_copy(update={"columns": Columns()})
    record = read(folder, plain, "Data fitting.xlsx")
    assert not record.points
    grids = [problem for problem in record.problems if "looks like a grid" in problem.what]
    assert {problem.place.sheet for problem in grids} == {"Sheet1"}
    told = said(record, "found on any sheet")
    assert told.severity == "error"
    assert all(
        f'"{name}"' in told.what
        for name in ("difference", "model fitted efficiency", "meas.data fitted efficiency")
    )


def test_a_table_without_names_gets_one_message(folder: Path) -> None:
    record = read(folder, vehicle_of(folder), "data.txt")
    assert not record.points
    problem = said(record, "no column names over its 1023 numbers")
    assert (problem.severity, "vehicle.yaml" in problem.remedy) == ("error", True)


def test_a_table_without_names_is_read_as_stated(folder: Path) -> None:
    stated = vehicle_of(folder).model_dump()
    stated["columns"]["load_test"] = {
        "shaft_speed": {"header": "column A", "unit": "rpm"},
        "torque": {"header": "column B", "unit": "N m"},
    }
    record = read(folder, Vehicle.model_validate(stated), "data.txt")
    assert len(record.points) == 341
    assert (record.points[0].shaft_speed_rpm, record.points[0].torque_nm) == (101.0, 0.015)
