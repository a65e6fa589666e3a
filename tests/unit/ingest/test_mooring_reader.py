"""Mooring tables in every shape that benches write them."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openpyxl import Workbook

from pipeline.errors import Problem
from pipeline.ingest.mooring import hysteresis, read_mooring_tables, sweeps, tare
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.vehicle.bench_schema import voltage_groups
from pipeline.vehicle.schema import Vehicle

KGF_N = 9.80665
LBF_N = 4.4482216152605
Rows = Sequence[Sequence[object]]


def make_vehicle(code_max: int = 127, supply_v: float | None = None, **mooring: object) -> Vehicle:
    tree: dict[str, Any] = {
        "name": "v",
        "title": "",
        "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
        "propellers": {"p": {"diameter_m": 0.2}},
        "drives": {"d": {"code_min": -code_max, "code_max": code_max}},
        "tables": {"propeller": "p", "drive": "d", "supply_voltage_v": supply_v},
        "columns": {"mooring": mooring},
    }
    return Vehicle.model_validate(tree)


def xlsx(path: Path, **sheets: Rows) -> Path:
    book = Workbook()
    book.remove(book.active)  # type: ignore[arg-type]
    for name, rows in sheets.items():
        sheet = book.create_sheet(name.replace("_", " "))
        for row in rows:
            sheet.append(list(row))
    path.parent.mkdir(parents=True, exist_ok=True)
    book.save(path)
    return path


def text(path: Path, rows: Rows, delimiter: str = ",") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, delimiter=delimiter).writerows(rows)
    return path


def read(vehicle: Vehicle, *paths: Path) -> MooringRecord:
    return read_mooring_tables(paths, vehicle, paths[0].parent)


def of_severity(record: MooringRecord, severity: str) -> list[Problem]:
    return [problem for problem in record.problems if problem.severity == severity]


def fitted(record: MooringRecord) -> list[tuple[float, float]]:
    return [(point.code, point.thrust_n) for point in record.points if not point.marks]


def one(problems: Sequence[Problem]) -> str:
    assert len(problems) == 1, "\n".join(str(problem) for problem in problems)
    return str(problems[0])


UP = ((0, 0.0), (20, 1.6), (40, 6.5), (80, 20.0), (127, 42.0))
DOWN = ((80, 20.5), (40, 7.0), (20, 2.1), (0, 0.0))
BACK = ((-20, -1.5), (-40, -6.0), (-80, -19.0), (-127, -41.0), (0, 0.0))


# --- units and names -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "newtons"),
    [
        ("N", 1.0),
        ("kN", 1000.0),
        ("kgf", KGF_N),
        ("kg", KGF_N),
        ("gf", KGF_N / 1000),
        ("g", KGF_N / 1000),
        ("lbf", LBF_N),
        ("lb", LBF_N),
        ("Н", 1.0),
        ("кгс", KGF_N),
        ("гс", KGF_N / 1000),
        ("Kg f", KGF_N),
    ],
)
def test_every_unit_of_thrust(tmp_path: Path, unit: str, newtons: float) -> None:
    rows = [(code, thrust / newtons) for code, thrust in UP]
    path = xlsx(tmp_path / "a.xlsx", run=[("Code", f"Thrust ({unit})"), *rows])
    record = read(make_vehicle(), path)
    assert [point.thrust_n for point in record.points] == pytest.approx([t for _, t in UP])
    (column,) = [c for c in record.sheets[0].columns if c.quantity == "thrust"]
    assert (column.unit, column.unit_from, column.column) == (unit, "header", "B")


@pytest.mark.parametrize(
    ("code", "thrust"),
    [
        ("Код управления", "Упор, кгс"),
        ("Код", "Тяга [кгс]"),
        ("N", "T, kgf"),
        ("Control code", "Bollard pull, kgf"),
        ("  CODE ", " Force (Kg f)"),
    ],
)
def test_names_in_english_and_russian(tmp_path: Path, code: str, thrust: str) -> None:
    path = text(tmp_path / "a.csv", [(code, thrust), *UP], ";")
    record = read(make_vehicle(), path)
    assert [p.thrust_n for p in record.points] == pytest.approx([t * KGF_N for _, t in UP])
    assert not of_severity(record, "error")


def test_decimal_comma_units_in_the_next_row_and_a_title(tmp_path: Path) -> None:
    rows = [
        ("Швартовные испытания, стенд 2", "", ""),
        ("Код", "Упор", "Обороты"),
        ("", "кгс", "об/мин"),
        ("0", "0,000", "0"),
        ("40", "0,664", "714"),
        ("127", "4,355", "1692"),
    ]
    record = read(make_vehicle(), text(tmp_path / "a.csv", rows, ";"))
    assert [point.thrust_n for point in record.points] == pytest.approx(
        [0.0, 0.664 * KGF_N, 4.355 * KGF_N]
    )
    assert [point.shaft_speed_rpm for point in record.points] == [0.0, 714.0, 1692.0]
    assert [point.source.row for point in record.points] == [4, 5, 6]


def test_sources_are_relative_to_the_raw_folder(tmp_path: Path) -> None:
    path = xlsx(tmp_path / "raw/v/mooring/run-1.xlsx", run=[("Code", "Thrust, N"), *UP])
    vehicle = make_vehicle()
    (inside,) = {
        p.source.file for p in read_mooring_tables([path], vehicle, tmp_path / "raw").points
    }
    (outside,) = {
        p.source.file for p in read_mooring_tables([path], vehicle, tmp_path / "other").points
    }
    assert (inside, outside) == ("v/mooring/run-1.xlsx", "run-1.xlsx")


def test_missing_unit_leaves_the_table_out_and_says_how_to_state_it(tmp_path: Path) -> None:
    bad = xlsx(tmp_path / "bad.xlsx", run=[("Code", "Thrust"), *UP])
    good = xlsx(tmp_path / "good.xlsx", run=[("Code", "Thrust, N"), *UP])
    record = read(make_vehicle(), bad, good)
    message = one(of_severity(record, "error"))
    assert message.startswith('bad.xlsx, sheet "run", row 1, column B: thrust "Thrust": no unit')
    assert 'thrust: {header: "Thrust", unit: ...}' in message
    assert {point.source.file for point in record.points} == {"good.xlsx"}
    stated = make_vehicle(thrust={"header": "Thrust", "unit": "kgf", "sign": -1})
    record = read(stated, xlsx(tmp_path / "c.xlsx", run=[("Code", "Thrust"), (0, 0), (40, -1)]))
    assert fitted(record) == [(40.0, pytest.approx(KGF_N))]


def test_wrong_unit_is_refused(tmp_path: Path) -> None:
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=[("Code", "Thrust, V"), *UP]))
    assert not record.points
    assert of_severity(record, "error")


# --- code and pulse width ------------------------------------------------------------------------


def test_pulse_width_becomes_a_code_and_the_assumption_is_said(tmp_path: Path) -> None:
    rows = [("PWM (µs)", "Thrust, N"), (1500, 0), (1600, 5), (1900, 40), (1100, -30)]
    path = xlsx(tmp_path / "a.xlsx", run=rows)
    record = read(make_vehicle(code_max=100), path)
    assert [point.code for point in record.points] == [0.0, 25.0, 100.0, -100.0]
    note = next(str(p) for p in of_severity(record, "note") if "pulse width" in p.what)
    assert "(pwm - 1500 us) / 400 us * 100, which is assumed" in note
    vehicle = make_vehicle(code_max=100, pwm_range={"neutral_us": 1500, "half_range_us": 500})
    record = read(vehicle, path)
    assert [point.code for point in record.points] == [0.0, 20.0, 80.0, -80.0]
    note = next(str(p) for p in of_severity(record, "note") if "pulse width" in p.what)
    assert "assumed" not in note


def test_pulse_width_in_milliseconds(tmp_path: Path) -> None:
    rows = [("ШИМ, мс", "Упор, Н"), ("1,5", "0"), ("1,7", "10"), ("1,9", "40")]
    record = read(make_vehicle(code_max=100), text(tmp_path / "a.csv", rows, ";"))
    assert [point.code for point in record.points] == pytest.approx([0.0, 50.0, 100.0])


def test_code_in_per_cent(tmp_path: Path) -> None:
    rows = [("Code, %", "Thrust, N"), (0, 0), (50, 10), (100, 40)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert [point.code for point in record.points] == pytest.approx([0.0, 63.5, 127.0])
    assert any("per cent" in p.what for p in record.problems)


def test_pulse_widths_called_codes_are_refused_with_the_remedy(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), (1500, 0), (1600, 5), (1900, 40)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    message = one(of_severity(record, "error"))
    assert "codes from 1500 to 1900" in message
    assert "If these are pulse widths" in message
    assert not record.points


def test_one_code_beyond_the_range_is_marked(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, (130, 44.0)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    message = one(of_severity(record, "warning"))
    assert message.startswith(
        'a.xlsx, sheet "run", row 7, column A: code outside of the drive\'s range'
    )
    assert record.points[-1].marks == ("code out of range",)
    assert len(fitted(record)) == len(UP) - 1


def test_one_code_only_is_said(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), (40, 6.5), (40, 6.6)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "one code only (40)" in one(of_severity(record, "error"))


# --- signs ---------------------------------------------------------------------------------------


def test_unsigned_shaft_speed_takes_the_sign_of_the_code(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N", "rpm"), (0, 0, 0), (40, 6, 714), (0, 0, 0), (-40, -5, 700)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert [point.shaft_speed_rpm for point in record.points] == [0.0, 714.0, 0.0, -700.0]


def test_signed_shaft_speed_stays_and_a_turned_one_is_turned_back(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N", "rpm"), (0, 0, 0), (40, 6, 714), (-40, -5, -700)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert [p.shaft_speed_rpm for p in record.points] == [0.0, 714.0, -700.0]
    rows = [(*row[:2], -row[2]) if isinstance(row[2], int) else row for row in rows]  # type: ignore[misc]
    record = read(make_vehicle(), xlsx(tmp_path / "b.xlsx", run=rows))
    assert [p.shaft_speed_rpm for p in record.points] == [0.0, 714.0, -700.0]


def test_thrust_without_sign_takes_that_of_the_code(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, *((code, -thrust) for code, thrust in BACK)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "read as a size without sign" in one(of_severity(record, "warning"))
    assert (-40.0, -6.0) in fitted(record)
    assert (40.0, 6.5) in fitted(record)


def test_a_sensor_the_other_way_round_is_refused_until_it_is_stated(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *((code, -thrust) for code, thrust in (*UP, *BACK))]
    path = xlsx(tmp_path / "a.xlsx", run=rows)
    record = read(make_vehicle(), path)
    message = one(of_severity(record, "error"))
    assert "opposite to its code in 6 of 6 rows" in message
    assert "sign: -1" in message
    assert not record.points
    record = read(make_vehicle(thrust={"header": "Thrust, N", "sign": -1}), path)
    assert not of_severity(record, "error")
    assert (127.0, 42.0) in fitted(record)


def test_a_single_wrong_sign_is_marked(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, (100, -29.0), *BACK]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "row 7: thrust has the sign opposite" in one(of_severity(record, "warning"))
    assert next(p for p in record.points if p.code == 100).marks == ("thrust against the code",)


def test_noise_about_zero_is_not_a_wrong_sign(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, (10, -0.05), (-10, 0.1), *BACK]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert not of_severity(record, "warning")


def test_forward_and_reverse_beside_one_code_column(tmp_path: Path) -> None:
    rows = [
        ("Code", "Thrust forward, N", "Thrust reverse, N"),
        (20, 1.6, 1.5),
        (80, 20.0, 19.0),
        (127, 42.0, 41.0),
    ]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert sorted(fitted(record)) == [
        (-127.0, -41.0),
        (-80.0, -19.0),
        (-20.0, -1.5),
        (20.0, 1.6),
        (80.0, 20.0),
        (127.0, 42.0),
    ]
    assert any("says reverse" in p.what for p in of_severity(record, "note"))


# --- tare, sweeps, hysteresis --------------------------------------------------------------------


def test_tare_is_interpolated_over_the_order_of_rows(tmp_path: Path) -> None:
    codes = [0, 40, 80, 40, 0, -40, -80, -40, 0]
    true = [0.0, 6.0, 20.0, 6.0, 0.0, -5.0, -18.0, -5.0, 0.0]
    drift = np.interp(range(9), [0, 4, 8], [0.30, 0.50, 0.40])
    rows = [("Code", "Thrust, N"), *zip(codes, true + drift, strict=True)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert [point.thrust_n for point in record.points] == pytest.approx(true, abs=1e-9)
    assert [point.tare_n for point in record.points] == pytest.approx(drift)
    assert record.tare_drift_n == pytest.approx(0.2)
    assert [point.marks for point in record.points if point.code == 0] == [("zero reading",)] * 3
    assert not any("tare" in problem.what for problem in record.problems)


def test_without_a_zero_reading_the_tare_stays_and_that_is_said(tmp_path: Path) -> None:
    path = xlsx(tmp_path / "a.xlsx", run=[("Code", "Thrust, N"), *UP[1:]])
    record = read(make_vehicle(), path)
    assert "no reading at code 0" in one(of_severity(record, "note"))
    assert fitted(record) == [(float(code), thrust) for code, thrust in UP[1:]]
    assert record.tare_drift_n is None


def test_a_sheet_without_zero_reading_takes_that_of_the_file(tmp_path: Path) -> None:
    head = ("Code", "Thrust, N")
    path = xlsx(
        tmp_path / "a.xlsx",
        up=[head, (0, 1.0), (40, 7.5), (80, 21.0)],
        down=[head, (80, 21.5), (40, 8)],
    )
    record = read(make_vehicle(), path)
    assert fitted(record) == [(40, 6.5), (80, 20.0), (80, 20.5), (40, 7.0)]


def test_a_large_tare_is_warned_of(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *((code, thrust + 5.0) for code, thrust in UP)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "the reading at code 0 is up to 5 N" in one(of_severity(record, "warning"))


def test_hysteresis_at_equal_codes(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, *DOWN, *BACK]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert record.hysteresis_n == pytest.approx(0.5)
    senses = [point.sweep for point in record.points]
    assert senses == ["up"] * 5 + ["down"] * 4 + ["up"] * 4 + ["down"]


def test_up_and_down_beside_one_code_column(tmp_path: Path) -> None:
    rows = [
        ("Код", "Упор вверх, Н", "Упор вниз, Н"),
        (20, 1.6, 2.0),
        (80, 20.0, 20.6),
        (127, 42, 42.2),
    ]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert [point.sweep for point in record.points] == ["up"] * 3 + ["down"] * 3
    assert record.hysteresis_n == pytest.approx(0.4)


def test_one_sweep_has_no_hysteresis(tmp_path: Path) -> None:
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=[("Code", "Thrust, N"), *UP]))
    assert record.hysteresis_n is None


@given(st.lists(st.integers(-127, 127), min_size=1, max_size=30))
def test_sweeps_do_not_depend_on_direction_of_thrust(codes: list[int]) -> None:
    assert sweeps(codes) == sweeps([-code for code in codes])
    assert len(sweeps(codes)) == len(codes)


@given(
    st.lists(st.floats(-1, 1), min_size=2, max_size=6),
    st.lists(st.floats(-50, 50), min_size=3, max_size=3),
)
def test_tare_is_exact_at_zero_readings_and_never_beyond_them(
    readings: list[float], at: list[float]
) -> None:
    zeros = np.arange(len(readings), dtype=float) * 3.0
    assert np.allclose(tare(zeros, zeros, np.array(readings)), readings)
    between = tare(np.sort(np.array(at)), zeros, np.array(readings))
    assert np.all(between >= min(readings) - 1e-12)
    assert np.all(between <= max(readings) + 1e-12)


@given(st.floats(-3, 3), st.lists(st.integers(1, 127), min_size=1, max_size=10, unique=True))
def test_hysteresis_finds_what_was_put_in(shift_n: float, codes: list[int]) -> None:
    rising = [0.002 * code**2 for code in codes]
    falling = [thrust + shift_n for thrust in rising]
    here = Source(file="a.csv", row=1)
    points = [
        MooringPoint(source=here, code=sign * code, thrust_n=sign * thrust, sweep=sweep)
        for sign in (1, -1)
        for thrusts, sweep in ((rising, "up"), (falling, "down"))
        for code, thrust in zip(codes, thrusts, strict=True)
    ]
    found = hysteresis(points)
    assert found == pytest.approx(shift_n, abs=1e-9)


# --- voltages ------------------------------------------------------------------------------------


def test_a_sheet_for_each_voltage(tmp_path: Path) -> None:
    head = ("Code", "Thrust, N")
    path = xlsx(tmp_path / "a.xlsx", **{"12 V": [head, *UP], "24,5_В": [head, *UP]})
    record = read(make_vehicle(supply_v=24.5), path)
    assert [point.voltage_v for point in record.points] == [12.0] * 5 + [24.5] * 5
    assert not of_severity(record, "warning")
    assert record.sheets[0].summary == "5 points, codes 0 to 127, 0 to 42 N, 12 V"


def test_a_voltage_column_goes_before_the_name_of_the_sheet(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N", "U, V", "I, mA"), (0, 0, 16.1, 10), (40, 6, 15.9, 2500)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", **{"16 V": rows}))
    assert [point.voltage_v for point in record.points] == [16.1, 15.9]
    assert [point.current_a for point in record.points] == pytest.approx([0.01, 2.5])


def test_several_voltages_ask_for_the_one_of_the_tables(tmp_path: Path) -> None:
    head = ("Code", "Thrust, N")
    path = xlsx(tmp_path / "a.xlsx", **{"12 V": [head, *UP], "16 V": [head, *UP]})
    assert "supply_voltage_v" in one(of_severity(read(make_vehicle(), path), "warning"))
    record = read(make_vehicle(supply_v=24.0), path)
    assert "no point at the supply voltage of the tables, 24 V; there is 12, 16 V" in one(
        of_severity(record, "warning")
    )


def test_hysteresis_compares_at_equal_voltage_only(tmp_path: Path) -> None:
    head = ("Code", "Thrust, N")
    path = xlsx(
        tmp_path / "a.xlsx",
        **{"12 V": [head, (20, 1.0), (40, 5.0)], "16 V": [head, (40, 9.0), (20, 3.0)]},
    )
    assert read(make_vehicle(supply_v=12.0), path).hysteresis_n is None


def test_voltage_groups_join_a_sagging_supply() -> None:
    assert voltage_groups([16.0, 15.5, 15.0, 14.4, 12.0]) == ((12.0, 12.0), (14.4, 16.0))


# --- bad rows and bad files ----------------------------------------------------------------------


def test_text_in_a_number_is_named_and_the_rest_is_read(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, (100, "1,2,3"), (110, "later")]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    message = one(of_severity(record, "warning"))
    assert message.startswith(
        'a.xlsx, sheet "run", row 7, column B: thrust "1,2,3" is not a number (rows 7-8)'
    )
    assert 'mark the row with "#"' in message
    assert len(record.points) == len(UP)


def test_empty_thrust_is_named(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, (100, None), (110, 30.0)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "row 7, column B: thrust is empty in row 7" in one(of_severity(record, "warning"))


@pytest.mark.parametrize("nothing", [None, "NaN", "n/a", "#DIV/0!"])
def test_a_column_without_a_number_leaves_the_table_out(
    tmp_path: Path, nothing: str | None
) -> None:
    rows = [("Code", "Thrust, N"), *((code, nothing) for code, _ in UP)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert not record.points
    assert "thrust" in one(of_severity(record, "error"))


@pytest.mark.parametrize(("cell", "severity"), [("NaN", "warning"), (None, "note")])
def test_an_optional_column_without_a_number_is_left_out(
    tmp_path: Path, cell: str | None, severity: Literal["warning", "note"]
) -> None:
    rows = [("Code", "Thrust, N", "rpm"), *((code, thrust, cell) for code, thrust in UP)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert "shaft speed" in one(of_severity(record, severity))
    assert len(record.points) == len(UP)
    assert {point.shaft_speed_rpm for point in record.points} == {None}


def test_commented_rows_are_kept_but_not_fitted(tmp_path: Path) -> None:
    rows = [("", "Code", "Thrust, N"), *(("", *row) for row in UP), ("#", 100, 99.0)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert record.points[-1].marks == ("commented out",)
    assert record.points[-1].thrust_n == 99.0
    assert not of_severity(record, "warning")
    (told,) = [p for p in record.problems if 'commented out with "#"' in p.what]
    assert told.place.row == record.points[-1].source.row


def test_a_copied_file_counts_once(tmp_path: Path) -> None:
    first = xlsx(tmp_path / "a.xlsx", run=[("Code", "Thrust, N"), *UP])
    second = tmp_path / "a (copy).xlsx"
    second.write_bytes(first.read_bytes())
    record = read(make_vehicle(), first, second)
    assert len(fitted(record)) == len(UP) - 1
    assert "again as in a.xlsx" in one(of_severity(record, "warning"))


def test_bad_files_do_not_stop_the_others(tmp_path: Path) -> None:
    good = xlsx(tmp_path / "good.xlsx", run=[("Code", "Thrust, N"), *UP])
    truncated = tmp_path / "truncated.xlsx"
    truncated.write_bytes(good.read_bytes()[:1500])
    no_workbook = tmp_path / "text.xlsx"
    no_workbook.write_text("hello")
    other = xlsx(tmp_path / "other.xlsx", run=[("Time, s", "Depth, m"), (1, 2)])
    missing = tmp_path / "missing.csv"
    record = read(make_vehicle(), truncated, no_workbook, other, missing, good)
    assert len(record.points) == len(UP)
    assert [problem.place.file for problem in of_severity(record, "error")] == [
        "truncated.xlsx",
        "text.xlsx",
        "other.xlsx",
        "missing.csv",
    ]


def test_no_files_give_an_empty_record(tmp_path: Path) -> None:
    record = read_mooring_tables([], make_vehicle(), tmp_path)
    assert record == MooringRecord(points=(), sheets=(), problems=())


def test_sheets_and_rows_are_chosen_by_the_vehicle_file(tmp_path: Path) -> None:
    rows = [("Blade", "Code", "Thrust, N"), ("A", 40, 6.0), ("B", 40, 9.0), ("A", 80, 20.0)]
    path = xlsx(tmp_path / "a.xlsx", good=rows, spare=rows)
    record = read(make_vehicle(sheets=("good",), only={"Blade": "A"}), path)
    assert fitted(record) == [(40.0, 6.0), (80.0, 20.0)]
    record = read(make_vehicle(only={"Blade": "C"}), path)
    assert "no row left by columns: mooring: only: Blade" in one(of_severity(record, "error"))


def test_the_record_survives_its_file_form(tmp_path: Path) -> None:
    rows = [("Code", "Thrust, N"), *UP, *DOWN, (100, "x")]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", run=rows))
    assert MooringRecord.model_validate_json(record.model_dump_json()) == record


CELLS = st.one_of(
    st.none(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.integers(-200, 2000),
    st.sampled_from(
        ["", "x", "1,5", "#", "NaN", "12 V", "Code", "Thrust, N", "1e308", "-", "50 %"]
    ),
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.lists(CELLS, min_size=4, max_size=4), max_size=8),
    st.sampled_from(["N", "kgf", "kN"]),
)
def test_whatever_stands_in_the_cells_there_is_a_record(
    tmp_path: Path, cells: list[list[object]], unit: str
) -> None:
    rows = [("Code", f"Thrust, {unit}", "rpm", "U, V"), *cells]
    for path in (text(tmp_path / "a.csv", rows, ";"), xlsx(tmp_path / "a.xlsx", run=rows)):
        record = read(make_vehicle(), path)
        assert record.points or record.problems
        assert MooringRecord.model_validate_json(record.model_dump_json()) == record


@pytest.mark.parametrize(
    ("name", "voltage_v"),
    [
        *[("12V up", 12.0), ("run-16V-a", 16.0), ("24В", 24.0), ("24 В вперед", 24.0)],
        *[("16в", 16.0), ("run V2", None)],
        *[("опыт 3 в бассейне", None), ("ОПЫТ 3 В БАССЕЙНЕ", None), ("16 В, опыт 3 в ванне", 16.0)],
    ],
)
def test_voltage_in_the_name_of_a_sheet(tmp_path: Path, name: str, voltage_v: float | None) -> None:
    path = xlsx(tmp_path / "a.xlsx", **{name: [("Code", "Thrust, N"), *UP]})
    assert {point.voltage_v for point in read(make_vehicle(), path).points} == {voltage_v}


def test_sheets_named_forward_and_reverse(tmp_path: Path) -> None:
    head = ("Code", "Thrust, N")
    path = xlsx(tmp_path / "a.xlsx", Вперёд=[head, *UP], Назад=[head, *UP])
    record = read(make_vehicle(), path)
    assert (127.0, 42.0) in fitted(record)
    assert (-127.0, -42.0) in fitted(record)
