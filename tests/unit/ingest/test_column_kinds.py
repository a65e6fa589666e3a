"""Set-points, calculated values, extremes and spreads beside what was measured."""

from collections.abc import Callable
from pathlib import Path

import pytest
from bench_workbooks import sweep, vehicle

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import (
    LoadTestRecord,
    MooringRecord,
    OpenWaterRecord,
    SheetRead,
)

Record = LoadTestRecord | MooringRecord | OpenWaterRecord


def read(tmp_path: Path, reader: Callable[..., Record], text: str) -> Record:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    return reader([path], vehicle(), tmp_path)


def header(record: Record, quantity: str) -> str:
    (sheet,) = record.sheets
    assert isinstance(sheet, SheetRead)
    return next(one.header for one in sheet.columns if one.quantity == quantity)


@pytest.mark.parametrize(
    ("names", "right"),
    [
        (["Thrust setpoint, N", "Measured force, N"], "Measured force, N"),
        (["Упор расчетный, Н", "Упор измеренный, Н"], "Упор измеренный, Н"),
        (["thrust std, N", "thrust mean, N", "thrust max, N"], "thrust mean, N"),
        (["thrust min, N", "thrust, N"], "thrust, N"),
        (["Упор СКО, Н", "Упор, Н"], "Упор, Н"),
        (["thrust uncertainty, N", "thrust CFD, N", "thrust, N"], "thrust, N"),
    ],
)
def test_the_measured_thrust_is_read(tmp_path: Path, names: list[str], right: str) -> None:
    rows = [[code, *(code / 4 + i for i in range(len(names)))] for code in (0, 40, 80, 127)]
    table = "\n".join(";".join(map(str, row)) for row in [["code", *names], *rows])
    assert header(read(tmp_path, read_mooring_tables, table), "thrust") == right


def test_the_measured_coefficients_are_read(tmp_path: Path) -> None:
    rows = "\n".join(f"{j};9;{0.4 - j / 3};9;{0.05 - j / 30}" for j in (0.0, 0.2, 0.4, 0.6))
    record = read(tmp_path, read_open_water, f"J;KT CFD;KT exp;KQ CFD;KQ exp\n{rows}\n")
    assert header(record, "thrust_coefficient") == "KT exp"
    assert header(record, "torque_coefficient") == "KQ exp"


def test_mean_speeds_go_before_the_smallest(tmp_path: Path) -> None:
    rows = "\n".join(f"90;{n - 9};{n};{n + 9};{m}" for n, m in sweep(90.0, 6))
    names = "code;speed min, rpm;speed avg, rpm;speed max, rpm;torque, N m"
    assert header(read(tmp_path, read_load_tests, f"{names}\n{rows}\n"), "shaft_speed") == (
        "speed avg, rpm"
    )


@pytest.mark.parametrize(
    "name", ["Electrical RPM", "Частота ЭДС, Гц", "Частота ШИМ, Гц", "Sampling frequency, Hz"]
)
def test_the_frequency_of_something_else_is_no_shaft_speed(tmp_path: Path, name: str) -> None:
    """The field of a motor turns as many times faster as it has pairs of poles."""
    rows = "\n".join(f"90;{7 * n};{m}" for n, m in sweep(90.0, 6))
    alone = read(tmp_path, read_load_tests, f"code;{name};torque, N m\n{rows}\n")
    assert not alone.points
    rows = "\n".join(f"{code};{code / 4};{100 * code}" for code in (0, 40, 80, 127))
    beside = read(tmp_path, read_mooring_tables, f"команда;упор, Н;{name}\n{rows}\n")
    assert len(beside.points) == 4
    assert all(point.shaft_speed_rpm is None for point in beside.points)  # type: ignore[union-attr]


def test_a_calculated_column_is_read_where_there_is_no_other(tmp_path: Path) -> None:
    record = read(tmp_path, read_mooring_tables, "code;Thrust calculated, N\n0;0\n40;4\n80;9\n")
    assert header(record, "thrust") == "Thrust calculated, N"


def test_two_equal_columns_are_both_named(tmp_path: Path) -> None:
    text = "code;thrust left, N;thrust side, N\n0;0;0\n40;4;5\n80;9;10\n"
    record = read(tmp_path, read_mooring_tables, text)
    assert not record.points
    (error,) = [one for one in record.problems if one.severity == "error"]
    assert 'B "thrust left, N" (9 at most) or C "thrust side, N" (10 at most)' in error.what
