"""Which topics are taken for which quantity by their names alone."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import Topic, imu_topic, ros_topic, rov, ticks, write_log

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
