"""Bench files that read well and mean something else: told apart by their rows, or refused."""

from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import vehicle

from pipeline.errors import Problem
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import LoadTestRecord, MooringRecord
from pipeline.vehicle.schema import Vehicle

CODES = (40, 80, 127)
Rows = list[tuple[float, ...]]


def drive(share: float = 1.0) -> Rows:
    """(code, rpm, N m) of a drive that slows down under load, to a share of its best."""
    return [
        (code, round(3000 * code / 127 * share * (1 - 0.3 * x), 1), round(code / 64 * share * x, 4))
        for code in CODES
        for x in np.linspace(0.05, 1, 8)
    ]


def text(head: str, rows: Rows) -> str:
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n"


def read(tmp_path: Path, content: str, name: str = "drive.csv", **pwm: float) -> LoadTestRecord:
    path = tmp_path / "trial" / "load_test" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")
    return read_load_tests([path], with_range(**pwm), tmp_path)


def with_range(**pwm: float) -> Vehicle:
    stated = vehicle().model_dump()
    stated["columns"]["mooring"] = {"pwm_range": pwm} if pwm else {}
    return Vehicle.model_validate(stated)


def errors(record: LoadTestRecord | MooringRecord) -> list[Problem]:
    return [problem for problem in record.problems if problem.severity == "error"]


def fitted(record: LoadTestRecord) -> Rows:
    return [
        (point.code or 0.0, point.shaft_speed_rpm, point.torque_nm)
        for point in record.points
        if not point.marks
    ]


HEAD = "code,speed rpm,torque N m"


@pytest.mark.parametrize("interleaved", [False, True])
def test_two_directions_without_a_sign_are_refused(tmp_path: Path, interleaved: bool) -> None:
    rows = [*drive(), *drive(0.85)]
    if interleaved:
        rows = [one for pair in zip(drive(), drive(0.85), strict=True) for one in pair]
    record = read(tmp_path, text(HEAD, rows))
    assert not record.points
    assert "the shaft turns at two speeds under one torque" in errors(record)[0].what
    assert "direction: {header" in errors(record)[0].remedy


def test_one_noisy_direction_is_no_pair_of_curves(tmp_path: Path) -> None:
    noise = np.random.default_rng(3).normal(1.0, 0.05, 400)
    rows = [(c, round(n * k, 1), m) for (c, n, m), k in zip(drive() * 3, noise, strict=False)]
    assert len(fitted(read(tmp_path, text(HEAD, rows)))) == len(rows)


@pytest.mark.parametrize(
    ("name", "head"),
    [("drive_reverse.csv", HEAD), ("drive.csv", f"Load test in reverse,,\n{HEAD}")],
)
def test_a_heading_or_a_file_name_tells_reverse(tmp_path: Path, name: str, head: str) -> None:
    record = read(tmp_path, text(head, drive()), name)
    assert fitted(record) == [(-code, -speed, -torque) for code, speed, torque in drive()]
    assert any("says reverse and no code" in one.what for one in record.problems)


@pytest.mark.parametrize("name", ["drive_rev_2.csv", "back_to_back.csv"])
def test_a_short_word_in_a_file_name_is_no_direction(tmp_path: Path, name: str) -> None:
    assert fitted(read(tmp_path, text(HEAD, drive()), name)) == drive()


def log(loads: tuple[float, ...], hold_s: float, lag_s: float, period_s: float = 0.1) -> Rows:
    """(time, code, rpm, N m) of loads that are held so long by a drive that lags so much."""
    noise = np.random.default_rng(5).normal(0.0, 1.0, 100_000)
    rows: Rows = []
    speed = 0.0
    for code in CODES:
        for load in loads:
            for _ in range(round(hold_s / period_s)):
                torque = load * 2 * code / 127
                speed += (3000 * code / 127 - 450 * torque - speed) * period_s / lag_s
                shown = round(speed + noise[len(rows)], 2)
                rows.append((round(len(rows) * period_s, 3), code, shown, round(torque, 4)))
    return rows


TIMED = "time s,code,speed rpm,torque N m"


def test_steps_of_a_log_in_time_count_once_where_the_speed_rests(tmp_path: Path) -> None:
    record = read(tmp_path, text(TIMED, log((0.1, 0.4, 0.7, 1.0), hold_s=6.0, lag_s=0.5)))
    points = fitted(record)
    assert len(points) == 12
    for code, speed, torque in points:
        assert speed == pytest.approx(3000 * code / 127 - 450 * torque, abs=0.006 * speed)
    assert any("12 steps of about 60 rows" in one.what for one in record.problems)


@pytest.mark.parametrize(("lag_s", "is_read"), [(0.0, True), (1.0, True), (3.0, False)])
@pytest.mark.parametrize("has_times", [True, False])
def test_a_speed_that_is_written_late(
    lag_s: float, is_read: bool, has_times: bool, tmp_path: Path
) -> None:
    """A step still ends in its own speed where the delay is short, and in that of another else."""
    rows = np.array(log((0.1, 0.4, 0.7, 1.0), hold_s=4.0, lag_s=0.1))
    late = round(lag_s / 0.1)
    rows[late:, 2] = rows[: len(rows) - late, 2].copy()
    rows[:late, 2] = rows[0, 2]
    head, shown = (TIMED, rows) if has_times else (TIMED.partition(",")[2], rows[:, 1:])
    record = read(tmp_path, text(head, [tuple(one) for one in shown.tolist()]))
    points = fitted(record)
    assert bool(points) == is_read
    assert is_read or "follows its command only after 30 rows" in errors(record)[0].what
    for code, speed, torque in points if has_times or late else []:
        assert speed == pytest.approx(3000 * code / 127 - 450 * torque, abs=0.02 * speed)


def test_a_slow_ramp_of_the_load_is_read_row_by_row(tmp_path: Path) -> None:
    ramp = tuple(np.linspace(0.0, 1.0, 250))
    points = fitted(read(tmp_path, text(TIMED, log(ramp, hold_s=0.1, lag_s=0.3))))
    assert len(points) > 500
    for code, speed, torque in points:
        assert speed == pytest.approx(3000 * code / 127 - 450 * torque, abs=0.015 * speed + 5)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (log((0.1, 0.4, 0.7, 1.0), hold_s=1.0, lag_s=0.9), "speed still moves"),
        (
            log(tuple(np.linspace(0, 1, 60)), hold_s=0.02, lag_s=0.4, period_s=0.02),
            "after 7.5 rows",
        ),
        ([(0.05 * k, k // 2, 20.0 * k, 0.001 * k) for k in range(250)], "command never rests"),
    ],
)
def test_a_log_that_never_settles_is_refused(tmp_path: Path, rows: Rows, says: str) -> None:
    record = read(tmp_path, text(TIMED, rows))
    assert not record.points
    assert says in errors(record)[0].what


def pulses(half_range_us: float) -> Rows:
    return [
        (round(1500 + side * half_range_us * code / 127), side * speed, side * torque)
        for side in (1, -1)
        for code, speed, torque in drive()
    ]


def test_pulse_widths_of_a_load_test_beyond_the_assumed_range_are_refused(tmp_path: Path) -> None:
    record = read(tmp_path, text("pwm us,speed rpm,torque N m", pulses(500)))
    assert not record.points
    assert "half_range_us: 500" in errors(record)[0].remedy


@pytest.mark.parametrize("kind", ["load_test", "mooring"])
@pytest.mark.parametrize(("said", "runs"), [("1000-2000", 400.0), ("1100-1900", 500.0)])
def test_a_heading_that_states_another_range_than_is_taken_is_refused(
    tmp_path: Path, kind: str, said: str, runs: float
) -> None:
    if kind == "load_test":
        content = text(f"PWM ({said}) us,speed rpm,torque N m", pulses(runs))
        record: LoadTestRecord | MooringRecord = read(tmp_path, content)
    else:
        rows = [(width, 1e-5 * speed * abs(speed)) for width, speed, _ in pulses(runs)]
        path = tmp_path / "trial" / "mooring" / "run.csv"
        path.parent.mkdir(parents=True)
        path.write_text(text(f"PWM ({said}) us,thrust N", rows), encoding="utf-8")
        record = read_mooring_tables([path], vehicle(), tmp_path)
    assert not record.points
    assert "pwm_range" in errors(record)[0].remedy


def test_pulse_widths_far_within_the_stated_range_are_told(tmp_path: Path) -> None:
    content = text("pwm us,speed rpm,torque N m", pulses(400))
    record = read(tmp_path, content, neutral_us=1500.0, half_range_us=500.0)
    told = [one for one in record.problems if "end far within the range" in one.what]
    assert [one.severity for one in told] == ["warning"]
    assert max(code for code, _, _ in fitted(record)) == pytest.approx(101.6)


def test_a_code_of_few_different_torques_is_read(tmp_path: Path) -> None:
    """Two torques by turns tell no polynomial of second degree."""
    rows = [(60, 264.0, 0.154), (60, 192.0, 0.103)] * 12
    assert len(read(tmp_path, text(HEAD, rows)).points) == len(rows)


def with_power(rows: Rows, unit: float, efficiency: float = 0.6) -> str:
    """The same drive with supply beside it; the torque in a unit that its head does not name."""
    lines = [
        (code, rpm, torque / unit, 24.0, round(torque * rpm * np.pi / 30.0 / efficiency / 24.0, 4))
        for code, rpm, torque in rows
    ]
    return text("code,speed rpm,torque N m,voltage V,current A", lines)


@pytest.mark.parametrize(("unit", "told"), [(1.0, False), (10.2, True), (100.0, True)])
def test_a_torque_that_makes_no_power(unit: float, told: bool, tmp_path: Path) -> None:
    said = [one.what for one in read(tmp_path, with_power(drive(), unit)).problems]
    assert any("2 pi n M over the power taken is" in one for one in said) == told


def test_zeros_where_no_torque_was_written_are_left_out(tmp_path: Path) -> None:
    rows = drive()
    for at in (3, 9, 14):
        rows[at] = (*rows[at][:2], 0.0)
    record = read(tmp_path, text(HEAD, rows))
    assert len(fitted(record)) == len(rows) - 3
    assert any("the torque is 0 in rows 5, 11, 16" in one.what for one in record.problems)


def test_a_shaft_without_load_is_a_reading(tmp_path: Path) -> None:
    rows = [(code, 3000 * code / 127, 0.0) for code in CODES]
    record = read(tmp_path, text(HEAD, [*rows, *drive()]))
    assert len(fitted(record)) == len(rows) + len(drive())


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (2.0, True), (0.5, True)])
def test_a_speed_of_advance_that_the_pitch_does_not_know(
    factor: float, told: bool, tmp_path: Path
) -> None:
    known = vehicle().model_dump()
    known["propellers"] = {
        name: {**one, "diameter_m": 0.14, "pitch_ratio": 0.6}
        for name, one in known["propellers"].items()
    }
    advance = np.linspace(0.0, 0.66, 12)
    rows = [(20.0 * 60.0, factor * 20.0 * 0.14 * j, 998.0 * 400.0 * 0.14**4 * (0.3 - 0.44 * j))
            for j in advance.tolist()]  # fmt: skip
    path = tmp_path / "trial" / "open_water" / "tank.csv"
    path.parent.mkdir(parents=True)
    path.write_text(text("rpm,speed m/s,thrust N", rows))
    record = read_open_water([path], Vehicle.model_validate(known), tmp_path)
    assert any("a screw of pitch ratio" in one.what for one in record.problems) == told
