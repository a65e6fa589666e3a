"""Channels of one motion at different times, or in axes that are turned against each other."""

import re
from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, SECOND_NS, Topic, joints_topic, json_topic, rov, ticks, write_log
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from pipeline.ingest.pool_run import read_pool_run
from pipeline.types import FloatArray

HZ = 20.0
TIMES = ticks(2400, HZ)


def lagging(values: FloatArray, lag_s: float) -> FloatArray:
    share = 1.0 - np.exp(-1.0 / (HZ * lag_s))
    return np.asarray(lfilter([share], [1.0, share - 1.0], values, axis=0))


def motion(seed: int = 0) -> dict[str, FloatArray]:
    """What a vehicle with four thrusters in steps of its own does; body axes SNAME."""
    generator = np.random.default_rng(seed)
    codes = np.repeat(generator.uniform(-90.0, 90.0, (60, 4)), 40, axis=0)
    thrust = codes * np.abs(codes) / 100.0**2
    thrusters = rov().thrusters
    push = thrust @ np.array([one.direction for one in thrusters])
    moment = thrust @ np.array([np.cross(one.position_m, one.direction) for one in thrusters])
    velocity = lagging(push * [0.8, 0.6, 0.4], 2.0)
    rates = lagging(moment * [0.6, 0.3, 4.0], 0.5)
    rates[:, :2] -= lagging(rates[:, :2], 2.0)  # righted
    turn = [Rotation.identity()]
    for rate in rates[:-1]:
        turn.append(turn[-1] * Rotation.from_rotvec(rate / HZ))
    attitude = Rotation.concatenate(turn)
    accelerated = np.gradient(velocity, 1.0 / HZ, axis=0) + np.cross(rates, velocity)
    noise = generator.standard_normal((len(codes), 3))
    return {
        "command": codes,
        "rates": rates + 1e-3 * noise,
        "attitude": attitude.as_quat(),
        "dvl": velocity + 5e-3 * noise[:, ::-1],
        "force": accelerated - attitude.inv().apply([0.0, 0.0, 9.81]) + 2e-2 * noise,
        "depth": 50.0 + np.cumsum(attitude.apply(velocity)[:, 2:], axis=0) / HZ,
    }


def warned(path: Path, moved: dict[str, FloatArray], late_s: dict[str, float]) -> str:
    at = {name: TIMES + round(late_s.get(name, 0.0) * SECOND_NS) for name in moved}
    heads = {
        "rates": "angular_velocity",
        "force": "linear_acceleration",
        "attitude": "orientation",
        "dvl": "velocity",
    }
    topics: list[Topic] = [
        joints_topic("/thrusters/command", at["command"], [NAMES] * 2400, moved["command"])
    ]
    for name, head in heads.items():
        if name in moved:
            rows = [{head: dict(zip("xyzw", one, strict=False))} for one in moved[name].tolist()]
            topics.append(json_topic(f"/{name}", at[name], rows))
    if "depth" in moved:
        depth = [{"depth": one} for (one,) in moved["depth"].tolist()]
        topics.append(json_topic("/depth", at["depth"], depth))
    run = read_pool_run(write_log(path / "run.mcap", topics), rov(), path)
    return "\n".join(one.what for one in run.problems if one.severity == "warning")


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("without", [(), ("dvl",), ("attitude",), ("force", "rates"), ("rates",)])
def test_a_sound_run_is_not_suspected(seed: int, without: tuple[str, ...], tmp_path: Path) -> None:
    moved = {name: one for name, one in motion(seed).items() if name not in without}
    assert warned(tmp_path, moved, {"dvl": 0.15, "depth": 0.1, "attitude": 0.05}) == ""


@pytest.mark.parametrize("late_s", [2.0, 0.7])
@pytest.mark.parametrize(
    ("late", "early"),
    [("rates", "attitude"), ("attitude", "rates"), ("dvl", "depth"), ("depth", "dvl")],
)
def test_a_topic_that_is_late(late: str, early: str, late_s: float, tmp_path: Path) -> None:
    told = warned(tmp_path, motion(), {late: late_s})
    found = re.search(rf"\(/{late}\) is ([0-9.]+) s behind \w+ \(/{early}\)", told)
    assert found is not None
    assert float(found[1]) == pytest.approx(late_s, abs=0.3)


def test_commands_that_are_late(tmp_path: Path) -> None:
    told = warned(tmp_path, motion(), {"command": 2.0})
    found = re.search(r"turns -([0-9.]+) s after the commands that turn it", told)
    assert found is not None
    assert float(found[1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("degrees", [90, 180, -90])
def test_an_imu_that_is_mounted_turned(degrees: int, tmp_path: Path) -> None:
    moved = {name: one for name, one in motion().items() if name != "depth"}
    turn = Rotation.from_euler("z", degrees, degrees=True)
    moved["rates"], moved["force"] = (turn.inv().apply(moved[name]) for name in ("rates", "force"))
    moved["attitude"] = (Rotation.from_quat(moved["attitude"]) * turn).as_quat()
    told = warned(tmp_path, moved, {})
    assert "the acceleration that the IMU feels explains" in told
    back = 180 if degrees == 180 else -degrees
    assert f"if it is read turned by {back} degrees" in told


@pytest.mark.parametrize("degrees", [20, -20])
def test_a_dvl_that_is_turned_a_little(degrees: int, tmp_path: Path) -> None:
    moved = motion()
    moved["dvl"] = Rotation.from_euler("z", -degrees, degrees=True).apply(moved["dvl"])
    told = warned(tmp_path, moved, {})
    assert f"if it is read turned by {15 if degrees > 0 else -15} degrees" in told
