"""The log as others read it: two decoders that are not ours, an MCAP reader that is not ours.

rosbags parses container, definitions and CDR with code of its own; mcap-ros2-support decodes the
messages that the MCAP project's reader gives it. Every value and every stamp is compared exactly.
"""

from collections import defaultdict
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import SeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from run_log_cases import DENSITY_KGPM3, GRAVITY_MPS2, THRUSTERS, make_log, make_truth

from pipeline.export.cdr import schema_text
from pipeline.export.mcap_log import DEFAULT_START_TIME_NS, write_run_log
from pipeline.simulate.run import Trajectory
from pipeline.simulate.sensors import Log
from pipeline.types import FloatArray, IntArray

DURATION_S = 3.0
TOPIC_TYPES = {
    "/thrusters/command": "sensor_msgs/msg/JointState",
    "/imu/data": "sensor_msgs/msg/Imu",
    "/dvl/velocity": "geometry_msgs/msg/TwistStamped",
    "/depth": "sensor_msgs/msg/FluidPressure",
    "/position": "geometry_msgs/msg/PointStamped",
    "/thrusters/state": "sensor_msgs/msg/JointState",
    "/battery": "sensor_msgs/msg/BatteryState",
}
TRUTH_TYPES = {
    "/sim/odometry": "nav_msgs/msg/Odometry",
    "/sim/thrusters/thrust": "sensor_msgs/msg/JointState",
}
CHANNELS = ("command", "imu", "dvl", "depth", "position", "shaft_speed", "voltage")
XYZ = ("x", "y", "z")
FRAMES = {
    "/imu/data": "imu_frd",
    "/dvl/velocity": "dvl_frd",
    "/depth": "depth_frd",
    "/position": "ned",
    "/sim/odometry": "ned",
}


@dataclass(frozen=True)
class Written:
    """A file and what was written to it."""

    path: Path
    log: Log
    simulated: Log
    truth: Trajectory


@dataclass(frozen=True)
class Decoded:
    """One message as a decoder gave it."""

    log_time_ns: int
    message: object


Reading = dict[str, list[Decoded]]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    """A log of every channel, its simulated twin and the truth."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    case = Written(path, make_log(DURATION_S), make_log(DURATION_S, seed=7), make_truth(DURATION_S))
    write_run_log(
        path,
        case.log,
        vehicle_name="plain",
        density_kgpm3=DENSITY_KGPM3,
        gravity_mps2=GRAVITY_MPS2,
        truth=case.truth,
        simulated=case.simulated,
        metadata={"seed": "3", "manoeuvre": "zigzag", "effects": "current:north_mps=0.2"},
    )
    return case


def with_rosbags(path: Path) -> Reading:
    reading: Reading = defaultdict(list)
    with AnyReader([path]) as reader:
        for connection, time_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            reading[connection.topic].append(Decoded(time_ns, message))
    return reading


def with_mcap_ros2(path: Path) -> Reading:
    reading: Reading = defaultdict(list)
    with path.open("rb") as stream:
        reader = SeekingReader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, record, message in reader.iter_decoded_messages():
            assert record.publish_time == record.log_time
            reading[channel.topic].append(Decoded(record.log_time, message))
    return reading


@pytest.fixture(scope="module", params=[with_rosbags, with_mcap_ros2])
def reading(written: Written, request: pytest.FixtureRequest) -> Reading:
    """The messages of the file, decoded by one of the two."""
    return request.param(written.path)  # type: ignore[no-any-return]


def field(decoded: list[Decoded], path: str) -> np.ndarray:
    """A field of all messages, as an array with a row a message."""
    get = attrgetter(path)
    return np.array([get(one.message) for one in decoded])


def vector(decoded: list[Decoded], path: str, names: tuple[str, ...] = XYZ) -> np.ndarray:
    return np.stack([field(decoded, f"{path}.{name}") for name in names], axis=1)


def time_ns(time_s: FloatArray) -> IntArray:
    whole = [round(1e9 * float(t)) for t in time_s]
    return np.array(whole) + DEFAULT_START_TIME_NS


def stamps(decoded: list[Decoded]) -> np.ndarray:
    seconds = field(decoded, "header.stamp.sec").astype(np.int64)
    return seconds * 1_000_000_000 + field(decoded, "header.stamp.nanosec").astype(np.int64)


def exactly(got: np.ndarray, expected: np.ndarray) -> None:
    assert got.shape == expected.shape
    assert np.array_equal(got, expected)


def test_topics_are_those_written(reading: Reading) -> None:
    twins = {f"/sim{topic}" for topic in TOPIC_TYPES}
    assert set(reading) == set(TOPIC_TYPES) | twins | set(TRUTH_TYPES)


@pytest.mark.parametrize("prefix", ["", "/sim"])
def test_stamps_are_validity_and_log_times_are_arrival(
    reading: Reading, written: Written, prefix: str
) -> None:
    log = written.simulated if prefix else written.log
    for topic, name in zip(TOPIC_TYPES, CHANNELS, strict=True):
        decoded = reading[prefix + topic]
        exactly(stamps(decoded), time_ns(log[name].valid_s))
        exactly(np.array([one.log_time_ns for one in decoded]), time_ns(log[name].logged_s))
        frame = FRAMES.get(topic, "")
        assert set(field(decoded, "header.frame_id").tolist()) == {frame}


@pytest.mark.parametrize("prefix", ["", "/sim"])
def test_every_measured_value_comes_back(reading: Reading, written: Written, prefix: str) -> None:
    log = written.simulated if prefix else written.log

    def got(topic: str) -> list[Decoded]:
        return reading[prefix + topic]

    exactly(field(got("/thrusters/command"), "position"), log["command"].values)
    exactly(field(got("/thrusters/state"), "velocity"), log["shaft_speed"].values * (np.pi / 30.0))
    imu = log["imu"].values
    exactly(vector(got("/imu/data"), "angular_velocity"), imu[:, 0:3])
    exactly(vector(got("/imu/data"), "linear_acceleration"), imu[:, 3:6])
    exactly(vector(got("/imu/data"), "orientation", ("w", "x", "y", "z")), imu[:, 6:10])
    exactly(vector(got("/dvl/velocity"), "twist.linear"), log["dvl"].values)
    depth = log["depth"].values[:, 0]
    pressure = 101325.0 + DENSITY_KGPM3 * GRAVITY_MPS2 * depth
    exactly(field(got("/depth"), "fluid_pressure"), pressure)
    exactly(vector(got("/position"), "point"), log["position"].values)
    single = log["voltage"].values[:, 0].astype(np.float32)
    exactly(field(got("/battery"), "voltage").astype(np.float32), single)


def test_every_true_value_comes_back(reading: Reading, written: Written) -> None:
    motion, thrust, truth = (
        reading["/sim/odometry"],
        reading["/sim/thrusters/thrust"],
        written.truth,
    )
    for decoded in (motion, thrust):
        exactly(stamps(decoded), time_ns(truth.time_s))
        exactly(np.array([one.log_time_ns for one in decoded]), time_ns(truth.time_s))
    exactly(vector(motion, "pose.pose.position"), truth.position_ned_m)
    exactly(vector(motion, "pose.pose.orientation", ("w", "x", "y", "z")), truth.quaternion)
    exactly(vector(motion, "twist.twist.linear"), truth.nu[:, :3])
    exactly(vector(motion, "twist.twist.angular"), truth.nu[:, 3:])
    exactly(field(thrust, "effort"), truth.thrust_n)
    assert set(field(motion, "header.frame_id").tolist()) == {"ned"}
    assert set(field(motion, "child_frame_id").tolist()) == {"base_link_frd"}


def test_what_is_not_measured_says_so(reading: Reading) -> None:
    """Empty sequences, zero covariances ("unknown") and NaN, as the definitions ask for."""
    for topic, used in (
        ("/thrusters/command", "position"),
        ("/thrusters/state", "velocity"),
        ("/sim/thrusters/thrust", "effort"),
    ):
        assert {tuple(one) for one in field(reading[topic], "name")} == {THRUSTERS}
        for unused in {"position", "velocity", "effort"} - {used}:
            assert field(reading[topic], unused).size == 0
    for name in ("orientation", "angular_velocity", "linear_acceleration"):
        assert not field(reading["/imu/data"], f"{name}_covariance").any()
    assert not vector(reading["/dvl/velocity"], "twist.angular").any()
    assert not field(reading["/depth"], "variance").any()
    assert not field(reading["/sim/odometry"], "pose.covariance").any()
    assert not field(reading["/sim/odometry"], "twist.covariance").any()
    battery = reading["/battery"]
    for name in ("temperature", "current", "charge", "capacity", "design_capacity", "percentage"):
        assert np.isnan(field(battery, name)).all()
    assert field(battery, "present").all()
    assert not field(battery, "power_supply_status").any()
    assert field(battery, "cell_voltage").size == 0
    assert set(field(battery, "serial_number").tolist()) == {""}


@pytest.mark.parametrize("store", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY])
def test_definitions_are_those_of_ros2(store: Stores) -> None:
    """The type hash covers every field's name, type and order, down through all parts."""
    published = get_typestore(store)
    for name in sorted({*TOPIC_TYPES.values(), *TRUTH_TYPES.values()}):
        ours = get_typestore(Stores.EMPTY)
        ours.register(get_types_from_msg(schema_text(name), name))
        assert ours.hash_rihs01(name) == published.hash_rihs01(name), name


def test_summary_counts_index_and_metadata(written: Written) -> None:
    with written.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        records = {record.name: record.metadata for record in reader.iter_metadata()}
    assert header.profile == "ros2"
    assert summary is not None
    assert summary.statistics is not None
    topics = {channel.topic: channel for channel in summary.channels.values()}
    counts = {
        topic: summary.statistics.channel_message_counts[channel.id]
        for topic, channel in topics.items()
    }
    expected = {"/sim/odometry": 151, "/sim/thrusters/thrust": 151}
    for topic, name in zip(TOPIC_TYPES, CHANNELS, strict=True):
        expected[topic] = expected[f"/sim{topic}"] = written.log[name].valid_s.size
    assert counts == expected
    assert summary.statistics.message_count == sum(expected.values())
    assert summary.statistics.chunk_count == len(summary.chunk_indexes)
    for topic, channel in topics.items():
        schema = summary.schemas[channel.schema_id]
        plain = topic.removeprefix("/sim")
        assert schema.name == (TOPIC_TYPES | TRUTH_TYPES).get(topic, TOPIC_TYPES.get(plain))
        assert schema.encoding == "ros2msg"
        assert channel.message_encoding == "cdr"
    assert records["rig2sea.run"] == {
        "seed": "3",
        "manoeuvre": "zigzag",
        "effects": "current:north_mps=0.2",
    }
    assert records["rig2sea.log"] == {
        "layout": "1",
        "vehicle": "plain",
        "start_time_ns": "1700000000000000000",
        "density_kgpm3": "1025.5",
        "gravity_mps2": "9.8155",
        "atmospheric_pressure_pa": "101325.0",
    }
