"""A DVL that stands askew: what is read is in the axes of the body."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, joints_topic, ros_topic, rov, stamp, ticks, vector, write_log

from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.records.run_arrays import PoolRun
from pipeline.vehicle.sensor_schema import Sensors


def run_with(path: Path, frame: str, rotation_deg: tuple[float, float, float]) -> PoolRun:
    times = ticks(50, 10.0)
    twists = [
        {
            "header": {"stamp": stamp(time), "frame_id": frame},
            "twist": {"linear": vector((1.0, 0.2, 0.1)), "angular": vector((0.0, 0.0, 0.0))},
        }
        for time in times
    ]
    topics = [
        ros_topic("/dvl/velocity", "geometry_msgs/msg/TwistStamped", times, twists),
        joints_topic("/thrusters/command", times, [NAMES] * 50, np.ones((50, 4))),
    ]
    sensors = Sensors.model_validate({"dvl": {"rate_hz": 10.0, "rotation_deg": rotation_deg}})
    vehicle = rov().model_copy(update={"sensors": sensors})
    return read_pool_run(write_log(path / "run.mcap", topics), vehicle, path)


@pytest.mark.parametrize(
    ("rotation_deg", "in_body"),
    [
        ((0.0, 0.0, 0.0), (1.0, 0.2, 0.1)),
        ((0.0, 0.0, 90.0), (-0.2, 1.0, 0.1)),
        ((180.0, 0.0, 0.0), (1.0, -0.2, -0.1)),
        ((0.0, 90.0, 0.0), (0.1, 0.2, -1.0)),
    ],
)
def test_the_stated_rotation_is_taken_out(
    tmp_path: Path, rotation_deg: tuple[float, float, float], in_body: tuple[float, ...]
) -> None:
    run = run_with(tmp_path, "dvl_frd", rotation_deg)
    np.testing.assert_allclose(
        run.channels["velocity"].values, np.tile(in_body, (50, 1)), atol=1e-12
    )
    np.testing.assert_allclose(resample(run, 10.0).values["velocity"][5], in_body, atol=1e-12)
    told = any("rotation_deg" in note for note in run.channels["velocity"].read.notes)
    assert told == any(rotation_deg)


def test_a_velocity_of_the_body_stays_as_it_is(tmp_path: Path) -> None:
    run = run_with(tmp_path, "base_link_frd", (0.0, 0.0, 90.0))
    np.testing.assert_array_equal(run.channels["velocity"].values[0], [1.0, 0.2, 0.1])
    assert "rotation_deg of the DVL is not applied" in run.channels["velocity"].read.notes[-1]


def test_the_base_of_a_dvl_is_not_the_body(tmp_path: Path) -> None:
    run = run_with(tmp_path, "dvl_base_link_frd", (0.0, 0.0, 90.0))
    np.testing.assert_allclose(run.channels["velocity"].values[0], [-0.2, 1.0, 0.1], atol=1e-12)
