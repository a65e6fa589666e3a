"""Tables whose words or numbers mean something else than they seem to: read so, or refused."""

from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import vehicle, write_workbook

from pipeline.stages.bench_records import READERS
from pipeline.stages.job import RawRecord

SHARE = np.linspace(-1.0, 1.0, 21)
THRUST = 40.0 * np.sign(SHARE) * np.clip((np.abs(SHARE) - 0.06) / 0.94, 0.0, None) ** 1.8
CODE = np.round(127.0 * SHARE)
ADVANCE = np.linspace(0.0, 0.7, 8)
K_T, K_Q = 0.4 * (1 - ADVANCE / 0.95), 0.044 - 0.03 * ADVANCE


def read(tmp_path: Path, kind: str, head: str, *columns: object) -> RawRecord:
    rows = zip(*(np.asarray(one, object) for one in columns), strict=True)
    table = [[*head.split(";")], *map(list, rows)]
    path = write_workbook(tmp_path / kind / "a.xlsx", {"Data": table})
    return READERS[kind]([path], vehicle(), tmp_path)


def errors(record: RawRecord) -> str:
    return "\n".join(
        f"{one.what} {one.remedy}" for one in record.problems if one.severity == "error"
    )


@pytest.mark.parametrize("neutral", [1500.0, 1480.0, 1520.0])
@pytest.mark.parametrize("astern", [0.7, 1.0, 1.2])
def test_pulses_that_rest_at_another_width(neutral: float, astern: float, tmp_path: Path) -> None:
    thrust = THRUST * np.where(SHARE < 0.0, astern, 1.0)
    record = read(tmp_path, "mooring", "PWM (us);Thrust (N)", neutral + 380.0 * SHARE, thrust)
    told = f"pwm_range: {{neutral_us: {neutral:g}, half_range_us: 380}}"
    assert (told in errors(record)) == (neutral != 1500.0)
    assert bool(record.points) == (neutral == 1500.0)


@pytest.mark.parametrize("first", [1100.0, 1140.0, 1200.0])
def test_a_test_that_ends_early_on_one_side_rests_where_assumed(
    first: float, tmp_path: Path
) -> None:
    pulses = np.arange(first, 1901.0, 20.0)
    thrust = np.interp((pulses - 1500.0) / 400.0, SHARE, THRUST)
    assert read(tmp_path, "mooring", "PWM (us);Thrust (N)", pulses, thrust).points


@pytest.mark.parametrize(
    ("head", "others"),
    [
        ("Code;Expected thrust (N);Measured (N)", (1.2 * THRUST,)),
        ("Code;Schub Soll (N);Schub Ist (N)", (np.round(THRUST / 3.0) * 3.0 + 2.0,)),
        ("Code;Écart-type (N);Poussée moyenne (N)", (0.1 + 0.01 * np.abs(THRUST),)),
        ("Code;Estimated thrust (N);Actual thrust (N)", (1.1 * THRUST,)),
        ("Code;T fit (N);Residual (N);T meas (N)", (1.15 * THRUST, 0.15 * THRUST)),
    ],
)
def test_what_was_measured_goes_before_what_was_wanted(
    head: str, others: tuple[object, ...], tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", head, CODE, *others, THRUST)
    assert [one.thrust_n for one in record.points] == pytest.approx(THRUST)


def test_two_columns_of_which_one_says_that_it_was_measured(tmp_path: Path) -> None:
    record = read(
        tmp_path, "mooring", "Code;Thrust (N);Measured (N)", CODE, THRUST + CODE / 9.0, THRUST
    )
    assert "thrust may be B" in errors(record)


@pytest.mark.parametrize("worth", [9.80665, 4.448])
def test_a_unit_that_changes_among_the_rows(worth: float, tmp_path: Path) -> None:
    mixed = np.where(np.arange(21) > 14, THRUST / worth, THRUST)
    record = read(tmp_path, "mooring", "Code;Thrust (N)", CODE, mixed)
    assert "grows on from there" in errors(record)


@pytest.mark.parametrize("slip", [3.0, 100.0])
def test_one_bad_reading_is_told_and_is_no_other_unit(slip: float, tmp_path: Path) -> None:
    thrust = np.where(np.arange(21) == 16, slip, THRUST)
    record = read(tmp_path, "mooring", "Code;Thrust (N)", CODE, thrust)
    assert len(record.points) == 21
    assert f"thrust is {slip:g} N at code 76" in str([one.what for one in record.problems])


@pytest.mark.parametrize(("share", "severity"), [(0.4, ""), (0.2248, "warning"), (0.102, "error")])
def test_thrust_of_one_direction_in_another_unit(
    share: float, severity: str, tmp_path: Path
) -> None:
    thrust = np.where(CODE < 0.0, share, 1.0) * THRUST
    record = read(tmp_path, "mooring", "Code;Thrust (N)", CODE, thrust)
    told = [one.severity for one in record.problems if "in another unit" in one.what]
    assert told == [severity] * bool(severity)
    assert bool(record.points) is (severity != "error")


@pytest.mark.parametrize("short", [0.3, 1.0])
def test_a_direction_that_was_tested_up_to_part_of_full_command(
    short: float, tmp_path: Path
) -> None:
    kept = -127.0 * short <= CODE
    record = read(tmp_path, "mooring", "Code;Thrust (N)", CODE[kept], THRUST[kept])
    assert not [one for one in record.problems if "in another unit" in one.what]


@pytest.mark.parametrize(
    ("code", "of_speed", "of_torque", "told"),
    [
        (90.0, 1.0, 100.0, "code 90 the torque is 100 times"),
        (60.0, 1.0 / 60.0, 1.0, "code 60 the shaft speed is 0.016"),
        (127.0, 1.0, 0.102, "code 127 the torque is 0.10"),
        (40.0, 0.1, 1.0, ""),
    ],
)
def test_one_code_in_another_unit(
    code: float, of_speed: float, of_torque: float, told: str, tmp_path: Path
) -> None:
    """At the least code a drive may hardly turn."""
    codes = np.repeat([40.0, 60.0, 90.0, 127.0], 6)
    torque = codes / 64.0 * np.tile(np.linspace(0.05, 1.0, 6), 4)
    speed = 3000.0 * codes / 127.0 - 450.0 * torque
    here = codes == code
    columns = np.where(here, of_speed, 1.0) * speed, np.where(here, of_torque, 1.0) * torque
    record = read(tmp_path, "load_test", "Code;Speed (rpm);Torque (N m)", codes, *columns)
    said = [one.what for one in record.problems if "by all other codes" in one.what]
    assert bool(said) is bool(told)
    assert told in "".join(said)


@pytest.mark.parametrize(
    ("head", "share"),
    [("Throttle [‰];Thrust (N)", 1000.0), ("Gaz (%);Poussée (N)", 100.0),
     ("Aussteuerung [Prozent];Schub [N]", 100.0)],
)  # fmt: skip
def test_shares_in_other_words(head: str, share: float, tmp_path: Path) -> None:
    record = read(tmp_path, "mooring", head, share * SHARE, THRUST)
    assert [one.code for one in record.points] == pytest.approx(list(127.0 * SHARE))


@pytest.mark.parametrize(
    "head",
    [
        "Fortschrittsziffer J;Schubbeiwert KT;Momentenbeiwert 10KQ",
        "Advance coefficient J;Thrust coefficient KT;Torque coefficient 10KQ",
        "Advance ratio;Thrust coeff;10KQ",
    ],
)
def test_coefficients_in_words_and_letters(head: str, tmp_path: Path) -> None:
    record = read(tmp_path, "open_water", head, ADVANCE, K_T, 10.0 * K_Q)
    assert [one.thrust_coefficient for one in record.points] == pytest.approx(K_T)
    assert [one.torque_coefficient for one in record.points] == pytest.approx(K_Q)
