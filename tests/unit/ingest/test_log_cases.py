"""Logs that were read wrongly, one a kind, each with its right value.

True motion in all of them: u 0.2 to 0.4 m/s, v about +-0.05, w the rate of depth (+-0.1), depth 1.5
to 2.5 m; body axes SNAME; thrusters upper, lower, left, right with codes +-100. Made for this
purpose; none holds anybody's data.
"""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import messages_one_by_one

from pipeline.ingest.log_files import day_of
from pipeline.ingest.pool_run import read_pool_run, summarize
from pipeline.ingest.same_run import repeated_runs
from pipeline.records.run_arrays import PoolRun
from pipeline.vehicle.load import load_vehicle

CASES = Path(__file__).parents[2] / "cases" / "logs"
ROV = load_vehicle(CASES / "vehicle_log.yaml")
START_NS = 1_700_000_000_000_000_000


def read(name: str) -> PoolRun:
    return read_pool_run(CASES / f"{name}.mcap", ROV, CASES)


def said(run: PoolRun, severity: str = "warning") -> str:
    return "\n".join(one.what for one in run.problems if one.severity == severity)


def span(run: PoolRun, channel: str, column: int = 0) -> tuple[float, float]:
    """Smallest and largest of the readings that count."""
    one = run.channels[channel]
    values = one.values[one.usable(), column]
    return float(np.nanmin(values)), float(np.nanmax(values))


def rate_hz(run: PoolRun, channel: str) -> float:
    return 1.0 / run.channels[channel].period_s


def test_a_topic_at_one_log_time() -> None:
    run = read("log_latched_topic")
    assert np.unique(run.channels["voltage"].log_time_ns).size == 1
    assert run.channels["voltage"].time_ns.size == 5
    assert "/battery: all its messages were logged at one time" in said(run)
    assert rate_hz(run, "angular_velocity") == pytest.approx(100.0)


def test_times_that_are_all_zero() -> None:
    run = read("log_times_all_zero")
    assert (run.start_time_ns, run.duration_s) == (START_NS, pytest.approx(9.99))
    assert rate_hz(run, "angular_velocity") == pytest.approx(100.0)
    assert "logged at one time (0 ns)" in said(run)


def test_times_that_are_zero_until_the_clock_is_set() -> None:
    run = read("log_times_zero_at_start")
    assert day_of(CASES / "log_times_zero_at_start.mcap") == "2023-11-14"
    assert rate_hz(run, "angular_velocity") == pytest.approx(100.0)
    assert run.channels["angular_velocity"].usable().all()
    assert run.duration_s == pytest.approx(10.19)
    assert "20 of 1020 messages of /imu/data" in said(run)


def test_times_in_milliseconds() -> None:
    run = read("log_times_in_ms")
    assert (run.start_time_ns, run.duration_s) == (START_NS, pytest.approx(9.99))
    assert run.channels["angular_velocity"].clock.used == "header"
    assert "count milliseconds" in said(run)
    assert day_of(CASES / "log_times_in_ms.mcap") == "2023-11-14"


@pytest.mark.parametrize("name", ["joints_prefixed_names", "joints_in_two_messages"])
def test_thrusters_by_the_names_of_their_joints(name: str) -> None:
    run = read(name)
    codes = {
        column.removeprefix("command."): channel.values[:, number]
        for channel in run.channels.values()
        if channel.quantity == "thruster_command"
        for number, column in enumerate(channel.columns)
    }
    found = {thruster: (values.min(), values.max()) for thruster, values in codes.items()}
    assert found == {
        "upper": pytest.approx((40.0, 50.0), abs=0.2),
        "lower": pytest.approx((35.0, 55.0), abs=0.5),
        "left": pytest.approx((-10.0, 30.0), abs=0.2),
        "right": pytest.approx((30.0, 70.0), abs=0.2),
    }
    assert {values.size for values in codes.values()} == {200}
    assert "not a number" not in said(run)


def test_two_vehicles_in_one_log() -> None:
    run = read("two_vehicles")
    assert run.channels["attitude"].topic == "/rov/imu/data"
    assert run.channels["angular_velocity"].topic == "/rov/imu/data"
    assert "topics of /asv and /rov" in said(run)
    other = read_pool_run(
        CASES / "two_vehicles.mcap", ROV.model_copy(update={"name": "heavy"}), CASES
    )
    assert "topics of several may be mixed" in said(other)


def test_a_velocity_over_the_earth_that_calls_itself_the_bodys() -> None:
    run = read("mavros_velocity_local")
    assert run.channels["velocity"].topic == "/mavros/local_position/velocity_body"
    low, high = span(run, "velocity")
    assert 0.29 < low < high < 0.41


def test_a_velocity_that_runs_against_the_depth() -> None:
    told = said(read("dvl_frd_called_dvl_link"))
    assert (
        "runs against the motion by depth (/depth) (correlation -0.99). With {quantity: velocity,"
        in told
    )
    assert "body_axes: frd}" in told


@pytest.mark.parametrize("name", ["dvl_beams_not_valid", "dvl_mode_changes_to_water"])
def test_what_a_dvl_says_of_its_beams_and_its_mode(name: str) -> None:
    run = read(name)
    velocity = run.channels["velocity"]
    left_out = (velocity.time_ns[velocity.marks["not_a_number"]] - START_NS) / 1e9
    np.testing.assert_allclose(left_out, 4.2 + 0.2 * np.arange(14), atol=1e-6)
    assert span(run, "velocity")[1] < 0.41


def test_standard_messages_without_their_definition() -> None:
    run = read("schema_empty")
    assert set(run.channels) >= {"attitude", "velocity", "depth", "thruster_command"}
    assert 0.19 < span(run, "velocity")[0] < span(run, "velocity")[1] < 0.41


def test_messages_that_are_compressed_one_by_one() -> None:
    run = read("messages_zstd")
    assert set(run.channels) >= {"attitude", "velocity", "depth", "thruster_command"}
    told = said(run, "note")
    assert "zstd-compressed one by one (ros2 bag, compression mode message)" in told
    with messages_one_by_one():
        other = read("messages_zstd")
    np.testing.assert_array_equal(
        other.channels["velocity"].values, run.channels["velocity"].values
    )


def test_messages_of_ros_1() -> None:
    run = read("ros1_encoded")
    assert run.channels["attitude"].values.shape == (500, 4)
    assert span(run, "specific_force", 2)[1] < -9.7
    assert "rosbags-convert" in "\n".join(map(str, run.problems))


def test_protobuf_with_a_well_known_type_that_is_not_defined() -> None:
    run = read("protobuf_without_timestamp")
    assert run.channels["angular_velocity"].topic == "/imu"
    assert rate_hz(run, "angular_velocity") == pytest.approx(100.0)


def test_json_that_is_null_first() -> None:
    run = read("json_null_first")
    depth = run.channels["depth"]
    assert depth.usable().sum() == 100
    assert 1.4 < span(run, "depth")[0] < span(run, "depth")[1] < 2.6
    assert "nothing to do with" not in said(run)


def test_a_frozen_imu_beside_one_that_lives() -> None:
    run = read("two_imus_one_identity")
    assert run.channels["attitude"].topic == "/ahrs/imu"
    assert "/board/imu never changes" in said(run)


def test_statistics_that_lie() -> None:
    folder = CASES.parent / "hostile"
    run = read_pool_run(folder / "stats_one_missing.mcap", ROV, folder)
    assert run.channels["depth"].time_ns.size == 40


def test_one_run_twice() -> None:
    names = ("same_run_twice_run", "same_run_twice_run_converted", "json_null_first")
    found = repeated_runs({name: summarize(read(name)) for name in names})
    assert found == {"same_run_twice_run_converted": "same_run_twice_run"}


@pytest.mark.parametrize("path", sorted(CASES.glob("*.mcap")), ids=lambda path: path.stem)
def test_every_topic_is_used_or_says_why_not(path: Path) -> None:
    run = read(path.stem)
    assert all(topic.used_for or topic.why_not for topic in run.topics)
