"""Inertial unit, velocity log and the times of readings, against numbers worked out by hand.

They follow from rigid-body kinematics, beside each case: body axes x forward, y starboard, z down;
earth axes north, east, down.
"""

from collections.abc import Callable

import numpy as np
import pytest
from sensor_cases import GRAVITY, changed, each, motion, sense, with_shaft_tables

from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.sensor_schema import Depth, Dvl, Imu, Position, ShaftSpeed, Voltage

Make = Callable[..., PackedVehicle]


# Inertial measurement unit


@pytest.mark.parametrize(
    ("attitude", "force"),
    [
        ((0, 0, 0), (0, 0, -GRAVITY)),
        ((0, 0, 2.0), (0, 0, -GRAVITY)),
        # nose up: the support pushes forward; starboard down: it pushes to port
        ((0, np.pi / 6, 0), (GRAVITY / 2, 0, -GRAVITY * np.sqrt(3) / 2)),
        ((np.pi / 6, 0, 0), (0, -GRAVITY / 2, -GRAVITY * np.sqrt(3) / 2)),
        ((np.pi, 0, 0), (0, 0, GRAVITY)),
    ],
)
def test_at_rest_the_specific_force_is_upward(
    make_packed: Make, attitude: tuple[float, float, float], force: tuple[float, ...]
) -> None:
    imu = sense(make_packed(), motion(roll_pitch_yaw=attitude), imu=Imu(rate_hz=100))["imu"]
    assert imu.columns == (
        *("p_radps", "q_radps", "r_radps"),
        *("fx_mps2", "fy_mps2", "fz_mps2"),
        *("qw", "qx", "qy", "qz"),
    )
    each(imu.values[:, :3], (0, 0, 0))
    each(imu.values[:, 3:6], force)


@pytest.mark.parametrize(
    ("attitude", "quaternion"),
    [
        ((np.pi / 3, 0, 0), (np.sqrt(3) / 2, 0.5, 0, 0)),
        ((0, np.pi / 3, 0), (np.sqrt(3) / 2, 0, 0.5, 0)),
        ((0, 0, np.pi / 3), (np.sqrt(3) / 2, 0, 0, 0.5)),
    ],
)
def test_attitude_is_body_to_earth_scalar_first(
    make_packed: Make, attitude: tuple[float, float, float], quaternion: tuple[float, ...]
) -> None:
    imu = sense(make_packed(), motion(roll_pitch_yaw=attitude), imu=Imu(rate_hz=10))["imu"]
    each(imu.values[:, 6:], quaternion)


def test_steady_turn_pulls_inwards(make_packed: Make) -> None:
    """u = 1, r = 0.5: the origin accelerates by r u to starboard, a point ahead by r^2 x aft."""
    log = sense(
        make_packed(),
        motion(nu=(1, 0, 0, 0, 0, 0.5)),
        imu=Imu(rate_hz=100, position_m=(0.4, 0, 0)),
    )
    each(log["imu"].values[:, :3], (0, 0, 0.5))
    each(log["imu"].values[:, 3:6], (-0.25 * 0.4, 0.5, -GRAVITY))


def test_angular_acceleration_shows_at_a_lever_arm(make_packed: Make) -> None:
    """Pitch rate growing by 0.2 rad/s^2: a point 0.5 ahead accelerates upwards (q positive)."""
    trajectory = motion(nu_dot=(0.3, 0, 0, 0, 0.2, 0))
    imu = sense(make_packed(), trajectory, imu=Imu(rate_hz=50, position_m=(0.5, 0, 0)))["imu"]
    t = imu.valid_s
    q, u = 0.2 * t, 0.3 * t
    # nu_dot + omega x v + omega_dot x l + omega x (omega x l), each by hand for omega = (0, q, 0)
    expected = np.stack([0.3 - q**2 * 0.5, 0 * t, -q * u - 0.2 * 0.5 - GRAVITY], axis=1)
    np.testing.assert_allclose(imu.values[:, 3:6], expected, atol=1e-12)


# Doppler velocity log


@pytest.mark.parametrize(
    ("nu", "place", "expected"),
    [
        # omega x l: for yaw (-r y, r x, 0), for pitch (q z, 0, -q x), for roll (0, -p z, p y)
        ((1, 0, 0, 0, 0, 0.5), (-0.4, 0.2, 0.1), (1 - 0.1, -0.2, 0)),
        ((1, 0, 0, 0, 0.3, 0), (-0.4, 0.2, 0.1), (1 + 0.03, 0, 0.12)),
        ((1, 0, 0, 0.6, 0, 0), (-0.4, 0.2, 0.1), (1, -0.06, 0.12)),
    ],
)
def test_dvl_sees_its_own_place_move(
    make_packed: Make, nu: tuple[float, ...], place: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    dvl = sense(make_packed(), motion(nu=nu), dvl=Dvl(rate_hz=10, position_m=place))["dvl"]
    assert dvl.columns == ("vx_mps", "vy_mps", "vz_mps")
    each(dvl.values, expected)


@pytest.mark.parametrize(
    ("rotation_deg", "expected"),
    [
        # yaw 90: its x axis points to starboard, its y axis aft
        ((0, 0, 90), (2, -1, 3)),
        # pitch 90: its x axis points up, its z axis forward
        ((0, 90, 0), (-3, 2, 1)),
        # roll 90: its y axis points down, its z axis to port
        ((90, 0, 0), (1, 3, -2)),
        # yaw first, then roll about the new x axis: x to starboard, y down, z forward
        ((90, 0, 90), (2, 3, 1)),
    ],
)
def test_dvl_reports_in_its_own_axes(
    make_packed: Make, rotation_deg: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    trajectory = motion(nu=(1, 2, 3, 0, 0, 0))
    log = sense(make_packed(), trajectory, dvl=Dvl(rate_hz=10, rotation_deg=rotation_deg))
    each(log["dvl"].values, expected)


def test_dvl_rotation_error_turns_the_sensor(make_packed: Make) -> None:
    """Turned by 0.1 rad to starboard, it sees a vehicle that goes ahead drift to port."""
    packed, trajectory = make_packed(), motion(nu=(1, 0, 0, 0, 0, 0))
    c, s = np.cos(0.1), np.sin(0.1)
    yawed = changed(packed, dvl_rotation=(0, 0, 0.1))
    each(sense(packed, trajectory, dvl=Dvl(rate_hz=10), vector=yawed)["dvl"].values, (c, -s, 0))
    # turned nose up, it sees the vehicle sink
    pitched = changed(packed, dvl_rotation=(0, 0.1, 0))
    each(sense(packed, trajectory, dvl=Dvl(rate_hz=10), vector=pitched)["dvl"].values, (c, 0, s))
    # about its own forward axis only what lies across changes: starboard drift partly upwards
    rolled, across = changed(packed, dvl_rotation=(0.1, 0, 0)), motion(nu=(0, 1, 0, 0, 0, 0))
    each(sense(packed, across, dvl=Dvl(rate_hz=10), vector=rolled)["dvl"].values, (0, c, -s))


def test_dvl_scale_and_lever_arm_errors(make_packed: Make) -> None:
    """The scale multiplies what the true place sees: the stated place plus the error."""
    packed, trajectory = make_packed(), motion(nu=(1, 0, 0, 0, 0, 0.5))
    wrong = changed(packed, dvl_scale=1.02, dvl_lever_arm=(0.2, -0.1, 0))
    dvl = Dvl(rate_hz=10, position_m=(-0.4, 0, 0))
    values = sense(packed, trajectory, dvl=dvl, vector=wrong)["dvl"].values
    each(values, (1.02 * (1 + 0.05), 1.02 * (-0.1), 0))


def test_dvl_in_water_track_leaves_the_current_out(make_packed: Make) -> None:
    """Heading east, a current to the north comes from starboard: the water moves to port."""
    packed, trajectory = (
        make_packed(),
        motion(nu=(1, 0, 0, 0, 0, 0), roll_pitch_yaw=(0, 0, np.pi / 2)),
    )
    flowing = changed(packed, current=(0.3, 0, 0))
    over_ground = sense(packed, trajectory, dvl=Dvl(rate_hz=10), vector=flowing)
    each(over_ground["dvl"].values, (1, 0, 0))
    through_water = sense(packed, trajectory, dvl=Dvl(rate_hz=10, water_track=True), vector=flowing)
    each(through_water["dvl"].values, (1, 0.3, 0))


# Times


def test_a_delayed_reading_tells_the_past(make_packed: Make) -> None:
    """u = 0.1 t; logged on the sensor's own clock, never before the run has a past to tell."""
    trajectory = motion(nu_dot=(0.1, 0, 0, 0, 0, 0))
    dvl = sense(make_packed(), trajectory, dvl=Dvl(rate_hz=8, delay_s=0.3))["dvl"]
    np.testing.assert_allclose(dvl.logged_s, np.arange(3, 17) / 8, atol=1e-12)
    np.testing.assert_allclose(dvl.valid_s, dvl.logged_s - 0.3, atol=1e-12)
    np.testing.assert_allclose(dvl.values[:, 0], 0.1 * (dvl.logged_s - 0.3), atol=1e-12)


def test_an_unstated_delay_makes_readings_older(make_packed: Make) -> None:
    packed, trajectory = make_packed(), motion(nu_dot=(0.1, 0, 0, 0, 0, 0))
    late = changed(packed, dvl_delay=0.25)
    dvl = sense(packed, trajectory, dvl=Dvl(rate_hz=8, delay_s=0.3), vector=late)["dvl"]
    np.testing.assert_allclose(dvl.logged_s, np.arange(5, 17) / 8, atol=1e-12)
    np.testing.assert_allclose(dvl.values[:, 0], 0.1 * (dvl.logged_s - 0.55), atol=1e-12)
    # it claims the stated age only, so readings are 0.25 s older than their times say
    np.testing.assert_allclose(dvl.valid_s, dvl.logged_s - 0.3, atol=1e-12)
    np.testing.assert_allclose(dvl.values[:, 0], 0.1 * (dvl.valid_s - 0.25), atol=1e-12)


@pytest.mark.parametrize("water_track", [False, True])
def test_a_stated_delay_that_is_too_long_ends_early(make_packed: Make, water_track: bool) -> None:
    """Readings are younger than stated; what lies beyond the end of the run is not made up."""
    packed, trajectory = make_packed(), motion(nu_dot=(0.1, 0, 0, 0, 0, 0))
    early = changed(packed, dvl_delay=-0.25)
    sensor = Dvl(rate_hz=8, water_track=water_track)
    dvl = sense(packed, trajectory, dvl=sensor, vector=early)["dvl"]
    np.testing.assert_allclose(dvl.valid_s, np.arange(15) / 8, atol=1e-12)
    np.testing.assert_allclose(dvl.values[:, 0], 0.1 * (dvl.valid_s + 0.25), atol=1e-12)


def test_a_run_shorter_than_the_delay_has_no_readings(make_packed: Make) -> None:
    log = sense(
        with_shaft_tables(make_packed()),
        motion(1.0),
        imu=Imu(rate_hz=10, delay_s=2, attitude_wander_rad=0.1),
        dvl=Dvl(rate_hz=10, delay_s=2, water_track=True),
        depth=Depth(rate_hz=10, delay_s=2),
        position=Position(rate_hz=10, delay_s=2),
        shaft_speed=ShaftSpeed(rate_hz=10, delay_s=2),
        voltage=Voltage(rate_hz=10, nominal_v=48, delay_s=2),
    )
    assert {name: len(channel.values) for name, channel in log.items() if name != "command"} == (
        dict.fromkeys(("imu", "dvl", "depth", "position", "shaft_speed", "voltage"), 0)
    )


def test_a_period_that_is_no_round_number_stays_inside_the_run(make_packed: Make) -> None:
    """100 periods of 3 ms are 0.30000000000000004 s, and the run ends at 0.3."""
    imu = sense(make_packed(), motion(0.3), imu=Imu(rate_hz=1000 / 3))["imu"]
    assert imu.valid_s.size == 101
    assert imu.valid_s[-1] <= 0.3


def test_every_sensor_keeps_its_rate_and_delay(make_packed: Make) -> None:
    """Also in a run that does not begin at zero."""
    packed = with_shaft_tables(make_packed())
    log = sense(
        packed,
        motion(2.0, start_s=100.0),
        command_rate_hz=20,
        imu=Imu(rate_hz=100, delay_s=0.01),
        dvl=Dvl(rate_hz=5, delay_s=0.2),
        depth=Depth(rate_hz=10, delay_s=0.1),
        position=Position(rate_hz=2, delay_s=0.5),
        shaft_speed=ShaftSpeed(rate_hz=25, delay_s=0.04),
        voltage=Voltage(rate_hz=4, nominal_v=48, delay_s=0.25),
    )
    stated = {
        "command": (20, 0),
        "imu": (100, 1),
        "dvl": (5, 1),
        "depth": (10, 1),
        "position": (2, 1),
        "shaft_speed": (25, 1),
        "voltage": (4, 1),
    }
    assert set(log) == set(stated)
    for name, (rate, periods_late) in stated.items():
        valid, logged = log[name].valid_s, log[name].logged_s
        np.testing.assert_allclose(logged, 100 + np.arange(periods_late, 2 * rate + 1) / rate)
        np.testing.assert_allclose(logged - valid, periods_late / rate, atol=1e-9)
        assert valid.shape == logged.shape == log[name].values.shape[:1]
