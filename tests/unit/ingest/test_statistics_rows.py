"""Rows of means, spreads and sums below the readings are no readings."""

from pathlib import Path

from bench_workbooks import Rows, vehicle, write_workbook

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water


def test_means_and_spreads_of_a_load_test(tmp_path: Path) -> None:
    sheets: dict[str, Rows] = {
        f"Код {code}": [
            ["№", "n, об/мин", "M, Н·см"],
            *([k + 1, code * 15 + k * 60, 40 - 6 * k] for k in range(4)),
            ["Среднее", code * 15 + 90, 31],
            ["СКО", 77, 7.7],
        ]
        for code in (40, 90, 127)
    }
    record = read_load_tests([write_workbook(tmp_path / "a.xlsx", sheets)], vehicle(), tmp_path)
    kept = [point for point in record.points if not point.marks]
    assert len(kept) == 12
    assert [point.marks for point in record.points[4:6]] == [("statistics row",)] * 2
    warnings = [one for one in record.problems if "means, spreads or sums" in one.what]
    assert [one.severity for one in warnings] == ["warning"] * 3
    assert "rows 6-7" in warnings[0].what


def test_means_and_extremes_of_a_mooring_table(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "No;code;thrust, N\n1;0;0\n2;40;4\n3;80;12\n4;127;30\nMax;127;30\nMean:;61.75;11.5\n"
    )
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert [point.code for point in record.points if not point.marks] == [40.0, 80.0, 127.0]
    (warning,) = [one for one in record.problems if "means, spreads or sums" in one.what]
    assert "rows 6-7" in warning.what
    assert not [one for one in record.problems if "whole number" in one.what]


def test_the_mean_of_an_open_water_table(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "No;J;KT;KQ\n1;0;0.4;0.05\n2;0.2;0.33;0.044\n3;0.4;0.25;0.037\nmean;0.2;0.3;0.04\n"
    )
    record = read_open_water([path], vehicle(), tmp_path)
    assert len([point for point in record.points if not point.marks]) == 3


def test_a_remark_behind_the_numbers_is_no_statistics(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("code;thrust, N;remark\n0;0;min\n40;4;\n127;30;max\n")
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert [point.code for point in record.points if not point.marks] == [40.0, 127.0]
