"""Noise, bias and wander of the sensors: size, independence, and one seed for all of it.

The vehicle rests level, so what a reading differs by from the known value is its error alone.
Limits are five standard errors of the estimate: a seed is fixed, so a test passes always or never.
"""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_cases import GRAVITY, motion, sense, with_shaft_tables

from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.sensors import Log
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import (
    Depth,
    Dvl,
    Imu,
    Position,
    Sensor,
    ShaftSpeed,
    Voltage,
)

Make = Callable[..., PackedVehicle]
DURATION_S = 100.0
RATE_HZ = 100.0
ATTITUDE_NOISE_RAD = 2e-3
BOARD: dict[str, Sensor] = {
    "imu": Imu(
        rate_hz=RATE_HZ,
        rate_noise_radps=0.01,
        force_noise_mps2=0.05,
        attitude_noise_rad=ATTITUDE_NOISE_RAD,
    ),
    "dvl": Dvl(rate_hz=RATE_HZ, noise_mps=0.02),
    "depth": Depth(rate_hz=RATE_HZ, noise_m=0.03),
    "position": Position(rate_hz=RATE_HZ, noise_m=0.4),
    "shaft_speed": ShaftSpeed(rate_hz=RATE_HZ, noise_rpm=7.0),
    "voltage": Voltage(rate_hz=RATE_HZ, nominal_v=48.0, noise_v=0.1),
}


def board(make_packed: Make, seed: int, sensors: dict[str, Sensor] | None = None) -> Log:
    packed = with_shaft_tables(make_packed())
    return sense(packed, motion(DURATION_S), seed, **(BOARD if sensors is None else sensors))


def deviation_matches(error: FloatArray, deviation: float) -> None:
    """Mean and standard deviation within five standard errors, no memory, no common part."""
    count = len(error)
    assert np.abs(error.mean(axis=0)).max() < 5 * deviation / np.sqrt(count)
    ratio = error.std(axis=0) / deviation
    assert np.abs(ratio - 1).max() < 5 / np.sqrt(2 * count)
    together = np.corrcoef(np.hstack([error[1:], error[:-1]]).T)
    assert np.abs(together - np.eye(len(together))).max() < 5 / np.sqrt(count)


@pytest.mark.parametrize(
    ("name", "columns", "true", "noise"),
    [
        ("imu", slice(0, 3), (0, 0, 0), 0.01),
        ("imu", slice(3, 6), (0, 0, -GRAVITY), 0.05),
        ("dvl", slice(0, 3), (0, 0, 0), 0.02),
        ("depth", slice(0, 1), (0,), 0.03),
        ("position", slice(0, 3), (0, 0, 0), 0.4),
        ("shaft_speed", slice(0, 5), (0, 0, 0, 0, 0), 7.0),
        ("voltage", slice(0, 1), (48.0,), 0.1),
    ],
)
def test_noise_is_white_and_of_the_stated_size(
    make_packed: Make, name: str, columns: slice, true: tuple[float, ...], noise: float
) -> None:
    channel = board(make_packed, seed=11)[name]
    deviation_matches(channel.values[:, columns] - np.array(true), noise)


def test_attitude_noise_is_a_small_rotation(make_packed: Make) -> None:
    w, x, y, z = board(make_packed, seed=12)["imu"].values[:, 6:].T
    np.testing.assert_allclose(w**2 + x**2 + y**2 + z**2, 1.0, atol=1e-12)
    errors = Rotation.from_quat(np.stack([x, y, z, w], axis=1)).as_rotvec()
    deviation_matches(errors, ATTITUDE_NOISE_RAD)


def test_attitude_wanders_slowly(make_packed: Make) -> None:
    """First-order Gauss-Markov: deviation 0.02 rad, correlation exp(-dt / 2 s), from the start."""
    sensor = Imu(rate_hz=20, attitude_wander_rad=0.02, attitude_wander_s=2.0)
    packed = make_packed()
    runs = []
    for seed in range(100):
        values = sense(packed, motion(20.0), seed, imu=sensor)["imu"].values
        runs.append(Rotation.from_quat(values[:, [7, 8, 9, 6]]).as_rotvec())
    error = np.stack(runs)  # (runs, samples, axes)
    ensemble = error.transpose(1, 0, 2).reshape(401, -1).std(axis=1) / 0.02
    # 300 independent values at each time; the first sample is as wide as the others
    assert np.abs(ensemble - 1).max() < 5 / np.sqrt(2 * 300)
    for lag_s, samples in ((0.5, 10), (2.0, 40), (4.0, 80)):
        correlation = (error[:, samples:] * error[:, :-samples]).mean() / 0.02**2
        # 3000 intervals of one correlation time, so about as many independent products
        assert abs(correlation - np.exp(-lag_s / 2.0)) < 5 / np.sqrt(3000)


def test_bias_is_one_value_a_run(make_packed: Make) -> None:
    sensors: dict[str, Sensor] = {
        "imu": Imu(rate_hz=5, rate_bias_radps=0.003, force_bias_mps2=0.04),
        "depth": Depth(rate_hz=5, bias_m=0.05),
    }
    packed = make_packed()
    found = []
    for seed in range(300):
        log = sense(packed, motion(1.0), seed, **sensors)
        for channel in log.values():
            assert np.ptp(channel.values, axis=0).max() == 0.0
        force = log["imu"].values[0, 3:6] - [0, 0, -GRAVITY]
        found.append([*log["imu"].values[0, :3], *force, log["depth"].values[0, 0]])
    scaled = np.array(found) / np.array([0.003] * 3 + [0.04] * 3 + [0.05])
    assert np.abs(scaled.std(axis=0) - 1).max() < 5 / np.sqrt(2 * 300)
    assert np.abs(scaled.mean(axis=0)).max() < 5 / np.sqrt(300)
    assert np.abs(np.corrcoef(scaled.T) - np.eye(7)).max() < 5 / np.sqrt(300)


def test_sensors_without_noise_read_the_truth_whatever_the_seed(make_packed: Make) -> None:
    quiet: dict[str, Sensor] = {"imu": Imu(rate_hz=10), "dvl": Dvl(rate_hz=10)}
    first, second = (board(make_packed, seed, quiet) for seed in (1, 2))
    for name in first:
        assert np.array_equal(first[name].values, second[name].values)


def test_one_seed_gives_one_log(make_packed: Make) -> None:
    first, again, other = (board(make_packed, seed) for seed in (5, 5, 6))
    assert list(first) == list(again)
    for name, channel in first.items():
        assert np.array_equal(channel.values, again[name].values)
        assert np.array_equal(channel.logged_s, again[name].logged_s)
        same = np.array_equal(channel.values, other[name].values)
        assert same == (name == "command")


@pytest.mark.parametrize("missing", sorted(BOARD))
def test_a_sensor_more_or_less_changes_no_other(make_packed: Make, missing: str) -> None:
    whole = board(make_packed, seed=5)
    others = board(make_packed, seed=5, sensors={n: s for n, s in BOARD.items() if n != missing})
    assert set(whole) - set(others) == {missing}
    for name, channel in others.items():
        assert np.array_equal(channel.values, whole[name].values)


def test_noise_of_two_sensors_is_not_the_same(make_packed: Make) -> None:
    log = board(make_packed, seed=5)
    errors = np.stack(
        [
            log["imu"].values[:, 0],
            log["dvl"].values[:, 0],
            log["depth"].values[:, 0],
            log["position"].values[:, 0],
            log["shaft_speed"].values[:, 0],
            log["voltage"].values[:, 0],
        ]
    )
    assert np.abs(np.corrcoef(errors) - np.eye(6)).max() < 5 / np.sqrt(errors.shape[1])


def test_the_run_is_not_changed(make_packed: Make) -> None:
    packed = with_shaft_tables(make_packed())
    trajectory = motion(2.0, nu=(1, 0, 0, 0, 0, 0.3), command=np.full((101, 5), 40.0))
    arrays = {name: value.copy() for name, value in vars(trajectory).items()}
    vector = packed.vector.copy()
    sense(packed, trajectory, 3, **BOARD)
    for name, before in arrays.items():
        assert np.array_equal(getattr(trajectory, name), before)
    assert np.array_equal(packed.vector, vector)
