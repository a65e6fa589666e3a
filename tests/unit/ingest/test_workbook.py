from datetime import datetime, time
from pathlib import Path

import pytest
from bench_workbooks import write_workbook
from openpyxl import Workbook

from pipeline.errors import InputError
from pipeline.ingest.workbook import Limits, read_sheets


def test_cells_keep_their_row_and_column_numbers(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        sheet = workbook["far"]
        sheet["C5"] = "n"
        sheet["D7"] = 12.5

    path = write_workbook(tmp_path / "a.xlsx", {"far": []}, finish)
    (sheet,) = read_sheets(path, "a.xlsx")
    assert (sheet.name, sheet.first_row, sheet.last_row) == ("far", 1, 7)
    assert sheet.cell(5, 2) == "n"
    assert sheet.cell(7, 3) == 12.5
    assert sheet.cell(7, 2) is None
    assert sheet.cell(99, 99) is None
    assert str(sheet.place(7, "D")) == 'a.xlsx, sheet "far", row 7, column D'


def test_kinds_of_cells(tmp_path: Path) -> None:
    row = ["text", "  padded ", 1, 2.5, True, None, datetime(2024, 5, 6, 7, 8, 9), time(1, 2, 3)]  # noqa: DTZ001
    (sheet,) = read_sheets(write_workbook(tmp_path / "a.xlsx", {"s": [row]}), "a.xlsx")
    assert sheet.rows[0][:6] == ("text", "padded", 1.0, 2.5, True, None)
    assert str(sheet.rows[0][6]).startswith("2024-05-06 07:08:09")
    assert "01:02:03" in str(sheet.rows[0][7])


def test_error_values_keep_their_text(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"s": [[1, "#DIV/0!"], ["#N/A", 2]]})
    assert read_sheets(path, "a.xlsx")[0].rows == ((1.0, "#DIV/0!"), ("#N/A", 2.0))


def test_merged_cells_hold_their_value_everywhere(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["s"].merge_cells("A1:C1")
        workbook["s"].merge_cells("A2:A4")

    rows = [["Loading", None, None, "x"], [90, 1, 2, 3], [None, 4, 5, 6], [None, 7, 8, 9]]
    (sheet,) = read_sheets(write_workbook(tmp_path / "a.xlsx", {"s": rows}, finish), "a.xlsx")
    assert sheet.rows[0] == ("Loading", "Loading", "Loading", "x")
    assert [row[0] for row in sheet.rows[1:]] == [90.0, 90.0, 90.0]
    assert (1, 1) in sheet.filled
    assert (1, 0) not in sheet.filled


def test_hidden_sheets_rows_and_columns_are_read(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["b"].sheet_state = "hidden"
        workbook["a"].row_dimensions[2].hidden = True
        workbook["a"].column_dimensions["B"].hidden = True

    rows = [["n", "M"], [1, 2]]
    path = write_workbook(tmp_path / "a.xlsx", {"a": rows, "b": rows}, finish)
    sheets = read_sheets(path, "a.xlsx")
    assert [sheet.name for sheet in sheets] == ["a", "b"]
    assert all(sheet.rows[1] == (1.0, 2.0) for sheet in sheets)


def test_an_empty_sheet_has_no_rows(tmp_path: Path) -> None:
    sheets = read_sheets(write_workbook(tmp_path / "a.xlsx", {"a": [], "b": [[1]]}), "a.xlsx")
    assert [len(sheet.rows) for sheet in sheets] == [0, 1]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1251"])
@pytest.mark.parametrize(
    ("delimiter", "row"),
    [(";", ["1324,5", "0,378"]), ("\t", ["1324,5", "0,378"]), (",", ["1324.5", "0.378"])],
)
def test_text_tables_of_any_encoding_and_delimiter(
    tmp_path: Path, encoding: str, delimiter: str, row: list[str]
) -> None:
    lines = [["Обороты", "Момент"], *[row] * 5]
    path = tmp_path / "a.csv"
    path.write_bytes("\r\n".join(delimiter.join(line) for line in lines).encode(encoding))
    (sheet,) = read_sheets(path, "a.csv")
    assert sheet.name is None
    assert sheet.rows[0] == ("Обороты", "Момент")
    assert sheet.rows[5] == tuple(row)


def test_quotes_and_blank_lines_of_a_csv_file(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text('"speed, rpm","torque, N m"\n\n1,2\n3,4\n', encoding="utf-8")
    (sheet,) = read_sheets(path, "a.csv")
    assert sheet.rows == (("speed, rpm", "torque, N m"), (), ("1", "2"), ("3", "4"))


def test_a_table_parted_by_blanks(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("shaft speed  torque\n1 0,5\n  2   0,7\n", encoding="utf-8")
    (sheet,) = read_sheets(path, "a.txt")
    assert sheet.rows == (("shaft speed", "torque"), ("1", "0,5"), ("2", "0,7"))


def test_decimal_commas_between_commas_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("rpm,torque\n1324,5,0,378\n1300,1,0,400\n", encoding="utf-8")
    with pytest.raises(InputError, match="both the decimal sign and the separator"):
        read_sheets(path, "a.csv")


def test_a_text_table_that_is_too_long(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1,2\n" * 50, encoding="utf-8")
    with pytest.raises(InputError, match="too large"):
        read_sheets(path, "a.csv", Limits(max_rows=40))


def test_content_counts_and_not_the_name(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"s": [[1, 2]]})
    renamed = path.rename(tmp_path / "a.csv")
    assert read_sheets(renamed, "a.csv")[0].rows == ((1.0, 2.0),)
