"""Depth, position, supply, shaft speeds and commands, against numbers worked out by hand."""

from collections.abc import Callable

import numpy as np
import pytest
from sensor_cases import changed, each, motion, sense, with_shaft_tables

from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.sensor_schema import Depth, Position, ShaftSpeed, Voltage

Make = Callable[..., PackedVehicle]


@pytest.mark.parametrize(
    ("attitude", "place", "expected"),
    [
        ((0, 0, 0), (0.8, 0.3, -0.1), 4.9),
        # nose up by 30 degrees lifts a sensor 0.8 m ahead by 0.4 m
        ((0, np.pi / 6, 0), (0.8, 0, 0), 4.6),
        # starboard down by 30 degrees sinks a sensor 0.4 m to starboard by 0.2 m
        ((np.pi / 6, 0, 0), (0, 0.4, 0), 5.2),
        ((0, 0, 1.3), (0.8, 0.4, 0), 5.0),
    ],
)
def test_depth_is_that_of_the_sensor(
    make_packed: Make,
    attitude: tuple[float, float, float],
    place: tuple[float, ...],
    expected: float,
) -> None:
    trajectory = motion(position=(7, -3, 5), roll_pitch_yaw=attitude)
    depth = sense(make_packed(), trajectory, depth=Depth(rate_hz=10, position_m=place))["depth"]
    assert depth.columns == ("depth_m",)
    each(depth.values, (expected,))


def test_position_is_that_of_the_origin(make_packed: Make) -> None:
    log = sense(make_packed(), motion(position=(7, -3, 5)), position=Position(rate_hz=4))
    assert log["position"].columns == ("north_m", "east_m", "down_m")
    each(log["position"].values, (7, -3, 5))


def test_supply_falls_by_what_is_missing_and_with_load(make_packed: Make) -> None:
    """Two of five thrusters at full either way, one at half: a mean square of 2.25 / 5."""
    packed = make_packed()
    codes = np.tile([127, -127, 63.5, 0, 0], (101, 1))
    sagging = changed(packed, supply_drop=0.05, load_drop=0.2)
    log = sense(
        packed, motion(command=codes), voltage=Voltage(rate_hz=5, nominal_v=48), vector=sagging
    )
    each(log["voltage"].values, (48 * (1 - 0.05 - 0.2 * 0.45),))
    healthy = sense(packed, motion(command=codes), voltage=Voltage(rate_hz=5, nominal_v=48))
    each(healthy["voltage"].values, (48.0,))


def test_shaft_speed_follows_code_sign_and_inflow(make_packed: Make) -> None:
    """u = 1, r = 0.5: the inflow of each thruster is its place's velocity along its axis."""
    packed = with_shaft_tables(make_packed())
    codes = np.tile([50.0, -50.0, 0.0, 12.5, 80.0], (101, 1))
    trajectory = motion(nu=(1, 0, 0, 0, 0, 0.5), command=codes)
    shaft = sense(packed, trajectory, shaft_speed=ShaftSpeed(rate_hz=10))["shaft_speed"]
    c, s = np.cos(np.radians(22.5)), np.sin(np.radians(22.5))
    # places (-0.9, 0, 0) of the four aft move with (1, -0.45, 0), the fourth points along (c, s, 0)
    fourth = 20 * 12.5 + 50 * (c - 0.45 * s)
    # the second turns astern: the motion comes from behind it, which the tables do not hold
    expected = (20 * 50 + 50 * c, -20 * 50, 0.0, fourth, 20 * 80)
    assert shaft.columns == ("upper", "lower", "left", "right", "bow")
    np.testing.assert_allclose(shaft.values, np.tile(expected, (len(shaft.values), 1)), atol=1e-9)


def test_current_and_inflow_fraction_count_in_the_inflow(make_packed: Make) -> None:
    packed = with_shaft_tables(make_packed())
    codes = np.tile([50.0, 0, 0, 0, 0], (101, 1))
    trajectory = motion(nu=(1, 0, 0, 0, 0, 0), command=codes)
    true = changed(packed, current=(0.4, 0, 0), inflow_fraction=0.5)
    shaft = sense(packed, trajectory, shaft_speed=ShaftSpeed(rate_hz=10), vector=true)
    c = np.cos(np.radians(22.5))
    np.testing.assert_allclose(shaft["shaft_speed"].values[:, 0], 1000 + 50 * 0.5 * 0.6 * c)


def test_a_shaft_solved_in_time_is_read_from_the_state(make_packed: Make) -> None:
    """The state is in revolutions a second, the reading in revolutions a minute."""
    packed = with_shaft_tables(make_packed())
    in_time = changed(packed, rotor_inertia=[1e-3] * 5 + [0.0] * 7)
    turning = np.tile([10.0, -20.0, 0.0, 1.5, 3.0], (101, 1))
    log = sense(
        packed, motion(actuator=turning), shaft_speed=ShaftSpeed(rate_hz=10), vector=in_time
    )
    each(log["shaft_speed"].values, (600, -1200, 0, 90, 180))


def test_unknown_shaft_speeds_are_not_logged(make_packed: Make) -> None:
    assert set(sense(make_packed(), motion(), shaft_speed=ShaftSpeed(rate_hz=10))) == {"command"}


def test_commands_are_those_in_force(make_packed: Make) -> None:
    """A step at 1.0 s, logged every 0.15 s: the reading at 0.9 s does not see it coming."""
    codes = np.zeros((101, 5))
    codes[50:, 3] = 100.0
    log = sense(make_packed(), motion(command=codes), command_rate_hz=1 / 0.15)
    command = log["command"]
    assert command.columns == ("upper", "lower", "left", "right", "bow")
    np.testing.assert_allclose(command.valid_s, 0.15 * np.arange(14))
    assert np.array_equal(command.valid_s, command.logged_s)
    assert command.values[:, 3].tolist() == [0.0] * 7 + [100.0] * 7
    at_step = sense(make_packed(), motion(command=codes), command_rate_hz=50)["command"]
    assert at_step.values[49:52, 3].tolist() == [0.0, 100.0, 100.0]
