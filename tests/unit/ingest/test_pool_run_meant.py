"""A velocity or an order of thrusters that contradicts the motion: told, with what would agree."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pool_logs import (
    NAMES,
    Topic,
    imu_topic,
    joints_topic,
    json_topic,
    rov,
    ticks,
    vector,
    write_log,
)
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from pipeline.ingest.pool_run import read_pool_run
from pipeline.types import FloatArray, IntArray

HZ = 10.0
TIMES = ticks(1200, HZ)
ALL = ("attitude", "rates", "position", "depth")


def lagging(values: FloatArray, lag_s: float) -> FloatArray:
    share = 1.0 - np.exp(-1.0 / (HZ * lag_s))
    return np.asarray(lfilter([share], [1.0, share - 1.0], values, axis=0))


@dataclass
class Motion:
    """Steps of all thrusters of `rov` and what the vehicle does: it goes aside and turns, too."""

    codes: FloatArray
    velocity: FloatArray
    rate: FloatArray
    turn: Rotation
    place: FloatArray


def motion(seed: int = 0) -> Motion:
    generator = np.random.default_rng(seed)
    codes = np.repeat(generator.uniform(-90.0, 90.0, (30, 4)), 40, axis=0)
    thrust = codes * np.abs(codes) / 100.0**2
    thrusters = rov().thrusters
    noise = generator.standard_normal((len(codes), 6)) * [0.01, 0.01, 0.01, 1e-3, 1e-3, 1e-3]
    push = thrust @ np.array([one.direction for one in thrusters])
    moment = thrust @ np.array([np.cross(one.position_m, one.direction) for one in thrusters])
    velocity = lagging(push * [0.5, 0.3, 0.2], 2.0)
    rate = lagging(moment * [0.0, 0.0, 4.0], 1.0)
    turn = Rotation.from_euler("z", (np.cumsum(rate[:, 2]) / HZ + 0.3)[:, None])
    place = np.cumsum(turn.apply(velocity), axis=0) / HZ + [0.0, 0.0, 5.0]
    return Motion(codes, velocity + noise[:, :3], rate + noise[:, 3:], turn, place)


def warned(
    path: Path,
    moved: Motion,
    velocity: FloatArray | None,
    logged: tuple[str, ...] = ALL,
    times: IntArray = TIMES,
) -> str:
    """What is told of a log of commands, this velocity, and some of the other channels."""
    topics: list[Topic] = [
        joints_topic("/thrusters/command", times, [NAMES] * len(times), moved.codes)
    ]
    if velocity is not None:
        named = [dict(zip(("vx", "vy", "vz"), one, strict=True)) for one in velocity.tolist()]
        topics.append(json_topic("/dvl", times, named))
    if "attitude" in logged:
        turns = [{"orientation": vector(one)} for one in moved.turn.as_quat()]
        topics.append(json_topic("/ahrs", times, turns))
    if "rates" in logged:
        topics.append(imu_topic(times, moved.rate))
    if "position" in logged:
        places = [{"pose": {"position": vector(one)}} for one in moved.place]
        topics.append(json_topic("/pose", times, places))
    if "depth" in logged:
        topics.append(json_topic("/depth", times, [{"depth": one} for one in moved.place[:, 2]]))
    run = read_pool_run(write_log(path / "run.mcap", topics), rov(), path)
    return "\n".join(one.what for one in run.problems if one.severity == "warning")


def beams(velocity: FloatArray, azimuths_deg: list[float]) -> FloatArray:
    angle, slant = np.radians(azimuths_deg), np.radians(22.5)
    look = np.stack([np.sin(slant) * np.cos(angle), np.sin(slant) * np.sin(angle)], axis=1)
    return velocity @ np.column_stack([look, np.full(3, np.cos(slant))]).T


def turned(degrees: float) -> Callable[[Motion], FloatArray]:
    return lambda moved: Rotation.from_euler("z", -degrees, degrees=True).apply(moved.velocity)


def over_earth(moved: Motion) -> FloatArray:
    return np.asarray(moved.turn.apply(moved.velocity))


LOGGED = [ALL, ("depth",), ("attitude", "position"), ("attitude", "depth"), ("rates", "depth"), ()]


@pytest.mark.parametrize("logged", LOGGED)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_sound_velocity_is_not_suspected(
    seed: int, logged: tuple[str, ...], tmp_path: Path
) -> None:
    moved = motion(seed)
    said = warned(tmp_path, moved, moved.velocity, logged)
    assert "contradicts" not in said
    assert "the rate of" not in said
    assert "swapped" not in said


@pytest.mark.parametrize("logged", LOGGED)
@pytest.mark.parametrize("degrees", [45, -45, 90, 135])
def test_a_dvl_that_is_mounted_turned(
    degrees: int, logged: tuple[str, ...], tmp_path: Path
) -> None:
    moved = motion()
    said = warned(tmp_path, moved, turned(degrees)(moved), logged)
    assert "the velocity (/dvl) contradicts the motion" in said
    assert f"turned by {degrees} degrees (sensors: dvl: rotation_deg)" in said


@pytest.mark.parametrize("logged", [("attitude",), ("attitude", "depth"), ("rates", "depth")])
@pytest.mark.parametrize("axes", ["ned", "enu"])
def test_a_velocity_over_the_earth_without_a_position(
    axes: str, logged: tuple[str, ...], tmp_path: Path
) -> None:
    moved = motion()
    earth = over_earth(moved)
    if axes == "enu":
        earth = earth[:, [1, 0, 2]] * [1.0, 1.0, -1.0]
        logged = tuple(one for one in logged if one != "depth")  # it would tell that z points up
    said = warned(tmp_path, moved, earth, logged)
    assert f"% if stated as {{quantity: velocity_earth, earth_axes: {axes}}}" in said


@pytest.mark.parametrize("logged", [ALL, ("depth",), ()])
@pytest.mark.parametrize("signs", [[-1, 1, 1], [1, -1, 1], [1, 1, -1]])
def test_one_axis_that_is_reversed(
    signs: list[int], logged: tuple[str, ...], tmp_path: Path
) -> None:
    moved = motion()
    assert f"{{sign: {signs}}}" in warned(tmp_path, moved, moved.velocity * signs, logged)


def felt(moved: Motion) -> Topic:
    """What an IMU at the centre of mass feels."""
    gained = np.gradient(moved.velocity, 1.0 / HZ, axis=0) + np.cross(moved.rate, moved.velocity)
    return imu_topic(TIMES, moved.rate, forces=gained - [0.0, 0.0, 9.81])


def told_by_the_imu(path: Path, moved: Motion, velocity: FloatArray, quantity: str) -> str:
    named = [dict(zip(("vx", "vy", "vz"), one, strict=True)) for one in velocity.tolist()]
    turns = [{"orientation": vector(one)} for one in moved.turn.as_quat()]
    topics = [felt(moved), json_topic("/dvl", TIMES, named), json_topic("/ahrs", TIMES, turns)]
    channel = {"quantity": quantity, "topic": "/dvl", "field": ["vx", "vy", "vz"]}
    vehicle = rov(channels=[channel])
    run = read_pool_run(write_log(path / "run.mcap", topics), vehicle, path)
    return "\n".join(one.what for one in run.problems)


@pytest.mark.parametrize("arm_m", [0.0, 1.2])
def test_a_dvl_away_from_the_imu(arm_m: float, tmp_path: Path) -> None:
    moved = motion()
    velocity = moved.velocity + np.cross(moved.rate, [arm_m, 0.0, 0.0])
    said = told_by_the_imu(tmp_path, moved, velocity, "velocity")
    assert ("m from the IMU (sensors: dvl: position_m)" in said) == (arm_m > 0.0)


@pytest.mark.parametrize("degrees", [0.0, 32.0, -32.0])
def test_a_dvl_that_is_tilted(degrees: float, tmp_path: Path) -> None:
    moved = motion()
    tilted = Rotation.from_euler("y", -degrees, degrees=True).apply(moved.velocity)
    said = told_by_the_imu(tmp_path, moved, tilted, "velocity")
    assert (f"tilted by {degrees / 32 * 30:.0f} degrees about y" in said) == bool(degrees)


@pytest.mark.parametrize("signs", [[1, 1, 1], [-1, 1, 1], [1, -1, 1]])
def test_an_axis_of_the_earth_that_is_reversed(signs: list[int], tmp_path: Path) -> None:
    moved = motion()
    said = told_by_the_imu(tmp_path, moved, over_earth(moved) * signs, "velocity_earth")
    assert (f"{{sign: {signs}}}" in said) == (min(signs) < 0)


@pytest.mark.parametrize("logged", [ALL, ("depth",), ()])
@pytest.mark.parametrize("azimuths_deg", [[45, 135, 225], [45, 225, 135], [0, 120, 240]])
def test_speeds_along_beams(
    azimuths_deg: list[float], logged: tuple[str, ...], tmp_path: Path
) -> None:
    moved = motion()
    said = warned(tmp_path, moved, beams(moved.velocity, azimuths_deg), logged)
    assert "as speeds along the beams of a DVL" in said


@pytest.mark.parametrize("logged", [("attitude",), ("attitude", "depth")])
def test_swapped_thrusters_show_in_the_attitude(logged: tuple[str, ...], tmp_path: Path) -> None:
    moved = motion()
    assert "swapped" not in warned(tmp_path, moved, None, logged)
    moved.codes = moved.codes[:, [1, 0, 2, 3]]
    said = warned(tmp_path, moved, None, logged)
    assert "port and starboard are swapped against the vehicle file" in said


@pytest.mark.parametrize(
    ("order", "two"), [([0, 3, 2, 1], "starboard and side"), ([2, 1, 0, 3], "port and bow")]
)
def test_swapped_thrusters_show_in_the_velocity(order: list[int], two: str, tmp_path: Path) -> None:
    moved = motion()
    moved.codes = moved.codes[:, order]
    said = warned(tmp_path, moved, moved.velocity, ())
    assert f"% if {two} are swapped" in said


def hovering(seed: int, current_mps: tuple[float, float]) -> Motion:
    """A vehicle that is held against a current at a steady heading, and does not quite stay."""
    generator = np.random.default_rng(seed)
    codes = np.tile([30.0, 30.0, 0.0, 20.0], (1200, 1)) + generator.normal(0.0, 2.0, (1200, 4))
    thrust = codes * np.abs(codes) / 100.0**2
    push = thrust @ np.array([one.direction for one in rov().thrusters])
    turn = Rotation.from_euler("z", 0.3 + 0.02 * np.sin(0.02 * np.arange(1200))[:, None])
    drift = turn.inv().apply([*current_mps, 0.0])
    noise = generator.normal(0.0, 0.01, (1200, 6))
    velocity = lagging(push * [0.5, 0.3, 0.2], 2.0) + drift + noise[:, :3]
    place = np.cumsum(turn.apply(velocity), axis=0) / HZ + [0.0, 0.0, 5.0]
    return Motion(codes, velocity, 0.1 * noise[:, 3:], turn, place)


@pytest.mark.parametrize("current_mps", [(-0.3, 0.1), (-0.35, -0.2), (0.1, -0.3)])
@pytest.mark.parametrize("logged", [("attitude", "rates"), ("attitude", "rates", "depth")])
def test_a_vehicle_that_drifts_in_a_current_is_not_suspected(
    logged: tuple[str, ...], current_mps: tuple[float, float], tmp_path: Path
) -> None:
    moved = hovering(1, current_mps)
    assert "contradicts the motion" not in warned(tmp_path, moved, moved.velocity, logged)


STEADY = np.arange(0.0, 40.0, 1.0 / HZ)
AHEAD = np.stack([np.full(STEADY.size, 60.0)] * 2 + [np.zeros(STEADY.size)] * 2, axis=1)


def steady(path: Path, codes: FloatArray, velocity: list[float]) -> str:
    """What is told of a run at one speed, straight on: nothing but signs and directions tell."""
    swing = 0.01 * np.sin(0.8 * STEADY)[:, None]
    moved = Motion(
        codes,
        np.array(velocity) + swing,
        0.1 * swing * [1.0, 1.0, 1.0],
        Rotation.from_euler("z", np.full((STEADY.size, 1), 0.3)),
        np.zeros((STEADY.size, 3)),
    )
    return warned(path, moved, moved.velocity, ("attitude", "rates"), ticks(STEADY.size, HZ))


@pytest.mark.parametrize(
    ("signs", "velocity", "words"),
    [
        ([1, 1], [0.3, 0.0, 0.0], ""),
        ([-1, -1], [0.3, 0.0, 0.0], "is against the push of the thrusters"),
        ([1, -1], [0.3, 0.0, 0.0], "turn the vehicle one way all the time"),
    ],
)
def test_a_steady_run_against_its_commands(
    signs: list[int], velocity: list[float], words: str, tmp_path: Path
) -> None:
    said = steady(tmp_path, AHEAD * [*signs, 1, 1], velocity)
    assert words in said
    assert bool(words) == ("push of the thrusters" in said or "one way" in said)


@pytest.mark.parametrize("signs", [[1, 1, 1, 1], [1, -1, 1, 1]])
@pytest.mark.parametrize("seed", [0, 1, 3, 6])
def test_a_reversed_thruster_in_a_short_run(seed: int, signs: list[int], tmp_path: Path) -> None:
    rows, whole = slice(0, 200), motion(seed)
    moved = Motion(
        whole.codes[rows] * signs,
        whole.velocity[rows],
        whole.rate[rows],
        whole.turn[rows],
        whole.place[rows],
    )
    said = warned(tmp_path, moved, None, ("attitude", "rates"), TIMES[rows])
    assert ("starboard is reversed" in said) == (signs != [1, 1, 1, 1])
