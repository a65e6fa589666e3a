import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.physics.thrust_grid import ThrustGrid, code_from_thrust, thrust_from_code

FORWARD = ThrustGrid(
    speed_mps=np.array([0.0, 1.0, 2.0]),
    thrust_max_n=np.array([40.0, 32.0, 20.0]),
    fraction=np.array([0.0, 0.25, 0.5, 1.0]),
    code=np.array(
        [[15.0, 40.0, 70.0, 127.0], [30.0, 55.0, 80.0, 127.0], [60.0, 75.0, 95.0, 127.0]]
    ),
)
REVERSE = ThrustGrid(
    speed_mps=np.array([0.0, 2.0]),
    thrust_max_n=np.array([30.0, 15.0]),
    fraction=np.array([0.0, 0.5, 1.0]),
    code=np.array([[12.0, 60.0, 120.0], [50.0, 80.0, 120.0]]),
)
GRIDS = {"positive": FORWARD, "negative": REVERSE}

speeds = st.floats(-3.0, 3.0)


def code(thrust: object, speed: object) -> np.ndarray:
    return code_from_thrust(thrust, speed, thrust_dead_n=0.5, **GRIDS)  # type: ignore[arg-type]


def thrust(codes: object, speed: object) -> np.ndarray:
    return thrust_from_code(codes, speed, **GRIDS)  # type: ignore[arg-type]


def test_nodes_are_hit_exactly() -> None:
    assert code(10.0, 0.0) == 40.0  # a quarter of 40 N at rest
    assert code(16.0, 1.0) == 80.0  # half of 32 N at 1 m/s
    assert code(20.0, 2.0) == 127.0
    assert code(-15.0, 0.0) == -60.0
    assert thrust(95.0, 2.0) == 10.0
    assert thrust(-80.0, -2.0) == -7.5


def test_between_nodes_by_hand() -> None:
    """At 1.5 m/s T_max is 26 N and the rows' mean holds: 13 N is half, code (80 + 95) / 2."""
    assert code(13.0, 1.5) == pytest.approx(87.5)
    assert thrust(87.5, 1.5) == pytest.approx(13.0)
    assert code(15.0, 0.0) == pytest.approx(55.0)  # fraction 0.375 at rest


@given(share=st.floats(0.02, 1.0), speed=speeds, sign=st.sampled_from([1.0, -1.0]))
def test_thrust_to_code_and_back(share: float, speed: float, sign: float) -> None:
    grid = FORWARD if sign > 0 else REVERSE
    largest = grid.at_speed(np.array([max(sign * speed, 0.0)]))[0][0]
    wanted = sign * share * largest
    back = float(thrust(code(wanted, speed), speed))
    if abs(wanted) <= 0.5:
        assert back == 0.0
    else:
        assert back == pytest.approx(wanted, rel=1e-12, abs=1e-12)


@given(share=st.floats(0.0, 1.0), speed=speeds, sign=st.sampled_from([1.0, -1.0]))
def test_code_to_thrust_and_back(share: float, speed: float, sign: float) -> None:
    """Every live code comes back, unless its thrust lies in the dead band."""
    grid = FORWARD if sign > 0 else REVERSE
    row = grid.at_speed(np.array([max(sign * speed, 0.0)]))[1][0]
    sent = sign * (row[0] + share * (row[-1] - row[0]))
    given_thrust = float(thrust(sent, speed))
    if abs(given_thrust) > 0.5:
        assert float(code(given_thrust, speed)) == pytest.approx(sent, rel=1e-12)


@given(speed=speeds)
def test_monotone_in_thrust_and_code(speed: float) -> None:
    assert (np.diff(code(np.linspace(-45, 45, 181), speed)) >= -1e-9).all()
    assert (np.diff(thrust(np.linspace(-130, 130, 261), speed)) >= -1e-9).all()


@given(wanted=st.floats(0.6, 19.0))
def test_more_speed_takes_more_code(wanted: float) -> None:
    assert (np.diff(code(wanted, np.linspace(0.0, 2.0, 41))) >= 0).all()


@given(code_sent=st.floats(0.0, 127.0))
def test_more_speed_gives_less_thrust(code_sent: float) -> None:
    assert (np.diff(thrust(code_sent, np.linspace(0.0, 2.0, 41))) <= 1e-12).all()


def test_clamped_in_thrust_speed_and_code() -> None:
    assert code(1e6, 0.0) == 127.0
    assert code(-1e6, 0.0) == -120.0
    assert code(10.0, 9.0) == code(10.0, 2.0)
    assert thrust(300.0, 0.0) == 40.0
    assert thrust(-300.0, 0.0) == -30.0


def test_dead_zone_and_dead_band() -> None:
    assert code(0.5, 0.0) == 0.0
    assert code(-0.5, 0.0) == 0.0
    assert code(0.51, 0.0) > 15.0
    assert thrust(14.9, 0.0) == 0.0
    assert thrust(0.0, 1.0) == 0.0
    assert thrust(-12.0, 0.0) == 0.0


def test_against_the_motion_the_row_at_rest_holds() -> None:
    assert code(10.0, -2.0) == code(10.0, 0.0)
    assert thrust(-60.0, 2.0) == thrust(-60.0, 0.0) == -15.0


def test_one_speed_only() -> None:
    one = ThrustGrid(np.array([0.0]), np.array([40.0]), FORWARD.fraction, FORWARD.code[:1])
    both = {"positive": one, "negative": one}
    at_speeds = code_from_thrust(10.0, np.array([0.0, 1.0, -1.0]), thrust_dead_n=0.5, **both)
    assert at_speeds.tolist() == [40.0, 40.0, 40.0]
    assert thrust_from_code(-40.0, 5.0, **both) == -10.0


def test_shapes_broadcast_and_inputs_stay() -> None:
    wanted, speed = np.linspace(-20, 20, 5)[:, None], np.linspace(0, 2, 3)[None, :]
    before = wanted.copy()
    assert code(wanted, speed).shape == (5, 3)
    np.testing.assert_array_equal(wanted, before)
    np.testing.assert_array_equal(code(wanted, speed)[1], code(wanted[1], speed[0]))
