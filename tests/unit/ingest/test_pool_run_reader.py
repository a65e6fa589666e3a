"""The whole reader: logs of every encoding, with faults, against what was written."""

import dataclasses
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import (
    NAMES,
    SECOND_NS,
    START_NS,
    Topic,
    array_topic,
    imu_topic,
    joints_topic,
    json_topic,
    log_bytes,
    messages_one_by_one,
    ros_topic,
    rov,
    stamp,
    ticks,
    vector,
    write_log,
)
from scipy.spatial.transform import Rotation
from test_mcap_protobuf import block, descriptor_set, double, number

from pipeline.errors import InputError
from pipeline.export.mcap_log import write_run_log
from pipeline.ingest.pool_run import read_pool_run, resample, summarize
from pipeline.records.run_arrays import PoolRun
from pipeline.simulate.sensors import Channel
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

RATE = ("p_radps", "q_radps", "r_radps")


def rates(count: int, seed: int = 0) -> FloatArray:
    time_s = np.arange(count) / 100.0
    slow = np.stack([np.sin(0.7 * time_s), np.cos(1.1 * time_s), np.sin(2.0 * time_s)], axis=1)
    return 0.2 * slow + 0.002 * np.random.default_rng(seed).standard_normal((count, 3))


def codes(count: int) -> FloatArray:
    time_s = np.arange(count)[:, None] / 50.0
    return np.round(60.0 * np.sin(np.array([0.5, 0.8, 1.3, 0.3]) * time_s))


def read(path: Path, vehicle: Vehicle | None = None) -> PoolRun:
    return read_pool_run(path, vehicle or rov(), path.parent)


def said(run: PoolRun, severity: str | None = None) -> str:
    return "\n".join(p.what for p in run.problems if severity in (None, p.severity))


def warned(run: PoolRun) -> list[str]:
    return [problem.what for problem in run.problems if problem.severity != "note"]


def standard(count: int = 1000) -> list[Topic]:
    times = ticks(count, 100.0)
    slow = ticks(count // 2, 50.0)
    return [
        imu_topic(times, rates(count)),
        joints_topic("/thrusters/command", slow, [NAMES] * slow.size, codes(slow.size)),
    ]


def simulated_log(seconds: float = 20.0) -> dict[str, Channel]:
    generator = np.random.default_rng(0)

    def one(columns: tuple[str, ...], rate_hz: float, delay_s: float = 0.0) -> Channel:
        time = np.arange(int(seconds * rate_hz)) / rate_hz
        values = generator.standard_normal((time.size, len(columns)))
        return Channel(columns, time, time + delay_s, values)

    return {
        "command": one(NAMES, 50.0),
        "imu": one((*RATE, "fx_mps2", "fy_mps2", "fz_mps2", "qw", "qx", "qy", "qz"), 100.0, 0.005),
        "dvl": one(("vx_mps", "vy_mps", "vz_mps"), 8.0, 0.1),
        "depth": one(("depth_m",), 20.0, 0.02),
        "position": one(("north_m", "east_m", "down_m"), 2.0, 0.3),
        "shaft_speed": one(NAMES, 20.0),
        "voltage": one(("supply_v",), 5.0),
    }


def test_our_own_logs_come_back_as_they_were_written(tmp_path: Path) -> None:
    """The layout of docs/formats_log.md needs no mapping; times to the nanosecond."""
    log = simulated_log()
    path = tmp_path / "run.mcap"
    write_run_log(
        path, log, vehicle_name="trial", density_kgpm3=1010.0, gravity_mps2=9.81,
        simulated={"imu": log["imu"]},
    )  # fmt: skip
    run = read(path)
    expected = {
        "thruster_command": ("command", log["command"].values),
        "angular_velocity": ("imu", log["imu"].values[:, :3]),
        "specific_force": ("imu", log["imu"].values[:, 3:6]),
        "attitude": ("imu", log["imu"].values[:, 6:]),
        "velocity": ("dvl", log["dvl"].values),
        "position": ("position", log["position"].values),
        "depth": ("depth", log["depth"].values),
        "shaft_speed": ("shaft_speed", log["shaft_speed"].values),
        "voltage": ("voltage", log["voltage"].values),
    }
    assert set(run.channels) == set(expected)
    for name, (source, values) in expected.items():
        channel = run.channels[name]
        tolerance = {"depth": 1e-9, "voltage": 1e-6, "shaft_speed": 1e-12}.get(name, 0.0)
        np.testing.assert_allclose(channel.values, values, rtol=tolerance, atol=tolerance)
        times = START_NS + np.rint(log[source].valid_s * SECOND_NS).astype(np.int64)
        np.testing.assert_array_equal(channel.time_ns, times)
        assert channel.delay_s == 0.0
        assert channel.clock.used == "header"
    assert run.channels["thruster_command"].columns == tuple(f"command.{name}" for name in NAMES)
    assert not [name for name in run.channels if run.channels[name].topic.startswith("/sim")]


def test_fast_and_slow_give_the_same_arrays(tmp_path: Path) -> None:
    """Names that change their order, lengths that change, a broken message in the midst."""
    times = ticks(400, 50.0)
    names = [NAMES if i % 3 else NAMES[::-1] for i in range(400)]
    values = np.random.default_rng(0).standard_normal((400, 4))
    joints = joints_topic("/thrusters/command", times, names, values)
    joints.messages[100] = joints.messages[100][:30]
    joints.messages[200] = b""
    path = write_log(tmp_path / "run.mcap", [joints, imu_topic(ticks(800, 100.0), rates(800))])
    fast = read(path)
    with messages_one_by_one():
        slow = read(path)
    assert fast.channels.keys() == slow.channels.keys()
    for name, channel in fast.channels.items():
        other = slow.channels[name]
        np.testing.assert_array_equal(channel.values, other.values)
        np.testing.assert_array_equal(channel.time_ns, other.time_ns)
        assert channel.marks.keys() == other.marks.keys()
        for mark, rows in channel.marks.items():
            np.testing.assert_array_equal(rows, other.marks[mark])
    assert fast.problems == slow.problems
    command = fast.channels["thruster_command"]
    assert np.flatnonzero(command.marks["broken"]).tolist() == [100, 200]
    assert np.isnan(command.values[[100, 200]]).all()
    expected = np.where((np.arange(400) % 3 > 0)[:, None], values, values[:, ::-1])
    good = ~command.marks["broken"]
    np.testing.assert_array_equal(command.values[good], expected[good])
    assert "2 of 400 messages cannot be decoded" in said(fast)


def test_json_with_the_same_fields_needs_no_mapping(tmp_path: Path) -> None:
    times = ticks(500, 50.0)
    values = rates(500)
    imu = json_topic(
        "/imu",
        times,
        [
            {
                "header": {"stamp": stamp(time - 4_000_000)},
                "angular_velocity": vector(row),
                "linear_acceleration": vector((0.0, 0.1, -9.8)),
            }
            for time, row in zip(times, values, strict=True)
        ],
    )
    commands = json_topic("/motor/command", times, [{"data": list(row)} for row in codes(500)])
    run = read(write_log(tmp_path / "run.mcap", [imu, commands]))
    np.testing.assert_array_equal(run.channels["angular_velocity"].values, values)
    np.testing.assert_array_equal(run.channels["angular_velocity"].time_ns, times - 4_000_000)
    np.testing.assert_array_equal(run.channels["thruster_command"].values, codes(500))
    assert run.channels["thruster_command"].clock.used == "log"


@pytest.mark.parametrize("order", ["xyzw", "wxyz", "zwyx"])
@pytest.mark.parametrize("stated", ["", "xyzw", "wxyz"])
def test_components_with_names_may_come_in_any_order(
    tmp_path: Path, order: str, stated: str
) -> None:
    """A program that sorts the members of an object writes the w of a quaternion first."""
    times = ticks(200, 50.0)
    turn = Rotation.from_euler("ZYX", np.radians([100.0, 5.0, -3.0])).as_quat()
    orientation = {name: float(turn["xyzw".index(name)]) for name in order}
    rate = dict(zip("zxy", (0.3, 0.1, 0.2), strict=True))
    messages = [{"orientation": orientation, "angular_velocity": rate}] * len(times)
    channel = {"quantity": "attitude_quaternion", "topic": "/imu"}
    mapped = [channel | {"order": stated}] if stated else []
    run = read(
        write_log(tmp_path / "run.mcap", [json_topic("/imu", times, messages)]),
        rov(channels=mapped),
    )
    np.testing.assert_array_equal(run.channels["attitude"].values[0], turn[[3, 0, 1, 2]])
    np.testing.assert_array_equal(run.channels["angular_velocity"].values[0], [0.1, 0.2, 0.3])


def test_protobuf_by_its_descriptor(tmp_path: Path) -> None:
    times = ticks(300, 10.0)
    messages = [
        block(1, number(1, int(time) // SECOND_NS) + number(2, int(time) % SECOND_NS))
        + double(2, 0.01 * i)
        for i, time in enumerate(times)
    ]
    topic = Topic("/d", "rig.Reading", "protobuf", descriptor_set(), "protobuf", times, messages)
    run = read(write_log(tmp_path / "run.mcap", [topic]), rov(channels=[
        {"quantity": "depth", "topic": "/d", "field": "depth", "unit": "cm"}
    ]))  # fmt: skip
    np.testing.assert_allclose(run.channels["depth"].values[:, 0], 1e-4 * np.arange(300))
    default = read(write_log(tmp_path / "run.mcap", [topic]))
    np.testing.assert_allclose(default.channels["depth"].values[:, 0], 1e-2 * np.arange(300))


def test_every_part_of_a_mapping_is_obeyed(tmp_path: Path) -> None:
    times = ticks(200, 50.0)
    raw = np.random.default_rng(0).uniform(-1, 1, (200, 9))
    raw[:, 0] = 1000.0 + np.arange(200) * 20.0  # the board's milliseconds
    vehicle = rov(
        defaults=False,
        channels=[
            {
                "quantity": "angular_velocity",
                "topic": "all",
                "field": ["data[3]", "data[1:3]"],
                "unit": "deg/s",
                "sign": [1, -1, 1],
                "body_axes": "flu",
                "clock_field": "data[0]",
                "clock_unit": "ms",
                "delay_s": 0.25,
            },
            {
                "quantity": "thruster_command",
                "topic": "/all",
                "field": "data",
                "index": [7, 5],
                "unit": "ratio",
                "thrusters": ["bow", "port"],
                "sign": -1,
            },
        ],
    )
    run = read(write_log(tmp_path / "run.mcap", [array_topic("/all", times, raw)]), vehicle)
    rate = run.channels["angular_velocity"]
    expected = np.radians(raw[:, [3, 1, 2]]) * [1, -1, 1] * [1, -1, -1]
    np.testing.assert_allclose(rate.values, expected, rtol=1e-15)
    assert rate.clock.used == "field"
    assert np.abs(rate.time_ns - times).max() < 1000
    assert rate.delay_s == 0.25
    command = run.channels["thruster_command"]
    assert command.columns == ("command.bow", "command.port")
    np.testing.assert_allclose(command.values, -100.0 * raw[:, [7, 5]])


@pytest.mark.parametrize(
    ("quantity", "body", "earth", "source", "expected"),
    [
        ("angular_velocity", "flu", "ned", (1, 2, 3), (1, -2, -3)),
        ("specific_force", "fur", "ned", (1, 2, 3), (1, 3, -2)),
        ("velocity", "frd", "ned", (1, 2, 3), (1, 2, 3)),
        ("position", "frd", "enu", (1, 2, 3), (2, 1, -3)),
        ("velocity_earth", "frd", "nwu", (1, 2, 3), (1, -2, -3)),
    ],
)
def test_vectors_are_turned_into_our_axes(  # noqa: PLR0917  one case a line
    tmp_path: Path, quantity: str, body: str, earth: str, source: object, expected: object
) -> None:
    channel = {
        "quantity": quantity,
        "topic": "/a",
        "field": "data",
        "body_axes": body,
        "earth_axes": earth,
    }
    topic = array_topic("/a", ticks(20, 10.0), [source] * 20)
    run = read(write_log(tmp_path / "run.mcap", [topic]), rov(channels=[channel]))
    assert run.channels[quantity].values[0].tolist() == list(expected)


@pytest.mark.parametrize("body", ["frd", "flu", "fur"])
@pytest.mark.parametrize("earth", ["ned", "enu", "nwu"])
def test_attitudes_are_turned_into_our_axes(tmp_path: Path, body: str, earth: str) -> None:
    """A vector known in source axes on both sides must come out right in ours."""
    turn = {
        "frd": np.eye(3),
        "flu": np.diag([1.0, -1.0, -1.0]),
        "fur": np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]),
        "ned": np.eye(3),
        "enu": np.array([[0, 1.0, 0], [1.0, 0, 0], [0, 0, -1.0]]),
        "nwu": np.diag([1.0, -1.0, -1.0]),
    }
    true = Rotation.random(20, rng=np.random.default_rng(0))
    source = [
        Rotation.from_matrix(turn[earth].T @ one.as_matrix() @ turn[body]).as_quat() for one in true
    ]
    channel = {
        "quantity": "attitude_quaternion",
        "topic": "/a",
        "field": "data",
        "body_axes": body,
        "earth_axes": earth,
    }
    topic = array_topic("/a", ticks(20, 10.0), source)
    run = read(write_log(tmp_path / "run.mcap", [topic]), rov(channels=[channel]))
    found = Rotation.from_quat(run.channels["attitude"].values[:, [1, 2, 3, 0]])
    assert (found * true.inv()).magnitude().max() < 1e-12


def test_euler_angles_become_a_quaternion(tmp_path: Path) -> None:
    angles = np.random.default_rng(0).uniform(-1.2, 1.2, (20, 3))
    channel = {"quantity": "attitude_euler", "topic": "/a", "field": "data", "unit": "deg"}
    topic = array_topic("/a", ticks(20, 10.0), np.degrees(angles).tolist())
    run = read(write_log(tmp_path / "run.mcap", [topic]), rov(channels=[channel]))
    found = Rotation.from_quat(run.channels["attitude"].values[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(found.as_euler("ZYX")[:, ::-1], angles, atol=1e-12)


def test_standard_messages_are_in_ros_axes_unless_the_frame_says_otherwise(tmp_path: Path) -> None:
    values = rates(200)
    for frame, sign in (("imu_link", [1, -1, -1]), ("imu_frd", [1, 1, 1])):
        path = write_log(tmp_path / "r.mcap", [imu_topic(ticks(200, 100.0), values, frame=frame)])
        channel = read(path).channels["angular_velocity"]
        np.testing.assert_array_equal(channel.values, values * sign)
        assert "body axes" in channel.read.notes[0]


def test_pulse_widths_are_recognised(tmp_path: Path) -> None:
    pwm = 1500.0 + 4.0 * codes(200)
    topic = array_topic("/mavros/rc/out", ticks(200, 50.0), np.hstack([pwm, pwm]).tolist())
    run = read(write_log(tmp_path / "run.mcap", [topic]))
    command = run.channels["thruster_command"]
    np.testing.assert_allclose(command.values, codes(200))
    assert command.read.unit == "us"
    assert command.read.unit_from == "values"
    assert "the first 4 of 8 elements are taken" in command.read.notes


def commands_apart(values: FloatArray) -> list[Topic]:
    """A topic of commands for each thruster, from values (k, 4)."""
    times = ticks(len(values), 50.0)
    return [
        ros_topic(
            f"/thruster/{name}/command", "std_msgs/msg/Float64", times,
            [{"data": float(value)} for value in values[:, i]], "float64 data",
        )
        for i, name in enumerate(NAMES)
    ]  # fmt: skip


def test_a_topic_for_each_thruster(tmp_path: Path) -> None:
    topics = commands_apart(codes(100))
    run = read(write_log(tmp_path / "run.mcap", topics))
    assert set(run.channels) == {f"thruster_command.{name}" for name in NAMES}
    table = resample(run, 50.0)
    assert table.thrusters == NAMES
    np.testing.assert_array_equal(table.values["command"], codes(100))
    numbered = [
        Topic(**{**topic.__dict__, "name": f"/motors/{10 - i}/command"})
        for i, topic in enumerate(topics)
    ]
    run = read(write_log(tmp_path / "run.mcap", numbered))
    assert run.channels["thruster_command.port"].topic == "/motors/7/command"


def test_a_thruster_that_is_switched_has_the_unit_of_the_others(tmp_path: Path) -> None:
    ratios = codes(200) / 100.0
    ratios[:, 1] = np.sign(ratios[:, 1])
    run = read(write_log(tmp_path / "run.mcap", commands_apart(ratios)))
    for i, name in enumerate(NAMES):
        channel = run.channels[f"thruster_command.{name}"]
        assert channel.read.unit == "ratio"
        np.testing.assert_allclose(channel.values[:, 0], 100.0 * ratios[:, i])


def test_thrusters_that_are_all_switched_are_asked_about(tmp_path: Path) -> None:
    switched = np.sign(codes(200))
    run = read(write_log(tmp_path / "run.mcap", commands_apart(switched)))
    assert "-1, 0 and 1 alone and were taken for codes" in said(run, "warning")
    stated = [
        {"quantity": "thruster_command", "topic": f"/thruster/{name}/command", "field": ["data"],
         "unit": "code", "thrusters": [name]}
        for name in NAMES
    ]  # fmt: skip
    run = read(tmp_path / "run.mcap", rov(channels=stated))
    assert "alone" not in said(run)


def test_a_clean_log_is_not_complained_about(tmp_path: Path) -> None:
    run = read(write_log(tmp_path / "run.mcap", standard()))
    assert warned(run) == []
    record = summarize(run)
    assert record.complete
    assert {channel.name: channel.readings for channel in record.channels} == {
        "angular_velocity": 1000,
        "specific_force": 1000,
        "thruster_command": 500,
    }
    assert type(record).model_validate_json(record.model_dump_json()) == record


# ------------------------------------------------------------------ bad input


def test_no_thruster_topic(tmp_path: Path) -> None:
    run = read(write_log(tmp_path / "run.mcap", standard()[:1]))
    assert "there are no thruster commands" in said(run, "error")
    assert "/imu/data" in said(run, "error")


def test_nothing_known_at_all(tmp_path: Path) -> None:
    text = ros_topic("/chatter", "std_msgs/msg/String", [1], [{"data": "x"}], "string data")
    with pytest.raises(InputError, match=r"/chatter \(std_msgs/msg/String, cdr, 1 messages\)"):
        read(write_log(tmp_path / "run.mcap", [text]))
    with pytest.raises(InputError, match="holds no messages"):
        read(write_log(tmp_path / "run.mcap", []))


def test_unknown_schema_and_encoding_are_explained(tmp_path: Path) -> None:
    times = ticks(10, 10.0)
    strange = [
        Topic("/a", "x/Y", "flatbuffer", b"..", "cdr", times, [b"\0\1\0\0"] * 10),
        Topic("/b", "x/Y", "", b"", "msgpack", times, [b"abcd"] * 10),
        Topic("/c", "x/msg/Y", "ros2msg", b"Missing x", "cdr", times, [b"\0\1\0\0"] * 10),
    ]
    run = read(write_log(tmp_path / "run.mcap", [*standard(), *strange]))
    why = {topic.topic: topic.why_not for topic in run.topics}
    assert "flatbuffer" in why["/a"]
    assert '"msgpack"' in why["/b"]
    assert "Missing is not defined in it" in why["/c"]
    with pytest.raises(InputError, match="flatbuffer"):
        read(write_log(tmp_path / "run.mcap", strange))


def test_a_wrong_mapping_is_told_and_the_rest_is_read(tmp_path: Path) -> None:
    vehicle = rov(channels=[
        {"quantity": "depth", "topic": "/none"},
        {"quantity": "voltage", "topic": "/imu/data", "field": "volts"},
        {"quantity": "velocity", "topic": "/imu/data", "field": "orientation"},
        {"quantity": "shaft_speed", "topic": "/imu/data", "field": "angular_velocity", "index": [7],
         "thrusters": ["bow"]},
    ])  # fmt: skip
    run = read(write_log(tmp_path / "run.mcap", standard()), vehicle)
    assert set(run.channels) == {"thruster_command", "angular_velocity", "specific_force"}
    text = said(run, "warning")
    assert "entry 1 (depth, /none): there is no such topic. The log has /imu/data" in text
    assert 'no number at "volts"; its messages have header.stamp.sec' in text
    assert "orientation gives 4 numbers, velocity has 3" in text
    assert "index 7 is beyond the 3 numbers" in text


@pytest.mark.parametrize("order", [1, -1])
def test_a_clock_stated_for_one_channel_is_that_of_its_topic(tmp_path: Path, order: int) -> None:
    """The header of the messages is 0.3 s old; the board's count is not, and is stated once."""
    times = ticks(200, 50.0)
    contents = [
        {"header": {"stamp": stamp(int(time) - 300_000_000)}, "w": row, "deep": 2.0 + 0.01 * k,
         "count": 20 * k}
        for k, (time, row) in enumerate(zip(times, rates(200).tolist(), strict=True))
    ]  # fmt: skip
    log = write_log(tmp_path / "run.mcap", [json_topic("/nav", times, contents)])
    channels = [
        {"quantity": "angular_velocity", "topic": "/nav", "field": "w"},
        {"quantity": "depth", "topic": "/nav", "field": "deep", "clock_field": "count",
         "clock_unit": "ms"},
    ]  # fmt: skip
    run = read(log, rov(channels=channels[::order]))
    assert run.channels["depth"].clock.used == "field"
    np.testing.assert_array_equal(run.channels["depth"].time_ns, times)
    assert "two clocks" not in said(run)
    channels[0]["clock"] = "header"
    assert "two clocks are stated for /nav" in said(read(log, rov(channels=channels)), "warning")


def test_commands_outside_of_the_range(tmp_path: Path) -> None:
    values = codes(500)
    values[100:110, 2] = 150.0
    topic = joints_topic("/thrusters/command", ticks(500, 50.0), [NAMES] * 500, values)
    run = read(write_log(tmp_path / "run.mcap", [topic]))
    assert "outside of the drive's range, -100 to 100: bow 10 (-60 to 150)" in said(run)
    assert run.channels["thruster_command"].marks["outside_range"].sum() == 10
    assert run.channels["thruster_command"].values.max() == 150.0  # nothing is clipped


def test_not_a_number_constant_gaps_and_duplicates(tmp_path: Path) -> None:
    values = rates(1000)
    values[50] = np.nan
    times = ticks(1000, 100.0)
    times[600:] += 2 * SECOND_NS
    times[300] = times[299]
    values[300] = values[299]
    forces = np.tile([0.0, 0.0, -9.81], (1000, 1))
    run = read(write_log(tmp_path / "run.mcap", [imu_topic(times, values, forces=forces)]))
    text = said(run, "warning")
    assert "1 of 1000 readings (0.1 %) are marked not a number" in text
    assert "marked after gap" in text
    assert "first at 8.000 s" in text
    assert "marked duplicate" in text
    assert "specific_force (/imu/data) never changes" in text


def test_a_clock_that_jumps(tmp_path: Path) -> None:
    times = ticks(1000, 100.0)
    stamps = times.copy()
    stamps[500:] += 100 * SECOND_NS
    topic = imu_topic(times, rates(1000), stamps_ns=stamps)
    run = read(write_log(tmp_path / "run.mcap", [topic]))
    assert "/imu/data: the clock jumps by +100.000 s at 5.000 s" in said(run, "warning")
    assert np.abs(run.channels["angular_velocity"].time_ns - times).max() < SECOND_NS // 100


@pytest.mark.parametrize("wild_ns", [0, 2**63 - 1, 2**64 - 1])
def test_one_wild_time_of_the_recorder_does_not_stretch_the_run(
    tmp_path: Path, wild_ns: int
) -> None:
    topics = standard()
    topics[1] = dataclasses.replace(
        topics[1], times_ns=[wild_ns, *(int(time) for time in topics[1].times_ns[1:])]
    )
    run = read(write_log(tmp_path / "run.mcap", topics))
    assert run.duration_s == pytest.approx(9.99)
    assert "not compared" not in said(run, "warning")


@pytest.mark.parametrize(
    ("step_s", "says", "left"),
    [
        (-3600, "the times of the log go back by 3599.990 s", 500),
        (3_000_000, "no part of the run: 500 of 1000 of /imu/data, 250 of 500 of /thrust", 1000),
        (-3_000_000, "no part of the run: 500 of 1000 of /imu/data, 250 of 500 of /thrust", 500),
    ],
)
def test_a_clock_of_the_recorder_that_is_set_during_the_run_is_told(
    tmp_path: Path, step_s: int, says: str, left: int
) -> None:
    """As that of a board without a battery is, when it first reaches a time server."""
    fast, slow = ticks(1000, 100.0), ticks(500, 50.0)
    fast[500:] += step_s * SECOND_NS
    slow[250:] += step_s * SECOND_NS
    topics = [
        imu_topic(fast, rates(1000)),
        joints_topic("/thrusters/command", slow, [NAMES] * 500, codes(500)),
    ]
    run = read(write_log(tmp_path / "run.mcap", topics, by_time=False))
    assert says in said(run, "warning")
    assert run.channels["angular_velocity"].usable().sum() == left
    assert "the first at -35" not in said(run)  # times count from the start of the run


def test_a_log_that_was_cut_off(tmp_path: Path) -> None:
    whole = log_bytes(standard())
    path = tmp_path / "run.mcap"
    path.write_bytes(whole[: len(whole) // 2])
    run = read(path)
    assert not run.complete
    assert 0 < run.channels["angular_velocity"].time_ns.size < 1000
    assert "without its closing record" in said(run, "warning")
    assert run.read_bytes < run.size_bytes


@pytest.mark.parametrize(
    ("factor", "says"), [(1000.0, "milli"), (0.001, "kilo"), (1.0 / 9.81, "multiples of g")]
)
def test_forces_in_another_unit(tmp_path: Path, factor: float, says: str) -> None:
    forces = factor * (np.array([0.0, 0.0, -9.81]) + rates(1000))
    topic = imu_topic(ticks(1000, 100.0), rates(1000), forces=forces)
    run = read(write_log(tmp_path / "run.mcap", [topic]))
    assert "specific_force (/imu/data) is" in said(run, "warning")
    assert says in said(run, "warning")


def test_depth_in_millimetres(tmp_path: Path) -> None:
    values = 3000.0 + 800.0 * np.sin(np.arange(500) / 30.0)
    topic = json_topic("/depth", ticks(500, 10.0), [{"depth": 20.0 * value} for value in values])
    run = read(write_log(tmp_path / "run.mcap", [topic]))
    assert "off by a factor such as 1000" in said(run, "warning")


@given(st.data())
def test_damaged_messages_never_break_the_reader(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Wild numbers, times, lengths and names are told, marked or refused, whatever they are."""
    topics = standard(60)
    for topic in topics:
        for _ in range(data.draw(st.integers(0, 4))):
            row = data.draw(st.integers(0, len(topic.messages) - 1))
            content = bytearray(topic.messages[row])
            at = data.draw(st.integers(0, len(content) - 1))
            some = data.draw(st.binary(min_size=1, max_size=8))
            content[at : at + len(some)] = some
            topic.messages[row] = bytes(content)
    path = write_log(tmp_path_factory.mktemp("damaged") / "run.mcap", topics)
    with suppress(InputError):
        run = read(path)
        summarize(run).model_dump_json()
        resample(run, 20.0)
        with messages_one_by_one():
            slow = read(path)
        for name, channel in run.channels.items():
            np.testing.assert_array_equal(channel.values, slow.channels[name].values)
            np.testing.assert_array_equal(channel.time_ns, slow.channels[name].time_ns)
