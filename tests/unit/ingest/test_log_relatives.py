"""Logs whose units, axes or message types say nothing: the readings tell, or it is said."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import (
    NAMES,
    SECOND_NS,
    START_NS,
    Topic,
    imu_topic,
    joints_topic,
    json_topic,
    ros_topic,
    rov,
    stamp,
    ticks,
    vector,
    write_log,
)

from pipeline.export.cdr import schema_text
from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray

TIMES = ticks(400, 20.0)
T = (np.asarray(TIMES) - START_NS) / SECOND_NS
EULER = np.stack([0.05 * np.sin(T), 0.04 * np.cos(T), 0.5 + 0.2 * np.sin(0.3 * T)], axis=1)
DEPTH = 2.0 + 0.5 * np.sin(0.4 * T)
SPEED = np.stack([0.3 + 0.1 * np.sin(0.5 * T), 0.05 * np.sin(T), 0.2 * np.cos(0.4 * T)], axis=1)


def read(path: Path, topics: list[Topic]) -> PoolRun:
    return read_pool_run(write_log(path / "run.mcap", topics), rov(), path)


def said(run: PoolRun, severity: str = "warning") -> str:
    return "\n".join(one.what for one in run.problems if one.severity == severity)


def number(name: str, values: FloatArray) -> Topic:
    contents = [{"data": float(one)} for one in values]
    return ros_topic(name, "std_msgs/msg/Float64", TIMES, contents, "float64 data")


def table(path: Path, text: str) -> PoolRun:
    (path / "run.csv").write_text(text, encoding="utf-8")
    return read_pool_run(path / "run.csv", rov(), path)


def rows_of(*columns: FloatArray) -> str:
    return "".join(",".join(f"{one:.6f}" for one in row) + "\n" for row in np.column_stack(columns))


@pytest.mark.parametrize(
    "heads",
    [
        "time,roll,pitch,yaw,depth\n",
        "time,roll,pitch,yaw,depth\ns,deg,deg,deg,m\n",
        "Time (s),Roll (°),Pitch (°),Yaw (°),Depth (m)\n",
    ],
)
def test_degrees_by_their_size_or_by_a_row_of_units(heads: str, tmp_path: Path) -> None:
    run = table(tmp_path, heads + rows_of(T, np.degrees(EULER), DEPTH))
    yaw = 2.0 * np.arctan2(*run.channels["attitude"].values[:, [3, 0]].T)
    np.testing.assert_allclose(yaw, EULER[:, 2], atol=3e-3)


def test_a_row_of_ones_is_a_reading(tmp_path: Path) -> None:
    rows = "".join(f"{k},{k},{k},{k}\n" for k in range(1, 40))
    assert table(tmp_path, f"time,p,q,r\n{rows}").channels["angular_velocity"].values[0, 0] == 1.0


def test_radians_stay_radians(tmp_path: Path) -> None:
    run = table(tmp_path, "time,roll,pitch,yaw,depth\n" + rows_of(T, EULER, DEPTH))
    yaw = 2.0 * np.arctan2(*run.channels["attitude"].values[:, [3, 0]].T)
    np.testing.assert_allclose(yaw, EULER[:, 2], atol=3e-3)


def test_a_column_in_an_unknown_unit_is_named(tmp_path: Path) -> None:
    run = table(tmp_path, "time [s],p [rev],q [rev],r [rev],depth [m]\n" + rows_of(T, EULER, DEPTH))
    assert '"rev" of column "p" is no unit of angular_velocity' in said(run)


def test_a_depth_that_no_vehicle_dives(tmp_path: Path) -> None:
    run = read(tmp_path, [imu_topic(TIMES, 0.1 * EULER), number("/depth", 100.0 * DEPTH)])
    assert "more than is possible" in said(run)


def test_a_pressure_stands_for_a_depth_in_another_unit(tmp_path: Path) -> None:
    pressure = [
        {"header": {"stamp": stamp(time), "frame_id": ""}, "fluid_pressure": 101325 + 9810 * one}
        for time, one in zip(TIMES, DEPTH.tolist(), strict=True)
    ]
    contents = [{**one, "variance": 0.0} for one in pressure]
    topic = ros_topic("/pressure", "sensor_msgs/msg/FluidPressure", TIMES, contents)
    run = read(tmp_path, [number("/depth", 100.0 * DEPTH), topic])
    assert run.channels["depth"].topic == "/pressure"


@pytest.mark.parametrize(("factor", "taken"), [(1.0, "depth"), (3.28, "pressure")])
def test_a_column_of_pressures_stands_for_a_depth_in_feet(
    factor: float, taken: str, tmp_path: Path
) -> None:
    still = 4.0 + 0.001 * np.sin(T)
    rows = rows_of(T, factor * still, 101_325.0 + 9810.0 * still, EULER)
    run = table(tmp_path, f"time [s],depth,pressure [Pa],p,q,r\n{rows}")
    assert run.channels["depth"].read.quantity == taken
    np.testing.assert_allclose(run.channels["depth"].values[:, 0], still, atol=1e-3)
    assert ("3.28 times that by the pressure" in said(run)) == (factor > 1.0)


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (1.944, True), (3.6, True)])
def test_a_velocity_in_knots_changes_more_than_is_felt(
    factor: float, told: bool, tmp_path: Path
) -> None:
    t = np.arange(0.0, 60.0, 0.05)
    surge, still = 0.5 + 0.4 * np.sin(0.8 * t), 0.0 * t
    felt = [0.32 * np.cos(0.8 * t), still, still - 9.81]
    columns = (factor * surge, still, still, *felt, still, still, 0.001 * np.sin(t))
    rows = rows_of(t, *columns)
    run = table(tmp_path, f"time,u,v,w,ax,ay,az,roll,pitch,yaw\n{rows}")
    assert ("times the acceleration by specific_force" in said(run)) == told


@pytest.mark.parametrize(("also", "taken"), [(True, "bottom"), (False, "water")])
def test_a_velocity_through_the_water_comes_last(also: bool, taken: str, tmp_path: Path) -> None:
    def track(name: str, every: int) -> Topic:
        contents = [dict(zip(("vx", "vy", "vz"), one, strict=True)) for one in SPEED.tolist()]
        return json_topic(f"/dvl/{name}_track", TIMES[::every], contents[::every])

    run = read(tmp_path, [track("water", 1), *([track("bottom", 2)] if also else [])])
    assert run.channels["velocity"].topic == f"/dvl/{taken}_track"
    assert ("velocity through the water" in said(run)) is not also


@pytest.mark.parametrize(("sign", "told"), [(1.0, False), (-1.0, True)])
def test_a_velocity_against_the_thrust(sign: float, told: bool, tmp_path: Path) -> None:
    body = SPEED * [sign, sign, 1.0]
    codes = np.tile([60.0, 60.0, 0.0, 0.0], (len(TIMES), 1))
    topics = [
        imu_topic(TIMES, 0.1 * EULER),
        number("/depth", DEPTH),
        joints_topic("/thrusters/command", TIMES, [NAMES] * len(TIMES), codes),
        json_topic(
            "/dvl",
            TIMES,
            [dict(zip(("vx", "vy", "vz"), one, strict=True)) for one in body.tolist()],
        ),
    ]
    run = read(tmp_path, topics)
    np.testing.assert_allclose(run.channels["velocity"].values, body, atol=1e-9)
    assert ("contradicts the motion: the push of the thrusters" in said(run)) == told


def test_what_a_dvl_of_waterlinked_calls_invalid(tmp_path: Path) -> None:
    contents = [
        {"vx": x, "vy": y, "vz": z, "velocity_valid": not 100 <= number < 120, "type": "velocity"}
        for number, (x, y, z) in enumerate(SPEED.tolist())
    ]
    run = read(tmp_path, [number("/depth", DEPTH), json_topic("/dvl/raw", TIMES, contents)])
    assert np.flatnonzero(~run.channels["velocity"].usable()).tolist() == list(range(100, 120))


def test_messages_of_sbg(tmp_path: Path) -> None:
    parts = ["std_msgs/msg/Header", "geometry_msgs/msg/Vector3"]
    below = "".join(
        f"\n{'=' * 80}\nMSG: {one.replace('/msg', '')}\n{schema_text(one)}" for one in parts
    )
    heads = [{"stamp": stamp(time), "frame_id": "imu_link_ned"} for time in TIMES]
    force = [0.0, 0.0, -9.81] + 0.01 * EULER
    imu = [
        {"header": head, "accel": vector(felt), "gyro": vector(rate)}
        for head, felt, rate in zip(heads, force.tolist(), (0.1 * EULER).tolist(), strict=True)
    ]
    euler = [
        {"header": head, "angle": vector(angle)}
        for head, angle in zip(heads, EULER.tolist(), strict=True)
    ]
    text = "std_msgs/Header header\ngeometry_msgs/Vector3 "
    run = read(
        tmp_path,
        [
            ros_topic(
                "/sbg/imu_data", "sbg_driver/msg/SbgImuData", TIMES, imu,
                f"{text}accel\ngeometry_msgs/Vector3 gyro{below}",
            ),
            ros_topic(
                "/sbg/ekf_euler", "sbg_driver/msg/SbgEkfEuler", TIMES, euler, f"{text}angle{below}"
            ),
        ],
    )  # fmt: skip
    np.testing.assert_allclose(run.channels["angular_velocity"].values, 0.1 * EULER)
    np.testing.assert_allclose(run.channels["specific_force"].values, force)
    assert run.channels["attitude"].topic == "/sbg/ekf_euler"


@pytest.mark.parametrize(
    ("one_s", "unit"), [(1e3, "ms"), (1e6, "us"), (1.0 / 86_400.0, "days"), (1.0, "")]
)
def test_times_without_a_unit_are_told_by_their_step(
    one_s: float, unit: str, tmp_path: Path
) -> None:
    rows = "".join(f"{t * one_s:.12g},{d:.4f}\n" for t, d in zip(T, DEPTH, strict=True))
    run = table(tmp_path, f"time,depth\n{rows}")
    assert run.duration_s == pytest.approx(T[-1], rel=1e-3)
    assert (f"is taken for {unit}" in said(run)) == bool(unit)


def test_a_yaw_in_degrees_beside_a_roll_in_radians_is_told(tmp_path: Path) -> None:
    t = np.arange(0.0, 60.0, 0.05)
    roll, rate = 0.1 * np.sin(0.7 * t), 0.07 * np.cos(0.7 * t)
    still = np.zeros_like(t)
    rows = rows_of(t, roll, still, 350.0 + still, rate, still, still)
    run = table(tmp_path, f"time,roll,pitch,yaw,p,q,r\n{rows}")
    assert "the roll rate (table) is 57" in said(run)


def test_rates_of_more_than_a_turn_a_second_are_told(tmp_path: Path) -> None:
    run = table(tmp_path, "time,p,q,r,depth\n" + rows_of(T, 30.0 * EULER, DEPTH))
    assert "more than a turn a second" in said(run)


@pytest.mark.parametrize(("order", "told"), [([1, 2, 3, 0], False), ([0, 1, 2, 3], True)])
def test_an_attitude_that_lies_on_its_back_is_told(
    order: list[int], told: bool, tmp_path: Path
) -> None:
    wxyz = np.stack([np.cos(0.3 + 0.0 * T), 0.02 * np.sin(T), 0.0 * T, np.sin(0.3 + 0.0 * T)], 1)
    contents = [{"orientation": one} for one in wxyz[:, order].tolist()]
    run = read(tmp_path, [json_topic("/ahrs", TIMES, contents), number("/depth", DEPTH)])
    assert ("order are others" in said(run)) == told


def test_columns_of_one_vector_in_different_units_are_not_mixed(tmp_path: Path) -> None:
    heads = "time [s],roll [deg],pitch [deg],yaw [rad],depth [m]\n"
    run = table(tmp_path, heads + rows_of(T, np.degrees(EULER[:, :2]), EULER[:, 2], DEPTH))
    assert "attitude" not in run.channels
    assert "columns roll, pitch, yaw have different units" in said(run)


def test_flags_are_known_however_they_are_spelled(tmp_path: Path) -> None:
    contents = [
        {"vx": x, "vy": y, "vz": z, "isValid": not 100 <= number < 120}
        for number, (x, y, z) in enumerate(SPEED.tolist())
    ]
    run = read(tmp_path, [number("/depth", DEPTH), json_topic("/dvl", TIMES, contents)])
    assert np.flatnonzero(~run.channels["velocity"].usable()).tolist() == list(range(100, 120))


@pytest.mark.parametrize(
    ("pressure", "said_of_it"),
    [
        (1013.0 + 98.1 * DEPTH, "this looks like hPa"),
        (1013.0 + 98.1 * (6.0 + DEPTH), "kPa or hPa"),
        (98.1 * (DEPTH - 1.0), "kPa or hPa"),
        (9.81 * DEPTH, "kPa or hPa"),
        (101_900.0 + 200.0 * np.sin(T), "the pressure inside of it"),
    ],
)
def test_a_pressure_that_is_none_of_the_water(
    pressure: FloatArray, said_of_it: str, tmp_path: Path
) -> None:
    rows = rows_of(T, pressure, EULER)
    assert said_of_it in said(table(tmp_path, f"time,pressure,p,q,r\n{rows}"))


@pytest.mark.parametrize(("rpm", "told"), [(600.0, False), (100.0, True)])
def test_shafts_that_turn_too_slowly_for_the_way(rpm: float, told: bool, tmp_path: Path) -> None:
    rows = rows_of(T, SPEED + np.array([0.7, 0.0, 0.0]), np.full(T.size, 60.0), rpm + np.sin(T))
    run = table(tmp_path, f"time [s],u,v,w,command_port,rpm_port\n{rows}")
    assert ("the shaft speed of port is too low" in said(run)) is told


@pytest.mark.parametrize(("unit", "worth"), [("ft", 0.3048), ("m", 1.0), ("bar", 0.0)])
def test_a_unit_that_the_message_says_is_taken(unit: str, worth: float, tmp_path: Path) -> None:
    contents = [{"depth": float(one), "unit": unit} for one in DEPTH]
    run = read(tmp_path, [imu_topic(TIMES, 0.1 * EULER), json_topic("/depth", TIMES, contents)])
    if worth:
        np.testing.assert_allclose(run.channels["depth"].values[:, 0], worth * DEPTH)
    else:
        assert "depth" not in run.channels
        assert 'have the unit "bar", which is none of it' in said(run, "note")


def test_angles_and_sensors_by_their_names(tmp_path: Path) -> None:
    names = ("roll", "pitch", "heading")
    force = [0.0, 0.0, -9.81] + 0.01 * EULER
    contents = [
        {**dict(zip(names, angles, strict=True)), "gyro": rates, "accel": vector(felt)}
        for angles, rates, felt in zip(
            np.degrees(EULER).tolist(), (0.1 * EULER).tolist(), force.tolist(), strict=True
        )
    ]
    run = read(tmp_path, [json_topic("/ahrs", TIMES, contents)])
    yaw = 2.0 * np.arctan2(*run.channels["attitude"].values[:, [3, 0]].T)
    np.testing.assert_allclose(yaw, EULER[:, 2], atol=3e-3)
    np.testing.assert_allclose(run.channels["angular_velocity"].values, 0.1 * EULER)
    np.testing.assert_allclose(run.channels["specific_force"].values, force)


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (3.28, True)])
def test_a_depth_in_feet_swings_more_than_is_felt(
    factor: float, told: bool, tmp_path: Path
) -> None:
    felt = -9.81 - 0.5 * 0.9**2 * np.sin(0.9 * T)
    depth = 3.0 + 0.5 * np.sin(0.9 * T) + 0.002 * np.random.default_rng(1).standard_normal(T.size)
    still = 0.0 * T
    rows = rows_of(T, factor * depth, still, still, felt, still, still, 0.001 * np.sin(T))
    run = table(tmp_path, f"time [s],depth [m],ax,ay,az,roll,pitch,yaw\n{rows}")
    assert ("the change of the depth (table) is 3." in said(run)) is told


@pytest.mark.parametrize(
    "heads",
    [
        "Время;Скорость X;Скорость Y;Скорость Z;Крен;Тангаж;Курс;Глубина, м\n",
        "time [s];surge velocity;sway velocity;heave velocity;roll;pitch angle;yaw;tiefe\n",
    ],
)
def test_columns_in_other_words(heads: str, tmp_path: Path) -> None:
    rows = rows_of(T, SPEED, EULER, DEPTH).replace(",", ";")
    run = table(tmp_path, heads + rows)
    np.testing.assert_allclose(run.channels["velocity"].values, SPEED, atol=1e-5)
    np.testing.assert_allclose(run.channels["depth"].values[:, 0], DEPTH, atol=1e-5)
    assert "attitude" in run.channels


def test_a_place_and_a_velocity_to_the_east_north_and_up(tmp_path: Path) -> None:
    place = np.cumsum(SPEED, axis=0) / 20.0
    rows = rows_of(T, SPEED[:, [1, 0]], -SPEED[:, 2], place[:, [1, 0]], -place[:, 2], EULER)
    run = table(tmp_path, f"time [s],v_east,v_north,v_up,east,north,up,roll,pitch,yaw\n{rows}")
    np.testing.assert_allclose(run.channels["velocity_earth"].values, SPEED, atol=1e-5)
    np.testing.assert_allclose(run.channels["position"].values, place, atol=1e-5)


@pytest.mark.parametrize(
    ("one_s", "start", "unit"),
    [(1e9, 0.0, "ns"), (1.0, 1.7e9, ""), (1e3, 1.7e12, ""), (1e9, 1.7e18, "")],
)
def test_times_since_1970_and_others_of_their_size(
    one_s: float, start: float, unit: str, tmp_path: Path
) -> None:
    rows = "".join(f"{start + t * one_s:.0f},{d:.4f}\n" for t, d in zip(T, DEPTH, strict=True))
    run = table(tmp_path, f"time,depth\n{rows}")
    assert run.duration_s == pytest.approx(T[-1], abs=0.6)
    assert (f"is taken for {unit}" in said(run)) == bool(unit)


@pytest.mark.parametrize(("lowest", "told"), [(0.6, True), (0.0, False)])
def test_a_share_whose_rest_is_not_seen(lowest: float, told: bool, tmp_path: Path) -> None:
    share = lowest + (1.0 - lowest) * (0.5 + 0.45 * np.sin(0.5 * T)) * (T > 4.0)
    share[T <= 4.0] = lowest
    rows = rows_of(T, share, share, DEPTH)
    run = table(tmp_path, f"time [s],command_port,command_starboard,depth\n{rows}")
    assert ("its rest is not seen" in said(run)) is told


def test_a_topic_that_was_logged_at_one_time_is_placed_by_its_stamps(tmp_path: Path) -> None:
    at_once = [START_NS + SECOND_NS] * len(TIMES)
    imu = imu_topic(at_once, 0.1 * EULER, stamps_ns=TIMES)
    run = read(tmp_path, [imu, number("/depth", DEPTH)])
    np.testing.assert_array_equal(run.channels["angular_velocity"].time_ns, TIMES)
    assert "/imu/data were logged at one time" in said(run)


@pytest.mark.parametrize("empty", [{}, {"state": "init"}])
def test_a_field_that_comes_late_and_numbers_written_as_texts(
    empty: dict[str, str], tmp_path: Path
) -> None:
    late = [{"depth": f"{one:.5f}"} if at > 100 else empty for at, one in enumerate(DEPTH)]
    run = read(tmp_path, [imu_topic(TIMES, 0.1 * EULER), json_topic("/depth", TIMES, late)])
    np.testing.assert_allclose(run.channels["depth"].values[101:, 0], DEPTH[101:], atol=1e-5)
