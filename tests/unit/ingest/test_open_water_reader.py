"""Open-water tests in every shape that towing tanks and wind tunnels write them."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openpyxl import Workbook

from pipeline.errors import Problem
from pipeline.ingest.open_water import read_open_water
from pipeline.ingest.open_water_coefficients import (
    Coefficients,
    check_efficiency,
    coefficients,
    doubt,
)
from pipeline.records.measurements import OpenWaterRecord
from pipeline.vehicle.schema import Vehicle

DENSITY = 1000.0
DIAMETER = 0.2
Rows = Sequence[Sequence[object]]


def efficiency(j: float, kt: float, kq: float) -> float:
    return float(Coefficients(*map(np.array, ([j], [kt], [kq]))).efficiency[0])


J = (0.0, 0.2, 0.4, 0.6, 0.8)
CURVES = tuple((j, 0.40 - 0.30 * j - 0.10 * j**2, 0.050 - 0.020 * j - 0.015 * j**2) for j in J)


def make_vehicle(**open_water: object) -> Vehicle:
    tree: dict[str, Any] = {
        "name": "v",
        "title": "",
        "water": {"density_kgpm3": DENSITY, "gravity_mps2": 9.81},
        "propellers": {"p": {"diameter_m": DIAMETER}},
        "drives": {"d": {"code_min": -127, "code_max": 127}},
        "tables": {"propeller": "p", "drive": "d"},
        "columns": {"open_water": open_water},
    }
    return Vehicle.model_validate(tree)


def text(path: Path, rows: Rows, delimiter: str = ",") -> Path:
    with path.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, delimiter=delimiter).writerows(rows)
    return path


def xlsx(path: Path, rows: Rows) -> Path:
    book = Workbook()
    sheet = book.create_sheet("test", 0)
    for row in rows:
        sheet.append(list(row))
    book.save(path)
    return path


def read(vehicle: Vehicle, *paths: Path) -> OpenWaterRecord:
    return read_open_water(paths, vehicle, paths[0].parent)


def of_severity(record: OpenWaterRecord, severity: str) -> list[Problem]:
    return [problem for problem in record.problems if problem.severity == severity]


def one(problems: Sequence[Problem]) -> str:
    assert len(problems) == 1, "\n".join(str(problem) for problem in problems)
    return str(problems[0])


def assert_curves(record: OpenWaterRecord) -> None:
    """The record holds the curves of this file, whatever the columns were."""
    assert not of_severity(record, "error")
    assert not of_severity(record, "warning")
    found = [
        (point.advance_ratio, point.thrust_coefficient, point.torque_coefficient)
        for point in record.points
    ]
    assert found == [pytest.approx(row, rel=1e-9, abs=1e-12) for row in CURVES]
    assert not any(point.marks for point in record.points)


# --- columns -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        (("J", "K_T", "K_M"), 1.0),
        (("J", "KT", "KQ"), 1.0),
        (("J", "Kt", "10KQ"), 10.0),
        (("J", "KT", "10 K_Q"), 10.0),
        (("J", "KT", "10*KQ"), 10.0),
        (("J", "KT", "10·K_Q"), 10.0),
        (("J", "KT", "KQ*10"), 10.0),
        (("J", "K_T", "10K_M"), 10.0),
        (("J", "CT", "CP"), 2 * math.pi),
        (("J", "C_T", "C_P"), 2 * math.pi),
        (("J", "CT", "CQ"), 1.0),
        (("Advance ratio J", "Thrust coefficient K_T", "Torque coefficient K_Q"), 1.0),
        (("Advance ratio", "Thrust coefficient", "Power coefficient"), 2 * math.pi),
        (("λ", "K1", "K2"), 1.0),
        (("λp", "K_T", "10K_Q"), 10.0),
        (("Поступь", "Коэффициент упора", "Коэффициент момента"), 1.0),
        (("Относительная поступь λ", "Коэффициент упора K_T", "Коэффициент момента K_M"), 1.0),
        (("Относительная поступь", "Коэффициент упора", "10 Коэффициент момента"), 10.0),
    ],
)
def test_names_of_coefficients(tmp_path: Path, header: tuple[str, ...], factor: float) -> None:
    rows = [header, *((j, kt, kq * factor) for j, kt, kq in CURVES)]
    assert_curves(read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows)))


def test_decimal_commas_and_russian_names(tmp_path: Path) -> None:
    rows = [("Поступь λ", "Коэффициент упора", "Коэффициент момента", "КПД")]
    for j, kt, kq in CURVES:
        eta = efficiency(j, kt, kq)
        rows.append(tuple(f"{number:.12g}".replace(".", ",") for number in (j, kt, kq, eta)))  # type: ignore[arg-type]
    assert_curves(read(make_vehicle(), text(tmp_path / "a.csv", rows, ";")))


def raw_rows(rpm: float = 900.0) -> list[tuple[float, float, float, float]]:
    """(V, n, T, Q) that give the curves."""
    n = rpm / 60.0
    return [
        (
            j * n * DIAMETER,
            rpm,
            kt * DENSITY * n**2 * DIAMETER**4,
            kq * DENSITY * n**2 * DIAMETER**5,
        )
        for j, kt, kq in CURVES
    ]


def test_raw_thrust_and_torque(tmp_path: Path) -> None:
    rows = [("V, m/s", "n, rpm", "T, N", "Q, N m"), *raw_rows()]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert_curves(record)
    note = one(of_severity(record, "note"))
    assert "thrust and torque made a coefficient with density 1000 kg/m^3 and diameter 0.2" in note


def test_raw_values_in_other_units(tmp_path: Path) -> None:
    header = ("Скорость потока, км/ч", "Частота вращения, об/с", "Упор, кгс", "Момент, кгс·см")
    rows = [
        header,
        *((v * 3.6, n / 60, t / 9.80665, q / 0.0980665) for v, n, t, q in raw_rows()),
    ]
    assert_curves(read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows)))


def test_raw_thrust_with_stated_advance_ratio(tmp_path: Path) -> None:
    rows = [("J", "n, rps", "Thrust, N", "K_Q")]
    rows += [(j, 15.0, kt * DENSITY * 225 * DIAMETER**4, kq) for j, kt, kq in CURVES]  # type: ignore[misc]
    assert_curves(read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows)))


def test_mapped_columns(tmp_path: Path) -> None:
    rows = [("x", "y", "10 z"), *((j, -kt, 10 * kq) for j, kt, kq in CURVES)]
    vehicle = make_vehicle(
        advance_ratio={"header": "x"},
        thrust_coefficient={"header": "y", "sign": -1},
        torque_coefficient={"header": "10 z"},
    )
    assert_curves(read(vehicle, xlsx(tmp_path / "a.xlsx", rows)))


def test_thrust_alone_is_read(tmp_path: Path) -> None:
    rows = [("J", "KT"), *((j, kt) for j, kt, _ in CURVES)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert [point.torque_coefficient for point in record.points] == [None] * len(J)
    assert record.sheets[0].summary == ("5 points, J 0 to 0.8, K_T 0.4 to 0.096, no K_Q, 1 at rest")


def test_raw_thrust_needs_its_unit_but_a_stray_column_does_not(tmp_path: Path) -> None:
    rows = [("V, m/s", "n, rpm", "T"), *(row[:3] for row in raw_rows())]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert not record.points
    assert "no unit is stated" in one(of_severity(record, "error"))
    rows = [("J", "KT", "KQ", "T"), *((*row, 1.0) for row in CURVES)]  # type: ignore[list-item]
    record = read(make_vehicle(), xlsx(tmp_path / "b.xlsx", rows))
    assert not of_severity(record, "error")
    assert len(record.points) == len(J)


def test_rows_at_rest_and_a_standing_shaft(tmp_path: Path) -> None:
    rows = [("V, m/s", "n, rpm", "T, N", "Q, N m"), (0.0, 0.0, 0.0, 0.0), *raw_rows()]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    message = one(of_severity(record, "warning"))
    assert "the shaft stands still" in message
    assert "row 2" in message
    assert record.points[0].advance_ratio == 0.0
    assert len(record.points) == len(J)


# --- filters -------------------------------------------------------------------------------------


def test_only_the_rows_of_one_propeller(tmp_path: Path) -> None:
    rows: list[tuple[object, ...]] = [("PropName", "N", "J", "CT", "CP")]
    for name, scale in (("a 4x4 - 2", 1.0), ("b", 0.5)):
        rows += [(name, 4000.0, j, scale * kt, scale * kq * 2 * math.pi) for j, kt, kq in CURVES]
    path = text(tmp_path / "a.csv", rows)
    assert_curves(read(make_vehicle(only={"PropName": "a 4x4 - 2"}), path))
    record = read(make_vehicle(), path)
    assert not record.points
    assert 'column "PropName" has 2 different texts' in of_severity(record, "warning")[0].what
    assert 'column "PropName" parts the rows' in of_severity(record, "error")[0].what
    record = read(make_vehicle(only={"PropName": "a 4x4 - 2", "N": "4000"}), path)
    assert len(record.points) == len(J)
    record = read(make_vehicle(only={"PropName": "c"}), path)
    assert 'no row left by columns: open_water: only: PropName = "c"' in one(
        of_severity(record, "error")
    )
    record = read(make_vehicle(only={"Propname typo": "c"}), path)
    assert any("Propname typo" in problem.what for problem in of_severity(record, "error"))


# --- cross-checks --------------------------------------------------------------------------------


def with_efficiency(factor: float = 1.0, unit: float = 1.0) -> list[tuple[float, ...]]:
    return [(j, kt, kq * factor, unit * efficiency(j, kt, kq)) for j, kt, kq in CURVES]


@pytest.mark.parametrize(
    ("torque", "factor", "unit", "suspicion"),
    [
        ("KQ", 10.0, 1.0, "is the column 10K_Q, not K_Q?"),
        ("10KQ", 1.0, 1.0, "is the column K_Q, not 10K_Q?"),
        ("KQ", 2 * math.pi, 1.0, "is the column C_P, not K_Q?"),
        ("CP", 1.0, 1.0, "is the column K_Q, not C_P?"),
        ("KQ", 1.0, 100.0, "looks to be in percent"),
        ("KQ", 1.7, 1.0, "do not belong together"),
    ],
)
def test_the_efficiency_column_finds_a_mix_up(
    tmp_path: Path, torque: str, factor: float, unit: float, suspicion: str
) -> None:
    rows = [("J", "KT", torque, "eta"), *with_efficiency(factor, unit)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert suspicion in one(of_severity(record, "warning"))
    assert len(record.points) == len(J)


def test_the_efficiency_column_agrees(tmp_path: Path) -> None:
    rows = [("J", "KT", "KQ", "eta"), *with_efficiency()]
    assert_curves(read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows)))
    rows = [("J", "KT", "KQ", "КПД, %"), *with_efficiency(unit=100.0)]
    assert_curves(read(make_vehicle(), xlsx(tmp_path / "b.xlsx", rows)))


def test_a_single_odd_row_is_named(tmp_path: Path) -> None:
    data = with_efficiency()
    data[2] = (*data[2][:3], data[2][3] * 1.3)
    rows = [("J", "KT", "KQ", "eta"), *data]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert "in row 4" in one(of_severity(record, "warning"))


@pytest.mark.parametrize(
    ("torque", "factor", "suspicion"),
    [
        ("KQ", 10.0, "is the column 10K_Q, not K_Q?"),
        ("10KQ", 1.0, "is the column K_Q, not 10K_Q?"),
        ("KQ", 0.25, "is in another unit"),
        ("KQ", 3.0, "is in another unit"),
    ],
)
def test_without_an_efficiency_column_the_impossible_is_found(
    tmp_path: Path, torque: str, factor: float, suspicion: str
) -> None:
    rows = [("J", "KT", torque), *((j, kt, kq * factor) for j, kt, kq in CURVES)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert suspicion in one(of_severity(record, "warning"))


def test_duplicates_and_impossible_advance_ratios_are_marked(tmp_path: Path) -> None:
    rows = [("J", "KT", "KQ"), *CURVES, CURVES[2], (80.0, 0.1, 0.02)]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    assert record.points[-2].marks == ("duplicate",)
    assert record.points[-1].marks == ("advance ratio beyond any propeller",)
    assert len(of_severity(record, "warning")) == 1


# --- bad files -----------------------------------------------------------------------------------


def test_text_in_a_number_and_an_empty_column(tmp_path: Path) -> None:
    rows = [("J", "KT", "KQ", "eta"), *((*row, "NaN") for row in CURVES), (0.9, "x", 0.02, "-")]
    record = read(make_vehicle(), xlsx(tmp_path / "a.xlsx", rows))
    messages = [str(problem) for problem in of_severity(record, "warning")]
    assert any('thrust coefficient "x" is not a number' in message for message in messages)
    assert any("efficiency" in message and "no number" in message for message in messages)
    assert record.points[-1].thrust_coefficient is None
    assert record.points[-1].torque_coefficient == 0.02


def test_bad_files_do_not_stop_the_others(tmp_path: Path) -> None:
    good = xlsx(tmp_path / "good.xlsx", [("J", "KT", "KQ"), *CURVES])
    bad = tmp_path / "bad.xlsx"
    bad.write_bytes(good.read_bytes()[:900])
    copy = tmp_path / "copy.xlsx"
    copy.write_bytes(good.read_bytes())
    other = text(tmp_path / "other.csv", [("C", "s_J", "t_PD"), (1, 2, 3)])
    record = read(make_vehicle(), bad, other, good, copy)
    assert len([point for point in record.points if not point.marks]) == len(J)
    assert [problem.place.file for problem in of_severity(record, "error")] == [
        "bad.xlsx",
        "other.csv",
    ]
    assert "again as in" in one(of_severity(record, "warning"))
    assert OpenWaterRecord.model_validate_json(record.model_dump_json()) == record


# --- formulas ------------------------------------------------------------------------------------


@given(
    j=st.floats(0.05, 1.5),
    kt=st.floats(-0.2, 0.6),
    kq=st.floats(0.001, 0.1),
    rpm=st.floats(100, 3000),
    density=st.floats(500, 1500),
    diameter=st.floats(0.02, 5),
)
def test_raw_values_and_coefficients_are_one(
    *, j: float, kt: float, kq: float, rpm: float, density: float, diameter: float
) -> None:
    n = rpm / 60.0
    raw = {
        "speed": j * n * diameter,
        "shaft_speed": rpm,
        "thrust": kt * density * n**2 * diameter**4,
        "torque": kq * density * n**2 * diameter**5,
    }
    found = coefficients({k: np.array([v]) for k, v in raw.items()}, density, diameter)
    assert found.advance_ratio == pytest.approx(j)
    assert found.thrust_coefficient == pytest.approx(kt, abs=1e-12)
    assert found.torque_coefficient == pytest.approx(kq)


@given(st.floats(0.5, 2.0), st.integers(1, 20))
def test_the_efficiency_check_is_silent_only_near_one(ratio: float, rows: int) -> None:
    check = check_efficiency(np.full(rows, 0.5 * ratio), np.full(rows, 0.5))
    assert check is not None
    assert (check.suspicion == "") == (abs(ratio - 1.0) <= 0.03)
    assert check.outliers == ()


def test_nothing_to_compare() -> None:
    assert check_efficiency(np.array([]), np.array([])) is None
    assert check_efficiency(np.array([math.nan, 0.5]), np.array([0.5, math.nan])) is None
    assert doubt(Coefficients(*map(np.array, ([0.5], [0.1], [math.nan])))) == ""
    assert math.isnan(efficiency(0.5, 0.1, 0.0))


CELLS = st.one_of(
    st.none(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from(["", "x", "0,5", "#", "NaN", "KT", "1e308", "1e-308", "-"]),
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.lists(CELLS, min_size=6, max_size=6), max_size=8))
def test_whatever_stands_in_the_cells_there_is_a_record(
    tmp_path: Path, cells: list[list[object]]
) -> None:
    for header in (
        ("J", "KT", "KQ", "eta", "a", "b"),
        ("V, m/s", "n, rpm", "T, N", "Q, N m", "eta", ""),
    ):
        path = xlsx(tmp_path / "a.xlsx", [header, *cells])
        record = read(make_vehicle(), path)
        assert record.points or record.problems
        assert OpenWaterRecord.model_validate_json(record.model_dump_json()) == record


@pytest.mark.parametrize("head", ["J", "λ", "Advance coefficient"])
@pytest.mark.parametrize("over_pi", [False, True])
def test_an_advance_coefficient_over_pi_is_asked_for(
    head: str, over_pi: bool, tmp_path: Path
) -> None:
    rows = [
        f"{j / (math.pi if over_pi else 1.0):.4f},{0.46 * (1 - j / 1.07):.4f},"
        f"{0.067 * (1 - j / 1.2):.5f}"
        for j in np.linspace(0.0, 1.0, 11)
    ]
    path = tmp_path / "open.csv"
    path.write_text("\n".join([f"{head},KT,KQ", *rows]), encoding="utf-8")
    record = read_open_water([path], make_vehicle(), tmp_path)
    refused = [one for one in record.problems if one.severity == "error"]
    assert bool(refused) == over_pi
    assert all("scale: 3.14159" in one.remedy for one in refused)
