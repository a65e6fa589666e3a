"""Channels that contradict another in a way that neither of them shows alone."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, START_NS, Topic, joints_topic, json_topic, rov, ticks, write_log
from scipy.spatial.transform import Rotation

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray

HZ = 20.0
TIMES = ticks(1600, HZ)
T = (np.asarray(TIMES) - START_NS) / 1e9
DEPTH = 4.0 + 0.5 * np.sin(0.7 * T) + 0.4 * np.sin(0.31 * T)


def angles(pitch: float) -> FloatArray:
    yaw = 0.5 + 1.5 * np.sin(0.11 * T)
    return np.stack([0.1 * np.sin(0.5 * T), pitch * np.sin(0.25 * T), yaw], axis=1)


def rates_of(euler: FloatArray) -> FloatArray:
    """Rates of a body with these angles."""
    turn = Rotation.from_euler("ZYX", euler[:, ::-1])
    steps = (turn[:-1].inv() * turn[1:]).as_rotvec()
    return np.asarray(np.concatenate([steps, np.zeros((1, 3))]) * HZ)


def imu(name: str, rates: FloatArray, euler: FloatArray, *, noise: float = 2e-3) -> Topic:
    """An IMU that feels gravity and how a vehicle sinks."""
    sinks = np.gradient(np.gradient(DEPTH, 1.0 / HZ), 1.0 / HZ)
    felt = np.stack([0.0 * T, 0.0 * T, sinks - 9.81], axis=1)
    turned = Rotation.from_euler("ZYX", euler[:, ::-1]).apply(felt, inverse=True)
    noisy = np.random.default_rng(1).standard_normal((2, len(T), 3))
    contents = [
        {"gyro": one.tolist(), "accel": two.tolist()}
        for one, two in zip(rates + noise * noisy[0], turned + 0.01 * noisy[1], strict=True)
    ]
    return json_topic(name, TIMES, contents)


def attitude(euler: FloatArray, name: str = "/ahrs") -> Topic:
    named = [dict(zip(("roll", "pitch", "yaw"), one, strict=True)) for one in euler.tolist()]
    return json_topic(name, TIMES, named)


def depth(values: FloatArray) -> Topic:
    return json_topic("/depth", TIMES, [{"depth": one} for one in values.tolist()])


def read(path: Path, *topics: Topic) -> PoolRun:
    return read_pool_run(write_log(path / "run.mcap", topics), rov(), path)


def said(run: PoolRun) -> str:
    return "\n".join(one.what for one in run.problems if one.severity != "note")


@pytest.mark.parametrize(("pitch", "told"), [(0.1, False), (0.9, True)])
def test_rates_of_the_angles_are_not_those_of_the_body(
    pitch: float, told: bool, tmp_path: Path
) -> None:
    euler = angles(pitch)
    true, of_angles = rates_of(euler), np.gradient(euler, 1.0 / HZ, axis=0)
    yaw = np.concatenate([true[:, :2], of_angles[:, 2:]], axis=1)
    assert "angles" not in said(read(tmp_path, imu("/imu", true, euler), attitude(euler)))
    run = read(tmp_path / "yaw", imu("/imu", yaw, euler), attitude(euler))
    assert ("the rates taken for those of the angles" in said(run)) == told


@pytest.mark.parametrize("knows_attitude", [True, False])
@pytest.mark.parametrize(
    ("factor", "tells"),
    [
        (1.0, ""),
        (9.81, "times the acceleration"),
        (0.5, "times the acceleration"),
        (-1.0, "runs against the acceleration"),
    ],
)
def test_a_depth_swings_as_the_imu_feels_it(
    factor: float, tells: str, knows_attitude: bool, tmp_path: Path
) -> None:
    euler = angles(0.1)
    swinging = 10.0 + factor * DEPTH
    topics = [imu("/imu", rates_of(euler), euler), depth(swinging)]
    run = read(tmp_path, *topics, *([attitude(euler)] if knows_attitude else []))
    assert ("the change of the depth" in said(run)) == bool(tells)
    assert tells in said(run)


def test_an_attitude_of_noise_alone_gives_way_to_one_that_lives(tmp_path: Path) -> None:
    euler = angles(0.1)
    dead = 1e-5 * np.random.default_rng(2).standard_normal(euler.shape)
    gyro = imu("/imu", rates_of(euler), euler)
    run = read(tmp_path, gyro, attitude(dead, "/z/ahrs"), attitude(euler, "/a/ahrs"))
    assert run.channels["attitude"].topic == "/a/ahrs"
    assert "that of /z/ahrs is noise alone" in said(run)
    alone = read(tmp_path / "alone", gyro, attitude(dead))
    assert "moves, and the turning by attitude (/ahrs) does not" in said(alone)


@pytest.mark.parametrize("lives", [True, False])
def test_rates_of_noise_alone_while_the_commands_turn_the_vehicle(
    lives: bool, tmp_path: Path
) -> None:
    euler = angles(0.1)
    codes = np.outer(np.sin(0.5 * T), [60.0, -60.0, 0.0, 0.0])
    topics = [
        imu("/imu", rates_of(euler) * lives, 0.0 * euler),
        joints_topic("/thrusters/command", TIMES, [NAMES] * len(T), codes),
    ]
    assert ("are noise alone while the commands" in said(read(tmp_path, *topics))) != lives


@pytest.mark.parametrize(("late_s", "told"), [(0.0, False), (2.0, True)])
def test_a_column_of_a_table_that_comes_late(late_s: float, told: bool, tmp_path: Path) -> None:
    generator = np.random.default_rng(4)
    rate = np.repeat(generator.uniform(-0.3, 0.3, 40), 40)
    rate = np.convolve(rate, np.full(30, 1 / 30), mode="same")
    yaw = np.interp(T - late_s, T, np.cumsum(rate) / HZ)
    noise = 0.002 * generator.standard_normal((3, len(T)))
    columns = (T, noise[0], noise[1], rate + noise[2], 0.0 * T, 0.0 * T, yaw)
    rows = "".join(",".join(f"{one:.6f}" for one in row) + "\n" for row in np.stack(columns, 1))
    (tmp_path / "run.csv").write_text(f"time [s],p,q,r,roll,pitch,yaw\n{rows}")
    run = read_pool_run(tmp_path / "run.csv", rov(), tmp_path)
    assert ("s behind angular_velocity" in said(run)) == told
