"""Measured pool runs and odd logs that nobody here wrote, with nothing but a vehicle.yaml."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from pipeline.errors import InputError
from pipeline.identify.manoeuvre_detection import find_manoeuvres
from pipeline.ingest.pool_run import read_pool_run, resample, summarize
from pipeline.ingest.pool_run_codec import Codec, codec_of
from pipeline.ingest.pool_run_resample import on_one_base
from pipeline.ingest.pool_run_thrusters import thrusters_against_rates
from pipeline.records.run_arrays import PoolRun
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

HERE = Path(__file__).parent
#: One count of the gyroscope's high byte: 256 / 16.4 degrees per second, as its program scales it.
TORN_READ_RADPS = 256 * 0.0174532 / 16.4


def logs_in(folder: Path) -> list[Path]:
    found = sorted(folder.glob("*.mcap"))
    if not found:
        pytest.skip(f"no logs in {folder}")
    return found


@pytest.fixture(name="vehicle", scope="module")
def vehicle_fixture() -> Vehicle:
    return load_vehicle(HERE / "exjobbrov")


@pytest.fixture(name="rov", scope="module")
def rov_fixture() -> Vehicle:
    """A vehicle whose thrusters and sensors have nothing to do with the odd logs."""
    return load_vehicle(HERE / "t200")


@pytest.fixture(name="runs", scope="module")
def runs_fixture(shared_data: Path, vehicle: Vehicle) -> dict[str, PoolRun]:
    return {
        path.stem: read_pool_run(path, vehicle, shared_data)
        for path in logs_in(shared_data / "exjobbrov_pool")
    }


def named(runs: dict[str, PoolRun], what: str) -> dict[str, PoolRun]:
    """Runs of one kind; the names of the files go on with the time of day."""
    found = {name: run for name, run in runs.items() if name.split("_")[0] == what}
    assert found, what
    return found


def decoded(path: Path, take: dict[str, Callable[[Any], list[float]]]) -> dict[str, np.ndarray]:
    """Numbers of some topics, by a library that is not ours."""
    rows: dict[str, list[list[float]]] = {topic: [] for topic in take}
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages(
            topics=list(take), log_time_order=False
        ):
            rows[channel.topic].append([message.log_time, *take[channel.topic](content)])
    return {topic: np.array(values, dtype=object) for topic, values in rows.items()}


def test_every_pool_run_is_read_whole(shared_data: Path, runs: dict[str, PoolRun]) -> None:
    assert len(runs) == len(logs_in(shared_data / "exjobbrov_pool")) >= 9
    for run in runs.values():
        assert set(run.channels) == {
            *("thruster_command", "angular_velocity", "specific_force", "attitude", "depth")
        }
        assert run.complete
        assert 16.0 < run.duration_s < 45.0
        assert not [problem for problem in run.problems if problem.severity == "error"]
        record = summarize(run)
        rates = {channel.name: channel.rate_hz for channel in record.channels}
        assert rates["thruster_command"] == pytest.approx(100.0, rel=0.01)
        assert rates["angular_velocity"] == pytest.approx(125.0, rel=0.01)
        assert rates["depth"] == pytest.approx(10.9, rel=0.02)


def test_the_numbers_are_those_of_a_library(shared_data: Path, vehicle: Vehicle) -> None:
    path = logs_in(shared_data / "exjobbrov_pool")[0]
    run = read_pool_run(path, vehicle, shared_data)
    theirs = decoded(
        path,
        {
            "rovio/imu/data": lambda message: list(message.data),
            "rovio/thrusters": lambda message: list(message.data),
        },
    )
    imu = theirs["rovio/imu/data"]
    rate, command = run.channels["angular_velocity"], run.channels["thruster_command"]
    np.testing.assert_array_equal(rate.values, imu[:, 2:5].astype(float))
    np.testing.assert_array_equal(rate.log_time_ns, imu[:, 0].astype(np.int64))
    pwm = theirs["rovio/thrusters"][:, 1:].astype(float)
    np.testing.assert_array_equal(command.values, pwm - 1500.0)


def _without_definition(*channel: Any) -> Codec:  # noqa: ANN401  channel and schema of a log
    return replace(codec_of(*channel), definition=None)


@pytest.mark.parametrize("some", [4, pytest.param(None, marks=pytest.mark.slow)])
def test_fast_and_slow_agree_on_measured_logs(
    shared_data: Path, vehicle: Vehicle, rov: Vehicle, some: int | None
) -> None:
    pool = logs_in(shared_data / "exjobbrov_pool")[:some]
    paths = [(path, vehicle) for path in pool]
    paths += [(path, rov) for path in logs_in(shared_data / "mcap_odd")]
    compared = 0
    for path, one in paths:
        try:
            fast = read_pool_run(path, one, shared_data)
        except InputError:
            continue
        with patch("pipeline.ingest.pool_run_topics.codec_of", _without_definition):
            slow = read_pool_run(path, one, shared_data)
        assert fast.problems == slow.problems
        for name, channel in fast.channels.items():
            np.testing.assert_array_equal(channel.values, slow.channels[name].values)
            np.testing.assert_array_equal(channel.time_ns, slow.channels[name].time_ns)
            compared += 1
    assert compared >= 5 * len(pool)


def test_the_boards_clock_is_one_clock_over_the_whole_day(runs: dict[str, PoolRun]) -> None:
    """Nothing ties the runs to each other, and still their lines are parts of one.

    The offset of the board's clock falls from run to run as the drift within the runs says, which
    was fitted to 16 to 45 s each. The clock loses 750 ppm in the first runs and about 550 in
    the last, so its offset is a curve, and the drift of a run is the slope of the curve there.
    """
    clocks = [run.channels["angular_velocity"].clock for run in runs.values()]
    assert {clock.used for clock in clocks} == {"field"}
    start_s = np.array([run.start_time_ns / 1e9 for run in runs.values()])
    offset_s = np.array([clock.offset_s for clock in clocks])
    hours = (start_s - start_s.min()) / 3600.0
    drift_ppm = np.array([clock.drift_ppm for clock in clocks])
    assert 1e6 * np.polyfit(hours, offset_s, 1)[0] / 3600.0 == pytest.approx(-595.0, abs=15.0)
    curve = np.polyfit(hours, offset_s, 3)
    slope_ppm = 1e6 * np.polyval(np.polyder(curve), hours) / 3600.0
    assert np.abs(offset_s - np.polyval(curve, hours)).max() < 0.01
    assert np.abs(drift_ppm - slope_ppm).max() < 100.0
    assert np.corrcoef(drift_ppm, slope_ppm)[0, 1] > 0.9
    assert max(clock.jitter_s or 0.0 for clock in clocks) < 0.005


def test_spikes_of_the_gyroscope_are_torn_reads(runs: dict[str, PoolRun]) -> None:
    """Most spikes are off by one count of the high byte: 0.2724 rad/s, which no rotation makes."""
    sizes: list[float] = []
    readings = 0
    for run in runs.values():
        channel = run.channels["angular_velocity"]
        values = channel.values
        rows = np.flatnonzero(channel.marks.get("spike", np.zeros(len(values), bool)))
        off = values[rows] - 0.5 * (values[rows - 1] + values[rows + 1])
        sizes += np.abs(off).max(axis=1).tolist()
        readings += len(values)
    assert len(sizes) >= 40
    assert 0.001 < len(sizes) / readings < 0.0025
    torn = np.abs(np.array(sizes) - TORN_READ_RADPS) < 0.03
    assert torn.mean() > 0.8


def test_gravity_and_depth_are_what_they_must_be(runs: dict[str, PoolRun]) -> None:
    for run in runs.values():
        force = np.linalg.norm(run.channels["specific_force"].values, axis=1)
        assert np.median(force) == pytest.approx(9.8, abs=0.25)
        depth = run.channels["depth"].values
        assert 0.0 < depth.min() < depth.max() < 2.0


def test_thrusters_are_not_suspected_but_a_swap_is_found(
    shared_data: Path, runs: dict[str, PoolRun], vehicle: Vehicle
) -> None:
    for run in runs.values():
        said = " ".join(problem.what for problem in run.problems)
        assert "rates suggest" not in said
        assert "runs against" not in said
        channels = {name: one for name, one in run.channels.items() if name != "attitude"}
        without = replace(run, channels=channels)
        table = on_one_base(without)
        assert not list(thrusters_against_rates(without, table, vehicle))
    path = next(
        path for path in logs_in(shared_data / "exjobbrov_pool") if path.name.startswith("sinPsi")
    )
    thrusters = list(vehicle.thrusters)
    left, right = thrusters[2], thrusters[3]
    thrusters[2] = left.model_copy(update={"position_m": right.position_m})
    thrusters[3] = right.model_copy(update={"position_m": left.position_m})
    swapped = vehicle.model_copy(update={"thrusters": tuple(thrusters)})
    text = "\n".join(problem.what for problem in read_pool_run(path, swapped, shared_data).problems)
    assert "surge_left and surge_right are swapped against the vehicle file" in text


def test_commands_of_the_depth_steps_hold_no_vertical_thrust(runs: dict[str, PoolRun]) -> None:
    """A quirk of the data: the vehicle dives half a metre, no vertical thruster is commanded."""
    for run in named(runs, "stepDepth").values():
        command = run.channels["thruster_command"]
        assert np.ptp(run.channels["depth"].values) > 0.4
        vertical = [i for i, name in enumerate(command.columns) if "vertical" in name]
        assert len(vertical) == 3
        assert not command.values[:, vertical].any()


def test_a_table_of_a_pool_run_has_gaps_only_where_readings_are_missing(
    runs: dict[str, PoolRun],
) -> None:
    for run in runs.values():
        table = resample(run, 50.0)
        assert np.mean(list(table.valid.values())) > 0.97
        assert table.values["command"].shape == (table.time_s.size, 6)
        # all of it but in one run, sinDepthA05F05, which lacks 0.3 s of the 23 s
        assert np.isfinite(table.values["angular_velocity"][5:-10]).mean() > 0.985
        assert table.time_s.size == pytest.approx(50.0 * run.duration_s, abs=3.0)


def test_stamps_of_a_simulated_clock_are_laid_onto_the_log(shared_data: Path, rov: Vehicle) -> None:
    path = shared_data / "mcap_odd" / "evo_nav2_turtlebot.mcap"
    logs_in(path.parent)
    run = read_pool_run(path, rov, shared_data)
    channel = run.channels["position"]
    assert channel.clock.used == "header"
    assert channel.clock.offset_s > 1.7e9  # simulated 928 s against the time of day
    late_s = (channel.log_time_ns - channel.time_ns) / 1e9
    assert np.median(np.abs(late_s)) < 0.01
    theirs = decoded(path, {"/odom": lambda m: [m.pose.pose.position.x, m.pose.pose.position.y]})
    east_north = theirs["/odom"][:, 1:].astype(float)
    np.testing.assert_array_equal(channel.values[:, [1, 0]], east_north)
    assert any("no thruster commands" in problem.what for problem in run.problems)


def test_mavros_needs_no_mapping(shared_data: Path, rov: Vehicle) -> None:
    path = shared_data / "mcap_odd" / "saab_2025_05_14-15_59_00_stdtopics.mcap"
    logs_in(path.parent)
    run = read_pool_run(path, rov, shared_data)
    assert run.channels["angular_velocity"].topic == "/mavros/imu/data"
    down = run.channels["specific_force"].values.mean(axis=0)
    assert down[2] == pytest.approx(-9.79, abs=0.05)  # forward, left, up has become ours
    assert run.channels["voltage"].values.mean() == pytest.approx(16.34, abs=0.02)
    assert "depth" not in run.channels  # the barometer of the autopilot is no depth sensor
    said = "\n".join(problem.what for problem in run.problems)
    assert "/mocap/hula/pose: " in said  # a clock that does not keep pace


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("rosbag2_cdr_test_0", "/array_topic (test_msgs/msg/Arrays, cdr, 4 messages)"),
        ("rosbag2_talker", "/rosout (rcl_interfaces/msg/Log, cdr, 10 messages)"),
        ("rosbag2_topics_and_services", "a service or an action, which is not one message"),
        ("rosbag2_wbag_0", "HHH (std_msgs/msg/String, cdr, 148 messages)"),
    ],
)
def test_logs_without_readings_say_what_they_hold(
    shared_data: Path, rov: Vehicle, name: str, says: str
) -> None:
    path = shared_data / "mcap_odd" / f"{name}.mcap"
    logs_in(path.parent)
    with pytest.raises(InputError) as caught:
        read_pool_run(path, rov, shared_data)
    assert says in str(caught.value)
    assert "none of its topics is known to carry" in str(caught.value)


def test_manoeuvres_of_the_measured_runs_are_plausible(
    runs: dict[str, PoolRun], vehicle: Vehicle
) -> None:
    """The names of the files say which axis was moved; there is no speed in the logs."""
    code_max = np.array([vehicle.drives[one.drive].code_max for one in vehicle.thrusters], float)
    longest = {}
    for name, run in runs.items():
        found = find_manoeuvres(resample(run, 20.0), code_max)
        assert found[-1].to_s <= run.duration_s + 0.1
        longest[name] = max(found, key=lambda one: one.to_s - one.from_s).name
    kinds = {name: name.split("_")[0] for name in longest}
    for kind in ("stepPsiS3E10", "sinPsiA05F05", "sinPsiA1F05"):
        assert {longest[name] for name in named(runs, kind)} == {"heading_steps"}
    for kind in ("stepAllAttitude", "sinAllA1F05", "sinAllAttitudeA05", "sinAllAttitudeA1"):
        assert {longest[name] for name in named(runs, kind)} == {"mixed"}
    # ExactLin is left out: by its name a controller was tried, no axis was stepped or swung, and
    # its commands are taken for a prbs. The other names speak of steps and sines only.
    others = {found for name, found in longest.items() if kinds[name] != "ExactLin"}
    assert not {"multisine", "chirp", "prbs", "straight", "circle"} & others
