"""What is left of a file: commented rows, files without a point, blank forms, what is said."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from bench_workbooks import sweep, vehicle

from pipeline.errors import Place, Problem
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.ingest.rows import with_cause
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.vehicle.bench_schema import FORM_MARK
from pipeline.vehicle.schema import Vehicle

Record = LoadTestRecord | MooringRecord | OpenWaterRecord
Reader = Callable[[Sequence[Path], Vehicle, Path], Record]
READERS: dict[str, Reader] = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}
HEADERS = {
    "load_test": "code;speed, rpm;torque, N m",
    "mooring": "code;thrust, N",
    "open_water": "J;KT;KM",
}
ROWS = {
    "load_test": [f"{code};{n};{m}" for code in (60, 90) for n, m in sweep(code)],
    "mooring": [f"{code};{0.002 * code * abs(code):.3f}" for code in range(-120, 121, 20)],
    "open_water": [f"0.{i};0.{139 - 15 * i:03};0.0{171 - 16 * i}" for i in range(7)],
}
KINDS = tuple(READERS)


def read(raw: Path, kind: str, **files: str) -> Record:
    folder = raw / "boat" / kind
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text + "\n", encoding="utf-8")
    return READERS[kind](sorted(folder.iterdir()), vehicle(), raw)


def table(kind: str, rows: Sequence[str]) -> str:
    return "\n".join([HEADERS[kind], *rows])


def errors(record: Record) -> list[Problem]:
    return [problem for problem in record.problems if problem.severity == "error"]


# --- rows that are commented out -----------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("mark", ["#", "# "])
def test_a_row_whose_first_number_is_commented_is_kept(
    tmp_path: Path, kind: str, mark: str
) -> None:
    rows = [f"{mark}{row}" if index == 3 else row for index, row in enumerate(ROWS[kind])]
    as_it_was = read(tmp_path / "a", kind, good=table(kind, ROWS[kind]))
    commented = read(tmp_path / "b", kind, good=table(kind, rows))
    assert len(commented.points) == len(as_it_was.points)
    assert [
        point.source.row for point in commented.points if point.marks == ("commented out",)
    ] == [5]
    assert not errors(commented)
    if isinstance(commented, MooringRecord) and isinstance(as_it_was, MooringRecord):
        assert commented.points[3].code == as_it_was.points[3].code == -60.0


# --- files that give nothing ---------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_without_a_usable_point_is_one_error(tmp_path: Path, kind: str) -> None:
    rows = [f"#{row}" for row in ROWS[kind][:5]]
    record = read(tmp_path, kind, good=table(kind, ROWS[kind]), none=table(kind, rows))
    (error,) = errors(record)
    assert error.place.file == f"boat/{kind}/none.csv"
    assert "5 points read (commented out)" in error.what
    assert len([point for point in record.points if not point.marks]) >= 7


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_of_headers_alone_is_one_error(tmp_path: Path, kind: str) -> None:
    record = read(tmp_path, kind, good=table(kind, ROWS[kind]), none=HEADERS[kind])
    (error,) = errors(record)
    assert error.place.file == f"boat/{kind}/none.csv"


def test_torque_against_the_code_throughout_is_one_error(tmp_path: Path) -> None:
    rows = [f"90;{n};{-m - 0.01:.5f}" for n, m in sweep(90)]
    good = table("load_test", ROWS["load_test"])
    record = read(tmp_path, "load_test", good=good, turned=table("load_test", rows))
    (error,) = errors(record)
    assert error.place.file == "boat/load_test/turned.csv"
    assert "sign of the sensor" in error.what
    assert error.what.endswith("No point of the file is left.")


@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_of_another_file_is_no_error(tmp_path: Path, kind: str) -> None:
    text = table(kind, ROWS[kind])
    record = read(tmp_path, kind, a=text, b=text)
    assert not errors(record)
    assert any("copy" in problem.remedy for problem in record.problems)


WARNING = Problem("warning", Place("a.csv", row=3), "odd.")
NOTE = Problem("note", Place("a.csv"), "by the way.")


def test_the_first_warning_is_the_cause() -> None:
    second = Problem("warning", Place("a.csv", row=9), "odd, too.")
    (error, note) = with_cause([NOTE, WARNING, second], Place("a.csv"), [("odd",)], "mooring")
    assert (error.severity, error.place.row) == ("error", 3)
    assert note == NOTE
    assert with_cause([WARNING], Place("a.csv"), [("odd",), ()], "mooring") == [WARNING]


@pytest.mark.parametrize("kind", KINDS)
def test_a_blank_form_is_no_fault(tmp_path: Path, kind: str) -> None:
    form = f"{kind} of boat ({FORM_MARK})\n{HEADERS[kind]}"
    alone = read(tmp_path / "a", kind, form=form)
    (note,) = alone.problems
    assert (note.severity, note.place.file) == ("note", f"boat/{kind}/form.csv")
    assert "no data yet" in note.what
    assert not alone.points
    beside = read(tmp_path / "b", kind, form=form, good=table(kind, ROWS[kind]))
    assert not errors(beside)
    assert len(beside.points) == len(ROWS[kind])
    filled = read(tmp_path / "c", kind, form="\n".join([form, *ROWS[kind]]))
    assert len(filled.points) == len(ROWS[kind])
    assert not [problem for problem in filled.problems if "no data yet" in problem.what]


# --- what is said --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "header", "row", "example"),
    [
        ("load_test", "speed;torque, N m", "100;0.1", "[rpm]"),
        ("load_test", "rpm;torque", "100;0.1", "[N m]"),
        ("mooring", "code;thrust", "40;6.5", "[N]"),
        ("open_water", "V;rpm;thrust, N", "1;600;16", "[m/s]"),
        ("open_water", "V, m/s;rpm;torque", "1;600;0.6", "[N m]"),
    ],
)
def test_a_missing_unit_is_asked_for_by_a_fitting_example(
    tmp_path: Path, kind: str, header: str, row: str, example: str
) -> None:
    record = read(tmp_path, kind, none="\n".join([header, *[row] * 5]))
    said = [problem for problem in record.problems if "no unit is stated" in problem.what]
    assert [f"e.g. {example}," in problem.expected for problem in said] == [True]


def test_a_tare_of_nothing_has_no_sign(tmp_path: Path) -> None:
    rows = [
        "0;0",
        *(f"{code};{abs(0.002 * code * code):.3f}" for code in (-80, -40, 40, 80)),
        "0;0",
    ]
    record = read(tmp_path, "mooring", unsigned=table("mooring", rows))
    assert isinstance(record, MooringRecord)
    assert [math.copysign(1.0, point.tare_n) for point in record.points] == [1.0] * 6
