"""The winch's drum: torque balance, friction that holds, and what is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.physics.winch import Winch, drum_step

DRUM = Winch(0.25, 12.0, 300.0, 8.0, viscous_nms=2.0, dry_friction_nm=10.0, brake_nm=200.0)


def settle(winch: Winch, command: float, tension: float, start: float = 0.0) -> float:
    speed = start
    for _ in range(4000):
        speed = drum_step(speed, command, tension, 0.01, *winch.numbers()[:7])
    return speed


def steady_speed(command: float, tension: float) -> float:
    """Speed of `DRUM` at which the torques balance; 0 is held by friction."""
    torque = 300.0 * command + 0.25 * tension
    held = 10.0 + (200.0 if command == 0.0 else 0.0)
    if abs(torque) <= held:
        return 0.0
    return (torque - math.copysign(held, torque)) / (300.0 / 8.0 + 2.0)


@given(command=st.floats(-1, 1), tension=st.floats(0, 2000), start=st.floats(-10, 10))
def test_the_drum_settles_at_the_balance_of_torques(
    command: float, tension: float, start: float
) -> None:
    steady = steady_speed(command, tension)
    assert settle(DRUM, command, tension, start) == pytest.approx(steady, abs=1e-6)
    if steady != 0.0:
        motor = 300.0 * (command - steady / 8.0)
        held = 10.0 + (200.0 if command == 0.0 else 0.0)
        friction = math.copysign(held, steady) + 2.0 * steady
        assert motor + 0.25 * tension - friction == pytest.approx(0.0, abs=1e-9)


def test_brake_holds_a_pull_up_to_its_torque_and_slips_above() -> None:
    assert settle(DRUM, 0.0, 839.0) == 0.0  # 0.25 m * 839 N is less than 210 N m
    assert settle(DRUM, 0.0, 841.0) > 0.0


def test_pull_pays_out_and_the_motor_hauls_against_it() -> None:
    assert steady_speed(0.001, 100.0) > 0  # the brake is off: the cable runs
    assert steady_speed(-1.0, 100.0) < 0
    assert steady_speed(-1.0, 1300.0) > 0  # more than the motor can hold


def test_run_up_is_the_exponential_of_the_linear_balance() -> None:
    """J w' = M_s u - (M_s / w_0) w, stepped finely."""
    winch = Winch(0.25, 12.0, 300.0, 8.0)
    speed = 0.0
    for _ in range(10000):
        speed = drum_step(speed, 1.0, 0.0, 1e-5, *winch.numbers()[:7])
    assert speed == pytest.approx(8.0 * (1 - math.exp(-0.1 * 300 / 8 / 12)), rel=1e-4)


def test_friction_alone_stops_the_drum_and_never_turns_it_back() -> None:
    winch = Winch(0.25, 12.0, 300.0, 1e9, dry_friction_nm=5.0)
    speeds = [3.0]
    for _ in range(2000):
        speeds.append(drum_step(speeds[-1], 0.0, 0.0, 0.01, *winch.numbers()[:7]))
    assert min(speeds) == 0.0
    assert speeds.index(0.0) * 0.01 == pytest.approx(3.0 * 12.0 / 5.0, abs=0.011)
