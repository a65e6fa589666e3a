"""Readings that stand for none or are missing at first, depths that cannot be."""

from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pool_logs import json_topic, messages_one_by_one, ros_topic, rov, ticks, vector, write_log

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

COUNT = 1000


def dvl(tmp_path: Path, values: FloatArray, valid: FloatArray | None = None) -> PoolRun:
    contents: list[dict[str, Any]] = [{"velocity": vector(row)} for row in values]
    if valid is not None:
        for content, flag in zip(contents, valid, strict=True):
            content["velocity_valid"] = bool(flag)
    path = write_log(tmp_path / "run.mcap", [json_topic("/dvl/data", ticks(COUNT, 10.0), contents)])
    return read_pool_run(path, rov(), tmp_path)


def velocities() -> FloatArray:
    noise = 0.003 * np.random.default_rng(3).standard_normal((COUNT, 3))
    noise[:, 0] += 0.5 * np.sin(0.03 * np.arange(COUNT))
    return noise


def said(run: PoolRun) -> str:
    return "\n".join(problem.what for problem in run.problems if problem.severity == "warning")


@pytest.mark.parametrize("length", [2, 3])
def test_no_lock_readings_are_left_out(tmp_path: Path, length: int) -> None:
    values = velocities()
    lost = np.arange(COUNT) % 200 >= 200 - length
    values[lost] = -32.768
    run = dvl(tmp_path, values)
    usable = run.channels["velocity"].usable()
    assert not usable[lost].any()
    assert usable[~lost].mean() > 0.99
    assert f"is up to 32.77 mps in {lost.sum()} of 1000 readings, more than is possible" in said(
        run
    )
    assert "unit is probably off" not in said(run)


def test_a_velocity_in_millimetres_is_a_unit_and_no_reading_is_marked(tmp_path: Path) -> None:
    run = dvl(tmp_path, 1000.0 * velocities())
    assert "unit is probably off" in said(run)
    assert run.channels["velocity"].usable().mean() > 0.99


def test_what_the_message_calls_invalid_is_left_out(tmp_path: Path) -> None:
    invalid = np.arange(COUNT) % 100 == 7
    run = dvl(tmp_path, velocities(), ~invalid)
    channel = run.channels["velocity"]
    assert not channel.usable()[invalid].any()
    assert channel.usable()[~invalid].all()
    assert (
        "readings that velocity_valid calls valid count, others as not a number: 10"
        in channel.read.notes
    )


@pytest.mark.parametrize("first", [0, 1])
def test_letters_of_validity_are_read(tmp_path: Path, first: int) -> None:
    values, lost = velocities(), np.arange(COUNT) % 10 == first
    letters = np.where(lost, "V", "A").tolist()
    rows = zip(values.tolist(), letters, strict=True)
    contents = [{"velocity": one, "velocity_valid": letter} for one, letter in rows]
    text = "float64[3] velocity\nstring velocity_valid\n"
    as_json = [{**one, "velocity": vector(row)} for one, row in zip(contents, values, strict=True)]
    topics = [
        json_topic("/dvl/data", ticks(COUNT, 10.0), as_json),
        ros_topic("/dvl", "rig/msg/Dvl", ticks(COUNT, 10.0), contents, text),
    ]
    paths = [
        write_log(tmp_path / f"{one.name[1:4]}{n}.mcap", [one]) for n, one in enumerate(topics)
    ]
    lines = [f"{k / 10.0},{row[0]},{row[1]},{row[2]},{letters[k]}" for k, row in enumerate(values)]
    table = tmp_path / "run.csv"
    table.write_text("\n".join(["t [s],vx [m/s],vy [m/s],vz [m/s],velocity_valid", *lines]))
    for path in (*paths, table):
        for way in (nullcontext, messages_one_by_one):
            with way():
                channel = read_pool_run(path, rov(), tmp_path).channels["velocity"]
            assert (channel.marks["not_a_number"] == lost).all(), path.name


@pytest.mark.parametrize(
    ("name", "well", "ill"),
    [
        ("state", "TRACKING", "LOST"),
        ("has_echo", True, False),
        ("no_fix", False, True),
        ("rejected", 0, 1),
        ("sigma", 0.01, 1.2),
    ],
)
@pytest.mark.parametrize("is_noise", [True, False])
def test_a_state_of_any_name_counts_where_readings_are_noise(
    name: str, well: object, ill: object, is_noise: bool, tmp_path: Path
) -> None:
    lost, values = np.arange(COUNT) % 100 >= 70, velocities()
    if is_noise:
        values[lost] += np.random.default_rng(5).standard_normal((lost.sum(), 3))
    kind = {str: "string", float: "float64", int: "uint8", bool: "bool"}[type(well)]
    contents = [
        {"velocity": row.tolist(), name: ill if odd else well}
        for row, odd in zip(values, lost, strict=True)
    ]
    text = f"float64[3] velocity\n{kind} {name}\n"
    topic = ros_topic("/dvl", "rig/msg/Dvl", ticks(COUNT, 10.0), contents, text)
    path = write_log(tmp_path / "run.mcap", [topic])
    for way in (nullcontext, messages_one_by_one):
        with way():
            channel = read_pool_run(path, rov(), tmp_path).channels["velocity"]
        assert channel.marks.get("not_a_number", np.zeros(1)).sum() == is_noise * lost.sum()


@pytest.mark.parametrize(
    ("name", "ill"),
    [("is_velocity_valid", False), ("bt_valid", 0), ("hasBottomLock", False), ("bottom_lost", True),
     ("altitude_valid", None), ("heading_ok", None)],
)  # fmt: skip
def test_what_a_name_says_of_this_reading_is_believed_of_no_other(
    name: str, ill: bool | int | None, tmp_path: Path
) -> None:
    lost = np.arange(COUNT) % 100 >= 70
    contents = [
        {"velocity": vector(row), name: bool(odd) == bool(ill)}
        for row, odd in zip(velocities(), lost, strict=True)
    ]
    path = write_log(tmp_path / "run.mcap", [json_topic("/dvl", ticks(COUNT, 10.0), contents)])
    marks = read_pool_run(path, rov(), tmp_path).channels["velocity"].marks
    assert marks.get("not_a_number", np.zeros(1)).sum() == (0 if ill is None else lost.sum())


@pytest.mark.parametrize("kind", ["beams", "list", "covariance"])
def test_beams_and_covariances_tell_of_readings_that_are_unlike_the_others(
    kind: str, tmp_path: Path
) -> None:
    lost, values = (np.arange(COUNT) > 600) & (np.arange(COUNT) < 700), velocities()
    values[lost] += [0.4, 0.1, 0.0]
    contents: list[dict[str, Any]] = [{"velocity": vector(row)} for row in values]
    for row, odd in zip(contents, lost.tolist(), strict=True):
        more: dict[str, dict[str, Any]] = {
            "beams": {"transducers": [{"id": k, "valid": not odd} for k in range(4)]},
            "list": {"beam_valid": [int(not odd)] * 4},
            "covariance": {"covariance": [9e4 if odd else 1e-4] + [0.0] * 8},
        }
        row.update(more[kind])
    path = write_log(tmp_path / "run.mcap", [json_topic("/dvl", ticks(COUNT, 10.0), contents)])
    marks = read_pool_run(path, rov(), tmp_path).channels["velocity"].marks
    assert (marks["not_a_number"] == lost).all()


def test_a_vehicle_that_rests_unarmed_is_read(tmp_path: Path) -> None:
    values = velocities()
    values[:200] = 0.0
    contents = [
        {"velocity": vector(row), "armed": k >= 200} for k, row in enumerate(values.tolist())
    ]
    path = write_log(tmp_path / "run.mcap", [json_topic("/dvl", ticks(COUNT, 10.0), contents)])
    marks = read_pool_run(path, rov(), tmp_path).channels["velocity"].marks
    assert "not_a_number" not in marks


def test_a_table_does_not_say_whose_validity_it_is(tmp_path: Path) -> None:
    lines = [f"{k / 10.0},{row[0]},{row[1]},{row[2]},{k % 2}" for k, row in enumerate(velocities())]
    for name, left_out in (("velocity_valid", COUNT / 2), ("valid", 0), ("is_valid", 0)):
        table = tmp_path / f"{name}.csv"
        table.write_text("\n".join([f"t [s],vx [m/s],vy [m/s],vz [m/s],{name}", *lines]))
        marks = read_pool_run(table, rov(), tmp_path).channels["velocity"].marks
        assert marks.get("not_a_number", np.zeros(1)).sum() == left_out


def test_the_flag_of_a_binary_message_is_read(tmp_path: Path) -> None:
    text = "float64[3] velocity\nbool velocity_valid\n"
    contents = [
        {"velocity": row.tolist(), "velocity_valid": k % 10 != 0}
        for k, row in enumerate(velocities())
    ]
    topic = ros_topic("/dvl", "rig/msg/Dvl", ticks(COUNT, 10.0), contents, text)
    path = write_log(tmp_path / "run.mcap", [topic])
    for way in (nullcontext, messages_one_by_one):
        with way():
            channel = read_pool_run(path, rov(), tmp_path).channels["velocity"]
        assert channel.marks["not_a_number"].sum() == COUNT / 10
        assert channel.values.shape == (COUNT, 3)


def pressures(tmp_path: Path, values: FloatArray, vehicle: Vehicle | None = None) -> PoolRun:
    contents = [{"fluid_pressure": float(value), "variance": 0.0} for value in values]
    text = "float64 fluid_pressure\nfloat64 variance\n"
    topic = ros_topic(
        "/pressure", "sensor_msgs/msg/FluidPressure", ticks(COUNT, 10.0), contents, text
    )
    path = write_log(tmp_path / "run.mcap", [topic])
    return read_pool_run(path, vehicle or rov(), tmp_path)


DEPTH = 2.0 + 0.5 * np.sin(0.02 * np.arange(COUNT))


@pytest.mark.parametrize(("unit_pa", "says"), [(100.0, "hPa"), (1000.0, "kPa"), (1.0, "")])
def test_pressures_in_another_unit_are_suspected(tmp_path: Path, unit_pa: float, says: str) -> None:
    run = pressures(tmp_path, (101325.0 + 9810.0 * DEPTH) / unit_pa)
    assert (f"looks like {says}" in said(run)) == bool(says)
    assert "looks like" in said(run) or not says


def test_a_gauge_near_the_surface_is_not_suspected(tmp_path: Path) -> None:
    assert "looks like" not in said(pressures(tmp_path, 9810.0 * 0.12 * np.abs(DEPTH - 2.0) * 2))


def test_a_stated_unit_is_not_suspected(tmp_path: Path) -> None:
    channel = {"quantity": "pressure", "topic": "/pressure", "unit": "mbar"}
    run = pressures(tmp_path, (101325.0 + 9810.0 * DEPTH) / 100.0, rov(channels=[channel]))
    assert "looks like" not in said(run)
    assert np.median(run.channels["depth"].values) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_depths_above_the_water_are_told(tmp_path: Path, sign: float) -> None:
    contents = [{"depth": float(value)} for value in sign * DEPTH]
    path = write_log(tmp_path / "run.mcap", [json_topic("/depth", ticks(COUNT, 10.0), contents)])
    text = said(read_pool_run(path, rov(), tmp_path))
    assert ("above the water" in text) == (sign < 0)


def test_what_the_first_message_lacks_is_found_in_the_next(tmp_path: Path) -> None:
    rows = velocities()
    contents: list[dict[str, Any]] = [
        {"angular_velocity": vector(row), "linear_acceleration": vector((0.0, row[1], -9.81))}
        for row in rows
    ]
    del contents[0]["linear_acceleration"]
    contents[1]["linear_acceleration"] = None
    path = write_log(tmp_path / "run.mcap", [json_topic("/imu", ticks(COUNT, 10.0), contents)])
    channel = read_pool_run(path, rov(), tmp_path).channels["specific_force"]
    assert channel.marks["not_a_number"].sum() == 2
    assert channel.usable().sum() == COUNT - 2
