import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.physics.thruster_static import (
    StaticTable,
    code_from_thrust,
    dead_zone_code,
    thrust_from_code,
)

SPEED = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
TABLE_2 = np.array(
    [
        [-4.0, 0.254, 8.82e-4],
        [-5.0, 0.215, 10.2e-4],
        [-8.0, 0.211, 9.65e-4],
        [-11.0, 0.210, 9.07e-4],
        [-15.0, 0.208, 8.67e-4],
    ]
)
TABLE = StaticTable(SPEED, TABLE_2)


@pytest.mark.parametrize(("row", "thrust"), list(enumerate([42.48, 38.76, 34.36, 30.30, 25.40])))
def test_thrust_at_code_127_of_table_2(row: int, thrust: float) -> None:
    assert float(thrust_from_code(127, TABLE_2[row])) == pytest.approx(thrust, abs=0.01)
    assert float(thrust_from_code(-127, TABLE_2[row])) == pytest.approx(-thrust, abs=0.01)


@pytest.mark.parametrize("row", range(5))
def test_dead_zone_ends_at_the_root(row: int) -> None:
    """Not at |N| = K_F0, which is a negative thrust."""
    edge = dead_zone_code(TABLE_2[row])
    k0, k1, k2 = TABLE_2[row]
    assert k0 + k1 * edge + k2 * edge**2 == pytest.approx(0.0, abs=1e-12)
    assert float(thrust_from_code(edge * (1 - 1e-9), TABLE_2[row])) == 0.0
    assert float(thrust_from_code(edge + 0.1, TABLE_2[row])) > 0.0
    assert edge > abs(k0)


@pytest.mark.parametrize(
    ("coefficients", "edge"),
    [
        ((1.0, 0.2, 0.0), 0.0),
        ((0.0, 0.2, 0.0), 0.0),
        ((-2.0, 0.2, 0.0), 10.0),
        ((-2.0, -0.2, 0.0), np.inf),
        ((-2.0, 0.0, 0.02), 10.0),
        ((-2.0, 0.3, -0.01), 10.0),  # concave: rises through zero at 10, falls again at 20
        ((-3.0, 0.3, -0.01), np.inf),
        ((-2.0, -0.3, -0.01), np.inf),
    ],
)
def test_dead_zone_of_other_shapes(coefficients: tuple[float, ...], edge: float) -> None:
    assert dead_zone_code(coefficients) == pytest.approx(edge)


@given(row=st.integers(0, 4), thrust=st.floats(-42.0, 42.0).filter(lambda t: abs(t) > 1e-6))
def test_exact_inverse(row: int, thrust: float) -> None:
    code = code_from_thrust(thrust, TABLE_2[row])
    assert float(thrust_from_code(code, TABLE_2[row])) == pytest.approx(thrust, abs=1e-9)


def test_no_thrust_no_code() -> None:
    assert float(code_from_thrust(0.0, TABLE_2[0])) == 0.0


@given(code=st.floats(-127.0, 127.0), speed=st.floats(-2.5, 2.5))
def test_mirrored_sign_mirrors_the_thrust(code: float, speed: float) -> None:
    assert float(TABLE.thrust_n(-code, -speed)) == -float(TABLE.thrust_n(code, speed))
    assert float(TABLE.thrust_n(code, speed)) * code >= 0.0


@given(speed=st.floats(0.0, 2.0))
def test_monotone_in_code_at_every_speed(speed: float) -> None:
    assert (np.diff(TABLE.thrust_n(np.arange(128.0), speed)) >= 0).all()


@given(code=st.floats(0.0, 127.0))
def test_speed_takes_thrust_away(code: float) -> None:
    assert (np.diff(TABLE.thrust_n(code, np.linspace(0, 2, 81))) <= 1e-9).all()


def test_between_rows_and_beyond_them() -> None:
    middle = TABLE.thrust_n(100.0, 0.25)
    ends = [float(TABLE.thrust_n(100.0, v)) for v in (0.0, 0.5)]
    assert float(middle) == pytest.approx(np.mean(ends))
    assert TABLE.thrust_n(100.0, 5.0) == TABLE.thrust_n(100.0, 2.0)


def test_against_the_motion_the_mooring_branch_holds() -> None:
    assert TABLE.thrust_n(-100.0, 2.0) == TABLE.thrust_n(-100.0, 0.0)
    assert TABLE.thrust_n(100.0, -1.0) == TABLE.thrust_n(100.0, 0.0)


def test_shapes() -> None:
    assert TABLE.at_speed(np.zeros((2, 3))).shape == (2, 3, 3)
    assert TABLE.thrust_n(np.zeros((4, 1)), np.zeros(5)).shape == (4, 5)
