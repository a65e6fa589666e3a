"""What the names of frames in messages decide: axes, and velocities over the earth."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import Topic, imu_topic, json_topic, ros_topic, rov, stamp, ticks, vector, write_log

from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.records.run_arrays import PoolRun

TIMES = ticks(50, 10.0)


def twist_topic(name: str, frame: str, velocity: tuple[float, float, float]) -> Topic:
    contents = [
        {
            "header": {"stamp": stamp(time), "frame_id": frame},
            "twist": {"linear": vector(velocity), "angular": vector((0.0, 0.0, 0.0))},
        }
        for time in TIMES
    ]
    return ros_topic(name, "geometry_msgs/msg/TwistStamped", TIMES, contents)


def read(folder: Path, *topics: Topic) -> PoolRun:
    return read_pool_run(write_log(folder / "run.mcap", topics), rov(), folder)


@pytest.mark.parametrize(
    ("frame", "axes"),
    [
        ("imu_link", "flu"),
        ("imu_aligned", "flu"),
        ("imu_frd", "frd"),
        ("rov/base_link_ned", "frd"),
        ("imuFRD", "frd"),
    ],
)
def test_axes_are_told_by_a_word_of_the_frame(tmp_path: Path, frame: str, axes: str) -> None:
    run = read(tmp_path, imu_topic(TIMES, np.ones((50, 3)), frame=frame))
    assert run.channels["angular_velocity"].read.axes == axes


@pytest.mark.parametrize("names", [("velocity_body", "velocity_local"), ("a_body", "z_local")])
def test_a_velocity_of_the_body_goes_before_one_over_the_earth(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    """As mavros publishes them, both as often: velocity_local is east, north, up."""
    body = twist_topic(f"/mavros/local_position/{names[0]}", "base_link", (1.0, 0.2, 0.1))
    earth = twist_topic(f"/mavros/local_position/{names[1]}", "map", (0.3, 0.9, 0.1))
    run = read(tmp_path, body, earth)
    np.testing.assert_array_equal(run.channels["velocity"].values[0], [1.0, -0.2, -0.1])
    assert "velocity_earth" not in run.channels


@pytest.mark.parametrize(
    ("frame", "over_earth"),
    [
        ("map", (0.9, 0.3, -0.1)),
        ("odom_combined", (0.9, 0.3, -0.1)),
        ("ned", (0.3, 0.9, 0.1)),
        ("world_ned", (0.3, 0.9, 0.1)),
    ],
)
def test_a_twist_in_a_frame_of_the_earth_is_a_velocity_over_the_earth(
    tmp_path: Path, frame: str, over_earth: tuple[float, float, float]
) -> None:
    run = read(tmp_path, twist_topic("/velocity_local", frame, (0.3, 0.9, 0.1)))
    assert "velocity" not in run.channels
    np.testing.assert_array_equal(run.channels["velocity_earth"].values[0], over_earth)
    assert any("cannot be turned into those of the body" in one.what for one in run.problems)


def test_a_velocity_over_the_earth_is_turned_by_the_attitude(tmp_path: Path) -> None:
    """Heading east at 1 m/s, and up slowly: bow to the east is forward."""
    turn = {"orientation": vector((0.0, 0.0, 0.5**0.5, 0.5**0.5))}  # yaw of 90 degrees, in NED
    topics = [
        twist_topic("/velocity_local", "map", (1.0, 0.0, 0.2)),
        json_topic("/imu", TIMES, [turn] * 50),
    ]
    run = read(tmp_path, *topics)
    assert not any("cannot be turned" in one.what for one in run.problems)
    velocity = resample(run, 10.0).values["velocity"][5]
    np.testing.assert_allclose(velocity, (1.0, 0.0, -0.2), atol=1e-12)
