"""The log writer: what it refuses, what it leaves behind, that it repeats itself byte for byte."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from run_log_cases import make_log, make_truth

from pipeline.errors import CannotComputeError
from pipeline.export.log_topics import nanoseconds_of_run
from pipeline.export.mcap_log import write_run_log
from pipeline.simulate.sensors import Channel, Log


def write(path: Path, log: Log, **options: object) -> None:
    chosen: dict = {
        "vehicle_name": "plain",
        "density_kgpm3": 1000.0,
        "gravity_mps2": 9.81,
    } | options
    write_run_log(path, log, **chosen)


def counts(path: Path) -> dict[str, int]:
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    of = summary.statistics.channel_message_counts
    return {channel.topic: of.get(channel.id, 0) for channel in summary.channels.values()}


def spoiled(log: Log, name: str, **changes: object) -> Log:
    return log | {name: dataclasses.replace(log[name], **changes)}  # type: ignore[arg-type]


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    """Whatever the file is called, and in whatever order metadata and channels come."""
    log = make_log(2.0)
    notes = {"seed": "1", "manoeuvre": "steps"}
    write(tmp_path / "a.mcap", log, truth=make_truth(2.0), metadata=notes)
    turned = dict(reversed(log.items()))
    reordered = dict(reversed(notes.items()))
    write(tmp_path / "deep" / "b.mcap", turned, truth=make_truth(2.0), metadata=reordered)
    first = (tmp_path / "a.mcap").read_bytes()
    assert first == (tmp_path / "deep" / "b.mcap").read_bytes()
    write(tmp_path / "c.mcap", make_log(2.0, seed=5), truth=make_truth(2.0), metadata=notes)
    assert first != (tmp_path / "c.mcap").read_bytes()


def test_only_what_was_measured_is_a_topic(tmp_path: Path) -> None:
    log = make_log(1.0)
    write(tmp_path / "a.mcap", {name: log[name] for name in ("command", "depth")})
    assert counts(tmp_path / "a.mcap") == {"/thrusters/command": 51, "/depth": 21}


def test_a_sensor_without_readings_is_a_topic_without_messages(tmp_path: Path) -> None:
    none = np.empty(0)
    log = make_log(1.0) | {"depth": Channel(("depth_m",), none, none, np.empty((0, 1)))}
    write(tmp_path / "a.mcap", log)
    assert counts(tmp_path / "a.mcap")["/depth"] == 0
    write(tmp_path / "b.mcap", {})
    assert counts(tmp_path / "b.mcap") == {}


def test_columns_are_found_by_name(tmp_path: Path) -> None:
    """A channel with its columns in another order gives the same file."""
    log = make_log(1.0)
    imu = log["imu"]
    turned = dataclasses.replace(imu, columns=imu.columns[::-1], values=imu.values[:, ::-1])
    write(tmp_path / "a.mcap", log)
    write(tmp_path / "b.mcap", log | {"imu": turned})
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_arrival_out_of_order_is_sorted(tmp_path: Path) -> None:
    log = make_log(1.0)
    depth = log["depth"]
    late = depth.logged_s.copy()
    late[3] += 0.2
    write(tmp_path / "a.mcap", spoiled(log, "depth", logged_s=late))
    with (tmp_path / "a.mcap").open("rb") as stream:
        messages = make_reader(stream).iter_messages(topics="/depth", log_time_order=False)
        rows = [(message.log_time, message.sequence) for _, _, message in messages]
    assert rows == sorted(rows)
    assert [row for _, row in rows][:8] == [0, 1, 2, 4, 5, 6, 3, 7]


@pytest.mark.parametrize(
    ("name", "changes", "text"),
    [
        ("imu", {"columns": ("p_radps",) * 10}, "imu channel has no column"),
        ("depth", {"logged_s": np.zeros(3)}, "21 times of validity and 3 times of logging"),
        ("dvl", {"values": np.zeros((4, 3))}, "has 4 readings and 8 times"),
        ("position", {"values": np.full((4, 3), np.nan)}, r"point is not a number at 0\.000 s"),
        ("voltage", {"valid_s": np.full(6, np.inf)}, "/battery: a time of the run"),
    ],
)
def test_a_broken_channel_is_refused(
    tmp_path: Path, name: str, changes: dict[str, object], text: str
) -> None:
    with pytest.raises(CannotComputeError, match=text):
        write(tmp_path / "a.mcap", spoiled(make_log(1.0), name, **changes))
    assert list(tmp_path.iterdir()) == []


def test_a_not_a_number_is_named_by_topic_and_time(tmp_path: Path) -> None:
    log = make_log(1.0)
    log["command"].values[7, 2] = np.nan
    with pytest.raises(CannotComputeError, match=r"/thrusters/command.*0\.140 s"):
        write(tmp_path / "a.mcap", log)


def test_an_unknown_channel_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CannotComputeError, match="no topic is defined for sonar"):
        write(tmp_path / "a.mcap", make_log(1.0) | {"sonar": make_log(1.0)["depth"]})


def test_truth_needs_the_names_of_its_thrusters(tmp_path: Path) -> None:
    log = make_log(1.0)
    with pytest.raises(CannotComputeError, match="no command channel"):
        write(tmp_path / "a.mcap", {"depth": log["depth"]}, truth=make_truth(1.0))
    three = log["command"]
    three = Channel(three.columns[:3], three.valid_s, three.logged_s, three.values[:, :3])
    with pytest.raises(CannotComputeError, match="thrust of 5 thrusters, but the names of 3"):
        write(tmp_path / "a.mcap", {"command": three}, truth=make_truth(1.0))


@pytest.mark.parametrize("start_time_ns", [-1, 2**31 * 1_000_000_000])
def test_times_beyond_a_stamp_are_refused_and_nothing_is_lost(
    tmp_path: Path, start_time_ns: int
) -> None:
    """The failure comes after writing has begun: the old file stays, no half of a new one."""
    path = tmp_path / "a.mcap"
    path.write_bytes(b"old")
    with pytest.raises(CannotComputeError, match="1970 to 2038"):
        write(path, make_log(1.0), start_time_ns=start_time_ns)
    assert [one.name for one in tmp_path.iterdir()] == ["a.mcap"]
    assert path.read_bytes() == b"old"


def test_an_unwritable_place_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(CannotComputeError, match=r"a\.mcap: the log of plain cannot be written"):
        write(tmp_path / "file" / "a.mcap", make_log(1.0))


@given(st.integers(0, 10**14), st.integers(0, 2 * 10**18))
def test_whole_nanoseconds_survive(run_ns: int, start_ns: int) -> None:
    """A run of up to a day: seconds as a double hold the nanosecond, the start adds exactly."""
    assert nanoseconds_of_run(np.array([run_ns / 1e9]), start_ns, "/t")[0] == run_ns + start_ns
