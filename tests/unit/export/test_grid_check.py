"""What the export refuses, each with a message that names the number."""

import firmware_cases
import pytest
from firmware_cases import CASES, table2
from hypothesis import given

from pipeline.errors import CannotComputeError
from pipeline.export.c_text import single_tables
from pipeline.export.fixed_point import fixed_tables
from pipeline.export.grid_check import check_characteristic
from pipeline.records.fits import FirmwareCharacteristic


@pytest.mark.parametrize("case", CASES)
def test_sound_characteristics_pass(case: str) -> None:
    check_characteristic(CASES[case]())


@firmware_cases.unhurried
@given(firmware_cases.characteristics())
def test_the_strategy_makes_sound_characteristics(characteristic: FirmwareCharacteristic) -> None:
    check_characteristic(characteristic)


def changed(**branch: object) -> FirmwareCharacteristic:
    """Table 2 with members of its positive branch replaced."""
    sound = table2()
    return sound.model_copy(update={"positive": sound.positive.model_copy(update=branch)})


def row_changed(index: int, code: float) -> FirmwareCharacteristic:
    rows = [list(row) for row in table2().positive.code]
    rows[3][index] = code
    return changed(code=tuple(map(tuple, rows)))


@pytest.mark.parametrize(
    ("characteristic", "message"),
    [
        (table2().model_copy(update={"code_max": 40000}), "largest code is 40000"),
        (table2().model_copy(update={"code_max": 0}), "largest code is 0"),
        (table2().model_copy(update={"code_min": -40000}), "most negative code is -40000"),
        (table2().model_copy(update={"code_min": 1}), "most negative code is 1"),
        (table2().model_copy(update={"thrust_dead_n": -0.1}), "dead zone is -0.1 N"),
        (changed(sign=-1), "positive branch has sign -1"),
        (changed(thrust_max_n=(1.0, 2.0)), "2 largest thrusts"),
        (changed(fraction=(0.0, 1.0)), "2 fractions"),
        (changed(speed_mps=(0.0, 0.5, 0.5, 1, 2, 3, 4, 5, 6)), "speeds of the positive branch"),
        (changed(fraction=tuple(i / 33 for i in range(33))), "fractions of the positive branch"),
        (changed(thrust_max_n=(42.0, 40, 38, 36, 34, 32, 30, 27, 0.0)), "at 2.0 m/s is 0.0 N"),
        (changed(thrust_max_n=(4e4, 40, 38, 36, 34, 32, 30, 27, 1.0)), "at 0.0 m/s is 40000.0 N"),
        (row_changed(5, 1.0), "at 0.75 m/s do not rise everywhere"),
        (row_changed(0, -0.5), "run from -0.5"),
        (row_changed(32, 127.5), "to 127.5"),
    ],
)
def test_unsound_characteristics_are_refused(
    characteristic: FirmwareCharacteristic, message: str
) -> None:
    with pytest.raises(CannotComputeError, match=message):
        check_characteristic(characteristic)


def test_rounding_at_the_ends_of_the_range_does_no_harm() -> None:
    """A fit may end at 127 and a last bit: the tables end at 127."""
    characteristic = row_changed(32, 127.00000000000003)
    check_characteristic(characteristic)
    assert fixed_tables(characteristic).positive.code_q16.max() == 127 * 65536
    assert single_tables(characteristic).positive.code.max() == 127
