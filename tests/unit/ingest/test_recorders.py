"""The same pool run by every recorder gives the same channels, to the resolution of the format."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from pool_logs import NAMES, rov
from recorded_runs import (
    Run,
    quaternion,
    run,
    write_bag,
    write_bin,
    write_csv,
    write_db3,
    write_mcap,
    write_parquet,
    write_tlog,
    write_ulg,
)

from pipeline.errors import InputError
from pipeline.ingest.log_files import LOG_SUFFIXES, TABLE_SUFFIXES, day_of
from pipeline.ingest.log_source import open_log
from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun

Writer = Callable[[Path, Run], Path]
#: Ending -> writer, resolution of times [s], rates [rad/s], forces [m/s2], angles, depth [m].
FORMATS: dict[str, tuple[Writer, float, float, float, float, float]] = {
    "mcap": (write_mcap, 1e-9, 1e-12, 1e-12, 1e-12, 1e-9),
    "bag": (write_bag, 1e-9, 1e-12, 1e-12, 1e-12, 1e-9),
    "db3": (lambda path, one: write_db3(path, one, path.parent), 1e-9, 1e-12, 1e-12, 1e-12, 1e-9),
    "csv": (write_csv, 1e-9, 1e-9, 1e-7, 1e-8, 1e-6),
    "parquet": (write_parquet, 1e-9, 1e-9, 1e-7, 1e-8, 1e-6),
    "BIN": (write_bin, 1.1e-3, 1e-7, 1e-6, 2e-4, 1e-3),
    "ulg": (write_ulg, 1.1e-6, 1e-7, 1e-6, 1e-6, 1e-3),
    "tlog": (write_tlog, 1.1e-3, 6e-4, 6e-3, 1e-6, 1e-3),
}


def read(path: Path) -> PoolRun:
    return read_pool_run(path, rov(), path.parent)


@pytest.mark.parametrize("ending", FORMATS)
def test_the_same_run_gives_the_same_channels(tmp_path: Path, ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    writer, time_s, rate, force, angle, depth_m = FORMATS[ending]
    one = run()
    found = read(writer(tmp_path / f"run.{ending}", one))
    expected = {
        "angular_velocity": (one.rates_radps, rate),
        "specific_force": (one.force_mps2, force),
        "attitude": (quaternion(one.euler_rad), angle),
        "depth": ((one.pressure_pa - 101_325.0) / 9810.0, depth_m),
    }
    for name, (values, resolution) in expected.items():
        channel = found.channels[name]
        read_values = channel.values
        if name == "attitude":  # q and -q are one
            read_values = read_values * np.sign((read_values * values).sum(axis=1))[:, None]
        np.testing.assert_allclose(read_values, values, atol=resolution, err_msg=name)
        np.testing.assert_allclose(
            (channel.time_ns - one.time_ns) / 1e9, 0.0, atol=time_s, err_msg=name
        )
    commands = {
        column.removeprefix("command."): channel.values[:, number]
        for channel in found.channels.values()
        if channel.quantity == "thruster_command"
        for number, column in enumerate(channel.columns)
    }
    assert set(commands) == set(NAMES)
    for number, name in enumerate(NAMES):
        codes = (one.command_us[:, number] - 1500.0) / 4.0
        np.testing.assert_allclose(commands[name], codes, atol=1e-9)
    assert all(topic.used_for or topic.why_not for topic in found.topics)
    assert not [one for one in found.problems if one.severity == "error"]


@pytest.mark.parametrize("ending", ["mcap", "bag", "db3", "csv", "tlog"])
def test_the_trial_day_is_that_of_the_recorder(tmp_path: Path, ending: str) -> None:
    path = FORMATS[ending][0](tmp_path / f"run.{ending}", run(20))
    assert day_of(path) == "2023-11-14"


def test_a_board_that_counts_from_its_start_has_the_day_in_its_name(tmp_path: Path) -> None:
    assert day_of(write_bin(tmp_path / "2026-05-04 dive.BIN", run(20))) == "2026-05-04"
    assert day_of(write_bin(tmp_path / "00000042.BIN", run(20))) == "undated"


@pytest.mark.parametrize("ending", FORMATS)
def test_a_damaged_recording_is_read_or_refused_by_name(tmp_path: Path, ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    path = FORMATS[ending][0](tmp_path / f"run.{ending}", run(60))
    whole = path.read_bytes()
    draws = np.random.default_rng(1)
    for cut in (0, 10, len(whole) // 3, len(whole) - 7):
        spoiled = bytearray(whole[:cut])
        for at in draws.integers(0, max(cut, 1), 8):
            if spoiled:
                spoiled[at] ^= int(draws.integers(1, 256))
        path.write_bytes(bytes(spoiled))
        with suppress(InputError):
            assert read(path).file == path.name


@pytest.mark.parametrize("ending", sorted({*LOG_SUFFIXES, *TABLE_SUFFIXES} - {".mcap"}))
def test_no_other_ending_is_read_as_mcap(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"run{ending}"
    path.write_bytes(b"no log of any recorder")
    said = ""
    try:
        open_log(path, path.name).topics()
    except InputError as refused:
        said = str(refused)
    assert "this is not MCAP" not in said


def test_a_bag_is_left_as_it_is(tmp_path: Path) -> None:
    path = write_db3(tmp_path / "run.db3", run(20), tmp_path)
    before = path.read_bytes()
    read(path)
    assert path.read_bytes() == before
    assert {one.name for one in tmp_path.iterdir()} == {"run.db3", "bag"}


def test_of_other_bytes_than_a_bag_it_is_said_that_they_are_none(tmp_path: Path) -> None:
    path = tmp_path / "run.bag"
    path.write_bytes(bytes(range(128, 256)) * 8)
    with pytest.raises(InputError, match="does not begin with #ROSBAG"):
        read_pool_run(path, rov(), tmp_path)


def test_a_table_without_a_time_is_no_run(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("code,thrust [N]\n10,1.5\n")
    with pytest.raises(InputError, match="no column of the table has the time"):
        read(path)


@pytest.mark.parametrize(
    ("head", "values", "seconds"),
    [
        ("t", ["0.0", "0.5"], 0.5),
        ("time_ms", ["1700000000000", "1700000000250"], 0.25),
        ("timestamp [us]", ["10", "500010"], 0.5),
        ("Time (minutes)", ["0", "0.5"], 30.0),
        ("t [h]", ["0.1", "0.2"], 360.0),
        ("time [msec]", ["0", "250"], 0.25),
        ("elapsed time [sec]", ["0", "0.25"], 0.25),
        ("TimeUS", ["20000000", "20250000"], 0.25),
        ("time_boot_ms", ["2000", "2250"], 0.25),
        ("T [degC];time [s]", ["18.5;0", "18.6;0.25"], 0.25),
        ("t;time", ["18.5;0", "18.6;0.25"], 0.25),
        ("time", ["2026-05-04T10:00:00.250Z", "2026-05-04T10:00:01Z"], 0.75),
    ],
)
def test_times_of_tables(tmp_path: Path, head: str, values: list[str], seconds: float) -> None:
    path = tmp_path / "run.csv"
    path.write_text(f"{head};depth [m]\n{values[0]};1,5\n{values[1]};1,75\n")
    found = read(path)
    assert found.duration_s == pytest.approx(seconds)
    assert found.channels["depth"].values[:, 0].tolist() == [1.5, 1.75]


def test_a_time_in_a_unit_that_is_not_known_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time [fortnights],depth [m]\n0,1\n1,2\n")
    with pytest.raises(InputError, match='"fortnights" of column "time" is no unit of time'):
        read(path)


@pytest.mark.parametrize(
    ("head", "whole", "step"),
    [("time_ms", 2**32, 100), ("time_us", 2**32, 100_000), ("time_ms", 2**16, 100),
     ("time [s]", 86_400, 1), ("time [s]", 604_800, 1)],
)  # fmt: skip
def test_a_counter_that_begins_anew_is_counted_on(
    tmp_path: Path, head: str, whole: int, step: int
) -> None:
    path = tmp_path / "run.csv"
    times = [(whole - 7 * step + step * k) % whole for k in range(20)]
    path.write_text(f"{head},depth [m]\n" + "".join(f"{t},{t % 7}\n" for t in times))
    found = read(path)
    assert np.ptp(np.diff(found.channels["depth"].time_ns)) == 0
    assert any("were counted on" in one.what for one in found.problems)


def test_a_clock_that_was_set_back_is_no_counter(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    times = [*range(50, 100), *range(30, 80)]
    path.write_text("time [s],depth [m]\n" + "".join(f"{t},{t % 7}\n" for t in times))
    said = " ".join(one.what for one in read(path).problems)
    assert "the times of the log go back by 69.000 s" in said


def test_rows_in_no_order_are_sorted(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    times = np.random.default_rng(1).permutation(40)
    path.write_text("time [s],depth [m]\n" + "".join(f"{t},{1 + 0.1 * t}\n" for t in times))
    found = read(path)
    np.testing.assert_allclose(found.channels["depth"].values[:, 0], 1.0 + 0.1 * np.arange(40))
    assert any("they were sorted" in one.what for one in found.problems)


def test_a_title_over_a_table_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("Run 3;;\ntime [s];depth [m]\n0;1\n1;2\n")
    with pytest.raises(InputError, match="no column of the table has the time"):
        read(path)


def test_two_columns_of_commands_of_one_thruster_are_told(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "run.csv", run())
    rows = path.read_text().splitlines()
    path.write_text("\n".join([f"{rows[0]},cmd_port", *(f"{row},0" for row in rows[1:])]))
    found = read(path)
    assert np.ptp(found.channels["thruster_command.port"].values) > 0.0
    assert any('"pwm_port" and "cmd_port" may both' in one.what for one in found.problems)


@pytest.mark.parametrize("how", ["numbers", "dates", "durations"])
def test_times_in_the_index_of_a_parquet_file(tmp_path: Path, how: str) -> None:
    pytest.importorskip("pyarrow")
    pd = pytest.importorskip("pandas")
    seconds = np.arange(20) * 0.5
    index = {"numbers": pd.Index(seconds, name="time"), "dates": pd.to_datetime(seconds, unit="s"),
             "durations": pd.to_timedelta(seconds, unit="s")}[how]  # fmt: skip
    frame = pd.DataFrame({"depth [m]": 1.0 + 0.1 * seconds}, index=index)
    frame.to_parquet(tmp_path / "run.parquet")
    assert read(tmp_path / "run.parquet").duration_s == pytest.approx(9.5)


def test_measured_thrust_and_cable_tension_are_quantities(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    rows = "".join(f"{0.1 * k},{k % 7},{2 * (k % 5)},{10 + k % 3}\n" for k in range(30))
    path.write_text("time [s],thrust_port [kgf],thrust_bow [kgf],cable_tension [N]\n" + rows)
    found = read(path)
    np.testing.assert_allclose(
        found.channels["thrust.port"].values[:, 0], 9.80665 * (np.arange(30) % 7)
    )
    assert found.channels["cable_tension"].columns == ("cable_tension_n",)


def test_commands_of_other_thrusters_than_the_vehicles_are_said_to_be_missing(
    tmp_path: Path,
) -> None:
    path = write_csv(tmp_path / "run.csv", run())
    path.write_text(path.read_text().replace("pwm_", "pwm_other_"))
    said = " ".join(problem.what for problem in read(path).problems)
    assert f"there are no commands for {', '.join(NAMES)}." in said


def test_real_logs_of_a_bluerov(shared_data: Path) -> None:
    found = read(shared_data / "ardusub" / "small.BIN")
    assert found.channels["depth"].topic == "BARO[1]"
    force = found.channels["specific_force"].values
    assert np.abs(np.linalg.norm(force, axis=1) - 9.81).max() < 0.3
    assert np.abs(found.channels["thruster_command"].values).max() < 5.0


def test_of_a_log_that_is_none_the_library_says_nothing_to_the_user(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.BIN"
    path.write_bytes(b"garbage")
    with pytest.raises(InputError, match="no message of ArduPilot"):
        open_log(path, "pool/run.BIN")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["noise.BIN", "noise.tlog"])
def test_a_file_without_a_single_message_is_said_to_be_no_such_log(
    tmp_path: Path, name: str
) -> None:
    path = tmp_path / name
    path.write_bytes(np.random.default_rng(1).bytes(20_000))
    with pytest.raises(InputError, match="no message of ArduPilot is in the file"):
        open_log(path, name)
