"""Channels against each other: faults are suspected where they are, and nowhere else."""

from functools import cache
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
    ticks,
    vector,
    write_log,
)
from scipy.spatial.transform import Rotation

from pipeline.ingest.pool_run import read_pool_run
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

RPM = np.pi / 30.0


def excited(seed: int = 0, seconds: float = 60.0) -> tuple[FloatArray, FloatArray]:
    """Commands (k, 4) at 100 Hz and the rates (k, 3) of the vehicle of `rov` that they make."""
    generator = np.random.default_rng(seed)
    count = int(seconds * 100)
    held = generator.uniform(-80, 80, (int(seconds / 1.5) + 1, 4))
    codes = np.repeat(held, 150, axis=0)[:count]
    vehicle = rov()
    arms = np.array([np.cross(one.position_m, one.direction) for one in vehicle.thrusters])
    thrust = 20.0 * codes / 100.0 * np.abs(codes / 100.0)
    push = 0.01 * (thrust @ arms) / [1.0, 2.0, 2.0]
    rate = np.zeros((count, 3))
    for k in range(1, count):
        rate[k] = (1.0 - 0.01 * 1.5) * rate[k - 1] + push[k - 1]
    return codes, rate + 0.003 * generator.standard_normal(rate.shape)


def warnings_of(path: Path, topics: list[Topic], vehicle: Vehicle | None = None) -> str:
    run = read_pool_run(write_log(path / "run.mcap", topics), vehicle or rov(), path)
    return "\n".join(problem.what for problem in run.problems if problem.severity != "note")


def topics_of(codes: FloatArray, rate: FloatArray) -> list[Topic]:
    return [rates_topic(rate.tobytes()), codes_topic(np.asarray(codes, float).tobytes())]


# encoding takes most of the time of these tests, and most of them have one of the two alike
@cache
def rates_topic(rate: bytes) -> Topic:
    rows = np.frombuffer(rate).reshape(-1, 3)
    return imu_topic(ticks(len(rows), 100.0), rows)


@cache
def codes_topic(codes: bytes) -> Topic:
    rows = np.frombuffer(codes).reshape(-1, 4)
    return joints_topic("/thrusters/command", ticks(len(rows), 100.0), [NAMES] * len(rows), rows)


def test_a_run_as_stated_is_not_suspected(tmp_path: Path) -> None:
    assert warnings_of(tmp_path, topics_of(*excited(1))) == ""


@pytest.mark.parametrize(
    ("seed", "order", "two"),
    [(1, [1, 0, 2, 3], "port and starboard"), (2, [0, 2, 1, 3], "starboard and bow")],
)
def test_two_thrusters_that_are_swapped_are_named(
    tmp_path: Path, seed: int, order: list[int], two: str
) -> None:
    codes, rate = excited(seed)
    text = warnings_of(tmp_path, topics_of(codes[:, order], rate))
    assert f"{two} are swapped" in text


@pytest.mark.parametrize(
    ("signs", "says"),
    [((1, 1, -1), "the yaw rate is reversed"), ((-1, -1, -1), "the rates are all reversed")],
)
def test_without_an_attitude_the_moments_tell_the_sign_of_a_rate(
    tmp_path: Path, signs: tuple[int, int, int], says: str
) -> None:
    codes, rate = excited()
    assert f"{says} against the vehicle file" in warnings_of(
        tmp_path, topics_of(codes, rate * signs)
    )


def test_a_thruster_that_is_reversed_is_named(tmp_path: Path) -> None:
    codes, rate = excited()
    text = warnings_of(tmp_path, topics_of(codes * [1, 1, -1, 1], rate))
    assert "bow is reversed" in text


def test_rates_that_have_nothing_to_do_with_the_commands_say_nothing(tmp_path: Path) -> None:
    codes, _ = excited(0)
    _, rate = excited(1)
    assert warnings_of(tmp_path, topics_of(codes, rate)) == ""


def shaft_topic(codes: FloatArray) -> Topic:
    noise = np.random.default_rng(5).standard_normal(codes.shape)
    rpm = 15.0 * codes + 3.0 * noise
    times = ticks(len(codes), 100.0)
    return joints_topic("/thrusters/state", times, [NAMES] * len(codes), RPM * rpm, "velocity")


def test_shaft_speeds_that_agree_are_not_suspected(tmp_path: Path) -> None:
    codes, rate = excited()
    topics = topics_of(codes, rate)
    assert warnings_of(tmp_path, [*topics, shaft_topic(codes)]) == ""
    assert warnings_of(tmp_path, [*topics, shaft_topic(np.abs(codes))]) == ""  # sizes only


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ([1, 0, 2, 3], "It follows the command of starboard"),
        ([0, 1, 2, 2], "the shaft speed of side contradicts its command"),
    ],
)
def test_shaft_speeds_of_another_thruster(tmp_path: Path, change: list[int], says: str) -> None:
    codes, rate = excited()
    assert says in warnings_of(tmp_path, [*topics_of(codes, rate), shaft_topic(codes[:, change])])


@pytest.mark.parametrize("swap", [False, True])
def test_shaft_speeds_of_another_thruster_whose_few_commands_are_held(
    swap: bool, tmp_path: Path
) -> None:
    """Few steps say little of how one speed follows its command, and all of whose it is."""
    steps = np.random.default_rng(4).uniform(30.0, 90.0, (8, 4))
    codes = np.repeat(steps, 500, axis=0)
    shafts = codes[:, [1, 0, 2, 3]] if swap else codes
    text = warnings_of(tmp_path, [codes_topic(codes.tobytes()), shaft_topic(shafts)])
    assert ("It follows the command of starboard" in text) is swap
    assert ("contradicts its command" in text) is swap


@pytest.mark.parametrize(("smallest", "odd"), [(30.0, False), (0.0, True)])
def test_a_shaft_that_reads_noise_in_the_dead_zone(
    tmp_path: Path, smallest: float, odd: bool
) -> None:
    """Commanded to 25 codes where the others turn from 30 on; or from 0 on, and this one not."""
    codes, rate = excited()
    codes = np.where(np.abs(codes) > smallest, codes, 0.0)
    ends = 25.0 / max(float(np.abs(codes[:, 1]).max()), 1.0)
    codes[:, 1] *= ends
    told = warnings_of(tmp_path, [*topics_of(codes, rate), shaft_topic(codes * [1, 0, 1, 1])])
    assert ("starboard contradicts" in told) == odd


def test_a_shaft_that_stands_still_or_turns_the_other_way(tmp_path: Path) -> None:
    codes, rate = excited()
    text = warnings_of(tmp_path, [*topics_of(codes, rate), shaft_topic(codes * [1, 0, -1, 1])])
    assert "the shaft speed of bow contradicts its command" in text
    assert "the other way" in text
    assert "the shaft speed of starboard contradicts its command" in text
    assert "port" not in text
    assert "side" not in text


def attitude_topic(rate: FloatArray) -> Topic:
    turns = [Rotation.identity()]
    for row in rate[:-1]:
        turns.append(turns[-1] * Rotation.from_rotvec(0.01 * row))
    times = ticks(len(rate), 100.0)
    contents = [
        {
            "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "ned"},
            "pose": {"position": vector((0, 0, 0)), "orientation": vector(turn.as_quat())},
        }
        for turn in turns
    ]
    text = "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + "".join(
        f"{'=' * 80}\nMSG: {name}\n{body}\n"
        for name, body in (
            ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
            ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
            ("geometry_msgs/Pose", "Point position\nQuaternion orientation"),
            ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
            ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
        )
    )
    return ros_topic("/pose", "geometry_msgs/msg/PoseStamped", times, contents, text)


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        ([1.0, 1.0, 1.0], ""),
        ([57.3, 57.3, 57.3], "it looks like degrees"),
        ([1000.0, 1000.0, 1000.0], "thousandths"),
        (
            [1.0, -1.0, 1.0],
            "the pitch rate (/imu/data) runs against the turning by attitude (/pose)",
        ),
    ],
)
def test_rates_against_the_attitude(tmp_path: Path, factor: list[float], says: str) -> None:
    _, rate = excited(seconds=30.0)
    topics = [imu_topic(ticks(len(rate), 100.0), rate * factor), attitude_topic(rate)]
    text = warnings_of(tmp_path, topics)
    if says:
        assert says in text
    else:
        assert "rate" not in text


@pytest.mark.parametrize(
    ("sign", "degrees"), [((1, 1, 1), ""), ((-1, -1, -1), "16"), ((1, -1, -1), "15")]
)
def test_down_by_the_accelerometer_against_down_by_the_attitude(
    tmp_path: Path, sign: tuple[int, int, int], degrees: str
) -> None:
    """Bow up by 10 degrees, accelerations of 2 m/s2: only wrong axes are told."""
    times = ticks(1000, 100.0)
    turn = Rotation.from_euler("ZYX", np.radians([150.0, 10.0, 0.0]))
    moving = 2.0 * np.random.default_rng(1).standard_normal((1000, 3))
    force = (moving + turn.inv().apply([0.0, 0.0, -9.81])) * sign
    contents = [
        {"orientation": vector(turn.as_quat()), "linear_acceleration": vector(row)} for row in force
    ]
    text = warnings_of(tmp_path, [json_topic("/imu", times, contents)])
    if degrees:
        assert f"down by the attitude (/imu) are {degrees}" in text
    else:
        assert "down by" not in text


@pytest.mark.parametrize(
    ("force", "degrees"),
    [
        ((0.0, 0.0, -9.81), ""),
        ((4.9, 0.0, -8.5), ""),
        ((0.0, 0.0, 9.81), "180"),
        ((0.0, 9.81, 0.0), "90"),
        ((0.0, 0.0, 0.01), ""),
    ],
)
def test_down_by_the_accelerometer_of_a_log_without_attitude(
    tmp_path: Path, force: tuple[float, float, float], degrees: str
) -> None:
    """Of JSON the axes are taken for forward, right, down; many boards write z up."""
    noise = 0.01 * np.random.default_rng(1).standard_normal((1000, 3))
    contents = [{"linear_acceleration": vector(row)} for row in force + noise]
    text = warnings_of(tmp_path, [json_topic("/imu", ticks(1000, 100.0), contents)])
    if degrees:
        assert f"down by the specific force (/imu) is {degrees} degrees" in text
    else:
        assert "down by" not in text


def test_a_supply_in_millivolts(tmp_path: Path) -> None:
    vehicle = rov()
    data = vehicle.model_dump(mode="json")
    data["sensors"] = {"voltage": {"rate_hz": 10.0, "nominal_v": 48.0}}
    vehicle = Vehicle.model_validate(data)
    volts = 47_000.0 + 20.0 * np.random.default_rng(0).standard_normal(300)
    times = ticks(300, 10.0)
    contents = [{"data": float(value)} for value in volts]
    topic = ros_topic("/battery/volts", "std_msgs/msg/Float64", times, contents, "float64 data")
    assert "looks like thousandths" in warnings_of(tmp_path, [topic], vehicle)


@pytest.mark.parametrize("seconds", [4, 10])
def test_a_steady_command_does_not_tell_how_the_speed_follows_it(
    tmp_path: Path, seconds: int
) -> None:
    """The shaft spins up for 1.2 s and keeps its speed; an autopilot trims the command a little."""
    t = np.arange(100 * seconds) / 100.0
    trim = np.outer(np.sin(2.0 * t) + (t > 1.0), [8.0, 6.0, 4.0, 8.0])
    codes = np.array([60.0, 50.0, 70.0, -60.0]) + trim
    shafts = np.where(t[:, None] < 1.2, 0.0, [40.0, 20.0, 70.0, -60.0])
    _, rate = excited()
    told = warnings_of(tmp_path, [*topics_of(codes, rate[: t.size]), shaft_topic(shafts)])
    assert "contradicts its command" not in told


def test_the_noise_of_a_shaft_that_is_hardly_commanded_says_nothing(tmp_path: Path) -> None:
    codes, rate = excited()
    codes[:, 3] = 0.01 * codes[:, 3]
    noisy = codes.copy()
    noisy[:, 3] = np.random.default_rng(3).standard_normal(len(codes))
    text = warnings_of(tmp_path, [*topics_of(codes, rate), shaft_topic(noisy)])
    assert "shaft speed of side" not in text


def tilting(count: int = 2000) -> tuple[list[int], FloatArray, FloatArray]:
    """Times at 50 Hz, rates (k, 3) and specific force (k, 3) of a vehicle that tilts."""
    t = np.arange(count) / 50.0
    turn = Rotation.from_euler(
        "ZYX", np.stack([0.1 * t, 0.15 * np.sin(0.5 * t), 0.1 * np.sin(0.8 * t + 0.3)], axis=1)
    )
    rate = (turn[:-1].inv() * turn[1:]).as_rotvec() * 50.0
    noise = np.random.default_rng(2).standard_normal((count, 3))
    force = turn.inv().apply([0.0, 0.0, -9.81]) + 0.05 * noise
    return ticks(count, 50.0).tolist(), np.concatenate([rate, rate[-1:]]), force


@pytest.mark.parametrize(
    ("factor", "said"),
    [(1.0, ""), (57.3, "it looks like degrees"), (-1.0, "runs against")],
)
def test_rates_against_the_turning_of_gravity(factor: float, said: str, tmp_path: Path) -> None:
    times, rate, force = tilting()
    codes = 40.0 + 10.0 * np.sin(np.outer(np.arange(len(times)) / 50.0, [0.4, 0.5, 0.6, 0.7]))
    topics = [
        imu_topic(times, factor * rate, forces=force),
        joints_topic("/thrusters/command", times, [NAMES] * len(times), codes),
    ]
    warned = warnings_of(tmp_path, topics)
    assert said in warned
    assert ("the turning by specific_force (/imu/data)" in warned) == bool(said)


def test_swapped_rates_show_in_the_turning_of_gravity(tmp_path: Path) -> None:
    times, rate, force = tilting()
    said = warnings_of(tmp_path, [imu_topic(times, rate[:, [1, 0, 2]], forces=force)])
    assert "With the axes x and y swapped it would agree" in said


def test_a_position_that_points_up(tmp_path: Path) -> None:
    times, rate, force = tilting()
    depth = 2.0 + 0.5 * np.sin(np.arange(len(times)) / 200.0)
    topics = [
        imu_topic(times, rate, forces=force),
        json_topic("/depth", times, [{"depth": one} for one in depth]),
        json_topic("/pose", times, [{"pose": {"position": vector([1, 2, -one])}} for one in depth]),
    ]
    assert "the downward position (/pose) runs against the motion by depth (/depth)" in warnings_of(
        tmp_path, topics
    )


def test_a_pressure_in_bars(tmp_path: Path) -> None:
    times, rate, force = tilting()
    bars = 1.2 + 0.05 * np.sin(np.arange(len(times)) / 200.0)
    topics = [
        imu_topic(times, rate, forces=force),
        json_topic("/pressure", times, [{"pressure": one} for one in bars]),
    ]
    assert "bar, dbar, psi" in warnings_of(tmp_path, topics)


def test_thrusters_that_push_more_and_less_than_stated_are_not_swapped(tmp_path: Path) -> None:
    """Two that pitch the vehicle alike, one strong and one weak, look like each other."""
    thrusters = [
        one.model_copy(update={"position_m": (-0.8, 0.0, 0.0), "direction": (0.0, 0.0, 1.0)})
        if one.name == "side"
        else one
        for one in rov().thrusters
    ]
    vehicle = rov().model_copy(update={"thrusters": tuple(thrusters)})
    arms = np.array([np.cross(one.position_m, one.direction) for one in thrusters])
    arms *= np.array([1.0, 1.0, 1.4, 0.55])[:, None]
    codes, _ = excited(3)
    thrust = 20.0 * codes / 100.0 * np.abs(codes / 100.0)
    push = 0.01 * (thrust @ arms) / [1.0, 2.0, 2.0]
    rate = np.zeros((len(codes), 3))
    for k in range(1, len(codes)):
        rate[k] = 0.985 * rate[k - 1] + push[k - 1]
    rate += 0.003 * np.random.default_rng(4).standard_normal(rate.shape)
    assert "swapped" not in warnings_of(tmp_path, topics_of(codes, rate), vehicle)
