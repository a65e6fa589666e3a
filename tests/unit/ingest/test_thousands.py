"""Thousands parted by commas are not read as decimals."""

from pathlib import Path

import pytest
from bench_workbooks import vehicle, write_workbook

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import MooringRecord


def mooring(tmp_path: Path, text: str) -> MooringRecord:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    return read_mooring_tables([path], vehicle(), tmp_path)


def speeds(record: MooringRecord) -> list[float | None]:
    return [point.shaft_speed_rpm for point in record.points]


def test_thousands_of_an_export_are_left_out(tmp_path: Path) -> None:
    text = (
        'code,"thrust, N","speed, rpm"\n0,0,0\n30,4,"612"\n60,14,"987"\n90,26,"1,324"\n'
        '127,42,"1,790"\n'
    )
    record = mooring(tmp_path, text)
    assert speeds(record) == [0.0, 612.0, 987.0, None, None]
    (warning,) = [one for one in record.problems if "may be 1324 or 1.324" in one.what]
    assert warning.severity == "warning"
    assert "(rows 5-6)" in warning.what


def test_thousands_beside_decimal_points_are_left_out(tmp_path: Path) -> None:
    rows = '40,0.5,"1,142"\n40,0.4,"1,211"\n40,0.3,"1,329"\n'
    path = tmp_path / "a.csv"
    path.write_text(f'code,"torque, N m","speed, rpm"\n{rows}')
    record = read_load_tests([path], vehicle(), tmp_path)
    assert record.points == ()
    assert any('"1,142" may be 1142 or 1.142' in problem.what for problem in record.problems)


def test_thousands_as_text_in_a_workbook_are_left_out(tmp_path: Path) -> None:
    rows = [["code", "thrust, N", "speed, rpm"], [0, 0, 0], [40, 4, 612], [80, 14, "1,324"]]
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows})
    assert speeds(read_mooring_tables([path], vehicle(), tmp_path)) == [0.0, 612.0, None]


@pytest.mark.parametrize(
    ("column", "numbers"),
    [
        (["0", "0,412", "1,324", "2,790"], [0.0, 0.412, 1.324, 2.79]),
        (["0", "1,324", "2", "3,5"], [0.0, 1.324, 2.0, 3.5]),
        (["0", "1,324", "2,111", "4"], [0.0, 1.324, 2.111, 4.0]),
        (["0", "1,324", "1,790", "2,012"], [0.0, 1.324, 1.79, 2.012]),
    ],
)
def test_decimal_commas_are_read(tmp_path: Path, column: list[str], numbers: list[float]) -> None:
    codes = (0, 40, 80, 127)
    lines = "\n".join(f"{code};{cell}" for code, cell in zip(codes, column, strict=True))
    record = mooring(tmp_path, f"code;thrust, N\n{lines}\n")
    assert [point.thrust_n for point in record.points] == pytest.approx(numbers)
