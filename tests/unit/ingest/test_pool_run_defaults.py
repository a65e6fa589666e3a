"""Which topics are taken for which quantity by their names alone."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import Topic, imu_topic, json_topic, ros_topic, rov, stamp, ticks, vector, write_log

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun

TIMES = ticks(50, 10.0)
RATES = 0.1 * np.random.default_rng(0).standard_normal((50, 3))


def float_topic(name: str) -> Topic:
    contents = [{"data": 0.5 + 0.001 * k} for k in range(50)]
    return ros_topic(name, "std_msgs/msg/Float64", TIMES, contents, "float64 data")


def read(folder: Path, *topics: Topic) -> PoolRun:
    return read_pool_run(write_log(folder / "run.mcap", topics), rov(), folder)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("/battery/voltage", "voltage"),
        ("/battery", "voltage"),
        ("/state/battery_volts", "voltage"),
        ("/attempt_2/battery/voltage", "voltage"),
        ("/battery/current", "current"),
        ("/battery/amps", "current"),
        ("/depth", "depth"),
        ("/depth_hold/depth", "depth"),
        ("/depth_filtered", "depth"),
        ("/water_pressure", "depth"),
    ],
)
def test_a_plain_number_is_known_by_the_name_of_its_topic(
    tmp_path: Path, name: str, quantity: str
) -> None:
    run = read(tmp_path, imu_topic(TIMES, RATES), float_topic(name))
    assert run.channels[quantity].topic == name


@pytest.mark.parametrize(
    "name",
    [
        *("/battery/percentage", "/battery_temperature_c", "/battery/level", "/depth_hold/error"),
        *("/depth_rate", "/pid/depth/output", "/lamp/level", "/sample_time", "/clamp"),
        *("/water/current_velocity", "/mission/current_waypoint", "/internal_pressure"),
    ],
)
def test_what_is_only_named_after_a_quantity_is_left_alone(tmp_path: Path, name: str) -> None:
    run = read(tmp_path, imu_topic(TIMES, RATES), float_topic(name))
    assert set(run.channels) == {"angular_velocity", "specific_force"}


@pytest.mark.parametrize(("clicks", "taken"), [(3, "/odom"), (50, "/clicked_point")])
def test_a_point_that_was_clicked_is_no_track(tmp_path: Path, clicks: int, taken: str) -> None:
    points = [{"point": vector((1.0, 2.0 + 0.1 * k, 3.0))} for k in range(clicks)]
    poses = [{"pose": {"position": vector((0.1 * k, 0.0, 1.0))}} for k in range(50)]
    run = read(
        tmp_path,
        json_topic("/clicked_point", TIMES[:clicks], points),
        json_topic("/odom", TIMES, poses),
    )
    assert run.channels["position"].topic == taken


@pytest.mark.parametrize(("stated_none", "zeros"), [(0.0, 1), (-1.0, 1), (0.0, 50)])
def test_an_attitude_of_zeros_or_that_is_said_to_be_none_is_none(
    tmp_path: Path, stated_none: float, zeros: int
) -> None:
    """That of an IMU which has just been switched on, or which has none at all."""
    zero = vector((0.0, 0.0, 0.0))
    contents = [
        {
            "header": {"stamp": stamp(time), "frame_id": "imu"},
            "orientation": vector((0.0, 0.0, 0.0, float(k >= zeros))),
            "orientation_covariance": [stated_none] + [0.0] * 8,
            "angular_velocity": vector(rate),
            "angular_velocity_covariance": [0.0] * 9,
            "linear_acceleration": zero,
            "linear_acceleration_covariance": [0.0] * 9,
        }
        for k, (time, rate) in enumerate(zip(TIMES, RATES, strict=True))
    ]
    run = read(tmp_path, ros_topic("/imu", "sensor_msgs/msg/Imu", TIMES, contents))
    is_there = stated_none == 0.0 and zeros < 50
    assert ("attitude" in run.channels) == is_there
    if is_there:
        assert run.channels["attitude"].usable().sum() == 50 - zeros
