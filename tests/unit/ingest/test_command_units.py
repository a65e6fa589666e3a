"""What commands without a unit are taken for: codes, pulse widths, shares."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, joints_topic, rov, ticks, write_log

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
