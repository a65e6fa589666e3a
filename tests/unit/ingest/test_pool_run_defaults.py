"""Which topics are taken for which quantity by their names alone."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import (
    NAMES,
    Topic,
    imu_topic,
    joints_topic,
    json_topic,
    ros_topic,
    rov,
    stamp,
    ticks,
    vector,
    write_log,
)

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


CODES = np.tile([10.0, 20.0, 30.0, 40.0], (50, 1)) + np.arange(50)[:, None] % 3


def commands(how: str) -> Topic:
    """Commands of the thrusters backwards, each by its name."""
    rows = CODES[:, ::-1].tolist()
    names = {"camel": "Thruster{}Joint", "number": "{}1", "simulator": "rov::{}_thruster"}
    if how in names:
        called = [names[how].format(one.title()) for one in NAMES[::-1]]
        return joints_topic("/thrusters/command", TIMES, [called] * 50, CODES[:, ::-1])
    pairs = [list(zip(NAMES[::-1], row, strict=True)) for row in rows]
    contents = {
        "fields": [dict(one) for one in pairs],
        "below": [{"command": dict(one)} for one in pairs],
        "elements": [{"command": [{"name": n, "value": v} for n, v in one]} for one in pairs],
        "numbers": [{"command": [{"id": 4 - k, "value": v} for k, v in enumerate(row)]}
                    for row in rows],
        "beside": [{"names": NAMES[::-1], "values": row} for row in rows],
    }  # fmt: skip
    return json_topic("/thrusters/command", TIMES, contents[how])


@pytest.mark.parametrize(
    "how",
    ["camel", "number", "simulator", "fields", "below", "elements", "numbers", "beside"],
)
def test_thrusters_are_known_by_their_names_wherever_these_stand(how: str, tmp_path: Path) -> None:
    run = read(tmp_path, commands(how))
    columns = {
        column.removeprefix("command."): values
        for channel in run.channels.values()
        for column, values in zip(channel.columns, channel.values.T, strict=True)
    }
    for name, values in zip(NAMES, CODES.T, strict=True):
        assert (columns[name] == values).all(), name


@pytest.mark.parametrize("form", ["/{}/{}", "/fleet/{}/{}", "/{1}/{0}"])
@pytest.mark.parametrize("ours", ["alpha", "beta"])
def test_topics_of_the_vehicle_that_has_the_commands(form: str, ours: str, tmp_path: Path) -> None:
    topics = [joints_topic(form.format(ours, "thrusters"), TIMES, [NAMES] * 50, CODES)]
    for name in ("alpha", "beta"):
        topics += [imu_topic(TIMES, RATES, name=form.format(name, "imu")),
                   float_topic(form.format(name, "depth"))]  # fmt: skip
    run = read(tmp_path, *topics)
    assert all(ours in channel.topic for channel in run.channels.values())
    assert any(f"those of /{ours} are taken" in one.what for one in run.problems)


def test_two_namespaces_without_a_topic_in_common(tmp_path: Path) -> None:
    topics = [
        joints_topic("/rov/thrusters", TIMES, [NAMES] * 50, CODES),
        imu_topic(TIMES, RATES, name="/rov/imu"),
        float_topic("/ship/water_depth"),
        json_topic("/ship/gps", TIMES, [{"point": vector((0.1 * k, 0, 0))} for k in range(50)]),
    ]
    run = read(tmp_path, *topics)
    assert any("the commands are of /rov" in one.what for one in run.problems)


@pytest.mark.parametrize("worth", [1_000, 1_000_000])
def test_times_from_the_start_in_another_unit(worth: int, tmp_path: Path) -> None:
    times = ((TIMES - TIMES[0]) // worth).tolist()
    depths = [{"depth": 1.0 + 0.01 * k} for k in range(50)]
    run = read(tmp_path, json_topic("/depth", times, depths))
    assert abs(run.duration_s - 4.9) < 1e-3
    assert any("seconds where MCAP has nanoseconds" in one.what for one in run.problems)


@pytest.mark.parametrize("rest", [NAMES[2:], NAMES[1:]], ids=["the others", "one of both"])
def test_topics_that_name_some_thrusters_each_are_read_together(
    rest: tuple[str, ...], tmp_path: Path
) -> None:
    codes = np.round(50.0 * RATES[:, :1] + 10.0 * np.arange(4))
    parts = {"a": NAMES[:2], "b": rest}
    topics = [
        joints_topic(
            f"/thrusters/{one}/command",
            TIMES,
            [names] * len(TIMES),
            codes[:, [NAMES.index(name) for name in names]],
        )
        for one, names in parts.items()
    ]
    run = read(tmp_path, *topics)
    found = {column: one for one in run.channels.values() for column in one.columns}
    both = set(NAMES[:2]).isdisjoint(rest)
    assert len(found) == (4 if both else max(map(len, parts.values())))
    for column, channel in found.items():
        at = NAMES.index(column.removeprefix("command."))
        own = channel.values[:, channel.columns.index(column)]
        np.testing.assert_allclose(own, codes[:, at])
