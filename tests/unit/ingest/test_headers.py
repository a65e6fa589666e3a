from pathlib import Path

import pytest
from bench_workbooks import Rows, write_workbook
from openpyxl import Workbook

from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import Sheet
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.headers import BlockSearch, find_blocks, names_seen
from pipeline.ingest.load_test_words import BRANCH_WORDS, REQUIRED
from pipeline.ingest.stated_columns import choose_sheets
from pipeline.ingest.vocabulary import split_header
from pipeline.ingest.workbook import read_sheets
from pipeline.vehicle.bench_schema import Column

DATA = [[1324, 5.0], [1300, 6.0], [1200, 7.0]]


def sheet_of(rows: Rows) -> Sheet:
    """A sheet as the reader would give it, without a file."""
    cells = tuple(
        tuple(float(cell) if isinstance(cell, int) else cell for cell in row) for row in rows
    )
    return Sheet("a.xlsx", "s", cells, 1)  # type: ignore[arg-type]  # rows of the tests hold cells


def search(rows: Rows, only: dict[str, str] | None = None, **mapping: Column) -> BlockSearch:
    wanted = Wanted("load_test", REQUIRED, mapping, only or {}, frozenset({"code"}), BRANCH_WORDS)
    return find_blocks(sheet_of(rows), wanted)


def one(rows: Rows, **mapping: Column) -> Block:
    found = search(rows, **mapping)
    assert len(found.blocks) == 1, found.problems
    return found.blocks[0]


def where(block: Block) -> dict[str, tuple[str, str]]:
    return {name: (column.letter, column.unit) for name, column in block.columns.items()}


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("Torque, kg cm", "Torque", "kg cm"),
        ("Torque [N·m]", "Torque", "N·m"),
        ("Torque (N·m)", "Torque", "N·m"),
        ("Момент (кгс·см)", "Момент", "кгс·см"),
        ("Момент, Н*м (датчик)", "Момент", "Н*м"),
        ("Момент [датчик 1] [Н·м]", "Момент [датчик 1]", "Н·м"),
        ("torque_nm", "torque", "nm"),
        ("Torque oz-in", "Torque", "oz-in"),
        ("Torque / N m", "Torque", "N m"),
        ("Скорость вращения, рад/с", "Скорость вращения", "рад/с"),
        ("Частота вращения об/мин", "Частота вращения", "об/мин"),
        (" Force (Kg f)", "Force", "Kg f"),
        ("U in V", "U", "V"),
        ("Torque", "Torque", None),
        ("10KQ", "10KQ", None),
    ],
)
def test_headers_are_cut_into_name_and_unit(header: str, name: str, unit: str | None) -> None:
    assert (split_header(header)[0].name, split_header(header)[0].unit) == (name, unit)


@pytest.mark.parametrize(
    "head",
    [
        [["Speed, rpm", "Torque, kg cm"]],
        [["Speed", "Torque"], ["rpm", "kg cm"]],
        [["Speed", "Torque"], ["[rpm]", "[kg·cm]"]],
        [["Load test of the drive"], [], ["Speed", "Torque"], [], ["rpm", "kgf.cm"], []],
        [["Shaft", "Shaft"], ["Speed", "Torque"], ["rpm", "kg cm"], ["measured", "load cell"]],
        [["Частота", "Момент"], ["вращения,", "на валу,"], ["об/мин", "кгс·см"]],
        [["Частота вращения", "Крутящий момент"], ["об/мин", "кг·см"]],
        [["n, об/мин", "M, кгс·см"]],
        [["RPM", "  Torque (kg cm) "]],
        [["# speed rpm", "torque kg cm"]],
    ],
)
def test_heads_of_any_depth(head: list[list[object]]) -> None:
    block = one([*head, *DATA])
    assert (block.first_row, block.last_row) == (len(head) + 1, len(head) + 3)
    numbers = [
        (block.value(cells, "shaft_speed"), block.value(cells, "torque"))
        for _, cells in block.rows()
    ]
    assert numbers[0] == (1324.0, pytest.approx(5 * 0.0980665))
    assert len(numbers) == 3


def test_where_the_unit_was_found() -> None:
    block = one([["Speed", "Torque, N m"], ["rad/s", ""], *DATA])
    assert block.columns["shaft_speed"].unit_from == "unit row"
    assert block.columns["shaft_speed"].unit_stated() == "rad/s, the unit stated in cell A2"
    assert block.columns["torque"].unit_from == "header"
    assert one([["RPM", "Torque, N m"], *DATA]).columns["shaft_speed"].unit_from == "assumed"


def test_merged_groups_over_the_names(tmp_path: Path) -> None:
    def finish(workbook: Workbook) -> None:
        workbook["s"].merge_cells("A1:F1")
        workbook["s"].merge_cells("A2:C2")
        workbook["s"].merge_cells("D2:F2")

    rows = [
        ["Torque and speed of drive 7"],
        ["Loading", None, None, "Unloading"],
        ["n", "M", "I", "n", "M", "I"],
        ["rpm", "N cm", "A", "rpm", "N cm", "A"],
        [1, 2, 3, 4, 5, 6],
    ]
    path = write_workbook(tmp_path / "a.xlsx", {"s": rows}, finish)
    (sheet,) = read_sheets(path, "a.xlsx")
    first, second = find_blocks(sheet, Wanted("load_test", REQUIRED)).blocks
    assert where(first) == {
        "shaft_speed": ("A", "rpm"),
        "torque": ("B", "N cm"),
        "current": ("C", "A"),
    }
    assert where(second)["torque"] == ("E", "N cm")
    assert first.columns["torque"].group.endswith("Loading")
    assert second.columns["torque"].group.endswith("Unloading")


def test_tables_side_by_side_told_apart_by_words() -> None:
    head = ["n loading, rpm", "M loading, N m", "n unloading, rpm", "M unloading, N m"]
    first, second = search([head, [1, 2, 3, 4]]).blocks
    assert (first.columns["torque"].letter, second.columns["torque"].letter) == ("B", "D")
    assert second.span == (2, 3)


def test_a_code_column_on_the_left_holds_for_both_tables() -> None:
    head = ["Code", "n, rpm", "M, N m", None, "n, rpm", "M, N m"]
    first, second = search([head, [90, 2, 3, None, 5, 6]]).blocks
    assert first.columns["code"].index == second.columns["code"].index == 0


def test_stacked_tables_keep_their_own_headings_and_rows() -> None:
    rows = [
        ["Code", 90], ["Speed, rpm", "Torque, N m"], *DATA, [],
        ["Code", 60], ["Speed, rpm", "Torque, kg cm"], *DATA,
    ]  # fmt: skip
    first, second = search(rows).blocks
    assert [(b.header_row, b.first_row, b.last_row) for b in (first, second)] == [
        (2, 3, 5), (8, 9, 11),
    ]  # fmt: skip
    assert [[cell.value for cell in block.above] for block in (first, second)] == [
        ["Code", 90.0], ["Code", 60.0],
    ]  # fmt: skip
    assert second.columns["torque"].unit == "kg cm"


def test_set_points_and_other_motors_are_not_taken() -> None:
    rows = [
        ["Input current", "Absorber current", "Output Torque", "Output Speed set-point",
         "Output Speed", "Torque constant"],
        ["mA", "A", "N.mm", "rad.s", "rad.s", "N.m"],
        [1, 2, 3, 4, 5, 6],
    ]  # fmt: skip
    block = one(rows)
    assert where(block) == {
        "current": ("A", "mA"),
        "torque": ("C", "N.mm"),
        "shaft_speed": ("E", "rad.s"),
    }
    assert block.not_used == {1: 'current is read from "Input current"'}


def test_stray_columns_beside_the_table_do_no_harm() -> None:
    rows = [["n, rpm", "M, N m", None, None], [1, 2, None, "note"], [3, 4, None, 17]]
    assert len(list(one(rows).rows())) == 2


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ([["Speed, rpm", "Torque"]], "no unit is stated"),
        ([["Speed", "Torque, N m"]], "no unit is stated"),
        ([["Speed, rpm", "Torque (furlong)"]], '"furlong" is not a known unit of torque'),
        ([["Speed", "Torque"], ["rpm", "furlong"]], '"furlong" is not a known unit of torque'),
        ([["Speed, rpm", "Torque, V"]], '"V" is a unit of voltage'),
        ([["Speed", "Torque"], ["rpm", "V"]], '"V" is a unit of voltage'),
        ([["Обороты", "Момент, кгсм"]], "could be two units"),
    ],
)
def test_missing_and_wrong_units_refuse_the_table(head: list[list[object]], said: str) -> None:
    found = search([*head, *DATA])
    assert not found.blocks
    (problem,) = [problem for problem in found.problems if problem.severity == "error"]
    assert said in problem.what
    assert "vehicle.yaml" in problem.remedy
    assert "unit: ..." in problem.remedy


def test_an_optional_column_with_a_wrong_unit_is_left_out() -> None:
    found = search([["n", "M", "Ток"], ["rpm", "N m", "furlong"], [1, 2, 3]])
    assert set(found.blocks[0].columns) == {"shaft_speed", "torque"}
    assert [problem.severity for problem in found.problems] == ["warning"]


def test_safe_units_are_assumed_for_current_and_voltage() -> None:
    block = one([["n, rpm", "M, N m", "Current", "Voltage"], [1, 2, 3, 4]])
    assert [block.columns[name].unit_from for name in ("current", "voltage")] == ["assumed"] * 2
    assert block.columns["current"].unit == "A"


def test_columns_stated_in_the_vehicle_file() -> None:
    rows = [["A1", "Zugkraft", "Torque"], [100, 3, 5]]
    block = one(
        rows,
        shaft_speed=Column(header="a1", unit="rad/s"),
        torque=Column(header=" Zugkraft", unit="N cm", sign=-1),
    )
    ((_, cells),) = block.rows()
    assert block.value(cells, "torque") == pytest.approx(-0.03)
    assert block.value(cells, "shaft_speed") == pytest.approx(100 * 60 / 6.283185307)
    assert block.columns["torque"].unit_from == "mapping"


def test_a_stated_column_that_is_not_there() -> None:
    found = search([["Speed, rpm", "Torqe, N m"], [1, 2]], torque=Column(header="Torque"))
    assert not found.blocks
    assert 'no column "Torque"' in found.problems[0].what
    assert 'The nearest is "Torqe, N m"' in found.problems[0].what


def test_columns_stated_by_letter_need_no_names() -> None:
    rows = [["some", "text"], [1, 2, 3], [4, 5, 6]]
    found = search(
        rows,
        shaft_speed=Column(header="column A", unit="rpm"),
        torque=Column(header="column C", unit="N cm"),
    )
    (block,) = found.blocks
    assert [block.value(cells, "torque") for _, cells in block.rows()] == pytest.approx(
        [0.03, 0.06]
    )


def test_columns_stated_by_letter_need_a_unit() -> None:
    found = search(
        [[1, 2]],
        shaft_speed=Column(header="column A", unit="rpm"),
        torque=Column(header="column B"),
    )
    assert not found.blocks
    assert "no unit is stated; known: N m" in found.problems[0].what


def test_only_rows_with_a_text() -> None:
    rows = [["Drive", "n, rpm", "M, N m"], ["a", 1, 2], ["B ", 3, 4], [7, 5, 6]]
    (block,) = search(rows, {"drive": "b"}).blocks
    assert [row for row, _ in block.rows()] == [3]
    (block,) = search(rows, {"Drive": "7"}).blocks
    assert [row for row, _ in block.rows()] == [4]
    found = search(rows, {"Prop": "b"})
    assert not found.blocks
    assert 'no column "Prop"' in found.problems[0].what


def test_a_grid_is_not_taken_for_points() -> None:
    rows = [["Torque", *["RPM"] * 6], ["N m", *range(100, 700, 100)], [0.1, *range(6)]]
    found = search(rows)
    assert not found.blocks
    assert "looks like a grid" in found.problems[0].what


def test_names_without_numbers() -> None:
    found = search([["n, rpm", "M, N m"], ["", ""]])
    assert not found.blocks
    assert "no numbers under them" in found.problems[0].what


@pytest.mark.parametrize(
    "rows",
    [[], [[]], [[None]], [["text"]], [[1, 2], [3, 4]], [["Speed"], [1]], [["a", "b"], [1, 2]]],
)
def test_sheets_without_a_table(rows: list[list[object]]) -> None:
    found = search(rows)
    assert not found.blocks
    assert not found.problems


def test_names_seen_are_told() -> None:
    assert names_seen(sheet_of([["title"], ["a", "b", "a"], [1, 2]])) == '"a", "b"'


def test_chosen_sheets() -> None:
    sheets = [Sheet("a.xlsx", name, (), 1) for name in ("Input ", "Output")]
    kept, problems = choose_sheets(sheets, ("input",), "load_test")
    assert [sheet.name for sheet in kept] == ["Input "]
    assert '"Output"' in problems[0].what
    kept, problems = choose_sheets(sheets, ("data",), "load_test")
    assert not kept
    assert "Input" in problems[0].expected
    csv = [Sheet("a.csv", None, (), 1)]
    assert choose_sheets(csv, ("data",), "load_test")[0] == tuple(csv)


def test_a_name_repeated_within_a_table_is_said() -> None:
    found = search([["n, rpm", "M, N m", "M, N m"], [1, 2, 3]])
    assert not found.blocks
    (problem,) = found.problems
    assert problem.severity == "error"
    assert 'torque may be B "M, N m" (2 at most) or C "M, N m" (3 at most)' in problem.what


def test_names_repeated_before_the_table_is_complete() -> None:
    (block,) = search([["Current, A", "n, rpm", "Current, A", "M, N m"], [1, 2, 3, 4]]).blocks
    assert {name: column.letter for name, column in block.columns.items()} == {
        "current": "A",
        "shaft_speed": "B",
        "torque": "D",
    }
