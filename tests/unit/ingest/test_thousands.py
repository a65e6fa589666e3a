"""Thousands parted by commas or points are not read as decimals."""

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


@pytest.mark.parametrize(("comma", "other"), [(",", ","), (".", ";")])
def test_neighbours_tell_thousands(tmp_path: Path, comma: str, other: str) -> None:
    text = (
        f'code{other}"thrust, N"{other}"speed, rpm"\n0{other}0{other}0\n30{other}4{other}"612"\n'
        f'60{other}14{other}"987"\n90{other}26{other}"1{comma}324"\n'
        f'127{other}42{other}"1{comma}790"\n'
    )
    record = mooring(tmp_path, text)
    assert speeds(record) == [0.0, 612.0, 987.0, 1324.0, 1790.0]
    (note,) = [one for one in record.problems if f'"1{comma}324" is read as 1324' in one.what]
    assert note.severity == "note"


def test_the_other_decimal_sign_of_the_table_tells_thousands(tmp_path: Path) -> None:
    rows = '40,0.5,"1,142"\n40,0.4,"1,211"\n40,0.3,"1,329"\n'
    path = tmp_path / "a.csv"
    path.write_text(f'code,"torque, N m","speed, rpm"\n{rows}')
    record = read_load_tests([path], vehicle(), tmp_path)
    assert [point.shaft_speed_rpm for point in record.points] == [1142.0, 1211.0, 1329.0]


def test_contradicting_signs_are_left_out(tmp_path: Path) -> None:
    """Neighbours say thousands, the decimal points of the other column say decimals."""
    text = "code;thrust, g;voltage, V\n0;0;16.5\n30;634;16.25\n60;1.085;16.5\n90;1.603;16.25\n"
    record = mooring(tmp_path, text)
    assert [point.code for point in record.points] == [0.0, 30.0]
    assert any('"1.085" may be 1085 or 1.085' in problem.what for problem in record.problems)


def test_thousands_as_text_in_a_workbook(tmp_path: Path) -> None:
    rows = [["code", "thrust, N", "speed, rpm"], [0, 0, 0], [40, 4, 612], [80, 14, "1,324"]]
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows})
    assert speeds(read_mooring_tables([path], vehicle(), tmp_path)) == [0.0, 612.0, 1324.0]


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
