"""Commands and start of any log: pulse widths, missing numbers, what was measured at first."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import SECOND_NS, START_NS, imu_topic, joints_topic, json_topic, write_log
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import InputError
from pipeline.export.mcap_log import write_run_log
from pipeline.ingest.run_commands import RunCommands, read_run_commands, read_true_start
from pipeline.records.pool_schema import PoolColumns
from pipeline.simulate.sensors import Channel
from pipeline.types import IntArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

ROV = load_vehicle(bundled_vehicle("rov8"))
NAMES = tuple(thruster.name for thruster in ROV.thrusters)


def every(period_ns: int, count: int, first_ns: int = START_NS) -> IntArray:
    return first_ns + period_ns * np.arange(count, dtype=np.int64)


def read(path: Path, vehicle: Vehicle = ROV) -> RunCommands:
    return read_run_commands(path, vehicle, path.parent)


def test_pulse_widths_in_json_become_codes(tmp_path: Path) -> None:
    """Eight outputs of a flight controller, 400 us for the full code of 400, sent on change."""
    times = [START_NS, START_NS + SECOND_NS, START_NS + 5 * SECOND_NS]
    outputs = [[1500] * 8, [1500, 1700, *[1500] * 6], [1100, 1900, *[1500] * 6]]
    depths = every(SECOND_NS // 5, 60)
    vehicle = ROV.model_copy(
        update={
            "pool": PoolColumns.model_validate(
                {
                    "channels": [
                        {
                            "quantity": "thruster_command",
                            "topic": "/rc",
                            "field": "channels",
                            "unit": "us",
                        },
                        {"quantity": "depth", "topic": "/deep", "field": "metres", "unit": "m"},
                    ]
                }
            )
        }
    )
    path = write_log(
        tmp_path / "run.mcap",
        [
            json_topic("/rc", times, [{"channels": row} for row in outputs]),
            json_topic("/deep", depths.tolist(), [{"metres": 2.0 + 0.01 * i} for i in range(60)]),
        ],
    )
    found = read(path, vehicle)
    assert found.names == NAMES
    np.testing.assert_allclose(found.time_s, [0.0, 1.0, 5.0])
    np.testing.assert_allclose(found.codes[:, :2], [[0, 0], [0, 200], [-400, 400]])
    assert found.start is not None
    gauge = ROV.sensors.depth.position_m  # type: ignore[union-attr]
    assert found.start.position_ned_m[2] == pytest.approx(2.0 - gauge[2], abs=0.01)
    assert any("depth" in note and "not measured" in note for note in found.notes)
    assert found.end_s >= 5.0


def test_a_number_that_is_missing_holds_the_last_command(tmp_path: Path) -> None:
    times = every(SECOND_NS // 50, 200)
    codes = np.tile(np.linspace(0.0, 100.0, 200)[:, None], (1, 8))
    codes[50:60, 3] = np.nan
    path = write_log(
        tmp_path / "run.mcap", [joints_topic("/thrusters/command", times, [NAMES] * 200, codes)]
    )
    found = read(path)
    assert np.isfinite(found.codes).all()
    np.testing.assert_array_equal(np.delete(found.codes, 3, axis=1), np.delete(codes, 3, axis=1))
    assert set(found.codes[50:60, 3]) == {codes[49, 3]}
    assert any("not a number" in note for note in found.notes)


def test_the_start_is_what_was_measured(tmp_path: Path) -> None:
    """A log of ours without its truth: heading, turning and the DVL's lever arm count."""
    turn = Rotation.from_euler("ZYX", [60.0, 5.0, -3.0], degrees=True)
    x, y, z, w = turn.as_quat()
    rate, velocity = np.array([0.01, -0.02, 0.1]), np.array([0.5, -0.1, 0.05])
    dvl, gauge = ROV.sensors.dvl, ROV.sensors.depth  # type: ignore[union-attr]
    assert dvl is not None
    assert gauge is not None
    at_dvl = velocity + np.cross(rate, dvl.position_m)
    mount = Rotation.from_euler("ZYX", np.radians(dvl.rotation_deg)[::-1])
    deep = 3.0 + float(turn.apply(gauge.position_m)[2])
    fast, slow = np.arange(200) / 100, np.arange(20) / 10
    log = {
        "command": Channel(NAMES, fast, fast, np.zeros((200, 8))),
        "imu": Channel(
            (
                *("p_radps", "q_radps", "r_radps"),
                *("fx_mps2", "fy_mps2", "fz_mps2"),
                *("qw", "qx", "qy", "qz"),
            ),
            fast,
            fast,
            np.tile([*rate, 0.1, 0.2, -9.8, w, x, y, z], (200, 1)) + 1e-6 * np.arange(200)[:, None],
        ),
        "dvl": Channel(
            ("vx_mps", "vy_mps", "vz_mps"),
            slow,
            slow + 0.1,
            mount.inv().apply(np.tile(at_dvl, (20, 1)) + 1e-6 * np.arange(20)[:, None]),
        ),
        "depth": Channel(("depth_m",), slow, slow, deep + 1e-6 * np.arange(20)[:, None]),
    }
    path = tmp_path / "run.mcap"
    water = ROV.water
    write_run_log(
        path,
        log,
        vehicle_name="rov8",
        density_kgpm3=water.density_kgpm3,
        gravity_mps2=water.gravity_mps2,
    )
    found = read(path)
    assert read_true_start(path) is None
    assert found.start is not None
    np.testing.assert_allclose(found.start.nu[:3], velocity, atol=1e-5)
    np.testing.assert_allclose(found.start.nu[3:], rate, atol=1e-5)
    np.testing.assert_allclose(np.abs(found.start.quaternion @ [w, x, y, z]), 1.0, atol=1e-6)
    np.testing.assert_allclose(found.start.position_ned_m, [0.0, 0.0, 3.0], atol=1e-4)
    assert found.notes[-1].endswith("position not measured then: level, at rest, at the origin "
                                    "for that.")  # fmt: skip


def test_an_attitude_of_four_zeros_is_no_start(tmp_path: Path) -> None:
    """An IMU gives none in its first message, just as the first command comes."""
    times = every(SECOND_NS // 50, 100)
    attitudes = [{"q": [0.0, 0.0, 0.0, 0.0]}, *[{"q": [0.0, 0.0, 0.6, 0.8]}] * 99]
    stated = [{"quantity": "attitude_quaternion", "topic": "/imu", "field": "q"}]
    vehicle = ROV.model_copy(update={"pool": PoolColumns.model_validate({"channels": stated})})
    commands = np.arange(100.0)[:, None] * np.ones(len(NAMES))
    topics = [
        json_topic("/imu", times.tolist(), attitudes),
        joints_topic("/thrusters/command", times, [NAMES] * 100, commands),
    ]
    start = read(write_log(tmp_path / "run.mcap", topics), vehicle).start
    assert start is not None
    np.testing.assert_allclose(start.quaternion, [0.8, 0.0, 0.0, 0.6])


def test_without_commands_it_says_what_to_map(tmp_path: Path) -> None:
    times = every(SECOND_NS // 100, 300)
    path = write_log(tmp_path / "run.mcap", [imu_topic(times, np.zeros((300, 3)))])
    with pytest.raises(InputError, match="no commands for the thrusters") as caught:
        read(path)
    assert "pool: channels:" in str(caught.value)
