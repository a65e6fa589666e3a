"""What commands without a unit are taken for: codes, pulse widths, shares."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, imu_topic, joints_topic, rov, ticks, write_log

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import RunChannel
from pipeline.types import FloatArray

COUNT = 200


def commands(tmp_path: Path, values: FloatArray, *records: str) -> RunChannel:
    topic = joints_topic("/thrusters/command", ticks(COUNT, 50.0), [NAMES] * COUNT, values)
    path = write_log(tmp_path / "run.mcap", [topic], metadata={name: {} for name in records})
    return read_pool_run(path, rov(), tmp_path).channels["thruster_command"]


def waves(size: float, middle: float = 0.0) -> FloatArray:
    phase = 0.05 * np.arange(COUNT)[:, None] + np.arange(4)
    return middle + size * np.sin(phase)


@pytest.mark.parametrize(
    ("size", "middle", "unit", "largest"),
    [
        (0.4, 0.0, "ratio", 40.0),
        (400.0, 1500.0, "us", 100.0),
        (40.0, 0.0, "code", 40.0),
    ],
)
def test_joint_states_are_told_by_their_numbers(
    tmp_path: Path, size: float, middle: float, unit: str, largest: float
) -> None:
    channel = commands(tmp_path, waves(size, middle))
    assert (channel.read.unit, channel.read.unit_from) == (unit, "values")
    assert np.abs(channel.values).max() == pytest.approx(largest, rel=0.01)
    assert any(f"commands are taken for {unit}" in note for note in channel.read.notes)


def test_tiny_commands_of_our_own_logs_are_codes(tmp_path: Path) -> None:
    channel = commands(tmp_path, waves(0.4), "rig2sea.log")
    assert (channel.read.unit, channel.read.unit_from) == ("code", "message")
    assert np.abs(channel.values).max() <= 0.4


def test_tiny_commands_of_a_foreign_log_are_ratios(tmp_path: Path) -> None:
    assert commands(tmp_path, waves(0.4), "rig2sea.run").read.unit == "ratio"


def halves(*, rests: bool) -> FloatArray:
    """Commands of 0 to 1 about 0.5, with rest between, or as they are without it."""
    values = waves(0.3, 0.5)
    if rests:
        values[:50] = values[-50:] = 0.5
    return values


def test_commands_that_rest_at_a_half_are_signed(tmp_path: Path) -> None:
    values = halves(rests=True)
    channel = commands(tmp_path, values)
    assert channel.values == pytest.approx(200.0 * (values - 0.5))


@pytest.mark.parametrize(
    "values",
    [
        halves(rests=False),
        np.where(halves(rests=True) == 0.5, 1100.0, waves(200.0, 1310.0)),
        np.round(255.0 * halves(rests=True) - 0.5),
    ],
)
def test_commands_that_may_mean_two_things_are_refused(tmp_path: Path, values: FloatArray) -> None:
    topics = [
        imu_topic(ticks(COUNT, 50.0), 0.1 * waves(0.1)[:, :3]),
        joints_topic("/thrusters/command", ticks(COUNT, 50.0), [NAMES] * COUNT, values),
    ]
    path = write_log(tmp_path / "run.mcap", topics)
    run = read_pool_run(path, rov(), tmp_path)
    assert "thruster_command" not in run.channels
    assert any("either" in one.what and one.severity == "error" for one in run.problems)


@pytest.mark.parametrize(("neutral", "full"), [(0.5, 200.0), (0.0, 100.0)])
def test_a_stated_rest_and_a_sign_turn_about_it(
    tmp_path: Path, neutral: float, full: float
) -> None:
    values, times = waves(0.3, 0.5), ticks(COUNT, 50.0)
    stated = {
        "quantity": "thruster_command",
        "topic": "/thrusters/command",
        "field": "position",
        "unit": "ratio",
        "neutral": neutral,
        "sign": -1,
    }
    topic = joints_topic("/thrusters/command", times, [NAMES] * COUNT, values)
    path = write_log(tmp_path / "run.mcap", [topic])
    channel = read_pool_run(path, rov(channels=[stated]), tmp_path).channels["thruster_command"]
    assert channel.values == pytest.approx(-full * (values - neutral))


@pytest.mark.parametrize(("code_max", "told"), [(100, False), (400, True)])
def test_codes_that_may_be_per_cent_are_told(tmp_path: Path, code_max: int, told: bool) -> None:
    topic = joints_topic("/thrusters/command", ticks(COUNT, 50.0), [NAMES] * COUNT, waves(60.0))
    path = write_log(tmp_path / "run.mcap", [topic])
    drive = rov().drive.model_copy(update={"code_min": -code_max, "code_max": code_max})
    run = read_pool_run(path, rov().model_copy(update={"drives": {"drive": drive}}), tmp_path)
    assert any("may be per cent" in one.what for one in run.problems) == told
