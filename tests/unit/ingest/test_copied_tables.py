"""What stands twice, in merged cells or hidden: counted once, left out, or told."""

from pathlib import Path

import pytest
from bench_workbooks import Rows, sweep, vehicle, write_workbook
from openpyxl import Workbook

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import MooringRecord, OpenWaterRecord

MOORING: Rows = [
    ["code", "thrust, N"],
    *((code, round(0.0026 * code * abs(code), 2)) for code in (0, 30, 60, 90, 127, -30, -60, -90)),
]
OPEN_WATER: Rows = [["J", "KT", "KQ"], *((i / 10, 0.4 - 0.04 * i, 0.05) for i in range(7))]


def as_text(path: Path, rows: Rows) -> Path:
    path.write_text("\n".join(";".join(map(str, row)) for row in rows))
    return path


def fitted(record: MooringRecord | OpenWaterRecord) -> int:
    return sum(not point.marks for point in record.points)


def told(record: MooringRecord | OpenWaterRecord, text: str) -> list[str]:
    return [problem.severity for problem in record.problems if text in problem.what]


def test_a_copied_sheet_counts_once(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"A": MOORING, "A (2)": MOORING})
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert (len(record.points), fitted(record)) == (16, 7)
    assert told(record, 'again as in a.xlsx, sheet "A"') == ["warning"]
    path = write_workbook(tmp_path / "b.xlsx", {"A": OPEN_WATER, "A (2)": OPEN_WATER})
    water = read_open_water([path], vehicle(), tmp_path)
    assert (len(water.points), fitted(water)) == (14, 7)
    assert told(water, "rows again as in") == ["warning"]


def test_a_table_as_workbook_and_as_text_counts_once(tmp_path: Path) -> None:
    paths = [
        as_text(tmp_path / "a.csv", MOORING),
        write_workbook(tmp_path / "a.xlsx", {"A": MOORING}),
    ]
    record = read_mooring_tables(paths, vehicle(), tmp_path)
    assert fitted(record) == 7
    assert not [problem for problem in record.problems if problem.severity == "error"]
    assert told(record, "there is no reading at code 0") == []


def test_a_repeated_test_counts_twice(tmp_path: Path) -> None:
    again = [list(row) for row in MOORING]
    again[3][1] = 9.37
    paths = [as_text(tmp_path / "a.csv", MOORING), as_text(tmp_path / "b.csv", again)]
    assert fitted(read_mooring_tables(paths, vehicle(), tmp_path)) == 14


def test_a_thrust_merged_over_several_codes_is_one_reading(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["s"].merge_cells("B3:B5")
        workbook["s"].merge_cells("A6:A7")

    rows: Rows = [
        ["code", "thrust, N"],
        (0, 0),
        (30, 4.4),
        (60, None),
        (90, None),
        (127, 42),
        ("", 41),
    ]
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows}, finish)
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert [point.code for point in record.points] == [0.0, 30.0, 127.0, 127.0]
    (problem,) = [one for one in record.problems if "is merged with the one above" in one.what]
    assert problem.severity == "warning"
    assert "(rows 4-5)" in problem.what


def test_a_torque_merged_over_several_speeds_is_one_reading(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["s"].merge_cells("C4:C6")

    table = [["code", "n, rpm", "M, N m"], *([90, n, m] for n, m in sweep(90.0, 6))]
    path = write_workbook(tmp_path / "a.xlsx", {"s": table}, finish)
    record = read_load_tests([path], vehicle(), tmp_path)
    rows = {point.source.row for point in record.points}
    assert 4 in rows
    assert not {5, 6} & rows
    assert any("torque stands in a cell that is merged" in one.what for one in record.problems)


def test_what_is_set_may_stand_in_merged_cells(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["s"].merge_cells("A2:A6")

    head = ["n, rps", "V, m/s", "thrust, N"]
    rows: Rows = [head, *([10 if i == 0 else None, 0.2 * i, 50 - 9 * i] for i in range(5))]
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows}, finish)
    assert fitted(read_open_water([path], vehicle(), tmp_path)) == 5


@pytest.mark.parametrize("state", ["hidden", "veryHidden"])
def test_hidden_sheets_and_rows_are_named(tmp_path: Path, state: str) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["b"].sheet_state = state
        for row in (3, 4, 6):
            workbook["a"].row_dimensions[row].hidden = True

    other = [MOORING[0], *([code, thrust * 1.01] for code, thrust in MOORING[1:])]  # type: ignore[operator]
    path = write_workbook(tmp_path / "a.xlsx", {"a": MOORING, "b": other}, finish)
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert fitted(record) == 14
    assert told(record, "read all the same: rows 3-4, 6") == ["note"]
    assert told(record, "the sheet is hidden and was read") == ["note"]
