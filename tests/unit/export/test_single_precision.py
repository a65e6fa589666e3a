"""The model of the floating-point firmware against the double-precision reference."""

import firmware_cases
import numpy as np
import pytest
import single_model as single_precision
from firmware_cases import CASES, reference_code, reference_thrust
from hypothesis import given
from hypothesis import strategies as st

from pipeline.export.self_test import tolerances
from pipeline.records.fits import FirmwareCharacteristic

THRUSTS = st.one_of(
    st.floats(width=32, allow_nan=False), st.floats(-250, 250, width=32), st.floats(-2, 2, width=32)
)
SPEEDS = st.one_of(st.floats(width=32, allow_nan=False), st.floats(-4, 4, width=32))


@pytest.mark.parametrize("case", CASES)
def test_single_precision_is_the_reference_but_for_rounding(case: str) -> None:
    characteristic = CASES[case]()
    tables = single_precision.single_tables(characteristic)
    limits = tolerances(characteristic)
    largest = 1.1 * max(characteristic.positive.thrust_max_n)
    thrust = np.linspace(-largest, largest, 801).astype(np.float32)
    code = np.unique(np.linspace(-characteristic.code_max, characteristic.code_max, 801, dtype=int))
    for speed in np.linspace(-2.5, 2.5, 101).astype(np.float32):
        got = single_precision.code_from_thrust(tables, thrust, speed)
        wanted = reference_code(characteristic, thrust.astype(float), float(speed))
        assert np.abs(got - wanted).max() <= 0.5 + limits.code_single
        thrust_n = single_precision.thrust_from_code(tables, code, speed)
        assert thrust_n.dtype == np.float32
        wanted_n = reference_thrust(characteristic, code, float(speed))
        assert np.abs(thrust_n - wanted_n).max() <= limits.thrust_single_n


@firmware_cases.unhurried
@given(firmware_cases.characteristics(), st.lists(THRUSTS, min_size=1, max_size=40), SPEEDS)
def test_code_never_falls_with_thrust_and_stays_in_range(
    characteristic: FirmwareCharacteristic, thrusts: list[float], speed: float
) -> None:
    """Also between neighbouring floats, where rounding would show."""
    tables = single_precision.single_tables(characteristic)
    chosen = np.array(thrusts, np.float32)
    with np.errstate(over="ignore", under="ignore"):
        above = np.nextafter(chosen, np.float32(np.inf))
    thrust = np.unique(np.concatenate((chosen, above)))
    codes = single_precision.code_from_thrust(tables, thrust, speed)
    assert (np.diff(codes) >= 0).all()
    assert codes.max() <= characteristic.code_max
    assert codes.min() >= characteristic.code_min


@firmware_cases.unhurried
@given(firmware_cases.characteristics(), SPEEDS)
def test_thrust_never_falls_with_code_and_stays_in_range(
    characteristic: FirmwareCharacteristic, speed: float
) -> None:
    tables = single_precision.single_tables(characteristic)
    code = np.unique(np.linspace(-(2**15), 2**15 - 1, 300).astype(int) // 16)
    thrust = single_precision.thrust_from_code(tables, code, speed)
    assert (np.diff(thrust) >= 0).all()
    # against the motion the limits promise less than the row at rest gives
    if speed >= 0:
        assert thrust.max() <= single_precision.thrust_limit(tables, speed, sign=1)
    if speed <= 0:
        assert thrust.min() >= single_precision.thrust_limit(tables, speed, sign=-1)


def test_what_is_not_a_number_gives_nothing() -> None:
    tables = single_precision.single_tables(CASES["table2"]())
    nan = float("nan")
    assert single_precision.code_from_thrust(tables, nan, 0.0) == 0
    assert single_precision.code_from_thrust(tables, 20.0, nan) == 0
    assert single_precision.thrust_from_code(tables, 100, nan) == 0
    assert single_precision.thrust_limit(tables, nan, sign=1) == 0
    assert single_precision.code_from_thrust(tables, float("inf"), float("inf")) == 127
    assert single_precision.code_from_thrust(tables, float("-inf"), 0.0) == -127


def test_dead_zone_is_rounded_towards_more_thrust() -> None:
    """0.3 is no float: the float below it must not ask for thrust, the one above must."""
    tables = single_precision.single_tables(CASES["bench_only"]())
    assert (
        float(tables.thrust_dead_n)
        <= 0.3
        < float(np.nextafter(tables.thrust_dead_n, np.float32(1)))
    )
    assert single_precision.code_from_thrust(tables, tables.thrust_dead_n, 0.0) == 0
    assert single_precision.code_from_thrust(tables, np.float32(0.30000001), 0.0) > 0


def test_the_ends_of_int16_give_the_limits() -> None:
    """-32768 has no positive twin among the int16."""
    tables = single_precision.single_tables(CASES["table2"]())
    for end, sign in ((-(2**15), -1), (2**15 - 1, 1)):
        thrust = single_precision.thrust_from_code(tables, end, sign * 0.5)
        assert thrust == single_precision.thrust_limit(tables, sign * 0.5, sign=sign)


def test_against_the_motion_no_more_is_promised_than_along_it() -> None:
    """Kostenko's thruster at 2 m/s: 25.4 N ahead, and in reverse as much and not the 42 of rest."""
    tables = single_precision.single_tables(CASES["table2"]())
    ahead = single_precision.thrust_limit(tables, 2.0, sign=1)
    back = single_precision.thrust_limit(tables, 2.0, sign=-1)
    assert ahead == pytest.approx(25.40, abs=0.01)
    assert back == single_precision.thrust_from_code(tables, -127, -2.0)
    assert -ahead <= back < -0.9 * ahead


def test_a_propeller_slower_than_the_water_drags() -> None:
    """Free at code 0, nothing at the edge of the dead zone, and against the motion never less."""
    rest = CASES["table2"]()
    drag = tuple(0.85 * v**2 for v in rest.positive.speed_mps)
    tables = single_precision.single_tables(
        rest.model_copy(
            update={
                side: getattr(rest, side).model_copy(update={"drag_n": drag})
                for side in ("positive", "negative")
            }
        )
    )
    thrust = single_precision.thrust_from_code(tables, np.arange(-127, 128), 2.0)
    assert thrust[127] == pytest.approx(-3.4, abs=1e-5)
    assert thrust[127 + 29] == pytest.approx(-3.4 / 2, abs=0.01)  # the edge is at 58.1
    assert (np.diff(thrust) >= 0).all()
    assert single_precision.thrust_from_code(tables, 5, -2.0) == -thrust[127]
    assert single_precision.thrust_from_code(tables, 100, -2.0) > 27


@pytest.mark.parametrize("case", ["weak_reverse", "forward_only"])
def test_codes_end_where_the_drive_does(case: str) -> None:
    tables = single_precision.single_tables(CASES[case]())
    end = tables.code_min
    limit = single_precision.thrust_limit(tables, 0.0, sign=-1)
    assert single_precision.code_from_thrust(tables, -1e9, 0.0) == end
    assert single_precision.thrust_from_code(tables, -(2**15), 0.0) == limit
    assert single_precision.thrust_from_code(tables, end, 0.0) == limit
    assert (limit < 0) == (end < 0)
