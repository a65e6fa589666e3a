"""A simulated log on one time base: what is interpolated, what is held, what is not made up."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.sensors import Channel
from pipeline.vehicle.sensor_schema import Dvl, Sensors

TIME_S = np.arange(0.0, 4.001, 0.02)


def channel(time_s: np.ndarray, values: np.ndarray) -> Channel:
    return Channel(("a",) * values.shape[1], time_s, time_s + 0.1, values)


@pytest.fixture
def command() -> Channel:
    return channel(TIME_S, np.where(TIME_S < 1.0, 0.0, 50.0)[:, None])


def test_delay_is_removed_and_values_lie_on_the_line_between_readings(command: Channel) -> None:
    reading_s = np.arange(0.1, 3.9, 0.2)
    log = {"command": command, "depth": channel(reading_s, (2.0 + 0.5 * reading_s)[:, None])}
    table = table_of_log(log, Sensors())
    inside = table.valid["depth"]
    np.testing.assert_allclose(table.values["depth"][inside, 0], 2 + 0.5 * table.time_s[inside])
    assert table.time_s[inside][[0, -1]] == pytest.approx([0.1, 3.7])
    np.testing.assert_allclose(table.time_s[table.reading["depth"]], reading_s, atol=1e-9)


def test_commands_are_held_not_interpolated(command: Channel) -> None:
    table = table_of_log({"command": command}, Sensors(), period_s=0.05)
    assert set(table.values["command"][:, 0]) == {0.0, 50.0}


def test_a_dropout_is_not_bridged(command: Channel) -> None:
    reading_s = np.concatenate([np.arange(0, 1, 0.1), np.arange(2, 4, 0.1)])
    log = {"command": command, "depth": channel(reading_s, np.ones((reading_s.size, 1)))}
    valid = table_of_log(log, Sensors()).valid["depth"]
    assert not valid[(TIME_S > 0.95) & (TIME_S < 1.99)].any()
    assert valid[TIME_S < 0.89].all()


def test_velocity_is_turned_into_body_axes(command: Channel) -> None:
    """A DVL whose own x points to starboard reads -v ahead as its y."""
    sensors = Sensors(dvl=Dvl(rate_hz=5.0, rotation_deg=(0.0, 0.0, 90.0)))
    readings = np.tile([0.0, -1.2, 0.0], (20, 1))
    log = {"command": command, "dvl": channel(np.arange(20) * 0.2, readings)}
    found = table_of_log(log, sensors).values["velocity"]
    np.testing.assert_allclose(found[0], [1.2, 0.0, 0.0], atol=1e-12)


def test_attitude_takes_the_shortest_turn(command: Channel) -> None:
    """The second quaternion has the other sign: half of 40 degrees is 20, not 200."""
    turn = Rotation.from_euler("z", [[0.0], [40.0], [0.0]], degrees=True).as_quat()[:, [3, 0, 1, 2]]
    turn[1] *= -1
    imu = np.column_stack([np.zeros((3, 6)), turn])
    log = {"command": command, "imu": channel(np.array([0.0, 2.0, 4.0]), imu)}
    table = table_of_log(log, Sensors())
    quaternion = table.values["attitude"][50]
    heading = Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_euler("ZYX", degrees=True)[0]
    assert heading == pytest.approx(20.0)
    np.testing.assert_allclose(np.linalg.norm(table.values["attitude"], axis=1), 1.0)
