"""A log in which thrust was measured gives the points of a mooring test, in a flow as well."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from pool_logs import array_topic, joints_topic, json_topic, rov, ticks, write_log

from pipeline.control.inverse import thrust_grid
from pipeline.identify.inverse import inverse_characteristic
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.physics.thrust_grid import thrust_from_code
from pipeline.records.measurements import IN_A_FLOW, MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

NAMES = ("port", "starboard", "bow", "side")
HELD_S, RATE_HZ = 5.0, 10.0
STEPS = np.arange(30.0, 101.0, 10.0)
CODES = np.concatenate([[0.0], STEPS, [0.0], -STEPS, [0.0]])
POOL = {
    "channels": [
        {"quantity": "thruster_command", "topic": "/codes", "unit": "code", "thrusters": NAMES},
        {"quantity": "thrust", "topic": "/load_cells", "unit": "kgf", "thrusters": NAMES[:2]},
        {"quantity": "velocity", "topic": "/dvl", "field": ["u", "v", "w"], "body_axes": "frd"},
    ]
}
KGF_N = 9.80665


def thrust_n(code: FloatArray, speed_mps: float) -> FloatArray:
    """T = a N|N| - b |N| V."""
    return 4e-3 * code * np.abs(code) - 0.05 * np.abs(code) * speed_mps


def log(
    path: Path,
    speed_mps: float | None,
    way: Sequence[Mapping[str, float]] | None = None,
    *,
    thrust: bool = True,
) -> Path:
    """Write steps of the port thruster, at rest without a velocity; its force lags by 0.3 s."""
    code = np.repeat(CODES, int(HELD_S * RATE_HZ))
    time_ns = ticks(code.size, RATE_HZ).tolist()
    force_n, held = np.zeros(code.size), 0.0
    for row, wanted in enumerate(thrust_n(code, speed_mps or 0.0)):
        held += (wanted - held) / 3.0
        force_n[row] = held
    codes = np.stack([code, 0.0 * code, 0.0 * code, 0.0 * code], axis=1)
    topics = [joints_topic("/codes", time_ns, [NAMES] * code.size, codes)]
    if thrust:
        forces = np.stack([force_n / KGF_N, 0.0 * code], axis=1)
        topics.append(array_topic("/load_cells", time_ns, forces.tolist()))
    if speed_mps is not None:
        way = [{"u": speed_mps, "v": 0.0, "w": 0.0}] * code.size
    if way is not None:
        topics.append(json_topic("/dvl", time_ns, way))
    return write_log(path, topics)


def read(vehicle: Vehicle, *paths: Path) -> MooringRecord:
    return read_mooring_tables(paths, vehicle, paths[0].parents[2])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "raw" / "trial" / "mooring"


def test_each_step_counts_once_with_its_speed(folder: Path) -> None:
    vehicle = rov(**POOL)
    record = read(vehicle, log(folder / "rest.mcap", None), log(folder / "tow.mcap", 0.8))
    assert [one.what for one in record.problems if one.severity == "error"] == []
    for file, speed, mark in (("rest", 0.0, ()), ("tow", 0.8, (IN_A_FLOW,))):
        points = [
            one
            for one in record.points
            if file in one.source.file and one.source.sheet == "port" and one.marks == mark
        ]
        code = np.array([one.code for one in points if one.code])
        assert sorted(code) == [*-STEPS[::-1], *STEPS]
        found = np.array([one.thrust_n for one in points if one.code])
        assert found == pytest.approx(thrust_n(code, speed), abs=0.1)
        assert {round(one.speed_mps, 6) for one in points} == {speed}


def test_a_log_that_cannot_serve_says_why(folder: Path) -> None:
    """No thrust; no command that turns anything; a vehicle that moved nobody knows how fast."""
    vehicle = rov(**POOL)
    still = log(folder / "still.mcap", None, thrust=False)
    (said,) = [one for one in read(vehicle, still).problems if one.severity == "error"]
    assert "measures the thrust of no thruster of this type" in said.what
    assert "pool/" in said.remedy
    bow_only = {
        "channels": [*POOL["channels"][:1], {**POOL["channels"][1], "thrusters": NAMES[2:]}]
    }
    (said,) = [
        one
        for one in read(rov(**bow_only), log(folder / "bow.mcap", None)).problems
        if one.severity == "error"
    ]
    assert said.what == "no command ever turned bow, side."


def test_a_vehicle_that_moved_needs_its_velocity(folder: Path) -> None:
    moved = [{"x": 0.1 * row, "y": 0.0, "z": 1.0} for row in range(CODES.size * 50)]
    place = {"quantity": "position", "topic": "/dvl", "field": ["x", "y", "z"], "earth_axes": "ned"}
    vehicle = rov(channels=[*POOL["channels"][:2], place])
    path = log(folder / "run.mcap", None, moved)
    (said,) = [one for one in read(vehicle, path).problems if one.severity == "error"]
    assert "velocity in body axes is not known" in said.what


def test_tables_follow_the_logs(folder: Path) -> None:
    """Without any calculation: at rest, towed, and at a speed between the two."""
    vehicle = rov(**POOL)
    found = inverse_characteristic(
        None, read(vehicle, log(folder / "rest.mcap", None), log(folder / "tow.mcap", 0.8)), vehicle
    )
    assert found.firmware is not None
    grids = [thrust_grid(one) for one in (found.firmware.positive, found.firmware.negative)]
    for speed in (0.0, 0.5, 0.8):
        given = thrust_from_code(STEPS[1:], speed, positive=grids[0], negative=grids[1])
        assert given == pytest.approx(thrust_n(STEPS[1:], speed), abs=0.25)
