from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import Rows, sweep, vehicle, write_workbook
from openpyxl import Workbook

from pipeline.errors import Problem
from pipeline.ingest.load_test import branches_of, read_load_tests
from pipeline.ingest.load_test_words import branch_in_text, code_in_text, is_warm_up
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord

HEAD = ["Speed, rpm", "Torque, N m"]
NAME = "trial/load_test/drive.xlsx"


def read(
    tmp_path: Path,
    content: dict[str, Rows],
    finish: Callable[[Workbook], None] | None = None,
    name: str = "drive.xlsx",
    **mapping: object,
) -> LoadTestRecord:
    path = write_workbook(tmp_path / "raw" / "trial" / "load_test" / name, content, finish)
    return read_load_tests([path], vehicle(**mapping), tmp_path / "raw")


def read_text(
    tmp_path: Path, text: str, name: str = "drive.csv", **mapping: object
) -> LoadTestRecord:
    path = tmp_path / "raw" / "trial" / "load_test" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return read_load_tests([path], vehicle(**mapping), tmp_path / "raw")


def rows_of(code: float, head: Rows = (HEAD,)) -> Rows:
    return [*head, *sweep(code)]


def said(record: LoadTestRecord, text: str) -> Problem:
    found = [problem for problem in record.problems if text in problem.what]
    assert len(found) == 1, [str(problem) for problem in record.problems]
    return found[0]


def warnings(record: LoadTestRecord) -> list[str]:
    return [str(problem) for problem in record.problems if problem.severity != "note"]


def fitted(record: LoadTestRecord) -> list[LoadTestPoint]:
    return [point for point in record.points if not point.marks]


# --- codes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("Код 90", 90),
        ("Код 90 (2)", 90),
        ("N=+127", 127),
        ("N=-127", -127),
        ("code_040", 40),
        ("code90", 90),
        ("90", 90),
        ("-90", -90),
        ("code -90", -90),
        ("Code 90 loading", 90),
        ("код минус 40", -40),
    ],
)
def test_the_code_in_a_sheet_name(tmp_path: Path, name: str, code: float) -> None:
    rows = [HEAD, *([n * code / abs(code), m * code / abs(code)] for n, m in sweep(abs(code)))]
    record = read(tmp_path, {name: rows})
    assert {point.code for point in record.points} == {code}
    assert len(fitted(record)) == len(rows) - 1


@pytest.mark.parametrize("name", ["Sheet1", "Лист90", "drive-07", "Код 20-30", "code 20-127"])
def test_a_number_in_a_name_is_no_code_by_itself(tmp_path: Path, name: str) -> None:
    record = read(tmp_path, {name: rows_of(90)})
    assert {point.code for point in record.points} == {None}
    assert "M(n, N) cannot be fitted" in said(record, "no control code").what
    assert code_in_text(name, alone=True) is None


@pytest.mark.parametrize(
    "headings",
    [
        [["Control code: 90"]],
        [["Control code:", 90]],
        [["Код управления", None, 90]],
        [["Drive 7"], ["N =", "90"], ["Volt", 24]],
        [["Код управления N = 90; стенд 2"], []],
    ],
)
def test_the_code_in_a_heading(tmp_path: Path, headings: list[list[object]]) -> None:
    record = read(tmp_path, {"Sheet1": [*headings, *rows_of(90)]})
    assert {point.code for point in record.points} == {90.0}
    assert not [text for text in warnings(record) if "one code only" not in text]


def test_the_heading_goes_before_the_sheet_name(tmp_path: Path) -> None:
    record = read(tmp_path, {"Code 60": [["Code 90"], *rows_of(90)]})
    assert {point.code for point in record.points} == {90.0}
    assert "the sheet's name 60" in said(record, "the heading says code 90").what


@pytest.mark.parametrize("header", ["Code", "Код управления", "N", "Control code"])
def test_a_code_column(tmp_path: Path, header: str) -> None:
    rows = [[header, *HEAD], *([code, n, m] for code in (60, 90) for n, m in sweep(code))]
    record = read(tmp_path, {"all": rows})
    assert {point.code for point in record.points} == {60.0, 90.0}
    assert not warnings(record)


def test_a_code_in_merged_cells(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["all"].merge_cells("A2:A24")
        workbook["all"].merge_cells("A25:A47")

    rows = [
        [code if index == 0 else None, n, m]
        for code in (60, 90)
        for index, (n, m) in enumerate(sweep(code))
    ]
    record = read(tmp_path, {"all": [["Code", *HEAD], *rows]}, finish)
    assert [point.code for point in record.points] == [60.0] * 23 + [90.0] * 23


def test_a_code_column_in_per_cent(tmp_path: Path) -> None:
    rows = [["Code, %", *HEAD], *([code, n, m] for code in (50, 100) for n, m in sweep(code))]
    record = read(tmp_path, {"all": rows})
    assert {point.code for point in record.points} == {63.5, 127.0}


def test_code_headings_between_the_rows(tmp_path: Path) -> None:
    rows = [HEAD, ["Code 60"], *sweep(60), ["Code:", 90], *sweep(90)]
    record = read(tmp_path, {"all": rows})
    assert [point.code for point in record.points] == [60.0] * 23 + [90.0] * 23


def test_the_code_of_a_text_file_is_in_its_name(tmp_path: Path) -> None:
    lines = "\n".join(f"{n};{m}".replace(".", ",") for n, m in sweep(90))
    record = read_text(tmp_path, f"n, об/мин;M, Н·м\n{lines}\n", "code_90.csv")
    assert {point.code for point in record.points} == {90.0}
    assert record.points[0].shaft_speed_rpm == sweep(90)[0][0]


def test_codes_out_of_range_are_not_fitted(tmp_path: Path) -> None:
    record = read(tmp_path, {"Code 300": rows_of(90), "Code 60": rows_of(60)})
    assert "outside of the drive's range" in said(record, "codes from 300").what
    assert {point.code for point in fitted(record)} == {60.0}


@pytest.mark.parametrize(("head", "told"), [("code", True), ("code, %", False)])
def test_codes_with_fractions_are_told_unless_they_are_shares(
    tmp_path: Path, head: str, told: bool
) -> None:
    lines = "\n".join(f"{code};{n};{m}" for code in (40.5, 60) for n, m in sweep(int(code)))
    record = read_text(tmp_path, f"{head};rpm;torque [N m]\n{lines}\n")
    found = [one for one in record.problems if "is a whole number" in one.what]
    assert [(one.place.row, one.place.column) for one in found] == [(2, "A")] * told
    if told:
        assert found[0].what.startswith("code 40.5: ")
        assert {point.code for point in fitted(record)} == {40.5, 60.0}


def test_one_code_only(tmp_path: Path) -> None:
    record = read(tmp_path, {"Code 90": rows_of(90)})
    problem = said(record, "one code only (90)")
    assert problem.severity == "error"
    assert problem.place.file == "trial/load_test"


def test_a_code_twice_in_one_file_is_a_repeated_test(tmp_path: Path) -> None:
    record = read(tmp_path, {"Код 90": rows_of(90), "Code 90": rows_of(91), "60": rows_of(60)})
    assert {point.source.sheet for point in fitted(record)} == {"Код 90", "Code 90", "60"}
    record = read(tmp_path, {"Код 90": rows_of(90), "Code 90": rows_of(110), "60": rows_of(60)})
    assert "times the shaft speed of the others" in said(record, "this table gives").what


def test_a_code_twice_with_the_same_values_is_a_copy(tmp_path: Path) -> None:
    record = read(tmp_path, {"Код 90": rows_of(90), "Код 90 (2)": rows_of(90), "60": rows_of(60)})
    assert said(record, "rows again as in").place.sheet == "Код 90 (2)"
    assert {point.marks for point in record.points if point.source.sheet == "Код 90 (2)"} == {
        ("duplicate",)
    }


def test_loading_and_unloading_on_two_sheets_are_one_code(tmp_path: Path) -> None:
    up, down = sweep(90)[:12], sweep(90)[12:]
    record = read(tmp_path, {"Код 90 нагружение": [HEAD, *up], "Код 90 разгрузка": [HEAD, *down]})
    assert len(fitted(record)) == 23
    assert {(point.source.sheet or "")[7:]: point.branch for point in record.points} == {
        "нагружение": "loading",
        "разгрузка": "unloading",
    }


def test_a_code_in_two_files_is_a_repeated_test(tmp_path: Path) -> None:
    folder = tmp_path / "raw" / "trial" / "load_test"
    paths = [
        write_workbook(folder / f"drive-{number}.xlsx", {"Code 90": rows_of(90 + number)})
        for number in (0, 1)
    ]
    record = read_load_tests(paths, vehicle(), tmp_path / "raw")
    assert len(fitted(record)) == 46


# --- units ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "newton_metres"),
    [
        ("oz in", 0.00706155181), ("ozf.in", 0.00706155181), ("lb in", 0.112984829),
        ("lb ft", 1.355817948), ("g cm", 9.80665e-5), ("гс·см", 9.80665e-5),
        ("kg cm", 0.0980665), ("кгс·см", 0.0980665), ("кг см", 0.0980665), ("N mm", 0.001),
        ("Н·мм", 0.001), ("N cm", 0.01), ("Н·см", 0.01), ("N m", 1.0), ("Н·м", 1.0),
    ],
)  # fmt: skip
@pytest.mark.parametrize("in_header", [True, False])
def test_torque_in_any_unit(
    tmp_path: Path, unit: str, newton_metres: float, in_header: bool
) -> None:
    head = [["n, rpm", f"M, {unit}"]] if in_header else [["n", "M"], ["rpm", unit]]
    rows = [*head, *([n, m / newton_metres] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows})
    assert [point.torque_nm for point in record.points] == pytest.approx(
        [m for _, m in sweep(90)], rel=1e-7
    )
    assert {c.unit for sheet in record.sheets for c in sheet.columns} == {"rpm", unit}


@pytest.mark.parametrize(
    ("unit", "rpm"),
    [("rpm", 1), ("об/мин", 1), ("min-1", 1), ("rad/s", 9.549296586), ("рад/с", 9.549296586),
     ("rps", 60), ("об/с", 60)],
)  # fmt: skip
def test_speed_in_any_unit(tmp_path: Path, unit: str, rpm: float) -> None:
    rows = [[f"Speed [{unit}]", "Torque [N m]"], *([n / rpm, m] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows})
    speeds = [point.shaft_speed_rpm for point in record.points]
    assert speeds == pytest.approx([n for n, _ in sweep(90)])


def test_a_missing_torque_unit_says_what_to_state(tmp_path: Path) -> None:
    rows = [["Speed, rpm", "Torque"], *sweep(90)]
    record = read(tmp_path, {"Code 90": rows, "Code 60": rows_of(60)})
    problem = said(record, "no unit is stated")
    assert str(problem.place) == f'{NAME}, sheet "Code 90", row 1, column B'
    assert 'torque: {header: "Torque", unit: ...}' in problem.remedy
    assert {point.code for point in record.points} == {60.0}
    stated = read(tmp_path, {"Code 90": rows}, torque={"header": "Torque", "unit": "N cm"})
    assert stated.points[-1].torque_nm == pytest.approx(sweep(90)[-1][1] / 100)


def test_decimal_commas_as_text(tmp_path: Path) -> None:
    rows = [
        ["Частота вращения, об/мин", "Момент, Н·м"],
        *([f"{n:.2f}".replace(".", ","), f"{m:.5f}".replace(".", ",")] for n, m in sweep(90)),
    ]
    record = read(tmp_path, {"Код 90": rows})
    assert [(p.shaft_speed_rpm, p.torque_nm) for p in record.points] == sweep(90)


def test_all_optional_quantities(tmp_path: Path) -> None:
    head = ["n, rpm", "M, N cm", "Ток, мА", "Напряжение, В", "Потребляемая мощность, кВт",
            "Мощность на валу, Вт"]  # fmt: skip
    rows = [
        head,
        *([n, m * 100, 2e4 * m, 24, 0.48 * m, 0.10471975512 * n * m] for n, m in sweep(90)),
    ]
    record = read(tmp_path, {"Код 90": rows})
    point, (n, m) = record.points[5], sweep(90)[5]
    assert point.torque_nm == pytest.approx(m)
    assert point.current_a == pytest.approx(20 * m)
    assert point.voltage_v == 24.0
    assert point.input_power_w == pytest.approx(480 * m)
    assert point.output_power_w == pytest.approx(0.10471975512 * n * m)
    assert str(point.source) == f'{NAME}, sheet "Код 90", row 7'


# --- branches and warm-up ------------------------------------------------------------------------


def test_branches_are_told_from_the_torque(tmp_path: Path) -> None:
    record = read(tmp_path, {"Code 90": rows_of(90)})
    assert [point.branch for point in record.points] == ["loading"] * 12 + ["unloading"] * 11


@pytest.mark.parametrize(
    ("torque", "branches"),
    [
        ([0, 1, 2, 3], "llll"),
        ([3, 2, 1, 0], "uuuu"),
        ([0, 1, 2, 3, 2, 1, 0], "lllluuu"),
        ([0, 1, 2, 3, 2, 1, 0, 1, 2, 3], "lllluuulll"),
        ([3, 2, 1, 0, 1, 2, 3], "uuuulll"),
        ([0, 1, 0.95, 2, 1.9, 3, 2], "llllllu"),
        ([1, 1, 1], "lll"),
        ([], ""),
        ([2], "l"),
    ],
)
def test_turning_points_beyond_the_scatter(torque: list[float], branches: str) -> None:
    assert "".join(name[0] for name in branches_of(np.array(torque, dtype=float))) == branches


@pytest.mark.parametrize(
    ("words", "column"),
    [(("loading", "unloading"), "Branch"), (("нагружение", "разгрузка"), "Ветвь"),
     (("up", "down"), "Sweep")],
)  # fmt: skip
def test_a_branch_column(tmp_path: Path, words: tuple[str, str], column: str) -> None:
    # The words say the opposite of the torque, so that they and not it are seen to count.
    rows = [
        [*HEAD, column],
        *([n, m, words[1 if i < 12 else 0]] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": rows})
    assert [point.branch for point in record.points] == ["unloading"] * 12 + ["loading"] * 11


def test_branch_headings_between_the_rows(tmp_path: Path) -> None:
    rows = [HEAD, ["Loading"], *sweep(90)[:9], ["Разгружение"], *sweep(90)[9:]]
    record = read(tmp_path, {"Code 90": rows})
    assert [point.branch for point in record.points] == ["loading"] * 9 + ["unloading"] * 14


def test_two_blocks_side_by_side_under_merged_headings(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["Данные"].merge_cells("A1:E1")
        workbook["Данные"].merge_cells("A2:B2")
        workbook["Данные"].merge_cells("D2:E2")

    up, down = sweep(90)[:11], sweep(90)[12:]
    rows = [
        ["Код управления: 90"],
        ["Нагружение", None, None, "Разгрузка"],
        ["n", "M", None, "n", "M"],
        ["об/мин", "Н·м", None, "об/мин", "Н·м"],
        *([*a, None, *b] for a, b in zip(up, down, strict=True)),
    ]
    record = read(tmp_path, {"Данные": rows}, finish)
    assert [(p.code, p.branch) for p in record.points] == [(90.0, "loading")] * 11 + [
        (90.0, "unloading")
    ] * 11
    assert [(p.shaft_speed_rpm, p.torque_nm) for p in record.points] == [*up, *down]


def test_blocks_of_two_codes_on_a_sheet(tmp_path: Path) -> None:
    side = [
        ["Код 60", None, None, "Код 90"],
        [*HEAD, None, *HEAD],
        *([*a, None, *b] for a, b in zip(sweep(60), sweep(90), strict=True)),
    ]
    stacked = [["Code 60"], *rows_of(60), [], ["Code 90"], *rows_of(90)]
    for rows in (side, stacked):
        record = read(tmp_path, {"all": rows})
        assert [p.code for p in record.points] == [60.0] * 23 + [90.0] * 23
        assert [p.torque_nm for p in record.points] == [m for c in (60, 90) for _, m in sweep(c)]


@pytest.mark.parametrize("word", ["warm-up", "Прогрев", "warming up"])
def test_warm_up_by_a_word(tmp_path: Path, word: str) -> None:
    rows = [
        [*HEAD, "Status"],
        *([n, m, word if i < 3 else "ok"] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": rows})
    assert [point.marks for point in record.points[:4]] == [("warm-up",)] * 3 + [()]
    assert said(record, "warm-up: 3 rows on 1 sheet").severity == "note"


@pytest.mark.parametrize(
    "times",
    [
        range(23),
        [f"12:00:{s:02d}" for s in range(23)],
        [f"2024-05-06 23:59:{s + 30}" for s in range(23)],
        [f"23:59:{s + 57}" if s < 3 else f"00:00:{s - 3:02d}" for s in range(23)],
        [f"23:59:{s + 50}" if s < 10 else f"00:00:{s - 10:02d}" for s in range(23)],
        [f"12:59:{s + 50} PM" if s < 10 else f"01:00:{s - 10:02d} PM" for s in range(23)],
    ],
)
def test_warm_up_by_time(tmp_path: Path, times: list[object]) -> None:
    rows = [["Time, s", *HEAD], *([t, n, m] for t, (n, m) in zip(times, sweep(90), strict=True))]
    record = read(tmp_path, {"Code 90": rows}, warm_up_s=4.5)
    assert [bool(point.marks) for point in record.points] == [True] * 5 + [False] * 18


@pytest.mark.parametrize("unit", ["hh:mm:ss", "[чч:мм:сс]", "Ч:ММ:СС"])
def test_a_clock_time_may_say_how_it_is_written(tmp_path: Path, unit: str) -> None:
    times = [f"12:00:{s:02d}" for s in range(23)]
    rows = [
        ["Время", "Частота вращения", "Момент"],
        [unit, "об/мин", "Н·м"],
        *([t, n, m] for t, (n, m) in zip(times, sweep(90), strict=True)),
    ]
    record = read(tmp_path, {"Code 90": rows}, warm_up_s=4.5)
    assert [bool(point.marks) for point in record.points] == [True] * 5 + [False] * 18


def test_no_key_is_offered_that_the_vehicle_file_does_not_have(tmp_path: Path) -> None:
    rows = [
        ["Time", *HEAD],
        ["V", "rpm", "N m"],
        *([s, n, m] for s, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": rows})
    problem = said(record, "is a unit of voltage")
    assert problem.remedy == "Write it there."


@pytest.mark.parametrize("unset", ["0000-00-00 12:00:00", "2024-13-45 12:00:00"])
def test_a_clock_that_was_not_set_is_no_time(tmp_path: Path, unset: str) -> None:
    rows = [[*HEAD, "Time"], *([n, m, unset] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows}, warm_up_s=150)
    assert "there is no time" in said(record, "there is no time").what
    assert len(fitted(record)) == len(rows) - 1
    for k in range(10):
        rows[-1 - k][2] = f"2024-03-05 10:{20 - k}:00"
    record = read(tmp_path, {"Code 90": rows}, warm_up_s=150)
    assert [point.marks for point in record.points if "warm-up" in point.marks]


def test_warm_up_time_without_a_time_column(tmp_path: Path) -> None:
    record = read(tmp_path, {"Code 90": rows_of(90)}, warm_up_s=4.5)
    assert "no time to count it by" in said(record, "warm_up_s: 4.5").what


# --- rows ----------------------------------------------------------------------------------------


def test_text_in_a_number_column(tmp_path: Path) -> None:
    rows = [list(row) for row in rows_of(90, (["Speed", "Torque"], [], ["rpm", "kg cm"]))]
    rows[13][1] = "1,2,3"
    rows[15][0] = "#DIV/0!"
    record = read(tmp_path, {"Код 90": rows, "Код 60": rows_of(60)})
    assert str(said(record, '"1,2,3"')) == (
        f'{NAME}, sheet "Код 90", row 14, column B: torque "1,2,3" is not a number. '
        "The row was left out.\n"
        "Expected a decimal number (point or comma), kg cm, the unit stated in cell B3.\n"
        'Fix the cell, or mark the row with "#" in column A to leave it out.'
    )
    assert said(record, '"#DIV/0!"').place.row == 16
    assert len([point for point in record.points if point.code == 90]) == 21


def test_text_in_an_optional_column_keeps_the_row(tmp_path: Path) -> None:
    rows = [
        [*HEAD, "Current, A"],
        *([n, m, "x" if i == 4 else 1 + m] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": rows})
    assert len(record.points) == 23
    assert record.points[4].current_a is None
    assert "The rest of the row was read" in said(record, 'current "x"').what


def test_a_number_beyond_any_bench_is_left_out(tmp_path: Path) -> None:
    rows = [[*HEAD, "Current, A"], *([n, m, 5.0] for n, m in sweep(90))]
    rows[4][1], rows[6][2] = 1e20, -1e12
    record = read(tmp_path, {"Code 90": rows})
    assert "1e+20 is beyond anything a bench measures" in said(record, "torque 1e+20").what
    assert "The rest of the row was read" in said(record, "current -1e+12").what
    assert len(record.points) == len(rows) - 2


def test_many_bad_cells_are_summed_up(tmp_path: Path) -> None:
    rows = [HEAD, *([n, "bad"] for n, _ in sweep(90)), *sweep(90)]
    record = read(tmp_path, {"Code 90": rows})
    found = [problem for problem in record.problems if "not a number" in problem.what]
    assert [one.what for one in found] == [
        'torque "bad" is not a number (rows 2-24). The rows were left out.'
    ]


def test_commented_rows_are_kept_but_not_fitted(tmp_path: Path) -> None:
    rows = [
        ["", *HEAD],
        *(["#" if i in {3, 4} else "", n, m] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": rows})
    assert [i for i, p in enumerate(record.points) if p.marks == ("commented out",)] == [3, 4]
    (told,) = [p for p in record.problems if 'commented out with "#"' in p.what]
    assert (told.severity, told.place.row) == ("note", record.points[3].source.row)
    text = "n, rpm;M, N m\n" + "\n".join(
        f"{'# ' if i == 2 else ''}{n};{m}" for i, (n, m) in enumerate(sweep(90))
    )
    record = read_text(tmp_path, text, "code_90.csv")
    assert record.points[2].marks == ("commented out",)
    assert record.points[2].shaft_speed_rpm == sweep(90)[2][0]


def test_repeated_rows_are_marked_and_counted(tmp_path: Path) -> None:
    rows = [HEAD, *sweep(90), sweep(90)[3], sweep(90)[20]]
    record = read(tmp_path, {"Code 90": rows})
    assert [p.source.row for p in record.points if p.marks == ("duplicate",)] == [25, 26]
    assert said(record, "again as further up").what.startswith("2 rows again")


def test_missing_cells(tmp_path: Path) -> None:
    rows = [
        [*HEAD, "U, V"],
        *([n, None if i in {2, 3} else m, 24] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(tmp_path, {"Code 90": [*rows, [], [None, None, None]]})
    assert said(record, "torque is empty").what == "torque is empty in rows 4-5; left out."
    assert len(record.points) == 21


@pytest.mark.parametrize("cell", [None, "NaN", "-"])
@pytest.mark.parametrize("quantity", [0, 1])
def test_a_column_without_any_number(tmp_path: Path, cell: str | None, quantity: int) -> None:
    rows = [
        [cell if index == quantity else value for index, value in enumerate(row)]
        for row in sweep(90)
    ]
    record = read(tmp_path, {"Code 90": [HEAD, *rows], "Code 60": rows_of(60)})
    problem = said(record, "holds no number at all")
    assert problem.severity == "error"
    assert ("shaft speed", "torque")[quantity] in problem.what
    assert {point.code for point in record.points} == {60.0}


@pytest.mark.parametrize(("cell", "severity"), [(None, "note"), ("NaN", "warning")])
def test_a_dead_channel_is_named_and_left_out(
    tmp_path: Path, cell: str | None, severity: str
) -> None:
    rows = [[*HEAD, "Input current, mA", "Voltage, V"], *([n, m, 0, cell] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows})
    reasons = {one.header: one.reason for sheet in record.sheets for one in sheet.not_used}
    assert reasons["Input current, mA"] == "it is 0 throughout: not connected?"
    assert said(record, 'voltage "Voltage, V" holds no number').severity == severity
    assert record.points[0].current_a is None


def test_formula_cells_without_values_are_said(tmp_path: Path) -> None:
    rows = [HEAD, *([n, f"={m}*1" if i == 5 else m] for i, (n, m) in enumerate(sweep(90)))]
    record = read(tmp_path, {"Code 90": rows})
    assert "B7" in said(record, "hold no stored value").what
    assert len(record.points) == 22


# --- signs and sizes -----------------------------------------------------------------------------


def test_reverse_sweeps_are_stored_as_measured(tmp_path: Path) -> None:
    rows = [HEAD, *([-n, -m] for n, m in sweep(90))]
    record = read(tmp_path, {"Code -90": rows, "Code 90": rows_of(90)})
    back = [point for point in record.points if point.code == -90]
    assert [(p.shaft_speed_rpm, p.torque_nm) for p in back] == [(-n, -m) for n, m in sweep(90)]
    assert [p.branch for p in back] == ["loading"] * 12 + ["unloading"] * 11
    assert not any(p.marks for p in record.points)


def test_some_negative_torques_are_marked(tmp_path: Path) -> None:
    rows = [HEAD, *([n, -m if i in {5, 6} else m] for i, (n, m) in enumerate(sweep(90)))]
    record = read(tmp_path, {"Code 90": rows})
    assert "in 2 rows (rows 7-8)" in said(record, "torque is negative").what
    assert [i for i, p in enumerate(record.points) if p.marks == ("negative torque",)] == [5, 6]


def test_noise_around_zero_is_not_a_sign(tmp_path: Path) -> None:
    rows = [HEAD, [1500, -0.002], [1490, -0.001], *sweep(90)]
    record = read(tmp_path, {"Code 90": rows})
    assert not any(point.marks for point in record.points)


def test_a_sensor_that_counts_the_other_way(tmp_path: Path) -> None:
    rows = [HEAD, *([n, -m] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows})
    problem = said(record, "looks like the sign of the sensor")
    assert "sign: -1" in problem.remedy
    assert record.points[3].torque_nm < 0  # nothing was turned round
    assert record.points[3].marks == ("negative torque",)
    stated = read(tmp_path, {"Code 90": rows}, torque={"header": "Torque", "sign": -1})
    assert [point.torque_nm for point in stated.points] == [m for _, m in sweep(90)]
    assert not any(point.marks for point in stated.points)


def test_a_hyphen_before_the_code_is_read_by_the_speed(tmp_path: Path) -> None:
    back = [HEAD, *([-n, -m] for n, m in sweep(90))]
    record = read(tmp_path, {"code-90": back, "code-60": rows_of(60)})
    assert {point.code for point in record.points} == {-90.0, 60.0}
    assert "taken for a minus" in said(record, "hyphen before 90").what


@pytest.mark.parametrize(
    ("stated", "true", "factor"),
    [
        ("N m", "N mm", 1000),
        ("kg cm", "lb in", 0.0980665 / 0.112984829),
        ("N cm", "oz in", 1.4161193),
    ],
)
def test_a_wrong_torque_unit_is_betrayed_by_the_power(
    tmp_path: Path, stated: str, true: str, factor: float
) -> None:
    worth = {"N m": 1.0, "kg cm": 0.0980665, "N cm": 0.01}[stated]
    head = ["n, rpm", f"M, {stated}", "Output power, W"]
    rows = [head, *([n, m / worth * factor, 0.10471975512 * n * m] for n, m in sweep(90))]
    record = read(tmp_path, {"Code 90": rows})
    problem = said(record, "a unit is likely wrong")
    assert f"torque is in {true}, not {stated}" in problem.what


def test_a_right_power_says_nothing(tmp_path: Path) -> None:
    rows = [[*HEAD, "Output power, W"], *([n, m, 0.1047 * n * m] for n, m in sweep(90))]
    assert not [text for text in warnings(read(tmp_path, {"Code 90": rows})) if "power" in text]


def test_a_wrong_speed_unit_is_betrayed_by_the_power(tmp_path: Path) -> None:
    rows = [
        ["n, rpm", "M, N m", "P2, W"],
        *([n / 9.549297, m, 0.10472 * n * m] for n, m in sweep(90)),
    ]
    assert (
        "shaft speed is in rad/s, not rpm"
        in said(read(tmp_path, {"Code 90": rows}), "a unit is likely wrong").what
    )


def test_a_wrong_current_unit_is_betrayed_by_the_input_power(tmp_path: Path) -> None:
    head = [*HEAD, "Current, A", "Voltage, V", "Input power, W"]
    rows = [head, *([n, m, 1000 + 2e4 * m, 24, 24 + 480 * m] for n, m in sweep(90))]
    problem = said(read(tmp_path, {"Code 90": rows}), "a unit is likely wrong")
    assert "current is in mA, not A" in problem.what


def test_more_power_out_than_in(tmp_path: Path) -> None:
    rows = [[*HEAD, "I, A", "U, V"], *([n, m, 0.02, 24] for n, m in sweep(90))]
    assert said(read(tmp_path, {"Code 90": rows}), "2 pi n M over the power taken is")


def test_torques_no_propeller_takes(tmp_path: Path) -> None:
    rows = [HEAD, *([n, 1000 * m] for n, m in sweep(90))]
    assert "A unit may be wrong" in said(read(tmp_path, {"Code 90": rows}), "far from what").what


# --- sheets and files ----------------------------------------------------------------------------


def test_sheets_without_a_load_test_are_told_once(tmp_path: Path) -> None:
    record = read(
        tmp_path,
        {"Code 90": rows_of(90), "Plan": [["Date", "Who"], ["a", "b"]], "Fit": [[1, 2]], "": []},
    )
    told = [one for one in record.problems if "the sheet was not read" in one.what]
    assert [(one.place.sheet, one.severity) for one in told] == [("Plan", "note"), ("Fit", "note")]
    assert 'It has "Date", "Who".' in told[0].what
    assert [sheet.rows for sheet in record.sheets] == [23]


def test_a_file_without_a_load_test_is_an_error(tmp_path: Path) -> None:
    record = read_text(tmp_path, "1\t2\n3\t4\n", "data.txt")
    problem = said(record, "no column names over its 4 numbers")
    assert problem.severity == "error"
    assert 'header: "column A"' in problem.remedy
    stated = read_text(
        tmp_path,
        "1\t2\n3\t4\n",
        "data.txt",
        shaft_speed={"header": "column A", "unit": "rpm"},
        torque={"header": "column B", "unit": "N m"},
    )
    assert [(p.shaft_speed_rpm, p.torque_nm) for p in stated.points] == [(1.0, 2.0), (3.0, 4.0)]


def test_sheets_and_rows_chosen_in_the_vehicle_file(tmp_path: Path) -> None:
    rows = [
        ["Drive", *HEAD],
        *(["a" if i % 2 else "b", n, m] for i, (n, m) in enumerate(sweep(90))),
    ]
    record = read(
        tmp_path, {"Code 90": rows, "Code 60": rows}, sheets=["Code 90"], only={"Drive": "a"}
    )
    assert len(record.points) == 11
    assert '"Code 60"' in said(record, "restricts the sheets").what


def test_results_beside_the_measurement_are_not_counted_twice(tmp_path: Path) -> None:
    results = [[round(n), round(m, 3)] for n, m in sweep(90)]
    record = read(tmp_path, {"input": rows_of(90), "Output": [HEAD, *results]})
    assert said(record, "again as in trial/load_test/drive.xlsx").place.sheet == "Output"
    assert {point.source.sheet for point in fitted(record)} == {"input"}


def test_what_was_understood_is_recorded(tmp_path: Path) -> None:
    record = read(tmp_path, {"Код 90": rows_of(90)})
    (sheet,) = record.sheets
    assert (sheet.file, sheet.sheet, sheet.rows) == (NAME, "Код 90", 23)
    assert sheet.summary.startswith("code 90 (sheet name), 23 points, 576 to 1440 rpm")
    assert [(c.quantity, c.column, c.unit, c.unit_from) for c in sheet.columns] == [
        ("shaft_speed", "A", "rpm", "header"),
        ("torque", "B", "N m", "header"),
    ]


def test_the_record_survives_its_file_format(tmp_path: Path) -> None:
    record = read(tmp_path, {"Код 90": [*rows_of(90), ["x", 1]]})
    assert LoadTestRecord.model_validate_json(record.model_dump_json()) == record


def test_nothing_at_all(tmp_path: Path) -> None:
    record = read_load_tests([], vehicle(), tmp_path)
    assert record == LoadTestRecord(points=(), sheets=(), problems=())


@pytest.mark.parametrize(
    ("text", "branch"),
    [("Unloading", "unloading"), ("Load test of drive 7", None), ("down", "unloading"),
     ("Нагрузочные испытания", None), ("прямой ход", "loading"), ("shut down", None)],
)  # fmt: skip
def test_branch_words(text: str, branch: str | None) -> None:
    assert branch_in_text(text) == branch


def test_warm_up_words() -> None:
    assert [is_warm_up(text) for text in ("Warm-up, 2 min", "прогрев", "steady")] == [
        True, True, False,
    ]  # fmt: skip
