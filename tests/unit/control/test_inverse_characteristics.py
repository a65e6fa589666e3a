import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paper_static import StaticTable

from pipeline.control.inverse import (
    CodeRange,
    MooringCubic,
    SpeedCubic,
    firmware_grid,
    mooring_cubic,
    rounded,
    speed_cubic,
)
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic

CODES = CodeRange(0.5, 127)


@pytest.fixture(scope="module")
def moored(paper_inverse: InverseCharacteristic) -> MooringCubic:
    cubic = mooring_cubic(paper_inverse, CODES)
    assert cubic is not None
    return cubic


@pytest.fixture(scope="module")
def cubic(paper_inverse: InverseCharacteristic) -> SpeedCubic:
    return speed_cubic(paper_inverse, CODES)


def test_table_3_by_hand(moored: MooringCubic) -> None:
    """20 N: 12.7 + 86.72 - 28 + 5.832; -20 N: -12.7 - 94.76 + 35.6 - 7.744."""
    np.testing.assert_allclose(moored.code([20.0, -20.0], 0.0), [77.252, -79.604], atol=1e-9)


def test_mooring_inverse_ignores_the_speed(moored: MooringCubic) -> None:
    thrust = np.linspace(-43, 43, 87)
    np.testing.assert_array_equal(moored.code(thrust, 0.0), moored.code(thrust, 2.0))
    assert moored.limits(2.0) == moored.limits(0.0)
    assert moored.limits(0.0).forward_n == 43.0


def test_mooring_inverse_holds_at_its_limit(moored: MooringCubic) -> None:
    """Beyond T_max the cubic would run away; it is held, and codes never pass 127."""
    assert moored.code(200.0, 0.0) == moored.code(43.0, 0.0)
    assert moored.code(43.0, 0.0) == 127.0
    assert moored.code(-43.0, 0.0) == -127.0


@pytest.mark.parametrize("thrust", [0.5, -0.5, 0.0, 0.3])
def test_dead_band_gives_code_zero(
    paper_inverse: InverseCharacteristic, moored: MooringCubic, cubic: SpeedCubic, thrust: float
) -> None:
    for inverse in (moored, cubic, firmware_grid(paper_inverse)):
        assert inverse.code(thrust, 1.0) == 0.0
        assert inverse.code(0.6 * np.sign(thrust or 1.0), 1.0) != 0.0


def test_missing_sign_is_mirrored(paper_inverse: InverseCharacteristic) -> None:
    only = paper_inverse.model_copy(update={"table3_negative": None})
    cubic = mooring_cubic(only, CODES)
    assert cubic is not None
    np.testing.assert_allclose(cubic.code(-20.0, 0.0), -77.252)
    assert "mirrored" in cubic.name
    other = mooring_cubic(paper_inverse.model_copy(update={"table3_positive": None}), CODES)
    assert other is not None
    np.testing.assert_allclose(other.code(20.0, 0.0), 79.604)


def test_no_mooring_data(paper_inverse: InverseCharacteristic) -> None:
    none = paper_inverse.model_copy(update={"table3_negative": None, "table3_positive": None})
    assert mooring_cubic(none, CODES) is None


def test_table_4_by_hand(cubic: SpeedCubic) -> None:
    """20 N at 2 m/s: 60 + 63.4 - 12.4 + 4."""
    np.testing.assert_allclose(cubic.code(20.0, 2.0), 115.0)
    np.testing.assert_allclose(cubic.code(-20.0, -2.0), -115.0)


def test_printed_cubics_agree_at_rest_within_the_gap_of_the_tables(
    moored: MooringCubic, cubic: SpeedCubic
) -> None:
    """Table 3 is the mooring test, Table 4 the calculation: up to about 4 codes apart at rest."""
    thrust = np.linspace(1.0, 42.0, 83)
    gap = np.abs(moored.code(thrust, 0.0) - cubic.code(thrust, 0.0)).max()
    assert 1.0 < gap < 4.0


def test_cubic_equals_its_rows_and_lies_between_them(cubic: SpeedCubic) -> None:
    fraction = np.linspace(0.05, 1.0, 20)
    slow, fast = (cubic.code(fraction * cubic.limits(v).forward_n, v) for v in (1.5, 2.0))
    middle = cubic.code(fraction * cubic.limits(1.75).forward_n, 1.75)
    np.testing.assert_allclose(middle, (slow + fast) / 2)


@given(st.floats(0.0, 2.0))
def test_cubic_rises_with_thrust_between_tabulated_speeds(speed: float) -> None:
    inverse = _printed_cubic()
    thrust = np.linspace(0.51, inverse.limits(speed).forward_n, 60)
    code = inverse.code(thrust, speed)
    below_limit = code < 127.0
    assert (np.diff(code)[below_limit[1:]] > 0.0).all()


@given(st.floats(0.6, 24.8))
def test_code_for_one_thrust_rises_with_the_speed(thrust: float) -> None:
    """Also between the tabulated speeds, though the printed coefficients are not monotone."""
    code = _printed_cubic().code(np.full(41, thrust), np.linspace(0.0, 2.0, 41))
    assert (np.diff(code) > 0.0).all()


@pytest.mark.parametrize("speed", [0.25, 0.75, 1.25, 1.75])
def test_interpolating_codes_or_coefficients_is_equally_exact(
    speed: float, table2: StaticTable
) -> None:
    """With the printed table the choice is one of safety, not of accuracy."""
    inverse = _printed_cubic()
    thrust = np.linspace(0.6, inverse.limits(speed).forward_n, 200)
    row = [np.interp(speed, inverse.speed_mps, column) for column in inverse.coefficients.T]
    at_equal_thrust = np.clip(np.polynomial.polynomial.polyval(thrust, row), 0.0, 127.0)
    chosen, other = (
        np.abs(table2.thrust_n(code, speed) - thrust).max()
        for code in (inverse.code(thrust, speed), at_equal_thrust)
    )
    assert chosen < 0.76
    assert abs(chosen - other) < 0.07


def _printed_cubic() -> SpeedCubic:
    return SpeedCubic(
        speed_mps=np.array([0.0, 0.5, 1.0, 1.5, 2.0]),
        thrust_max_n=np.array([42.0, 38.5, 34.5, 29.9, 24.8]),
        coefficients=np.array(
            [
                [11.7, 4.32, -0.073, 8.51e-4],
                [20.6, 4.04, -0.062, 7.43e-4],
                [30.8, 3.97, -0.063, 8.33e-4],
                [43.2, 3.95, -0.074, 12.1e-4],
                [60.0, 3.17, -0.031, 5.00e-4],
            ]
        ),
        codes=CODES,
    )


def test_a_single_speed_is_enough() -> None:
    one = SpeedCubic(np.array([0.0]), np.array([42.0]), np.array([[11.7, 4.32, 0, 0]]), CODES)
    np.testing.assert_allclose(one.code([10.0, -10.0], 1.3), [54.9, -54.9])


def test_against_the_motion_the_row_at_rest_holds(
    paper_inverse: InverseCharacteristic, cubic: SpeedCubic
) -> None:
    for inverse in (cubic, firmware_grid(paper_inverse)):
        np.testing.assert_allclose(inverse.code(-20.0, 2.0), inverse.code(-20.0, 0.0))
        np.testing.assert_allclose(inverse.code(20.0, -2.0), inverse.code(20.0, 0.0))


def test_limits_fall_with_speed_and_promise_no_more_against_the_motion(
    paper_inverse: InverseCharacteristic,
) -> None:
    grid = firmware_grid(paper_inverse)
    assert grid.limits(0.0).forward_n == pytest.approx(42.48, abs=0.01)
    assert grid.limits(2.0).forward_n == pytest.approx(25.40, abs=0.01)
    assert grid.limits(2.0).reverse_n == grid.limits(2.0).forward_n
    assert grid.limits(-2.0) == grid.limits(2.0)
    at_rest = firmware_grid(paper_inverse, at_rest=True)
    assert at_rest.limits(2.0) == grid.limits(0.0)
    np.testing.assert_array_equal(at_rest.code([10.0], 2.0), grid.code([10.0], 0.0))


def test_firmware_grid_inverts_table_2(
    paper_inverse: InverseCharacteristic, table2: StaticTable
) -> None:
    """T(N(T, V), V) = T: the round trip through Table 2 closes to a few hundredths of a newton."""
    grid = firmware_grid(paper_inverse)
    for speed in np.linspace(0.0, 2.0, 21):
        thrust = np.linspace(0.51, grid.limits(speed).forward_n, 100)
        np.testing.assert_allclose(
            table2.thrust_n(grid.code(thrust, speed), speed), thrust, atol=0.03
        )


def test_what_is_missing_is_said(paper_inverse: InverseCharacteristic) -> None:
    empty = paper_inverse.model_copy(
        update={"firmware": None, "table4": (), "explanations": ("No open-water data.",)}
    )
    with pytest.raises(CannotComputeError, match="No open-water data"):
        firmware_grid(empty)
    with pytest.raises(CannotComputeError, match="No open-water data"):
        speed_cubic(empty, CODES)


@given(st.floats(-200.0, 200.0))
def test_rounding_is_odd_and_at_most_half_a_code(code: float) -> None:
    one = float(rounded(np.array(code)))
    assert abs(one - code) <= 0.5
    assert one == -float(rounded(np.array(-code)))
    assert one == int(one)


def test_codes_and_limits_end_where_the_drive_does(paper_inverse: InverseCharacteristic) -> None:
    """A drive that takes -100 to 127: no inverse sends less, and none promises more thrust."""
    firmware = paper_inverse.firmware
    assert firmware is not None
    weak = paper_inverse.model_copy(
        update={"firmware": firmware.model_copy(update={"code_min": -100})}
    )
    grid = firmware_grid(weak)
    cubic = speed_cubic(weak, CodeRange(0.5, 127, -100))
    moored = mooring_cubic(weak, CodeRange(0.5, 127, -100))
    assert moored is not None
    for inverse in (grid, cubic, moored):
        codes = inverse.code(np.linspace(-60, 60, 121), 0.0)
        assert codes.min() == -100
        assert codes.max() == pytest.approx(127, abs=0.5)
    # the mooring test and the calculation are a newton or two apart in print
    for inverse, forward_n, reverse_n in (
        (grid, 42.2, 30.2),
        (cubic, 42.2, 30.2),
        (moored, 43.0, 29.1),
    ):
        limits = inverse.limits(0.0)
        assert limits.forward_n == pytest.approx(forward_n, abs=0.3)
        assert limits.reverse_n == pytest.approx(reverse_n, abs=0.5)
        assert inverse.code(-limits.reverse_n, 0.0) == pytest.approx(-100, abs=0.3)


def test_drive_without_negative_codes_promises_no_reverse_thrust(
    paper_inverse: InverseCharacteristic,
) -> None:
    firmware = paper_inverse.firmware
    assert firmware is not None
    one_way = paper_inverse.model_copy(
        update={"firmware": firmware.model_copy(update={"code_min": 0})}
    )
    cubic = speed_cubic(one_way, CodeRange(0.5, 127, 0))
    moored = mooring_cubic(one_way, CodeRange(0.5, 127, 0))
    assert moored is not None
    for inverse in (firmware_grid(one_way), cubic, moored):
        assert inverse.limits(0.0).reverse_n == 0.0
        assert inverse.code(-20.0, 0.0) == 0.0
