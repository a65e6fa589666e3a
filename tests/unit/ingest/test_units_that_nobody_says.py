"""Units, axes and flags that nobody states: what numbers tell is said, of right ones nothing."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, Topic, imu_topic, joints_topic, json_topic, ros_topic, rov, ticks
from pool_logs import write_log as write
from recorded_runs import run, write_bin, write_db3

from pipeline.errors import InputError
from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray

TIMES = ticks(400, 10.0)
T = np.arange(400) / 10.0
RATES = 0.05 * np.stack([np.sin(T), np.cos(0.7 * T), np.sin(0.3 * T)], axis=1)


def read(path: Path, topics: list[Topic], code_max: int = 100) -> PoolRun:
    vehicle = rov()
    drive = vehicle.drives["drive"].model_copy(update={"code_min": -code_max, "code_max": code_max})
    vehicle = vehicle.model_copy(update={"drives": {"drive": drive}})
    return read_pool_run(write(path / "run.mcap", topics), vehicle, path)


def warned(found: PoolRun) -> str:
    return "\n".join(one.what for one in found.problems if one.severity == "warning")


def number(name: str, values: FloatArray) -> Topic:
    contents = [{"data": float(one)} for one in values]
    return ros_topic(name, "std_msgs/msg/Float64", TIMES, contents, "float64 data")


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (100.0, True), (1000.0, True)])
def test_a_steady_depth_in_another_unit(factor: float, told: bool, tmp_path: Path) -> None:
    depth = factor * (4.0 + 0.002 * np.sin(T))
    found = read(tmp_path, [imu_topic(TIMES, RATES), number("/depth", depth)])
    assert ("nobody says that it is in m" in warned(found)) == told


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (7.0, True), (9.55, True)])
def test_tips_that_are_too_fast(factor: float, told: bool, tmp_path: Path) -> None:
    speed = factor * 200.0 * np.abs(np.sin(np.outer(T, [0.5, 0.6, 0.7, 0.8])))
    shafts = joints_topic("/thrusters/state", TIMES, [NAMES] * 400, speed, "velocity")
    found = read(tmp_path, [imu_topic(TIMES, RATES), shafts])
    assert ("more than is possible under water" in warned(found)) == told


def codes_of(code_max: int, most: float) -> FloatArray:
    """Commands in steps of a code, which a limit holds."""
    wanted = 1.3 * code_max * np.sin(np.outer(T, [0.5, 0.6, 0.7, 0.8]))
    return np.round(np.clip(wanted, -most * code_max, most * code_max))


@pytest.mark.parametrize(
    ("codes", "code_max", "told"),
    [
        (codes_of(127, 1.0), 127, ""),
        (codes_of(127, 0.7), 127, ""),
        (codes_of(400, 1.0), 400, ""),
        (codes_of(127, 1.0) / 1.27, 127, "may be per cent"),
        (codes_of(127, 0.7) / 1.27, 127, "may be per cent"),
        (codes_of(100, 1.0), 127, "may be per cent"),
        (codes_of(400, 1.0) / 4.0, 400, "may be per cent"),
        (codes_of(127, 1.0), 400, "steps of 127"),
    ],
)
def test_commands_of_another_full_scale(
    codes: FloatArray, code_max: int, told: str, tmp_path: Path
) -> None:
    commands = joints_topic("/thrusters/command", TIMES, [NAMES] * 400, codes)
    said = warned(read(tmp_path, [imu_topic(TIMES, RATES), commands], code_max))
    assert told in said
    assert told or "taken for codes" not in said


def test_steps_to_a_round_code_are_codes(tmp_path: Path) -> None:
    codes = np.repeat([0.0, 50.0, 100.0, -50.0, -100.0, 25.0, 75.0, 0.0], 50)[:, None]
    commands = joints_topic("/thrusters/command", TIMES, [NAMES] * 400, np.tile(codes, 4))
    found = read(tmp_path, [imu_topic(TIMES, RATES), commands], 127)
    assert "taken for codes" not in warned(found)


def test_one_thruster_that_goes_astern_shows_the_rest_of_all(tmp_path: Path) -> None:
    rows = [
        f"{t},{60 + 30 * np.sin(t):.3f},{50 - 20 * np.sin(t):.3f},{-40 * np.sin(t):.3f},0"
        for t in T
    ]
    head = ",".join(["t", *(f"command_{name} [%]" for name in NAMES)])
    (tmp_path / "run.csv").write_text("\n".join([head, *rows]))
    found = read_pool_run(tmp_path / "run.csv", rov(), tmp_path)
    assert set(found.channels) == {f"thruster_command.{name}" for name in NAMES}
    assert found.channels["thruster_command.port"].values[0, 0] == pytest.approx(60.0)


DVL = {
    "status": (0, 1), "ok": (1, 0), "fom": (0.002, 4.0), "quality": (96, 8), "lock": (True, False),
    "error": (False, True), "num_beams": (4, 1),
}  # fmt: skip


@pytest.mark.parametrize("flag", DVL)
@pytest.mark.parametrize("bad", [True, False])
def test_what_a_dvl_thinks_of_its_velocity(flag: str, bad: bool, tmp_path: Path) -> None:
    """Readings of an unusual status are left out where they are unlike the others.

    Without a lock on the bottom there is no velocity over it, however smooth it looks.
    """
    odd = (np.arange(400) // 20) % 5 == 1
    values = np.stack([0.4 + 0.1 * np.sin(0.4 * T), 0.05 * np.sin(T), 0.02 * np.cos(T)], axis=1)
    draws = np.random.default_rng(1).normal(0.0, 1.0, (400, 3))
    values += np.where(odd[:, None] & bad, 0.6, 0.005) * draws
    name = "status" if flag == "ok" else flag
    contents = [
        {**dict(zip(("vx", "vy", "vz"), map(float, one), strict=True)), name: DVL[flag][int(ill)]}
        for one, ill in zip(values, odd, strict=True)
    ]
    channel = read(tmp_path, [json_topic("/dvl", TIMES, contents)]).channels["velocity"]
    left_out = channel.marks.get("not_a_number", np.zeros(400, np.bool_))
    np.testing.assert_array_equal(left_out, odd & (bad or flag == "lock"))


@pytest.mark.parametrize(
    ("name", "usual", "odd"),
    [("mode", "BT", "WT"), ("reference", 1, 2), ("over_ground", True, False)],
)
@pytest.mark.parametrize("current", [0.0, 0.15])
def test_a_velocity_that_jumps_where_a_state_changes(
    name: str, usual: object, odd: object, current: float, tmp_path: Path
) -> None:
    """Through the water it is as smooth as over the ground."""
    water = (T > 6.0) & (T < 9.0)
    values = np.stack([0.4 + 0.1 * np.sin(0.4 * T), 0.05 * np.sin(T), 0.02 * np.cos(T)], axis=1)
    values += 0.003 * np.random.default_rng(1).normal(0.0, 1.0, values.shape)
    values[:, 0] += current * water
    contents = [
        {**dict(zip(("vx", "vy", "vz"), one, strict=True)), name: odd if ill else usual}
        for one, ill in zip(values.tolist(), water, strict=True)
    ]
    channel = read(tmp_path, [json_topic("/dvl", TIMES, contents)]).channels["velocity"]
    np.testing.assert_array_equal(channel.usable(), ~(water & (current > 0.0)))


@pytest.mark.parametrize(("rest", "told"), [(1500.0, False), (1520.0, True)])
def test_pulses_that_begin_and_dwell_at_another_width(
    rest: float, told: bool, tmp_path: Path
) -> None:
    codes = codes_of(100, 1.0) * ((T > 2.0) & (T < 14.0))[:, None]
    commands = joints_topic("/thrusters/command", TIMES, [NAMES] * 400, rest + 3.8 * codes)
    found = read(tmp_path, [imu_topic(TIMES, RATES), commands], 100)
    line = "pool: pwm_range: {neutral_us: 1520, half_range_us: ...}"
    assert (line in "\n".join(one.what for one in found.problems)) is told
    assert ("thruster_command" in found.channels) is not told


@pytest.mark.parametrize("swap", [False, True])
def test_axes_of_an_attitude_that_are_swapped(swap: bool, tmp_path: Path) -> None:
    """A steady heading, tilts of a degree or less."""
    one = run(400)
    path = tmp_path / "run.csv"
    t = np.arange(400) / 25.0
    noise = np.random.default_rng(2).normal(0.0, 2e-4, (400, 3))
    roll, pitch = np.degrees([0.01 * np.sin(1.3 * t), 0.008 * np.cos(0.9 * t)])
    rates = noise + np.stack(
        [0.013 * np.cos(1.3 * t), -0.0072 * np.sin(0.9 * t), np.zeros(400)], axis=1
    )
    named = ("pitch", "roll") if swap else ("roll", "pitch")
    head = f"time_ns,{named[0]} [deg],{named[1]} [deg],yaw [deg],p [rad/s],q [rad/s],r [rad/s]"
    rows = [
        ",".join([str(at), *(f"{x:.6f}" for x in (*angles, 30.0, *rate))])
        for at, angles, rate in zip(one.time_ns, zip(roll, pitch, strict=True), rates, strict=True)
    ]
    path.write_text("\n".join([head, *rows]))
    said = warned(read_pool_run(path, rov(), tmp_path))
    assert ("With the axes x and y swapped it would agree" in said) == swap


def test_a_barometer_that_was_never_under_water_is_told(tmp_path: Path) -> None:
    path = write_bin(tmp_path / "run.BIN", run(200))
    path.write_bytes(path.read_bytes().replace(b"BARO", b"BARX"))
    assert "depth" not in read_pool_run(path, rov(), tmp_path).channels
    one = run(200)
    dry = one.pressure_pa * 0.0 + 100_200.0 + np.arange(200.0)[:, None]
    path = write_bin(tmp_path / "dry.BIN", type(one)(**{**vars(one), "pressure_pa": dry}))
    assert "the vehicle was not under water" in warned(read_pool_run(path, rov(), tmp_path))


def test_a_bag_with_messages_beside_it_is_told(tmp_path: Path) -> None:
    path = write_db3(tmp_path / "run.db3", run(50), tmp_path)
    Path(f"{path}-wal").write_bytes(b"pages")
    assert "messages in run.db3-wal are not in it yet" in warned(
        read_pool_run(path, rov(), tmp_path)
    )


def test_a_bag_with_all_its_messages_beside_it_is_refused(tmp_path: Path) -> None:
    import sqlite3

    path = write_db3(tmp_path / "run.db3", run(50), tmp_path)
    with sqlite3.connect(path) as database:
        database.execute("DELETE FROM messages")
    Path(f"{path}-wal").write_bytes(b"pages")
    with pytest.raises(InputError, match=r"messages in run\.db3-wal are not in it yet"):
        read_pool_run(path, rov(), tmp_path)
