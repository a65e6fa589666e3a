"""Bench files as rigs write them: each is read as its truth says, or refused with the way out.

The files stand beside this module in ``bench_cases``. A row of the table is a file and what must
come of it: the ends of its codes and of its readings, how many count, or why it is refused.
"""

from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline.identify.inverse import inverse_characteristic
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.fits import InverseCharacteristic
from pipeline.stages.bench_records import READERS
from pipeline.stages.job import RawRecord
from pipeline.vehicle.load import load_vehicle

CASES = Path(__file__).parent / "bench_cases"
FOLDERS = CASES / "folders"
#: Truth of the folders: 50 N ahead and 40 N astern, within what noise and settling leave.
FULL = (-40.0, 50.0)


@dataclass(frozen=True)
class Right:
    """What must be read: readings that count, ends of the codes, ends of a quantity."""

    used: int
    codes: tuple[float, float] | None
    quantity: str
    ends: tuple[float, float]
    tolerance: float = 0.01


def thrust(used: int, codes: tuple[float, float], low: float, high: float) -> Right:
    return Right(used, codes, "thrust_n", (low, high))


def speed(used: int, codes: tuple[float, float] | None, low: float, high: float) -> Right:
    return Right(used, codes, "shaft_speed_rpm", (low, high))


def folder(used: int) -> Right:
    return Right(used, (-400, 400), "thrust_n", FULL, 0.03)


PULSES = (-400.0, 400.0)
READ: dict[str, Right] = {
    "mooring_forward_only.csv": thrust(20, (10, 100), 0.29, 50.06),
    "mooring_direction_100.csv": thrust(40, (-100, 100), -38.11, 50.06),
    "mooring_direction.csv": thrust(14, (-127, 127), -31.86, 42.48),
    "mooring_direction_ru.csv": thrust(14, (-127, 127), -31.86, 42.48),
    "mooring_direction_cw.csv": thrust(14, (-127, 127), -31.86, 42.48),
    "load_direction.csv": speed(72, (-127, 127), -2057, 2286),
    "load_direction_ru.csv": speed(72, (-127, 127), -2057, 2286),
    "load_unsigned_run100.csv": speed(9, (100, 100), 1260, 1800),
    "load_unsigned_run-100.csv": speed(9, (-100, -100), -1800, -1260),
    "mooring_thousands_points.csv": thrust(38, (-100, 100), -38.03, 49.98),
    "mooring_thousands_points_volt.csv": thrust(62, PULSES, -39.9, 51.4),
    "load_thousands_points.csv": speed(27, (70, 127), 1882, 3286),
    "load_thousands_commas.csv": speed(27, (70, 127), 1882, 3286),
    "open_water_thousands_points.csv": Right(14, None, "advance_ratio", (0.0, 0.65)),
    "mooring_two_units.csv": thrust(38, (-100, 100), -38.03, 49.98),
    "mooring_two_units_exact.csv": thrust(62, PULSES, -39.9, 51.4),
    "mooring_two_units_apart.csv": thrust(62, PULSES, -39.9, 51.4),
    "mooring_row_number_n.csv": thrust(62, PULSES, -39.9, 51.4),
    "load_row_number_n.csv": speed(36, (40, 127), 504, 2286),
    "mooring_tyto.csv": thrust(62, PULSES, -39.9, 51.4),
    "mooring_tyto_blank_servos.csv": thrust(62, PULSES, -39.9, 51.4),
    "load_tyto.csv": speed(36, (40, 127), 504, 2286),
    "mooring_p_t_units_row.csv": thrust(62, PULSES, -39.9, 51.4),
    "load_oz_ft.csv": Right(36, (40, 127), "torque_nm", (0.034, 0.9)),
    "mooring_esc_us.csv": thrust(62, PULSES, -39.9, 51.4),
    "mooring_throttle_percent.csv": thrust(62, PULSES, -39.9, 51.4),
    "mooring_both_star.csv": thrust(12, (10, 120), 0.22, 31.68),
    "mooring_paren.csv": thrust(12, (10, 120), 0.22, 31.68),
    "folders/thousands_points_gf": folder(32),
    "folders/settling_of_steps": folder(32),
    "folders/several_thrusters": folder(96),
    "folders/two_unit_columns": folder(32),
    "folders/throttle_share": folder(40),
    "folders/throttle_percent": folder(40),
    "folders/test_stand_csv": folder(32),
}
#: File -> what the refusal says, and a line that helps.
REFUSED = {
    "mooring_left_right.csv": ('"Thrust right (N)"', "plus:"),
    "mooring_two_equal_cells.csv": ('"thrust right (N)"', "plus:"),
    "mooring_p_f.csv": ('C "F"', "unit: ..."),
    "folders/grams_as_kg": ("K_T at rest comes out as 464", "unit: ..."),
    "folders/two_load_cells": ('"Force right (N)"', "plus:"),
    "folders/lever_ratio": ("speaks of a lever", "scale: ..."),
    "folders/one_way_esc": ("beyond the assumed range", "neutral_us: 1000"),
    "folders/unit_row_contradicts": ("the row under it кгс", "unit: ..."),
    "folders/e_rpm": ("pole pairs", "pole_pairs: ..."),
    "folders/speed_erpm": ("pole pairs", "pole_pairs: ..."),
}


def read(case: str) -> RawRecord:
    """Read a case by its own vehicle file, or by the one for its codes."""
    if case.startswith("folders/"):
        place = CASES / case
        kind = next(one for one in READERS if (place / one).is_dir())
        files = sorted((place / kind).iterdir())
        return READERS[kind](files, load_vehicle(place / "vehicle.yaml"), place.parent)
    path = CASES / case
    kind = next(one for one in READERS if one.startswith(case.partition("_")[0]))
    own = path.with_suffix(".vehicle.yaml")
    if case in ("mooring_direction_100.csv", "mooring_two_units.csv"):
        own = CASES / "mooring_forward_only.vehicle.yaml"
    elif not own.exists():
        own = CASES / ("vehicle_us.yaml" if kind == "mooring" else "vehicle_127.yaml")
        if "direction" in case:
            own = CASES / "vehicle_127.yaml"
    return READERS[kind]([path], load_vehicle(own), CASES)


@pytest.mark.parametrize("case", READ)
def test_read_as_the_truth_says(case: str) -> None:
    right = READ[case]
    used = [point for point in read(case).points if not point.marks]
    assert len(used) == right.used
    if right.codes is not None:
        codes = [point.code for point in used]  # type: ignore[union-attr]
        assert (min(codes), max(codes)) == pytest.approx(right.codes, abs=0.02)  # type: ignore[type-var]
    values = [getattr(point, right.quantity) for point in used]
    scale = max(map(abs, right.ends))
    assert (min(values), max(values)) == pytest.approx(right.ends, abs=right.tolerance * scale)


@pytest.mark.parametrize("case", REFUSED)
def test_refused_with_the_way_out(case: str) -> None:
    record = read(case)
    assert not record.points
    why, way_out = REFUSED[case]
    errors = [str(problem) for problem in record.problems if problem.severity == "error"]
    assert any(why in text and way_out in text for text in errors), errors


def test_every_case_is_in_the_table() -> None:
    there = {path.name for path in CASES.glob("*.csv")}
    there |= {f"folders/{path.name}" for path in FOLDERS.iterdir()}
    assert there == {*READ, *REFUSED, "mooring_fold_back.csv"}


def test_a_weak_thruster_is_named() -> None:
    problems = [str(problem) for problem in read("folders/several_thrusters").problems]
    assert any('"T3" gives 0.7' in text for text in problems)


@pytest.mark.parametrize("case", ["mooring_both_star.csv", "mooring_paren.csv"])
def test_rows_without_any_number_are_named(case: str) -> None:
    problems = [str(problem) for problem in read(case).problems if problem.severity == "warning"]
    assert any("code" in text and "is not a number (rows 2-13)" in text for text in problems)


def inverse(case: str, sign: float = 1.0) -> InverseCharacteristic:
    vehicle = load_vehicle((CASES / case).with_suffix(".vehicle.yaml"))
    record = read_mooring_tables([CASES / case], vehicle, CASES)
    turned = tuple(
        one.model_copy(update={"code": sign * one.code, "thrust_n": sign * one.thrust_n})
        for one in record.points
    )
    return inverse_characteristic(None, record.model_copy(update={"points": turned}), vehicle)


def test_codes_beyond_a_fold_are_in_no_table() -> None:
    found = inverse("mooring_fold_back.csv")
    assert found.firmware is not None
    branch = found.firmware.positive
    assert branch.thrust_max_n[0] == pytest.approx(34.8, abs=0.2)
    assert max(branch.code[0]) == 80
    (check,) = [one for one in found.checks if one.gate == "thrust_rises"]
    assert not check.passed
    assert "beyond code 80" in check.text


@pytest.mark.parametrize(("sign", "there"), [(1.0, "table3_positive"), (-1.0, "table3_negative")])
def test_a_test_of_one_sign_gives_its_half_of_table_3(sign: float, there: str) -> None:
    found = inverse("mooring_forward_only.csv", sign)
    assert getattr(found, there) is not None
    assert found.firmware is None
    assert any("No firmware tables" in text for text in found.explanations)
