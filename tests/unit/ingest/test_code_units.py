"""Codes in per cent, in cells formatted as per cent, and as shares of the full code."""

from pathlib import Path

import pytest
from bench_workbooks import Rows, sweep, vehicle, write_workbook

from pipeline.errors import Problem
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.measurements import LoadTestRecord, MooringRecord

HEAD = ["n, rpm", "M, N m"]
Record = LoadTestRecord | MooringRecord


def load_test(tmp_path: Path, sheets: dict[str, Rows], name: str = "a.xlsx") -> LoadTestRecord:
    return read_load_tests([write_workbook(tmp_path / name, sheets)], vehicle(), tmp_path)


def mooring(tmp_path: Path, text: str) -> MooringRecord:
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    return read_mooring_tables([path], vehicle(), tmp_path)


def mooring_sheet(tmp_path: Path, rows: Rows) -> MooringRecord:
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows})
    return read_mooring_tables([path], vehicle(), tmp_path)


def codes(record: Record) -> list[float]:
    found = {point.code for point in record.points if point.code is not None}
    return [round(code, 4) for code in sorted(found)]


def said(record: Record, text: str) -> Problem:
    (found,) = {problem for problem in record.problems if text in problem.what}
    return found


def column(*shown: float) -> Rows:
    return [(code, speed, torque) for code in shown for speed, torque in sweep(100.0, 4)]


@pytest.mark.parametrize("unit", ["%", "percent", "pct", "проц", "процент"])
def test_per_cent_is_known_in_all_its_spellings(tmp_path: Path, unit: str) -> None:
    lines = "\n".join(f"{code};{code / 4}" for code in (0, 40, 70, 100))
    record = mooring(tmp_path, f"Code [{unit}];Thrust [N]\n{lines}\n")
    assert codes(record) == [0.0, 50.8, 88.9, 127.0]
    assert said(record, "in per cent").severity == "note"
    both = load_test(tmp_path, {"s": [[f"Code [{unit}]", *HEAD], *column(40, 70, 100)]})
    assert codes(both) == [50.8, 88.9, 127.0]
    assert "100 % is taken for code 127" in said(both, "in per cent").what


def test_per_cent_in_the_name_of_a_sheet_a_heading_and_a_section(tmp_path: Path) -> None:
    by_name = load_test(tmp_path, {f"{code}%": [HEAD, *sweep(code, 4)] for code in (50, 100)})
    assert codes(by_name) == [63.5, 127.0]
    assert [one.severity for one in by_name.problems if "in per cent" in one.what] == ["note"] * 2
    heads: dict[str, Rows] = {
        f"run {code}": [[f"Код {code} %"], HEAD, *sweep(code, 4)] for code in (50, 100)
    }
    assert codes(load_test(tmp_path, heads)) == [63.5, 127.0]
    sections: Rows = [HEAD, ["Код 50 %"], *sweep(50, 4), ["Код 100 %"], *sweep(100, 4)]
    record = load_test(tmp_path, {"s": sections})
    assert codes(record) == [63.5, 127.0]
    assert {one.severity for one in record.problems if "in per cent" in one.what} == {"note"}


def test_a_name_and_a_heading_of_one_code_agree_in_per_cent(tmp_path: Path) -> None:
    record = load_test(tmp_path, {"50%": [["Код 63.5"], HEAD, *sweep(50, 4)]})
    assert codes(record) == [63.5]
    assert not [one for one in record.problems if "the heading says" in one.what]


def test_cells_formatted_as_per_cent_are_shares(tmp_path: Path) -> None:
    record = load_test(tmp_path, {"s": [["Код, %", *HEAD], *column(0.25, 0.5, 1.0)]})
    assert codes(record) == [31.75, 63.5, 127.0]
    problem = said(record, "look like shares")
    assert (problem.severity, problem.place.column) == ("warning", "A")
    bollard = mooring_sheet(tmp_path, [["Код, %", "Упор, Н"], (0, 0), (0.5, 3), (-1, -9), (1, 10)])
    assert codes(bollard) == [-127.0, 0.0, 63.5, 127.0]
    assert said(bollard, "look like shares").severity == "warning"


def test_per_cent_in_the_cells_alone(tmp_path: Path) -> None:
    record = mooring(tmp_path, "Код;Упор, Н\n0%;0\n20%;4.4\n100%;26\n")
    assert [point.code for point in record.points] == pytest.approx([0.0, 25.4, 127.0])
    assert "code is in per cent" in str(record.problems[0])


def test_shares_without_a_unit_are_of_full_throttle_in_mooring_tables(tmp_path: Path) -> None:
    lines = "\n".join(f"{code};{10 * code}" for code in (0, 0.25, 0.5, 1))
    record = mooring(tmp_path, f"code;thrust, N\n{lines}\n")
    assert "1 is code 127" in said(record, "shares of full throttle").what
    assert [point.code for point in record.points] == [0.0, 31.75, 63.5, 127.0]


def test_codes_made_of_pulse_widths_may_have_fractions(tmp_path: Path) -> None:
    record = mooring(tmp_path, "pwm, us;thrust, N\n1500;0\n1601;3\n1703;12\n")
    assert not [one for one in record.problems if "whole number" in one.what]


@pytest.mark.parametrize(
    ("begin", "end", "told"), [(0, 11, "grows to both sides"), (5, 11, "begins at code")]
)
def test_shares_that_rest_at_a_half_are_refused(
    tmp_path: Path, begin: int, end: int, told: str
) -> None:
    rows = [f"{0.51 + 0.1 * (k - 5):.2f},{1.6 * (k - 5) ** 2}" for k in range(begin, end)]
    record = mooring(tmp_path, "\n".join(["Throttle,Thrust (N)", *rows]))
    assert record.points == ()
    assert said(record, told).severity == "error"


def test_a_corrected_thrust_goes_before_a_thrust(tmp_path: Path) -> None:
    rows = [f"{code},{0.2 * code},{0.19 * code}" for code in range(0, 101, 10)]
    record = mooring(tmp_path, "\n".join(["Code,Thrust (N),Thrust corrected (N)", *rows]))
    assert max(point.thrust_n for point in record.points) == pytest.approx(19.0)
