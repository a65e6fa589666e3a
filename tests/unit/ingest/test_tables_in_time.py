"""Tables in time as programs and people write them: titles, encodings, clocks, names with units."""

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from pool_logs import array_topic, json_topic, rov, ticks, write_log

from pipeline.errors import InputError
from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun

T = np.arange(400) / 20.0
DEPTH = 2.0 + 0.5 * np.sin(0.4 * T)
RATES = 0.1 * np.stack([np.sin(T), np.cos(T), np.sin(0.3 * T)], axis=1)
START = datetime(2024, 5, 13, 23, 59, 50, tzinfo=UTC)
HEADS = "time [s],depth [m],p,q,r"


def text(heads: str = HEADS, times: list[str] | None = None) -> str:
    shown = times or [f"{one:.2f}" for one in T]
    rows = np.column_stack([DEPTH, RATES])
    lines = [
        ",".join([time, *(f"{one:.6f}" for one in row)])
        for time, row in zip(shown, rows, strict=True)
    ]
    return "\n".join([heads, *lines]) + "\n"


def read(tmp_path: Path, content: str, encoding: str = "utf-8") -> PoolRun:
    (tmp_path / "run.csv").write_bytes(content.encode(encoding))
    return read_pool_run(tmp_path / "run.csv", rov(), tmp_path)


def said(run: PoolRun) -> str:
    return "\n".join(one.what for one in run.problems if one.severity == "warning")


def is_right(run: PoolRun) -> bool:
    depth, rates = run.channels["depth"], run.channels["angular_velocity"]
    np.testing.assert_allclose((depth.time_ns - depth.time_ns[0]) / 1e9, T, atol=0.05)
    np.testing.assert_allclose(depth.values[:, 0], DEPTH, atol=1e-5)
    np.testing.assert_allclose(rates.values, RATES, atol=1e-5)
    return True


@pytest.mark.parametrize(
    ("change", "encoding"),
    [
        (lambda one: f"# pool log, 20 Hz\n# tank\n{one}", "utf-8"),
        (lambda one: f"Pool log 13.05.2024\n\n{one}", "utf-8"),
        (lambda one: f"sep=;\n{one.replace(',', ';').replace('.', ',')}", "utf-8"),
        (lambda one: f"# {one}", "utf-8"),
        (lambda one: one, "utf-16"),
        (lambda one: one.replace("depth [m]", "depth [м]"), "cp1251"),
        (lambda one: one.replace("\n", ",Rückwärts\n", 1).replace("\n", ",ü\n"), "cp1252"),
        (lambda one: one.replace(" [", "[").replace(",", " "), "utf-8"),
        (lambda one: one.replace("time [s],depth [m]", '"time, s","depth, m"'), "utf-8"),
        (lambda one: one.replace("depth [m],p,q,r", "depth_m,p_radps,q_radps,r_radps"), "utf-8"),
    ],
)
def test_tables_as_programs_write_them(
    change: Callable[[str], str], encoding: str, tmp_path: Path
) -> None:
    run = read(tmp_path, change(text()), encoding)
    assert is_right(run)
    assert not said(run)


@pytest.mark.parametrize(
    ("head", "form", "warned"),
    [
        ("time", lambda at: f"{at:%H:%M:%S.%f}", ""),
        ("time", lambda at: f"{at:%M:%S.%f}", ""),
        ("time", lambda at: f"{at:%d.%m.%Y %H:%M:%S.%f}", ""),
        ("time", lambda at: f"{at:%m/%d/%Y %H:%M:%S.%f}", ""),
        ("time", lambda at: f"{at - timedelta(days=9):%m/%d/%Y %H:%M:%S.%f}", "month"),
        ("date,time", lambda at: f"{at:%Y-%m-%d,%H:%M:%S.%f}", ""),
        ("sec,nanosec", lambda at: f"{int(at.timestamp())},{at.microsecond * 1000}", ""),
        ("millis", lambda at: f"{(at - START) / timedelta(milliseconds=1):.0f}", ""),
        ("time", lambda at: f"{at:%Y-%m-%d %H:%M:%S}", "whole seconds"),
        ("time [s]", lambda at: f"{(at - START).seconds}", "whole seconds"),
    ],
)
def test_times_as_people_write_them(
    head: str, form: Callable[[datetime], str], warned: str, tmp_path: Path
) -> None:
    times = [form(START + timedelta(seconds=float(one))) for one in T]
    run = read(tmp_path, text(HEADS.replace("time [s]", head), times))
    assert is_right(run)
    assert warned in said(run)
    assert bool(warned) == bool(said(run))


def test_times_of_32_bits_tell_no_rows_apart(tmp_path: Path) -> None:
    pd = pytest.importorskip("pandas")
    times = (1.7156e9 + T).astype(np.float32)
    pd.DataFrame({"time": times, "depth": DEPTH}).to_parquet(tmp_path / "run.parquet")
    with pytest.raises(InputError, match="cannot tell the rows apart"):
        read_pool_run(tmp_path / "run.parquet", rov(), tmp_path)


def test_a_depth_in_bar_is_a_pressure_and_one_in_rev_is_not_read(tmp_path: Path) -> None:
    bar = text("time [s],depth [bar],p,q,r")
    run = read(tmp_path, bar)
    np.testing.assert_allclose(
        run.channels["depth"].values[:, 0], (DEPTH * 1e5 - 101_325.0) / 9810.0, atol=1e-3
    )
    assert "depth" not in read(tmp_path, bar.replace("[bar]", "[rev]")).channels


def test_columns_that_tell_nothing_are_named(tmp_path: Path) -> None:
    notes = [one.what for one in read(tmp_path, text("time [s],depth,p,q,hdg2")).problems]
    assert "columns whose names tell no quantity: p, q, hdg2; they were not read." in notes


@pytest.mark.parametrize("first", [0, 1])
def test_commands_by_number_are_those_of_thrusters_in_order(first: int, tmp_path: Path) -> None:
    heads = ",".join(f"pwm_{first + number}" for number in range(6))
    rows = [
        f"{one},{1400 + k % 9},{1420 + k % 7},{1600 + k % 5},{1630 + k % 3},1500,1500"
        for k, one in enumerate(T)
    ]
    run = read(tmp_path, "\n".join([f"time [s],{heads}", *rows]))
    command = run.channels["thruster_command"]
    assert command.columns == tuple(
        f"command.{one}" for one in ("port", "starboard", "bow", "side")
    )
    np.testing.assert_allclose(command.values[0], [-25.0, -20.0, 25.0, 32.5])


@pytest.mark.parametrize(("idle", "told"), [(0, False), (2, True)])
def test_elements_that_move_and_are_not_read_are_told(
    idle: int, told: bool, tmp_path: Path
) -> None:
    moving = 40.0 * np.sin(np.outer(T, [0.5, 0.6, 0.7, 0.8]))
    rows = np.hstack([np.zeros((400, idle)), moving, np.zeros((400, 4 - idle))]).tolist()
    topics = [
        array_topic("/thrusters/command", ticks(400, 20.0), rows),
        json_topic("/depth", ticks(400, 20.0), [{"depth": float(one)} for one in DEPTH]),
    ]
    run = read_pool_run(write_log(tmp_path / "run.mcap", topics), rov(), tmp_path)
    assert ("its elements 0, 1 (from 0) never change, and 4, 5" in said(run)) == told


def test_a_pitch_counted_to_a_full_turn(tmp_path: Path) -> None:
    angles = np.degrees(RATES) % 360.0
    rows = "".join(
        f"{t},{','.join(f'{one:.6f}' for one in row)}\n" for t, row in zip(T, angles, strict=True)
    )
    channel = read(tmp_path, f"time [s],roll,pitch,heading\n{rows}").channels["attitude"]
    assert channel.usable().all()
    pitch = 2.0 * np.arcsin(np.abs(channel.values[:, 2]))
    np.testing.assert_allclose(pitch, np.abs(RATES[:, 1]), atol=0.01)


def test_a_unit_is_said_to_be_of_the_head_that_states_it(tmp_path: Path) -> None:
    channels = read(tmp_path, text()).channels
    assert channels["depth"].read.unit_from == "head of the column"
    assert channels["angular_velocity"].read.unit_from == "assumed"
