"""The bit-exact model of the fixed-point firmware against the double-precision reference."""

import firmware_cases
import fixed_model
import numpy as np
import pytest
from firmware_cases import CASES, codes_that_return, reference_code, reference_thrust
from hypothesis import given
from hypothesis import strategies as st

from pipeline.export import fixed_point
from pipeline.export.self_test import tolerances
from pipeline.records.fits import FirmwareCharacteristic

ONE = fixed_point.Q16_ONE
INT32 = st.integers(-(2**31), 2**31 - 1)
INT16 = st.integers(-(2**15), 2**15 - 1)
SPEEDS_Q16 = np.rint(np.arange(-2.5, 2.501, 0.05) * ONE).astype(np.int64)[:, None]


def test_known_values_at_knots() -> None:
    """At rest Table 2 gives 42.48 N at code 127 and code 0 for half a newton."""
    tables = fixed_point.fixed_tables(CASES["table2"]())
    largest = fixed_model.thrust_from_code(tables, 127, 0)
    assert largest == round((-4 + 0.254 * 127 + 8.82e-4 * 127**2) * ONE)
    assert fixed_point.code_from_thrust(tables, largest, 0) == 127
    assert fixed_point.code_from_thrust(tables, ONE // 2, 0) == 0
    assert fixed_point.code_from_thrust(tables, ONE // 2 + 1, 0) > 0


@pytest.mark.parametrize("case", CASES)
def test_code_is_within_one_of_the_reference(case: str) -> None:
    characteristic = CASES[case]()
    tables = fixed_point.fixed_tables(characteristic)
    largest = 1.1 * max(characteristic.positive.thrust_max_n)
    thrust = np.rint(np.linspace(-largest, largest, 801) * ONE).astype(np.int64)
    for speed in SPEEDS_Q16:
        got = fixed_point.code_from_thrust(tables, thrust, speed)
        wanted = reference_code(characteristic, thrust / ONE, speed / ONE)
        rounded = np.sign(wanted) * np.floor(np.abs(wanted) + 0.5)
        assert np.abs(got - rounded).max() <= 1
        assert np.abs(got - wanted).max() <= 0.5 + tolerances(characteristic).code_fixed


@pytest.mark.parametrize("case", CASES)
def test_round_trip_outside_the_dead_zone(case: str) -> None:
    """Every code comes back, at every speed, unless its thrust is one that asks for nothing."""
    characteristic = CASES[case]()
    tables = fixed_point.fixed_tables(characteristic)
    codes = codes_that_return(characteristic, 801)
    for speed in SPEEDS_Q16:
        thrust = fixed_model.thrust_from_code(tables, codes, speed)
        back = fixed_point.code_from_thrust(tables, thrust, speed)
        live = np.abs(thrust) > tables.thrust_dead_q16
        assert np.abs(back - codes)[live].max() <= 1
        assert not back[~live].any()


@firmware_cases.unhurried
@given(firmware_cases.characteristics(), st.lists(INT32, min_size=1, max_size=30), INT32)
def test_code_never_falls_with_thrust_and_stays_in_range(
    characteristic: FirmwareCharacteristic, thrusts: list[int], speed: int
) -> None:
    tables = fixed_point.fixed_tables(characteristic)
    # Large arguments saturate, so small ones are tried beside them.
    thrust = np.unique([t // divisor for t in thrusts for divisor in (1, 2**6, 2**9, 2**14)])
    codes = fixed_point.code_from_thrust(tables, thrust, speed)
    assert (np.diff(codes) >= 0).all()
    assert codes.max() <= characteristic.code_max
    assert codes.min() >= characteristic.code_min
    assert (codes * thrust >= 0).all()


@firmware_cases.unhurried
@given(
    firmware_cases.characteristics(),
    st.lists(INT32, min_size=1, max_size=10),
    st.integers(-(2**18), 2**18),
)
def test_code_is_the_reference_but_for_rounding(
    characteristic: FirmwareCharacteristic, thrusts: list[int], speed: int
) -> None:
    tables = fixed_point.fixed_tables(characteristic)
    thrust = np.array([t // divisor for t in thrusts for divisor in (1, 2**6, 2**9, 2**14)])
    got = fixed_point.code_from_thrust(tables, thrust, speed)
    wanted = reference_code(characteristic, thrust / ONE, np.array(speed / ONE))
    assert np.abs(got - wanted).max() <= 0.5 + tolerances(characteristic).code_fixed


@firmware_cases.unhurried
@given(
    firmware_cases.characteristics(),
    st.lists(INT16, min_size=1, max_size=30),
    st.integers(-(2**18), 2**18),
)
def test_thrust_is_the_reference_but_for_rounding(
    characteristic: FirmwareCharacteristic, codes: list[int], speed: int
) -> None:
    tables = fixed_point.fixed_tables(characteristic)
    code = np.unique([c // divisor for c in codes for divisor in (1, 2**4, 2**8)])
    got = fixed_model.thrust_from_code(tables, code, speed)
    wanted = reference_thrust(characteristic, code, np.array(speed / ONE))
    assert (np.diff(got) >= 0).all()
    assert np.abs(got / ONE - wanted).max() <= tolerances(characteristic).thrust_fixed_n
    # against the motion the limits promise less than the row at rest gives
    if speed >= 0:
        assert (got <= fixed_model.thrust_limit(tables, speed, sign=1)).all()
    if speed <= 0:
        assert (got >= fixed_model.thrust_limit(tables, speed, sign=-1)).all()


@firmware_cases.unhurried
@given(firmware_cases.characteristics(), INT32)
def test_extremes_of_the_arguments_give_the_limits(
    characteristic: FirmwareCharacteristic, speed: int
) -> None:
    tables = fixed_point.fixed_tables(characteristic)
    for sign, end in ((1, 2**15 - 1), (-1, -(2**15))):
        along = sign * abs(speed)
        limit = fixed_model.thrust_limit(tables, along, sign=sign)
        assert fixed_model.thrust_from_code(tables, end, along) == limit
        far = fixed_point.code_from_thrust(tables, end * ONE, speed)
        assert far == fixed_point.code_from_thrust(tables, sign * (2**31 - 1), speed)


def test_against_the_motion_the_row_at_rest_holds() -> None:
    tables = fixed_point.fixed_tables(CASES["table2"]())
    thrust = np.arange(-45, 46) * ONE
    at_rest = fixed_point.code_from_thrust(tables, thrust, 0)
    astern = fixed_point.code_from_thrust(tables, thrust, -2 * ONE)
    assert (astern[thrust > 0] == at_rest[thrust > 0]).all()
    assert (astern[thrust < 0] <= at_rest[thrust < 0]).all()
    assert (astern[thrust < 0] < at_rest[thrust < 0]).any()


def test_codes_end_where_the_drive_does() -> None:
    """Table 2 mirrored, a drive that takes -100 to 127: reverse thrust ends with T(-100)."""
    tables = fixed_point.fixed_tables(CASES["weak_reverse"]())
    at_end = fixed_model.thrust_from_code(tables, 100, 0)
    for thrust in (at_end, at_end + ONE, 40 * ONE, 2**31 - 1):
        assert fixed_point.code_from_thrust(tables, -thrust, 0) == -100
    assert fixed_point.code_from_thrust(tables, 2**31 - 1, 0) == 127
    for code in (-100, -101, -127, -(2**15)):
        assert fixed_model.thrust_from_code(tables, code, 0) == -at_end
    assert fixed_model.thrust_limit(tables, 0, sign=-1) == -at_end
    assert at_end / ONE == pytest.approx(-4 + 0.254 * 100 + 8.82e-4 * 1e4, abs=0.01)


def test_drive_without_negative_codes_gives_no_reverse_thrust() -> None:
    tables = fixed_point.fixed_tables(CASES["forward_only"]())
    assert fixed_point.code_from_thrust(tables, -40 * ONE, 0) == 0
    assert fixed_model.thrust_from_code(tables, -127, 0) == 0
    assert fixed_model.thrust_limit(tables, ONE, sign=-1) == 0


def test_more_negative_codes_than_positive_ones() -> None:
    tables = fixed_point.fixed_tables(CASES["strong_reverse"]())
    assert fixed_point.code_from_thrust(tables, -40 * ONE, 0) == -180
    assert fixed_point.code_from_thrust(tables, 40 * ONE, 0) == 100
    assert fixed_model.thrust_limit(tables, 0, sign=-1) / ONE == pytest.approx(-33.2, abs=1e-4)
