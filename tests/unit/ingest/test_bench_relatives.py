"""Tables that read well and say, somewhere beside the numbers, that they mean something else."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import vehicle, write_workbook

from pipeline.stages.bench_records import READERS
from pipeline.stages.job import RawRecord

SHARE = np.linspace(-1.0, 1.0, 21)
CODE = np.round(127.0 * SHARE)
THRUST = 40.0 * np.sign(SHARE) * np.clip((np.abs(SHARE) - 0.06) / 0.94, 0.0, None) ** 1.8
CODES = np.repeat([40.0, 60.0, 90.0, 127.0], 6)
TORQUE = CODES / 64.0 * np.tile(np.linspace(0.05, 1.0, 6), 4)
SPEED = 3000.0 * CODES / 127.0 - 450.0 * TORQUE
ADVANCE = np.linspace(0.0, 0.7, 8)
K_T = 0.4 * (1 - ADVANCE / 0.95)
Rows = list[list[object]]


def rows_of(head: str, *columns: object) -> Rows:
    rows = zip(*(np.asarray(one, object) for one in columns), strict=True)
    return [[*head.split(";")], *map(list, rows)]


def read(tmp_path: Path, kind: str, rows: Rows, sheet: str = "Data") -> RawRecord:
    path = write_workbook(tmp_path / kind / "a.xlsx", {sheet: rows})
    return READERS[kind]([path], vehicle(), tmp_path)


def said(record: RawRecord, severity: str) -> str:
    return "\n".join(one.what for one in record.problems if one.severity == severity)


@pytest.mark.parametrize(
    ("title", "sheet"),
    [
        ("Force in kg, time in s", "Data"),
        ("Values in lbf", "Data"),
        ("Thrust [gf] over the code", "Data"),
        ("Упор в кгс", "Data"),
        ("", "lbf"),
        ("", "Thrust kgf"),
    ],
)
def test_a_unit_beside_the_table_contradicts_its_names(
    title: str, sheet: str, tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", [[title], *rows_of("Code;Thrust (N)", CODE, THRUST)], sheet)
    assert "it states N, " in said(record, "error")
    assert not record.points


@pytest.mark.parametrize(
    ("title", "sheet"),
    [("Thrust in N, test 3 at 16 V, range 500 kgf", "A"), ("Thruster A, tank N, 20 kg", "N")],
)
def test_a_size_or_a_letter_beside_the_table_is_no_unit(
    title: str, sheet: str, tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", [[title], *rows_of("Code;Thrust (N)", CODE, THRUST)], sheet)
    assert len(record.points) == CODE.size
    assert not said(record, "warning")


@pytest.mark.parametrize("sheet", ["KT", "Run KT", "Min"])
def test_what_a_sheet_shows_is_no_unit_of_speed(sheet: str, tmp_path: Path) -> None:
    head, rps = "Time (s);V (m/s);n (rps);T (N)", np.full(8, 10.0)
    columns = (ADVANCE, ADVANCE * 1.4, rps, K_T * 1000 * 100 * 0.14**4)
    record = read(tmp_path, "open_water", rows_of(head, *columns), sheet)
    assert len(record.points) == 8
    assert not said(record, "warning")


@pytest.mark.parametrize(
    ("title", "beside"),
    [
        ("Load cell at 0.6 m, thruster at 0.3 m from the hinge", "Run"),
        ("Force over a double pulley", "Run"),
        ("Pair of thrusters", "Run"),
        ("Thrust of the pair", "Run"),
        ("Bras de levier 0,6 m", "Run"),
        ("2 thrusters on the frame", "Run"),
        ("Balance beam 2:1", "Run"),
        ("L1 = 0.5 m, L2 = 1.0 m", "Run"),
        ("Rig factor 2", "Run"),
        ("Force x2", "Run"),
        ("True thrust = 2 x reading", "Run"),
        ("", "L1 (m)"),
        ("", "Lever arm (m)"),
        ("", "Плечо, м"),
    ],
)
def test_a_lever_or_a_second_thruster_is_asked_for(title: str, beside: str, tmp_path: Path) -> None:
    rows = rows_of(f"Code;Force (N);{beside}", CODE, THRUST, np.full(21, 0.6))
    assert "scale: ..." in str([one.remedy for one in _errors(tmp_path, "mooring", title, rows)])


@pytest.mark.parametrize("title", ["Gear ratio 3:1, speed of the motor", "Редуктор 1:3"])
def test_a_gear_is_asked_for(title: str, tmp_path: Path) -> None:
    rows = rows_of("Code;Speed (rpm);Torque (N m)", CODES, SPEED, TORQUE)
    remedies = str([one.remedy for one in _errors(tmp_path, "load_test", title, rows)])
    assert "shaft_speed: {header" in remedies
    assert "torque: {header" in remedies


def test_a_number_of_poles_is_told(tmp_path: Path) -> None:
    rows = rows_of("Code;Speed (rpm);Torque (N m)", CODES, SPEED, TORQUE)
    record = read(tmp_path, "load_test", [["Direct drive, 14 poles"], *rows])
    assert len(record.points) == CODES.size
    assert "speaks of poles" in said(record, "warning")


def _errors(tmp_path: Path, kind: str, title: str, rows: Rows) -> list[object]:
    record = read(tmp_path, kind, [[title], *rows])
    assert not record.points
    return [one for one in record.problems if one.severity == "error"]


@pytest.mark.parametrize("summed_up", [np.mean, np.std, np.sum])
def test_a_row_that_sums_up_those_above_by_no_known_word(
    summed_up: Callable[[object], float], tmp_path: Path
) -> None:
    code, thrust = CODE[10:], THRUST[10:]
    rows = rows_of("Code;Thrust (N)", code, thrust)
    rows.append([float(summed_up(code)), float(summed_up(thrust)), "Mittelwert"])
    record = read(tmp_path, "mooring", rows)
    assert [one.code for one in record.points if not one.marks] == [*code[1:]]
    assert "1 row of means, spreads or sums" in said(record, "warning")


def test_a_last_reading_at_rest_sums_up_nothing(tmp_path: Path) -> None:
    """Readings ahead and astern that are alike have a mean of next to nothing, too."""
    rows = rows_of("Code;Thrust (N)", [*CODE, 0.0], [*THRUST, 0.0])
    assert not said(read(tmp_path, "mooring", rows), "warning")


def test_what_has_an_offset_is_not_the_sum(tmp_path: Path) -> None:
    columns = (CODES, SPEED, TORQUE + 0.3, np.full(24, 0.3), TORQUE)
    head = "Code;Speed (rpm);Torque raw (Nm);Torque zero (Nm);Torque net (Nm)"
    record = read(tmp_path, "load_test", rows_of(head, *columns))
    assert [one.torque_nm for one in record.points] == pytest.approx(TORQUE)


@pytest.mark.parametrize(
    ("head", "factors", "why"),
    [
        ("J;KT", (-1.0, 1.0), "grows with J"),
        ("J;KT", (1.0, -1.0), "negative throughout"),
        ("J;KT", (1.0 / 7.0, 1.0 / 49.0), "a screw has 0.1 to 0.8"),
    ],
)
def test_what_no_propeller_does_in_open_water(
    head: str, factors: tuple[float, float], why: str, tmp_path: Path
) -> None:
    rows = rows_of(head, factors[0] * ADVANCE, factors[1] * K_T)
    record = read(tmp_path, "open_water", rows)
    assert why in said(record, "error")
    assert not record.points


def test_a_torque_made_of_the_current_is_told(tmp_path: Path) -> None:
    head = "Code;Speed (rpm);Torque (N m);Current (A)"
    record = read(tmp_path, "load_test", rows_of(head, CODES, SPEED, TORQUE, TORQUE / 0.05))
    assert "computed from the current" in said(record, "warning")


def test_a_one_way_controller_of_a_load_test(tmp_path: Path) -> None:
    pulses = 1100.0 + 800.0 * CODES / 127.0
    rows = rows_of("PWM (us);Speed (rpm);Torque (N m)", pulses, SPEED, TORQUE)
    record = read(tmp_path, "load_test", rows)
    assert "taken for neutral" in said(record, "error")
    assert not record.points


def test_a_command_over_microseconds(tmp_path: Path) -> None:
    rows = rows_of("Command;Thrust", 1500 + 400 * SHARE, THRUST)
    record = read(tmp_path, "mooring", [rows[0], ["us", "N"], *rows[1:]])
    assert [one.code for one in record.points] == pytest.approx(127 * SHARE)


@pytest.mark.parametrize(("end", "told"), [(100.0, True), (50.0, True), (110.0, False)])
def test_codes_that_may_count_to_another_end(end: float, told: bool, tmp_path: Path) -> None:
    record = read(tmp_path, "mooring", rows_of("Code;Thrust (N)", np.round(end * SHARE), THRUST))
    assert (f"the codes end at {end:g}" in said(record, "warning")) is told


def test_sensors_in_front_and_at_the_back_are_no_directions(tmp_path: Path) -> None:
    rows = rows_of("Code;Front force (N);Back force (N)", CODE, 0.3 * THRUST, 0.7 * THRUST)
    assert "thrust may be B" in said(read(tmp_path, "mooring", rows), "error")


@pytest.mark.parametrize(
    ("head", "odd", "usual"), [("Remark", "bad reading", ""), ("Valid", 0, 1), ("OK?", "no", "yes")]
)
def test_rows_that_a_column_sets_apart_are_told(
    head: str, odd: object, usual: object, tmp_path: Path
) -> None:
    marks = [odd if at in {3, 7} else usual for at in range(21)]
    record = read(tmp_path, "mooring", rows_of(f"Code;Thrust (N);{head}", CODE, THRUST, marks))
    assert f'"{head}" says "{odd}" of rows 5, 9' in said(record, "warning")


def test_a_title_that_states_a_flow_is_told(tmp_path: Path) -> None:
    rows = [["Carriage speed 1.0 m/s"], *rows_of("Code;Thrust (N)", CODE, THRUST)]
    assert "states a speed" in said(read(tmp_path, "mooring", rows), "warning")


@pytest.mark.parametrize(
    ("head", "beside", "why"),
    [("Thrust (mN)", "Run", "less than most give"), ("Thrust (kgf)", "Power (W)", "was drawn")],
)
def test_too_little_thrust_for_disc_or_power(
    head: str, beside: str, why: str, tmp_path: Path
) -> None:
    power_w = np.abs(THRUST) ** 1.5 / np.sqrt(2000.0 * np.pi / 4.0 * 0.14**2) / 0.35
    part = 1.0 if head.endswith("(mN)") else 0.01
    rows = rows_of(f"Code;{head};{beside}", CODE, part * THRUST, power_w)
    assert why in said(read(tmp_path, "mooring", rows), "warning")


@pytest.mark.parametrize(("words", "told"), [(("P1", "P2"), True), (("up", "down"), False)])
def test_rows_of_two_propellers_are_told(
    words: tuple[str, str], told: bool, tmp_path: Path
) -> None:
    columns = (np.repeat(words, 21), np.tile(CODE, 2), np.r_[THRUST, 0.97 * THRUST])
    record = read(tmp_path, "mooring", rows_of("Which;Code;Thrust (N)", *columns))
    assert ("may be of several machines" in said(record, "warning")) is told


@pytest.mark.parametrize(
    ("head", "ahead", "astern"),
    [
        ("Richtung", "Vorwärtslauf", "Rückwärtslauf"),
        ("Sens", "Marche avant", "Marche arrière"),
        ("Verso", "avanti", "indietro"),
        ("Mode", "Forward thrust", "Reverse thrust"),
        ("Forward", 1, 0),
        ("Is forward", "TRUE", "FALSE"),
        ("Reverse", 0, 1),
    ],
)
def test_directions_in_phrases_and_truths(
    head: str, ahead: object, astern: object, tmp_path: Path
) -> None:
    words = [astern if code < 0 else ahead for code in CODE]
    rows = rows_of(f"{head};Code;Thrust (N)", words, abs(CODE), abs(THRUST))
    record = read(tmp_path, "mooring", rows)
    assert [one.code for one in record.points] == [*CODE]
    assert [one.thrust_n for one in record.points] == pytest.approx(THRUST)


def test_a_column_that_parts_the_rows_is_named(tmp_path: Path) -> None:
    columns = (np.repeat([1, 2], 21), np.tile(CODE, 2), np.r_[THRUST, 0.7 * THRUST])
    record = read(tmp_path, "mooring", rows_of("Thruster;Code;Thrust (N)", *columns))
    (problem,) = [one for one in record.problems if one.severity == "error"]
    assert 'column "Thruster" parts the rows' in problem.what
    assert 'only: {"Thruster": ...}' in problem.remedy


@pytest.mark.parametrize(("other", "why"), [("N", ""), ("gf", "it states N, its cells gf")])
def test_units_in_the_cells(other: str, why: str, tmp_path: Path) -> None:
    cells = [f"{one:.3f} {other if one > 20.0 else 'N'}" for one in THRUST]
    record = read(tmp_path, "mooring", rows_of("Code;Thrust", CODE, cells))
    if why:
        assert why in said(record, "error")
    else:
        assert [one.thrust_n for one in record.points] == pytest.approx(THRUST, abs=1e-3)


@pytest.mark.parametrize(("stem", "told"), [("pull_lbf", True), ("pull_N", False), ("a", False)])
def test_a_unit_in_the_name_of_the_file_contradicts(stem: str, told: bool, tmp_path: Path) -> None:
    path = tmp_path / "mooring" / f"{stem}.xlsx"
    write_workbook(path, {"Data": rows_of("Code;Thrust (N)", CODE, THRUST)})
    record = READERS["mooring"]([path], vehicle(), tmp_path)
    assert ("it states N, the name of the file lbf" in said(record, "error")) is told


@pytest.mark.parametrize(("factor", "told"), [(0.8, True), (1.0, False)])
def test_propellers_of_two_pitches_in_one_table(factor: float, told: bool, tmp_path: Path) -> None:
    columns = (np.repeat([0.8, 1.0], 8), np.tile(ADVANCE, 2), np.r_[factor * K_T, K_T])
    record = read(tmp_path, "open_water", rows_of("P/D;J;KT", *columns))
    assert ('column "P/D" parts the rows' in said(record, "error")) is told
    assert bool(record.points) is not told


@pytest.mark.parametrize("times", [0.1, 0.0980665, 10.0, 1 / 0.0980665, 100.0])
def test_a_torque_in_another_unit_is_none_of_the_propeller(times: float, tmp_path: Path) -> None:
    """Nothing but the propeller of the vehicle file tells it: no current, no voltage."""
    load = TORQUE * 0.9
    rows = rows_of("Code;Speed (rpm);Torque (N m)", CODES, SPEED, times * load)
    assert "A unit may be wrong" in said(read(tmp_path, "load_test", rows), "warning")
    rows = rows_of("Code;Speed (rpm);Torque (N m)", CODES, SPEED, load)
    assert not said(read(tmp_path / "right", "load_test", rows), "warning")


@pytest.mark.parametrize(
    ("title", "times", "words"),
    [
        ("Drive on 48 V", 10.0, "2 pi n M over the power taken is"),
        ("Drive, KV = 95", 10.0, "a motor of 95 rpm/V gives 0.101"),
        ("Motor 95KV", 0.1, "a motor of 95 rpm/V gives 0.101"),
        ("", 0.03, "2 pi n M over the current [V] is"),
    ],
)
def test_a_current_tells_a_torque_in_another_unit(
    title: str, times: float, words: str, tmp_path: Path
) -> None:
    current = TORQUE / 0.1 + 0.5
    head = "Code;Speed (rpm);Torque (N m);Current (A)"
    for factor in (1.0, times):
        rows = [[title], *rows_of(head, CODES, SPEED, factor * TORQUE, current)]
        told = said(read(tmp_path / f"{factor:g}", "load_test", rows), "warning")
        assert (words in told) == (factor != 1.0)


@pytest.mark.parametrize(
    ("head", "command"),
    [
        ("Код ШИМ;Тяга, Н", CODE),
        ("PWM;Thrust (N)", CODE),
        ("PWM duty;Thrust (N)", SHARE),
        ("Stellgröße;Schub [N]", CODE),
        ("Consigna;Empuje (kgf)", CODE),
        ("Sygnał sterujący;Ciąg [N]", CODE),
        ("控制码;推力(N)", CODE),
        ("Signal;Weight (kg)", CODE),
        ("Co\u200bde;Thrust\uff08N\uff09", CODE),
    ],
)
def test_a_command_in_other_words(head: str, command: object, tmp_path: Path) -> None:
    in_newton = 9.80665 if "kg" in head else 1.0
    record = read(tmp_path, "mooring", rows_of(head, command, THRUST / in_newton))
    assert [one.code for one in record.points] == pytest.approx(list(CODE), abs=0.6)
    assert max(one.thrust_n for one in record.points) == pytest.approx(40.0)


@pytest.mark.parametrize(
    ("head", "columns", "words"),
    [
        ("PWM (us);Thrust (N)", (1500 + 375 * SHARE, THRUST), "end far within the range"),
        ("Code;Thrust (N)", (np.round(127 + 127 * SHARE), THRUST), "rest is not at code 0"),
        ("Code;Thrust (N)", (CODE, THRUST / 9.80665 / 2), "less than most give"),
        ("Code;Thrust (kgf)", (CODE, 2.0 * THRUST), "more than most give"),
    ],
)
def test_what_may_be_another_end_or_unit_is_told(
    head: str, columns: tuple[object, ...], words: str, tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", rows_of(head, *columns))
    assert words in said(record, "warning") + said(record, "error")


@pytest.mark.parametrize(("ahead", "astern"), [("cw", "ccw"), ("f", "r")])
def test_files_that_a_turn_or_a_letter_tells_apart(ahead: str, astern: str, tmp_path: Path) -> None:
    files = []
    for name, keep, sign in ((ahead, CODE >= 0, 1.0), (astern, CODE <= 0, -1.0)):
        rows = rows_of("Code;Thrust (N)", sign * CODE[keep], 0.9 * THRUST[keep] * sign)
        files.append(write_workbook(tmp_path / "mooring" / f"{name}.xlsx", {"Data": rows}))
    record = READERS["mooring"](files, vehicle(), tmp_path)
    assert min(one.thrust_n for one in record.points) == pytest.approx(-36.0)
    assert f'"{astern}" says reverse' in said(record, "warning")


@pytest.mark.parametrize(
    ("diameters", "sign", "words"),
    [(2.0, 1.0, "the speed or the diameter"), (1.0, -1.0, "the sign of the torque sensor")],
)
def test_coefficients_that_no_screw_has(
    diameters: float, sign: float, words: str, tmp_path: Path
) -> None:
    model_m = 0.14 / diameters
    rest = 1000.0 * 10.0**2 * model_m**4
    k_q = 0.1 * K_T + 0.004
    columns = (ADVANCE * 10.0 * model_m, K_T * rest, sign * k_q * rest * model_m)
    rows = rows_of("V (m/s);n (rps);T (N);Q (N m)", columns[0], np.full(8, 10.0), *columns[1:])
    record = read(tmp_path, "open_water", rows)
    assert words in said(record, "warning") + said(record, "error")


def test_a_command_that_stands_in_the_first_of_its_rows(tmp_path: Path) -> None:
    once = [code if at % 6 == 0 else None for at, code in enumerate(CODES)]
    record = read(tmp_path, "load_test", rows_of("Code;rpm;Torque (N m)", once, SPEED, TORQUE))
    assert [one.code for one in record.points] == list(CODES)
    assert not said(record, "warning")


@pytest.mark.parametrize(
    ("of_speed", "of_thrust", "told"),
    [(1.0, 1.0, False), (1 / 0.514444, 1.0, True), (3.6, 1.0, True), (0.01, 1.0, True),
     (1 / 3.6, 1.0, True), (1.0, 8.0 / np.pi, True)],
)  # fmt: skip
def test_thrust_that_ends_where_that_of_no_screw_does(
    of_speed: float, of_thrust: float, told: bool, tmp_path: Path
) -> None:
    """Without a torque and a pitch, K_T near rest and the J of no thrust tell of units."""
    rest = 1000.0 * 10.0**2 * 0.14**4
    columns = (ADVANCE * 10.0 * 0.14 * of_speed, np.full(8, 10.0), K_T * rest * of_thrust)
    record = read(tmp_path, "open_water", rows_of("V (m/s);n (rps);T (N)", *columns))
    assert ("as of no screw" in said(record, "warning")) is told


@pytest.mark.parametrize(
    ("head", "told"),
    [
        ("Code;omega;Torque (N m)", ""),
        ("Code;ω [rad/s];Torque (N m)", ""),
        ("Code;ω [1/s];Torque (N m)", "it states 1/s, its name rad/s"),
        ("Code;ω [rad/s];Torque (N m);i = 3", '"i = 3" speaks of a lever, a gear'),
    ],
)
def test_an_angular_speed_is_in_radians(head: str, told: str, tmp_path: Path) -> None:
    columns = (CODES, SPEED * np.pi / 30.0, TORQUE, CODES)[: head.count(";") + 1]
    record = read(tmp_path, "load_test", rows_of(head, *columns))
    assert told in said(record, "error")
    if not told:
        speeds = [one.shaft_speed_rpm for one in record.points]
        np.testing.assert_allclose(speeds, SPEED, rtol=1e-9)
    assert bool(told) != bool(record.points)


@pytest.mark.parametrize("title", ["Pitch ratio 1.2, power factor 0.9", "Test at 9:30", "Gear 3:1"])
def test_other_ratios_are_no_levers(title: str, tmp_path: Path) -> None:
    record = read(tmp_path, "mooring", [[title], *rows_of("Code;Thrust (N)", CODE, THRUST)])
    assert len(record.points) == CODE.size


@pytest.mark.parametrize(("ahead", "astern"), [(1.0, 0.0), (1.0, 2.0), (0.0, 180.0)])
def test_two_numbers_of_a_direction_are_asked_for(
    ahead: float, astern: float, tmp_path: Path
) -> None:
    sides = np.where(CODE < 0.0, astern, ahead)
    rows = rows_of("Code;Dir;Thrust (N)", np.abs(CODE), sides, np.abs(THRUST))
    record = read(tmp_path, "mooring", rows)
    assert not record.points
    assert "which of them is reverse is not known" in said(record, "error")
    signed = read(tmp_path, "mooring", rows_of("Code;Dir;Thrust (N)", CODE, sides, THRUST))
    assert len(signed.points) == CODE.size
    assert not said(signed, "error")


@pytest.mark.parametrize(("falling", "told"), [(False, True), (True, False)])
def test_thrust_that_is_less_the_second_time(falling: bool, told: bool, tmp_path: Path) -> None:
    """Less thrust on the way back is hysteresis; in a second rising sweep something is another."""
    again = slice(None, None, -1) if falling else slice(None)
    code, thrust = CODE[11:], THRUST[11:]
    rows = rows_of(
        "Code;Thrust (N)",
        [0.0, *code, *code[again]],
        [0.0, *thrust, *0.93 * thrust[again]],
    )
    record = read(tmp_path, "mooring", rows)
    assert ("the second time thrust is 7 % less" in said(record, "warning")) == told


@pytest.mark.parametrize("name", ["Elektrische Drehzahl (1/min)", "Vitesse électrique (tr/min)"])
def test_an_electrical_speed_in_other_languages(name: str, tmp_path: Path) -> None:
    rows = rows_of(f"Code;{name};Torque (N m)", CODES, 7.0 * SPEED, TORQUE)
    assert not read(tmp_path, "load_test", rows).points
