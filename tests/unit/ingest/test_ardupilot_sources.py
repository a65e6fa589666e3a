"""Who speaks in telemetry, which outputs drive motors, and which sensors call themselves ill."""

import struct
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from pool_logs import NAMES, rov
from recorded_runs import Run, run, write_bin, write_tlog

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun


def read(path: Path) -> PoolRun:
    return read_pool_run(path, rov(), path.parent)


def is_of(found: PoolRun, one: Run) -> bool:
    rates = found.channels["angular_velocity"].values
    codes = found.channels["thruster_command"].values
    return bool(
        len(rates) == len(one.time_ns) == len(codes)
        and np.abs(rates - one.rates_radps).max() < 1e-3
        and np.abs(codes - (one.command_us - 1500.0) / 4.0).max() < 1.0
    )


def boat(dialect: ModuleType, k: int) -> list[tuple[int, int, Any]]:
    return [
        (2, 1, dialect.MAVLink_heartbeat_message(11, 3, 0, 0, 0, 3)),
        (2, 1, dialect.MAVLink_attitude_message(40 * k, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0)),
        (2, 1, dialect.MAVLink_servo_output_raw_message(40 * k, 0, *[1500] * 8)),
    ]


def gimbal(dialect: ModuleType, k: int) -> list[tuple[int, int, Any]]:
    return [
        (1, 154, dialect.MAVLink_heartbeat_message(26, 8, 0, 0, 0, 3)),
        (1, 154, dialect.MAVLink_attitude_message(40 * k, 0.5, -0.7, 0.3, 1.0, 0.0, 0.0)),
    ]


def companion(dialect: ModuleType, _row: int) -> list[tuple[int, int, Any]]:
    return [(42, 191, dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 0, 3))]


def second_port(dialect: ModuleType, k: int) -> list[tuple[int, int, Any]]:
    message = dialect.MAVLink_servo_output_raw_message(40 * k, 1, *[1100] * 8)
    return [(1, 1, message)]


@pytest.mark.parametrize(
    ("others", "told"), [(boat, "vehicles 2 too"), (gimbal, ""), (companion, ""), (second_port, "")]
)
def test_what_others_say_is_not_mixed_in(
    tmp_path: Path, others: Callable[[ModuleType, int], list[tuple[int, int, Any]]], told: str
) -> None:
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    one = run(100)
    path = write_tlog(tmp_path / "run.tlog", one)
    spoken = b"".join(
        struct.pack(">Q", int(time) // 1000 + 1)
        + message.pack(dialect.MAVLink(None, srcSystem=system, srcComponent=component))
        for k, time in enumerate(one.time_ns)
        for system, component, message in others(dialect, k)
    )
    path.write_bytes(spoken + path.read_bytes())
    found = read(path)
    assert is_of(found, one)
    warned = " ".join(one.what for one in found.problems if one.severity == "warning")
    assert told in warned
    assert told or "vehicles" not in warned


def test_outputs_without_parameters_are_told(tmp_path: Path) -> None:
    path = write_tlog(tmp_path / "run.tlog", run(50))
    assert "no parameter SERVOn_FUNCTION" in " ".join(one.what for one in read(path).problems)


def test_a_motor_on_an_output_that_is_not_logged_moves_no_other(tmp_path: Path) -> None:
    one = run(50)
    path = write_bin(tmp_path / "run.BIN", one)
    text = path.read_bytes().replace(b"SERVO3_FUNCTION\0", b"SERVO9_FUNCTION\0")
    path.write_bytes(text)
    found = read(path)
    codes = found.channels["thruster_command"].values
    expected = (one.command_us - 1500.0) / 4.0
    np.testing.assert_allclose(codes[:, [0, 2, 3]], expected[:, [0, 2, 3]], atol=1e-9)
    said = " ".join(one.what for one in found.problems)
    assert np.isnan(codes[:, 1]).all()
    assert f"{NAMES[1]}: no command is a number" in said


def test_sensors_that_call_themselves_ill_are_left_out(tmp_path: Path) -> None:
    path = write_bin(tmp_path / "run.BIN", run(60), ill=range(20, 30))
    found = read(path)
    for name in ("angular_velocity", "specific_force", "depth"):
        marks = found.channels[name].marks["not_a_number"]
        assert np.flatnonzero(marks).tolist() == list(range(20, 30))


def test_motors_that_change_their_outputs_in_the_log(tmp_path: Path) -> None:
    one = run(100)
    found = read(write_bin(tmp_path / "run.bin", one, (5, 3, 4, 2), rewired=(3, 5, 2, 4)))
    assert is_of(found, one)
    assert [problem.what for problem in found.problems if "SERVO5_FUNCTION" in problem.what]
