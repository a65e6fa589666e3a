"""Bad logs through ``rig2sea check``: each has its one clear message, and none ends in a fault."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pool_logs import (
    NAMES,
    SECOND_NS,
    START_NS,
    Topic,
    imu_topic,
    joints_topic,
    json_topic,
    log_bytes,
    ros_topic,
    rov,
    stamp,
    ticks,
)

from pipeline.cli import cli
from pipeline.types import FloatArray

HZ = 50.0
COUNT = 1500
TIMES = ticks(COUNT, HZ)
SECONDS = np.arange(COUNT) / HZ


def codes() -> FloatArray:
    return np.round(60.0 * np.sin(np.array([0.5, 0.8, 1.3, 0.3]) * SECONDS[:, None]))


def rates() -> FloatArray:
    """What the moments of the commands make of a body with drag: the vehicle file is right."""
    arms = np.array([np.cross(one.position_m, one.direction) for one in rov().thrusters])
    effort = codes() / 60.0
    moment = 2.0 * (effort * np.sqrt(np.abs(effort))) @ arms
    rate = np.zeros((COUNT, 3))
    for k in range(COUNT - 1):
        rate[k + 1] = rate[k] + (moment[k] - 0.8 * rate[k]) / HZ
    return rate + 0.002 * np.random.default_rng(0).standard_normal(rate.shape)


def good(
    *, command: FloatArray | None = None, rate: FloatArray | None = None, **imu: object
) -> list[Topic]:
    commands = codes() if command is None else command
    return [
        imu_topic(TIMES, rates() if rate is None else rate, **imu),
        joints_topic("/thrusters/command", TIMES, [NAMES] * COUNT, commands),
    ]


def shafts(speed: FloatArray) -> Topic:
    return joints_topic("/thrusters/state", TIMES, [NAMES] * COUNT, speed, "velocity")


def depths(values: FloatArray) -> Topic:
    contents = [
        {"header": {"stamp": stamp(time)}, "depth": float(value)}
        for time, value in zip(TIMES, values, strict=True)
    ]
    return json_topic("/depth", TIMES, contents)


def empty() -> bytes:
    return b""


def forty_bytes() -> bytes:
    return b"not a log at all, merely some forty byte"


def forty_bytes_that_begin_well() -> bytes:
    return log_bytes(good())[:40]


def no_messages() -> bytes:
    return log_bytes([])


def truncated() -> bytes:
    data = log_bytes(good())
    return data[: len(data) * 2 // 3]


def no_thrusters() -> bytes:
    return log_bytes(good()[:1])


def unknown_schema() -> bytes:
    text = "weird encoding of a definition"
    odd = Topic("/thrusters/command", "a/B", "capnp", text.encode(), "cdr", TIMES, [b"x"] * COUNT)
    return log_bytes([good()[0], odd])


def unknown_message() -> bytes:
    odd = ros_topic("/odd", "odd_msgs/msg/Odd", TIMES, [{"x": 1.0}] * COUNT, "float64 x")
    return log_bytes([odd])


def outside_the_range() -> bytes:
    return log_bytes(good(command=3.0 * codes()))


def swapped() -> bytes:
    return log_bytes(good(command=codes()[:, [1, 0, 2, 3]]))


def clock_jumps() -> bytes:
    stamps = TIMES.copy()
    stamps[700] += 5000 * SECOND_NS
    return log_bytes(good(stamps_ns=stamps))


def not_numbers() -> bytes:
    rate = rates()
    rate[100:130] = np.nan
    return log_bytes(good(rate=rate, forces=np.nan_to_num(rate) - [0.0, 0.0, 9.81]))


def constant() -> bytes:
    return log_bytes([*good(), depths(np.full(COUNT, 1.5))])


def contradicting_rpm() -> bytes:
    return log_bytes([*good(), shafts(codes() * np.array([1.0, 1.0, -1.0, 1.0]))])


def forces_in_milli() -> bytes:
    forces = 1000.0 * (np.tile([0.0, 0.0, -9.81], (COUNT, 1)) + 0.01 * rates())
    return log_bytes(good(forces=forces))


def rates_in_milli() -> bytes:
    return log_bytes(good(rate=1000.0 * rates()))


def depth_in_millimetres() -> bytes:
    return log_bytes([*good(), depths(30_000.0 + 500.0 * np.sin(SECONDS))])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "trial" / "pool").mkdir(parents=True)
    vehicle = rov().model_dump(mode="json", exclude_defaults=True)
    (tmp_path / "trial" / "vehicle.yaml").write_text(json.dumps(vehicle))
    return tmp_path / "trial"


def check(folder: Path, data: bytes, name: str = "run.mcap") -> tuple[int, str]:
    path = folder / "pool" / name
    path.write_bytes(data)
    result = CliRunner().invoke(cli, ["check", str(path)])
    assert "fault of rig2sea" not in result.output
    assert "Traceback" not in result.output
    return result.exit_code, result.output


def test_a_good_log_shows_what_was_understood(folder: Path) -> None:
    code, text = check(folder, log_bytes(good()))
    assert code == 0
    assert "warning" not in text.replace("0 warnings", "")
    assert "2023-11-14 22:13:20 UTC, 30.0 s" in text
    assert "angular_velocity from /imu/data angular_velocity in rad/s" in text
    assert "1500 readings, 50 Hz" in text
    assert "clock: stamp in the message" in text
    assert "command.port -60 to 60" in text


@pytest.mark.parametrize(
    ("make", "exit_code", "says"),
    [
        (empty, 1, "the file is empty"),
        (forty_bytes, 1, "this is not MCAP: 40 bytes that begin with"),
        (
            forty_bytes_that_begin_well,
            1,
            "the log was cut off after 40 bytes and holds no messages",
        ),
        (no_messages, 1, "the log holds no messages"),
        (truncated, 0, "without its closing record: the recorder was stopped hard"),
        (no_thrusters, 1, "there are no thruster commands; the run cannot be simulated"),
        (unknown_schema, 1, 'its definition is written in "capnp"'),
        (unknown_message, 1, "/odd (odd_msgs/msg/Odd, cdr, 1500 messages)"),
        (
            outside_the_range,
            0,
            "lie outside of the drive's range, -100 to 100: port 967 (-180 to 180)",
        ),
        (swapped, 0, "port and starboard are swapped"),
        (clock_jumps, 0, "marked clock jump: its clock jumped here"),
        (not_numbers, 0, "30 of 1500 readings (2 %) are marked not a number"),
        (constant, 0, "depth (/depth) never changes: the sensor is dead or not connected"),
        (contradicting_rpm, 0, "the shaft speed of bow contradicts its command"),
        (forces_in_milli, 0, "it looks like thousandths (milli)"),
        (rates_in_milli, 0, "its unit is probably off by a factor such as 1000"),
        (depth_in_millimetres, 0, "its unit is probably off by a factor such as 1000"),
    ],
)
def test_each_has_its_message(
    folder: Path, make: Callable[[], bytes], exit_code: int, says: str
) -> None:
    code, text = check(folder, make())
    told = [part for part in text.split("\n\n") if part.startswith(("error: ", "warning: "))]
    assert code == exit_code, text
    assert sum(says in part for part in told) == 1, text
    # one thing is wrong, so one thing is said, or two where it also shows elsewhere
    assert len(told) <= 2, text
    assert all("run.mcap" in part for part in told)


def test_a_wild_stamp_costs_no_other_reading(folder: Path) -> None:
    _, text = check(folder, clock_jumps())
    assert "    marked: clock jump (1)\n" in text
    assert "1500 readings, 50 Hz, 0.00 to 29.98 s, longest gap 0.04 s" in text


def test_the_same_as_json_and_for_the_whole_vehicle(folder: Path) -> None:
    (folder / "pool" / "run.mcap").write_bytes(log_bytes(good()))
    (folder / "pool" / "run.yaml").write_text("who: A\nballast: [{what: lead, mass_kg: 0.5}]\n")
    (folder / "pool" / "broken.mcap").write_bytes(b"")
    (folder / "pool" / "stray.yaml").write_text("who: B\n")
    result = CliRunner().invoke(cli, ["check", str(folder), "--json"])
    assert result.exit_code == 1
    found = json.loads(result.output)
    assert [Path(run["file"]).name for run in found["runs"]] == ["broken.mcap", "run.mcap"]
    assert found["runs"][0]["run"] is None
    run = found["runs"][1]["run"]
    assert run["start_time_ns"] == START_NS
    assert {one["name"] for one in run["channels"]} == {
        "angular_velocity",
        "specific_force",
        "thruster_command",
    }
    assert run["notes"]["ballast"][0]["mass_kg"] == 0.5
    told = [problem for problem in found["problems"] if problem["severity"] != "note"]
    places = {Path(problem["file"]).name: problem["what"] for problem in told}
    assert places.keys() == {"broken.mcap", "stray.yaml"}
    assert "no run stray that" in places["stray.yaml"]


def test_wrong_notes_are_told_and_the_run_is_read(folder: Path) -> None:
    (folder / "pool" / "run.yaml").write_text("wo: A\n")
    code, text = check(folder, log_bytes(good()))
    assert code == 1
    assert 'run.yaml, row 1: unknown key "wo"' in text
    assert "command.port -60 to 60" in text


def test_notes_alone_are_shown(folder: Path) -> None:
    path = folder / "pool" / "run.yaml"
    path.write_text("who: [A, B]\nbattery_v: 24.5\n")
    result = CliRunner().invoke(cli, ["check", str(path)])
    assert result.exit_code == 0, result.output
    assert "notes of a pool run\n  who: A; B\n  battery_v: 24.5" in result.output
