"""Factors in the names of columns, and units that contradict each other, are not passed over."""

from pathlib import Path

import pytest
from bench_workbooks import vehicle
from openpyxl import Workbook  # type: ignore[import-untyped]  # it has no stubs

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.ingest.vocabulary import factor_in_name
from pipeline.vehicle.schema import Vehicle


def file(tmp_path: Path, text: str) -> list[Path]:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    return [path]


@pytest.mark.parametrize(
    "name",
    [
        "Thrust x 10, N",
        "Thrust [N] x 0.1",
        "Thrust / 10, N",
        "Thrust ×10 [N]",
        "Упор ·10^-1, кгс",
        "Thrust, 10³ N",
        "10*thrust, N",
    ],
)
def test_a_factor_in_the_name_of_a_thrust_is_refused(tmp_path: Path, name: str) -> None:
    text = f'code;"{name}"\n0;0\n40;44\n80;144\n127;260\n'
    record = read_mooring_tables(file(tmp_path, text), vehicle(), tmp_path)
    assert record.points == ()
    (error,) = [problem for problem in record.problems if problem.severity == "error"]
    assert "may multiply the numbers or divide them" in error.what
    assert "unit: ..." in error.remedy


def test_a_factor_in_the_name_of_a_torque_is_refused(tmp_path: Path) -> None:
    text = "code;rpm;Torque x 1000 [N m]\n" + "".join(f"90;{900 - k};{100 + k}\n" for k in range(9))
    record = read_load_tests(file(tmp_path, text), vehicle(), tmp_path)
    assert record.points == ()
    assert any('"x 1000" in the name' in problem.what for problem in record.problems)


@pytest.mark.parametrize("name", ["10*KT", "10KT", "10 K_T", "KT x10"])
def test_ten_times_the_thrust_coefficient_is_refused(tmp_path: Path, name: str) -> None:
    text = f"J;{name};10KQ\n0;3.9;0.47\n0.2;3.3;0.42\n0.4;2.5;0.36\n"
    record = read_open_water(file(tmp_path, text), vehicle(), tmp_path)
    assert [point.thrust_coefficient for point in record.points] == [None] * 3
    assert record.points[0].torque_coefficient == pytest.approx(0.047)
    (warning,) = [problem for problem in record.problems if "may multiply" in problem.what]
    assert (warning.severity, warning.place.column) == ("warning", "B")


def test_a_unit_in_the_vehicle_file_decides(tmp_path: Path) -> None:
    mapping = {"thrust": {"header": "Thrust x 10, N", "unit": "N"}}
    stated = Vehicle.model_validate(vehicle().model_dump() | {"columns": {"mooring": mapping}})
    text = 'code;"Thrust x 10, N"\n0;0\n40;44\n80;144\n'
    record = read_mooring_tables(file(tmp_path, text), stated, tmp_path)
    assert [point.thrust_n for point in record.points] == [0.0, 44.0, 144.0]


@pytest.mark.parametrize(
    "name",
    [
        "Thrust, N",
        "APC 10x10 thrust, N",
        "thrust (mean of 5 x 10 s), N",
        "Max 1000 N cell thrust, N",
        "10 s average thrust, N",
        "Torque, N·m",
        "speed, min^-1",
        "LC 5*100 thrust [N]",
    ],
)
def test_other_numbers_in_names_are_no_factors(name: str) -> None:
    assert factor_in_name(name, "thrust") is None


@pytest.mark.parametrize(("unit", "told"), [("кгс", True), ("N", False), ("Н", False)])
def test_a_unit_row_that_contradicts_the_name_is_told(
    tmp_path: Path, unit: str, told: bool
) -> None:
    text = f"code;Упор, Н\n;{unit}\n0;0\n40;4\n80;14\n"
    record = read_mooring_tables(file(tmp_path, text), vehicle(), tmp_path)
    assert [point.thrust_n for point in record.points] == ([] if told else [0.0, 4.0, 14.0])
    found = [one for one in record.problems if "states Н, the row under it кгс" in one.what]
    assert [one.severity for one in found] == (["error"] if told else [])


@pytest.mark.parametrize(
    ("name", "form", "largest_n"),
    [
        ("Thrust (g)", '0.0 "kg"', None),
        ("Thrust (g)", r"0.0\ \g", 0.5 * 9.80665),
        ("Thrust", '0.0" gf"', 0.5 * 9.80665),
        ("Thrust (g)", '0.0 "V"', None),
    ],
)
def test_the_number_format_of_cells_is_a_word_about_the_unit(
    tmp_path: Path, name: str, form: str, largest_n: float | None
) -> None:
    book = Workbook()
    sheet = book.worksheets[0]
    sheet.append(["code", name])
    for code in (0, 20, 40, 60, 80, 100):
        sheet.append([code, 0.05 * code**2])
        sheet.cell(sheet.max_row, 2).number_format = form
    book.save(tmp_path / "a.xlsx")
    record = read_mooring_tables([tmp_path / "a.xlsx"], vehicle(), tmp_path)
    assert max((one.thrust_n for one in record.points), default=None) == pytest.approx(largest_n)
    refused = [one for one in record.problems if one.severity == "error"]
    assert bool(refused) == (largest_n is None)
    assert all("the number format of its cells" in one.what for one in refused)
